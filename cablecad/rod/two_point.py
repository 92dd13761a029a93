"""Cables between clamps and pins in one plane: from ends and length to equilibria, one cable or many at once.

Each cable is reduced to its free span, spans of one kind go through the planar solver together, and what comes back is
given its length, its plane and its lead-outs.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import Literal

import numpy as np

from cablecad.centreline import Array
from cablecad.errors import CablecadError, SolveError
from cablecad.model import Cable
from cablecad.rod.draw import draw
from cablecad.rod.equilibria import Numbers
from cablecad.rod.judge import RowStability
from cablecad.rod.planar import solve_planar
from cablecad.rod.rise import rise_of
from cablecad.rod.solution import Equilibrium, RodSolution, choose
from cablecad.rod.span import Span, span_of
from cablecad.rod.trace import Trace

Search = Literal["answer", "wide"]

SAME_ENERGY = 1e-9
"""Relative difference of the energies of mirror twins: rounding, amplified by a hair of slack."""


def solve_two_point(
    cables: Sequence[Cable], lengths: Sequence[float], *, search: Search = "answer"
) -> list[RodSolution | CablecadError]:
    """Find the equilibria of cables of given lengths [mm] between two positions each, at least one of them a clamp.

    Args:
        cables: What holds them; spans of one kind and torsional stiffness are solved together.
        lengths: Of each, beside its data.
        search: "wide" for windings to -2..2 and more starts; taken too where a cable asks for another equilibrium
            than the first.

    Returns:
        For each cable its solution, or the reason why it has none; none keeps the others from theirs.
    """
    results: list[RodSolution | CablecadError] = [SolveError("not solved")] * len(cables)
    groups: dict[tuple[bool, bool, float | None, bool], list[tuple[int, Span]]] = defaultdict(list)
    for i, (cable, length) in enumerate(zip(cables, lengths, strict=True)):
        try:
            span = span_of(cable, length)
        except CablecadError as error:
            results[i] = error
            continue
        wide = search == "wide" or cable.equilibrium != 0
        groups[span.start_clamped, span.end_clamped, torsion_ratio(cable, span), wide].append((i, span))
    for (start_clamped, end_clamped, ratio, wide), members in groups.items():
        spans = [span for _, span in members]
        found = solve_planar(
            np.array([span.start_angle for span in spans]),
            np.array([span.end_angle for span in spans]),
            np.array([span.end_point for span in spans]),
            excess=np.array([span.excess for span in spans]),
            start_clamped=start_clamped,
            end_clamped=end_clamped,
            torsion_ratio=ratio,
            search="wide" if wide else "answer",
        )
        equilibria = found.equilibria
        numbers, bounds = equilibria.numbers(), np.searchsorted(equilibria.scene, range(len(members) + 1)).tolist()
        for j, (i, span) in enumerate(members):
            try:
                if found.result[j] != "solved":
                    raise SolveError(
                        f"no equilibrium was found to a residual of 1e-12 in {found.descents[j]} starts, although none "
                        "is known to be impossible; change the length or an end a little"
                    )
                listed = [
                    equilibrium_of(cables[i], Trace(span, equilibria, k), numbers[k], ratio)
                    for k in range(bounds[j], bounds[j + 1])
                ]
                results[i] = _solution(cables[i], lengths[i], span, listed, int(found.descents[j]))
            except CablecadError as error:
                results[i] = error
    return results


def torsion_ratio(cable: Cable, span: Span) -> float | None:
    """GJ/EI where both ends hold the cable's spin and the ratio is known."""
    if cable.material is None or not (span.start_clamped and span.end_clamped):
        return None
    GJ = cable.material.GJ(cable.section)
    return None if GJ is None else GJ / cable.material.EI(cable.section)


def _solution(cable: Cable, length: float, span: Span, listed: list[Equilibrium], starts: int) -> RodSolution:
    equilibria = tuple(_twins_by_bulge(listed))
    index = choose(cable, equilibria)
    kinds = " and ".join("clamped" if held else "pinned" for held in (span.start_clamped, span.end_clamped))
    reason = f"the ends ({kinds}) lie in one plane: planar elastica, {starts} starts over the windings that can win"
    if any(other is not equilibria[index] and _same_energy(other, equilibria[index]) for other in equilibria):
        reason += "; the bulge decided between mirror twins"
    return solution_of(cable, length, span, equilibria, index, reason)


