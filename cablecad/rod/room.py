"""Self-gaps and margins of many planar equilibria at once: the same as one by one, in a fraction of the time.

A report tells both of every equilibrium that was found. Asked for one after the other they take several times as long
as solving does, for at this size calls of numpy cost more than the arithmetic. Here the search for the least critical
distance runs over the states of all equilibria together, and stability is judged in one go.

Taut equilibria, and those with closed forms of their own, are left to themselves.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import fields
from functools import cached_property

import numpy as np

from cablecad.centreline import Array
from cablecad.rod.equilibria import Equilibria
from cablecad.rod.judge import judge
from cablecad.rod.polish import Middle
from cablecad.rod.solution import Equilibrium
from cablecad.rod.stability import NEUTRAL, Stability
from cablecad.rod.trace import Trace, gathered, give_back
from cablecad.rod.twins import first_twins
from cablecad.self_gap import (
    Indices,
    greatest_between,
    is_measurable,
    self_gap,
    self_gaps,
)

_FEWEST_JUDGED = 3
"""So many equilibria are judged together, fewer one by one."""

_BLOCK = 512
"""Equilibria searched at once: 200 MB."""

_LEAST_SAMPLES, _PER_OMEGA = 32, 4.0
"""Samples of the curvature at least, and for each unit of omega times the length: a bound of it is an eighth of omega,
or of the curvature, too high at most. Three times as many took a twentieth longer in all."""


def measure_gaps(equilibria: Iterable[Equilibrium]) -> None:
    """Find the self-gaps of equilibria, which then have them at hand."""
    plain = [(one, trace) for one in equilibria if (trace := _plain_trace(one)) is not None]
    if not plain:
        return
    traces = [trace for _, trace in plain]
    rows = gathered(traces)
    first = first_twins(traces, rows)
    single = np.flatnonzero(first == np.arange(len(first)))
    order = single[np.argsort(np.maximum(rows.omega, rows.kappa_max)[single], kind="stable")]  # alike in their samples
    for low in range(0, len(order), _BLOCK):
        own = order[low : low + _BLOCK]
        some = [plain[i] for i in own]
        for (one, _), gap in zip(some, _gaps(some, rows.take(own)), strict=True):
            one.__dict__["self_gap"] = gap
    for (one, _), twin in zip(plain, first.tolist(), strict=True):
        one.__dict__["self_gap"] = plain[twin][0].self_gap


def gap_of(one: Equilibrium) -> float | None:
    """The self-gap of a single equilibrium; in its plane where it may be, in three quarters of the time."""
    if one.trace is None or one.trace.is_taut:
        return self_gap(one.centreline, one.diameter / 2.0)
    return _gaps([(one, one.trace)], one.trace.row)[0]


def judge_together(equilibria: Iterable[Equilibrium]) -> None:
    """Find the stability of equilibria, which then have it at hand."""
    asked = [
        (one, one.trace)
        for one in equilibria
        if one.trace is not None and not isinstance(one.__dict__.get("stability"), Stability)
    ]
    if len(asked) < _FEWEST_JUDGED:
        return
    traces = [trace for _, trace in asked]
    rows = gathered(traces)
    first = first_twins(traces, rows)
    _judge_first(rows, first)
    margins, free = rows.margins.tolist(), rows.free_turns.tolist()
    spins = np.where(np.isnan(rows.torsion_ratio), "free", "clamped").tolist()
    give_back(traces, rows, "margins", "verdict", "free_turns")
    for i, (one, _) in enumerate(asked):
        one.__dict__["stability"] = Stability(margins[i][0], margins[i][1], free[i], spins[i])


def _judge_first(rows: Equilibria, first: Indices) -> None:
    """Judge each first of twins, and take for the others what is not known of them."""
    single = np.flatnonzero(first == np.arange(len(first)))
    some = rows.take(single)
    judge(some)
    place = np.searchsorted(single, first)
    rows.free_turns[:] = np.where(np.isnan(rows.margins[:, 1]), some.free_turns[place], rows.free_turns)
    rows.margins[:] = np.where(np.isnan(rows.margins), some.margins[place], rows.margins)
    rows.verdict[:] = np.where(rows.margins > NEUTRAL, 1, -1)


def _plain_trace(one: Equilibrium) -> Trace | None:
    """The solver's own state of an equilibrium of one elastica whose self-gap nobody has asked for yet."""
    trace = one.trace
    return None if trace is None or "self_gap" in one.__dict__ or trace.is_taut else trace


