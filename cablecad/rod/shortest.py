"""The shortest cable that keeps its least bend radius: length as the question.

The bend radius is not monotone in the length: a short cable is bent hard at its clamps, a longer one relaxes, one
longer still forms a loop, and the equilibrium of least energy may change on the way. So lengths are sampled from the
chord upwards, ranges in which the rule holds are found, and their ends are narrowed down inside the bracket. A range
counts only if it reaches 5 % beyond its beginning: nobody cuts cables closer than that.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import islice

import numpy as np

from cablecad.centreline import Array
from cablecad.errors import InfeasibleError, Mistake, NotPlanarError, SceneError
from cablecad.model import Cable, EquilibriumKey
from cablecad.rod.pinned_data import solve_pinned
from cablecad.rod.planar import solve_planar
from cablecad.rod.plane import unit_vector
from cablecad.rod.select import select_model
from cablecad.rod.span import Span, span_of

ROOM = 1.05
"""A range must hold from L to this times L."""

_GROWTH, _STEP = 1.15, 1.024
"""Lengths tried first: neighbours differ by 15 % of the excess, and by 2.4 % of the length at most, so that two lie in
any range that counts."""

_HAIRS = 31
"""Lengths tried of less excess than the first, where that may keep the rule."""

_LEAST, _LITTLE, _MOST = 1e-8, 1e-4, 40.0
"""Excess of the least length, of the first that is tried, and of the last, in units of the chord or the bend radius,
whichever is greater. Less than the least no cable is cut to; beyond 40 the cable is all loop and its bend radius grows
with its length."""

_CLOSE, _ROUNDS = 3e-11, 30
"""The ends of a range are narrowed to this share of the bracket they were met in, in so many rounds at most: ten or so
where the radius jumps, five where it goes smoothly through the rule."""

_NEAR = 0.02
"""How close to where it is expected the end of a range is looked for at first, over its bracket."""

_WITHIN = 17
"""Lengths tried between the beginning of a range and 5 % beyond."""

_INWARD = (0.0, 1e-15, 1e-14, 1e-13, 1e-12, 1e-11, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6)
"""By such shares of itself the beginning of a range goes inward until the cable is found there when it is solved alone:
where an equilibrium appears, a search may miss it."""

Radii = Callable[[Array], Array]


def shortest_length(cable: Cable) -> tuple[float, str]:
    """The least length at which the chosen equilibrium keeps `min_bend_radius`, and keeps it up to 1.05 of itself.

    Args:
        cable: With positions at both ends and a `min_bend_radius`.

    Returns:
        The length [mm], which errs to the side that keeps the rule, and what the report should say of the ranges.

    Raises:
        InfeasibleError: No length does.

    Accuracy: the beginning of the range to 1e-10 of the bracket it was met in. Gaps between two of the lengths that are
        tried, 2.4 % apart or less, may be missed; in the first 5 % of a range those below 0.3 %.
    """
    rule = cable.min_bend_radius
    assert rule is not None  # checked with the cable
    base = _least_length(cable)
    unit = max(base, rule)
    radii = _pinned_radii(cable) if cable.is_pinned else _radii(cable)
    tried = _Tried(radii, rule)
    tried.add(_first_lengths(base, unit))
    straight = _may_be_straight(cable, base)
    if tried.keeps(0) or straight:
        # Only then can less excess do: between misaligned clamps the radius falls to nothing with it.
        tried.add(base + unit * np.geomspace(_LEAST, _LITTLE, _HAIRS)[:-1])
    least, most = tried.lengths[0], tried.lengths[-1]
    if cable.equilibrium != 0 and not tried.values.any():
        problem = f"no such equilibrium was found at any length from {least:.6g} mm to {most:.6g} mm"
        raise SceneError([Mistake("equilibrium", problem, _shown(cable.equilibrium))])
    ranges = list(islice(_ranges(tried, base if straight else None), 2))
    if not ranges:
        raise InfeasibleError(
            f"no length between {least:.6g} mm and {most:.6g} mm keeps the least bend radius at "
            f"{rule:g} mm with this equilibrium; move the ends apart, turn them, or allow a tighter bend"
        )
    begin, end = ranges[0]
    said = f"length {begin:.9g} mm is the shortest that keeps min_bend_radius = {rule:g} mm"
    said += "; less excess was not tried; it is kept " if begin == least and not straight else "; it is kept "
    said += "at every greater length that was tried" if end == math.inf else f"up to {end:.9g} mm"
    if len(ranges) > 1:
        said += f", and again from {ranges[1][0]:.9g} mm"
    return begin, said


def _first_lengths(base: float, unit: float) -> Array:
    """Lengths from a little excess to far more than is ever needed [mm]."""
    excess = [_LITTLE]
    while excess[-1] < _MOST:
        excess.append(min(_GROWTH * excess[-1], excess[-1] + (_STEP - 1.0) * (base / unit + excess[-1])))
    return base + unit * np.array(excess)


def _shown(wanted: EquilibriumKey | int) -> object:
    return wanted if isinstance(wanted, int) else {"winding": wanted.winding, "side": wanted.side}


class _Tried:
    """Lengths that were tried, from the least on, and the least bend radius at each.

    Attributes:
        lengths: [mm].
        values: [mm]; 0 where there is no such equilibrium.
    """

    def __init__(self, radii: Radii, rule: float) -> None:
        self.radii, self.rule = radii, rule
        self.lengths, self.values = np.zeros((2, 0))

    def add(self, lengths: Array) -> None:
        """Try more lengths."""
        every, values = np.append(self.lengths, lengths), np.append(self.values, self.radii(lengths))
        order = np.argsort(every, kind="stable")
        self.lengths, self.values = every[order], values[order]

    def keeps(self, i: int) -> bool:
        """Whether one of them keeps the rule."""
        return bool(self.values[i] >= self.rule)

    def next(self, i: int, keeps: bool) -> int:
        """The first from `i` on that keeps the rule, or does not; their number where there is none."""
        found = np.flatnonzero((self.values[i:] >= self.rule) == keeps)
        return i + int(found[0]) if len(found) else len(self.lengths)


def _ranges(tried: _Tried, straight: float | None) -> Iterator[tuple[float, float]]:
    """The ranges in which the rule is kept for 5 % at least, as they are found.

    Args:
        tried: What is known; more lengths are tried where need be.
        straight: The length of the straight cable, where that is one too [mm].
    """
    i = 0
    while (i := tried.next(i, keeps=True)) < len(tried.lengths):
        if i == 0:
            # Kept by a hair of excess: by none too, if the straight cable is one; else that hair is short enough.
            begin = float(tried.lengths[0]) if straight is None else straight
        else:
            begin = _as_solved_alone(tried, _narrow(tried, i - 1, i))
        reach = ROOM * begin
        tried.add(np.linspace(begin, reach, _WITHIN + 1)[1:])
        first = int(np.searchsorted(tried.lengths, begin, side="right"))
        broken = tried.next(first, keeps=False)
        if broken < len(tried.lengths) and tried.lengths[broken] <= reach:
            i = broken
            continue
        yield begin, math.inf if broken == len(tried.lengths) else _narrow(tried, broken, broken - 1)
        i = broken


def _as_solved_alone(tried: _Tried, begin: float) -> float:
    """The beginning of a range where the cable is found, and keeps the rule, by itself as it is among others."""
    for share in _INWARD:
        length = begin * (1.0 + share)
        if tried.radii(np.array([length]))[0] >= tried.rule:
            return length
    return begin * (1.0 + _INWARD[-1])


def _may_be_straight(cable: Cable, length: float) -> bool:
    """Whether the ends allow a cable without excess, and it is asked for: pins apart, or clamps along their line."""
    if length == 0.0 or cable.equilibrium != 0:
        return False
    try:
        return select_model(replace(cable, length=length)).model == "straight"
    except InfeasibleError:
        return False


def _narrow(tried: _Tried, broken: int, kept: int) -> float:
    """The end of a range, between a length that breaks the rule and one that keeps it, on that one's side [mm]."""
    rule, near, missed = tried.rule, _NEAR, 0
    ends = np.array([tried.lengths[broken], tried.lengths[kept]])
    values = np.array([tried.values[broken], tried.values[kept]])
    enough = max(_CLOSE * abs(ends[1] - ends[0]), 4e-16 * ends[1])
    for _ in range(_ROUNDS):
        smooth = values[0] > 0.0 and values[1] < math.inf and missed < 2
        if smooth:
            # Where the radius, were it straight between the two, would meet the rule, and close beside.
            cross = (rule - values[0]) / (values[1] - values[0])
            shares = np.unique(np.clip([cross - near, cross, cross + near, 0.5], 1e-12, 1.0 - 1e-12))
        else:
            shares = np.linspace(0.0, 1.0, 6)[1:-1]
        inner = ends[0] + (ends[1] - ends[0]) * shares
        every = np.concatenate([ends[:1], inner, ends[1:]])
        radii = np.concatenate([values[:1], tried.radii(inner), values[1:]])
        last = int(np.flatnonzero(~(radii[:-1] >= rule))[-1])
        caught = abs(every[last + 1] - every[last]) <= 2.0 * near * abs(ends[1] - ends[0])
        ends, values = every[last : last + 2], radii[last : last + 2]
        near = max(near**2, 1e-9) if smooth and caught else _NEAR
        missed += smooth and not caught  # twice, and the radius jumps there
        if abs(ends[1] - ends[0]) <= enough:
            break
    return float(ends[1])


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
            except NotPlanarError:  # of which the length says nothing
                raise
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