def solution_of(
    cable: Cable, length: float, span: Span, equilibria: tuple[Equilibrium, ...], index: int, reason: str
) -> RodSolution:
    """The solution of a cable from equilibria of its span."""
    chosen = equilibria[index]
    begin, finish = np.array(cable.start_support.position), np.array(cable.end_support.position)  # type: ignore[union-attr]
    chord = math.dist(begin, finish)
    return RodSolution(
        cable=cable,
        model="planar",
        reason=reason,
        equilibria=equilibria,
        index=index,
        length=length,
        chord=chord,
        slack=None if chord == 0.0 else cable.slack if cable.slack is not None else (length - chord) / chord,
        measure_rise=partial(_rise, chosen, begin, finish),
        measure_end_angle=partial(_end_angle, chosen, finish - begin),
        measure_residual=partial(_residual, chosen, span, begin, finish, length),
        out_of_plane_deg=math.degrees(span.out_of_plane),
    )


def _twins_by_bulge(listed: list[Equilibrium]) -> Iterator[Equilibrium]:
    """Equilibria of one energy in the order of the bulge: by their middle, then by their quarter point.

    Their energies, equal but for rounding, are made equal, so that the list is in order of energy to the last digit.
    """
    i = 0
    while i < len(listed):
        j = i + 1
        while j < len(listed) and _same_energy(listed[i], listed[j]) and _alike(listed[i], listed[j]):
            j += 1
        if j == i + 1:
            yield listed[i]
        else:
            energy = listed[i].energy_per_EI
            twins = sorted(listed[i:j], key=_towards_bulge)
            yield from (twin if twin.energy_per_EI == energy else replace(twin, energy_per_EI=energy) for twin in twins)
        i = j


def _same_energy(one: Equilibrium, other: Equilibrium) -> bool:
    return abs(one.energy_per_EI - other.energy_per_EI) <= SAME_ENERGY * abs(one.energy_per_EI)


def _alike(one: Equilibrium, other: Equilibrium) -> bool:
    return bool(one.stability.stable_in_plane) == bool(other.stability.stable_in_plane)


def _towards_bulge(twin: Equilibrium) -> tuple[float, ...]:
    """Heights of the middle and of the quarter point towards the bulge, negative; rounding counts as level."""
    assert twin.trace is not None  # the planar solver's own equilibria have one
    return tuple(-round(height, 9) for height in twin.trace.among.heights[twin.trace.place].tolist())


def equilibrium_of(cable: Cable, trace: Trace, numbers: Numbers, ratio: float | None) -> Equilibrium:
    """One of the equilibria of rods of length one, given its span's length and place."""
    length = trace.span.length
    return Equilibrium(
        winding=numbers.winding,
        side=numbers.side,
        inflections=numbers.inflections,
        branch=numbers.branch,
        energy_per_EI=numbers.energy / length,
        draw=partial(draw, trace),
        judge=partial(RowStability, trace, "free" if ratio is None else "clamped"),
        diameter=cable.diameter,
        trace=trace,
        kappa_max=numbers.kappa_max / length,
    )


def _residual(chosen: Equilibrium, span: Span, begin: Array, finish: Array, length: float) -> float:
    """The largest unmet end condition of the delivered centreline: position over length, direction as an angle."""
    centreline = chosen.centreline
    ends = centreline.ends()
    unmet = [float(np.linalg.norm(ends.position[i] - place)) / length for i, place in ((0, begin), (1, finish))]
    for i, (clamped, angle) in enumerate(((span.start_clamped, span.start_angle), (span.end_clamped, span.end_angle))):
        if clamped:
            wanted = math.cos(angle) * span.e1 + math.sin(angle) * span.e2
            unmet.append(float(np.linalg.norm(ends.tangent[i] - wanted)))
        else:
            unmet.append(abs(float(centreline.curvature(i * centreline.length)[0])) * length)
    return max(unmet)


def _rise(chosen: Equilibrium, begin: Array, finish: Array) -> float:
    return rise_of(chosen.centreline, begin, finish)


def _end_angle(chosen: Equilibrium, chord: Array) -> float | None:
    if not chord.any():
        return None
    tangent = chosen.start.direction
    return math.degrees(math.atan2(float(np.linalg.norm(np.cross(tangent, chord))), float(tangent @ chord)))
