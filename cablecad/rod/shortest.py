"""The shortest cable that keeps its least bend radius: length as the question.

The bend radius is not monotone in the length: a short cable is bent hard at its clamps, a longer one relaxes, one
longer still forms a loop, and the equilibrium of least energy may change on the way. So lengths are sampled from the
chord upwards, ranges in which the rule holds are found, and their ends are narrowed down by sampling again inside the
bracket. A range counts only if it reaches 5 % beyond its beginning: nobody cuts cables closer than that.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from cablecad.centreline import Array
from cablecad.errors import InfeasibleError
from cablecad.model import Cable, EquilibriumKey
from cablecad.rod.arch import solve_pinned
from cablecad.rod.planar import solve_planar
from cablecad.rod.plane import unit_vector
from cablecad.rod.select import select_model
from cablecad.rod.span import Span, span_of

ROOM = 1.05
"""A range must hold from L to this times L."""

_SAMPLES = 93
"""Lengths tried first, geometric in the excess: neighbours differ by 15 %."""

_LEAST, _LITTLE, _MOST = 1e-8, 1e-4, 40.0
"""Excess of the least length, of the first that is tried, and of the last, in units of the chord or the bend radius,
whichever is greater. Less than the least no cable is cut to; beyond 40 the cable is all loop and its bend radius grows
with its length."""

_SECTIONS, _ROUNDS = 5, 15
"""The ends of a range are narrowed by cutting the bracket in 5, fifteen times: 3e-11 of it, at the fewest solutions."""

Radii = Callable[[Array], Array]


def shortest_length(cable: Cable) -> tuple[float, str]:
    """The least length at which the chosen equilibrium keeps `min_bend_radius`, and keeps it up to 1.05 of itself.

    Args:
        cable: With positions at both ends and a `min_bend_radius`.

    Returns:
        The length [mm], which errs to the side that keeps the rule, and what the report should say of the ranges.

    Raises:
        InfeasibleError: No length does.

    Accuracy: the beginning of the range to 1e-10 of the bracket it was met in. A range narrower than the distance of
        two samples, 15 % of the excess, may be missed.
    """
    rule = cable.min_bend_radius
    assert rule is not None  # checked with the cable
    base = _least_length(cable)
    unit = max(base, rule)
    radii = _pinned_radii(cable) if cable.is_pinned else _radii(cable)
    lengths = base + unit * np.geomspace(_LITTLE, _MOST, _SAMPLES)
    keeps = radii(lengths) >= rule
    straight = _may_be_straight(cable, base)
    if keeps[0] or straight:
        # Only then can less excess do: between misaligned clamps the radius falls to nothing with it.
        hairs = base + unit * np.geomspace(_LEAST, _LITTLE, _SAMPLES // 3)[:-1]
        lengths, keeps = np.concatenate([hairs, lengths]), np.concatenate([radii(hairs) >= rule, keeps])
    ranges = []
    i = 0
    while i < len(lengths):
        if not keeps[i]:
            i += 1
            continue
        j = i
        while j + 1 < len(lengths) and keeps[j + 1]:
            j += 1
        if i == 0:
            # Kept by a hair of excess: by none too, if the straight cable is one; else that hair is short enough.
            begin = base if straight else float(lengths[0])
        else:
            begin = _narrow(radii, rule, lengths[i - 1], lengths[i])
        end = math.inf if j + 1 == len(lengths) else _narrow(radii, rule, lengths[j + 1], lengths[j])
        if end >= ROOM * begin and np.all(radii(np.linspace(begin, ROOM * begin, 18)[1:]) >= rule):
            ranges.append((float(begin), float(end)))
        i = j + 1
    if not ranges:
        raise InfeasibleError(
            f"no length between {lengths[0]:.6g} mm and {lengths[-1]:.6g} mm keeps the least bend radius at "
            f"{rule:g} mm with this equilibrium; move the ends apart, turn them, or allow a tighter bend"
        )
    begin, end = ranges[0]
    said = f"length {begin:.9g} mm is the shortest that keeps min_bend_radius = {rule:g} mm; it is kept "
    said += "at every greater length that was tried" if end == math.inf else f"up to {end:.9g} mm"
    if len(ranges) > 1:
        said += f", and again from {ranges[1][0]:.9g} mm"
    return begin, said


def _may_be_straight(cable: Cable, length: float) -> bool:
    """Whether the ends allow a cable without excess, and it is asked for: pins apart, or clamps along their line."""
    if length == 0.0 or cable.equilibrium != 0:
        return False
    try:
        return select_model(replace(cable, length=length)).model == "straight"
    except InfeasibleError:
        return False


def _narrow(radii: Radii, rule: float, broken: float, kept: float) -> float:
    """The end of a range between a length that breaks the rule and one that keeps it, on the side that keeps it."""
    for _ in range(_ROUNDS):
        inner = np.linspace(broken, kept, _SECTIONS + 1)
        keeps = radii(inner[1:-1]) >= rule
        last = int(np.flatnonzero(~np.concatenate([[False], keeps, [True]]))[-1])
        broken, kept = float(inner[last]), float(inner[last + 1])
        if abs(kept - broken) <= 4e-16 * abs(kept):
            break
    return kept


def _least_length(cable: Cable) -> float:
    """The length without excess: the chord of the free part and the straights [mm]."""
    ends = []
    for support, way in ((cable.start_support, 1.0), (cable.end_support, -1.0)):
        position = np.array(support.position)  # type: ignore[union-attr]
        straight = getattr(support, "straight", 0.0)
        if straight:
            direction = support.direction  # type: ignore[union-attr]
            position = position + way * straight * unit_vector(direction)
        ends.append((position, straight))
    return float(np.linalg.norm(ends[1][0] - ends[0][0])) + ends[0][1] + ends[1][1]


def _pinned_radii(cable: Cable) -> Radii:
    chord = _least_length(cable)
    mode = 1 if isinstance(cable.equilibrium, EquilibriumKey) else cable.equilibrium // 2 + 1

    def radii(lengths: Array) -> Array:
        return np.array(
            [solve_pinned({"length": float(x), "chord": chord}).datum("bend_radius") / mode for x in lengths]
        )

    return radii


def _radii(cable: Cable) -> Radii:
    """Least bend radius by length, all lengths solved together; 0 where there is no such equilibrium."""
    wanted = cable.equilibrium

    def radii(lengths: Array) -> Array:
        spans: dict[int, Span] = {}
        for i, length in enumerate(lengths):
            try:
                spans[i] = span_of(cable, float(length))
            except InfeasibleError:
                continue
        values = np.zeros(len(lengths))
        if not spans:
            return values
        first = next(iter(spans.values()))
        found = solve_planar(
            np.array([span.start_angle for span in spans.values()]),
            np.array([span.end_angle for span in spans.values()]),
            np.array([span.end_point for span in spans.values()]),
            excess=np.array([span.excess for span in spans.values()]),
            start_clamped=first.start_clamped,
            end_clamped=first.end_clamped,
            search="answer" if wanted == 0 else "wide",
        ).equilibria
        for j, (i, span) in enumerate(spans.items()):
            rows = found.of(j)
            if isinstance(wanted, EquilibriumKey):
                rows = rows.take(np.flatnonzero((rows.winding == wanted.winding) & (rows.side == wanted.side)))
            index = 0 if isinstance(wanted, EquilibriumKey) else wanted
            if index < len(rows):
                kappa = float(rows.kappa_max[index]) / span.length
                values[i] = math.inf if kappa == 0.0 else 1.0 / kappa
        return values

    return radii