def _gaps(some: list[tuple[Equilibrium, Trace]], rows: Equilibria) -> list[float | None]:
    """Self-gaps of equilibria of one elastica each, searched together."""
    spans = [trace.span for _, trace in some]
    free = np.array([span.length for span in spans])
    straights = np.array([[span.lead_out, span.lead_in] for span in spans]) / free[:, None]
    radii = np.array([one.diameter for one, _ in some]) / 2.0 / free
    lengths = 1.0 + straights.sum(axis=1)
    good = is_measurable(lengths, rows.kappa_max, radii)
    gaps = np.full(len(some), np.nan)
    if good.any():
        rods = _Rods(rows.take(np.flatnonzero(good)), straights[good])
        gaps[good] = self_gaps(rods, radii[good]) * free[good]
    return [gap if known else None for gap, known in zip(gaps.tolist(), good.tolist(), strict=True)]


class _Rods:
    """Elastica of length one from their states at mid-span, between straights, as the search takes them.

    Args:
        rows: The equilibria.
        straights: Held straight before and after the free part, shape (rods, 2).
    """

    def __init__(self, rows: Equilibria, straights: Array) -> None:
        self._courses = Middle(*(getattr(rows, f.name) for f in fields(Middle))).courses
        self._kappa_max, self._omega = rows.kappa_max, rows.omega
        self._before = straights[:, 0]
        self.lengths = 1.0 + straights.sum(axis=1)

    @cached_property
    def bends(self) -> _RodBends:
        """From samples as many as the steepest needs: between two the curvature changes by omega^2 a unit of length."""
        omega = self._omega[:, None]
        count = max(_LEAST_SAMPLES, math.ceil(_PER_OMEGA * float((omega * self.lengths[:, None]).max())))
        s = np.linspace(0.0, 1.0, count + 1) * self.lengths[:, None] - self._before[:, None]
        # A straight next to a bend has its curvature: no sample knows where between two the straight ends.
        kappa = np.abs(self._courses.take(np.s_[:, None]).kappa(_between(s, 0.0, 1.0) - 0.5))
        higher = np.maximum(kappa[:, 1:], kappa[:, :-1]) + omega * omega * self.lengths[:, None] / (2.0 * count)
        bounds = np.minimum(higher, self._kappa_max[:, None])
        bounds *= 1.0 + 1e-9  # rounding
        bounds[(s[:, 1:] <= 0.0) | (s[:, :-1] >= 1.0)] = 0.0
        return _RodBends(bounds, self.lengths)

    def states(self, curve: Indices, s: Array) -> tuple[Array, Array, Array]:
        """Positions, tangents and curvature vectors in the frame of the compression, shape (2, n) each."""
        s = s - self._before[curve]
        inside = _between(s, 0.0, 1.0)
        beyond = s - inside
        at = self._courses.take(curve).at(inside - 0.5)
        kappa = np.where(beyond == 0.0, at.kappa, 0.0)
        position = np.array([at.along + beyond * at.cosine, at.across + beyond * at.sine])
        return position, np.array([at.cosine, at.sine]), np.array([-kappa * at.sine, kappa * at.cosine])


def _between(values: Array, least: float, most: float) -> Array:
    clipped: Array = np.minimum(np.maximum(values, least), most)
    return clipped


class _RodBends:
    """Bounds between equidistant samples of curves of given lengths, shape (rods, samples)."""

    def __init__(self, bounds: Array, lengths: Array) -> None:
        self._count = bounds.shape[1]
        self._per_length = self._count / lengths
        self._bounds = bounds.ravel()
        turned = np.cumsum(bounds, axis=1) / self._per_length[:, None]
        self._turned = np.concatenate([np.zeros((len(bounds), 1)), turned], axis=1).ravel()

    def greatest(self, curve: Indices, begin: Array, end: Array) -> Array:
        """A bound on the curvature between `begin` and `end`."""
        per_length = self._per_length[curve]
        first = np.floor(begin * per_length).astype(np.intp)
        last = np.ceil(end * per_length).astype(np.intp)
        return greatest_between(self._bounds, first, last, curve * self._count, self._count)

    def turning(self, curve: Indices, s: Array) -> Array:
        """The angle the tangent has turned through from the start to `s`."""
        x = _between(s * self._per_length[curve], 0.0, float(self._count))
        below = np.minimum(np.floor(x).astype(np.intp), self._count - 1)
        start = curve * (self._count + 1) + below
        angle: Array = self._turned[start] + (x - below) * (self._turned[start + 1] - self._turned[start])
        return angle
