"""Self-gaps and margins of many planar equilibria at once: the same as one by one, in a fraction of the time.

A report tells both of every equilibrium that was found. Asked for one after the other they take several times as long
as solving does, for at this size calls of numpy cost more than the arithmetic. Here the search for the least critical
distance runs over the states of all equilibria together, and stability is judged in one go.

Equilibria of cables with lead-outs, taut ones, and those with closed forms of their own are left to themselves.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import fields
from functools import cached_property

import numpy as np

from cablecad.centreline import Array
from cablecad.rod.equilibria import Equilibria
from cablecad.rod.judge import judge
from cablecad.rod.polish import Middle
from cablecad.rod.solution import Equilibrium
from cablecad.self_gap import (
    Indices,
    curvature_bounds,
    greatest_between,
    is_measurable,
    samples_of,
    self_gaps,
)

_FEWEST = 3
"""So many equilibria are measured together, fewer one by one."""

_BLOCK = 512
"""Equilibria searched at once: 200 MB."""


def measure_gaps(equilibria: Iterable[Equilibrium]) -> None:
    """Find the self-gaps of equilibria, which then have them at hand."""
    plain = [one for one in equilibria if _is_plain(one)]
    if len(plain) < _FEWEST:
        return
    steepness = [max(row.omega[0], row.kappa_max[0]) for row in _rows(plain)]
    plain = [plain[i] for i in np.argsort(steepness, kind="stable")]  # alike in their number of samples
    for low in range(0, len(plain), _BLOCK):
        _measure_gaps(plain[low : low + _BLOCK])


def judge_together(equilibria: Iterable[Equilibrium]) -> None:
    """Find the margins of stability of equilibria, which then have them at hand."""
    rows = [row for row in _rows(equilibria) if np.isnan(row.margins).any()]
    if len(rows) < _FEWEST:
        return
    together = _joined(rows)
    judge(together)
    for i, row in enumerate(rows):
        for name in ("margins", "verdict", "free_turns"):
            getattr(row, name)[:] = getattr(together, name)[i : i + 1]


def _rows(equilibria: Iterable[Equilibrium]) -> list[Equilibria]:
    """The solver's own state of those that have one."""
    return [one.trace.row for one in equilibria if one.trace is not None]


def _is_plain(one: Equilibrium) -> bool:
    """Whether the whole cable is one elastica whose self-gap nobody has asked for yet."""
    if one.trace is None:
        return False
    span, row = one.trace.span, one.trace.row
    return "self_gap" not in one.__dict__ and not (row.taut[0] or span.lead_out > 0.0 or span.lead_in > 0.0)


def _joined(rows: list[Equilibria]) -> Equilibria:
    return Equilibria(*(np.concatenate([getattr(row, f.name) for row in rows]) for f in fields(Equilibria)))


def _measure_gaps(some: list[Equilibrium]) -> None:
    spans = [one.trace.span for one in some if one.trace is not None]
    lengths = np.array([span.length for span in spans])
    radii = np.array([one.diameter for one in some]) / 2.0 / lengths
    rows = _joined(_rows(some))
    good = [i for i in range(len(some)) if is_measurable(1.0, float(rows.kappa_max[i]), float(radii[i]))]
    gaps: list[float | None] = [None] * len(some)
    if good:
        found = self_gaps(_Rods(rows.take(np.array(good))), radii[good]) * lengths[good]
        for i, gap in zip(good, found.tolist(), strict=True):
            gaps[i] = gap
    for one, own in zip(some, gaps, strict=True):
        one.__dict__["self_gap"] = own


class _Rods:
    """Elastica of length one from their states at mid-span, as the search for critical pairs takes them."""

    def __init__(self, rows: Equilibria) -> None:
        self._middle = Middle(*(getattr(rows, f.name) for f in fields(Middle)))
        self._kappa_max = rows.kappa_max
        self.lengths = np.ones(len(rows))

    @cached_property
    def bends(self) -> _RodBends:
        """From samples as many as the steepest needs."""
        count = samples_of(1.0, float(self._kappa_max.max()))
        kappa = np.abs(self._middle.jump(np.linspace(-0.5, 0.5, count + 1)).kappa)
        return _RodBends(curvature_bounds(kappa, self._kappa_max[:, None]))

    def states(self, curve: Indices, s: Array) -> tuple[Array, Array, Array]:
        """Positions, tangents and curvature vectors in the frame of the compression, shape (n, 2) each."""
        at = self._middle.take(curve).jump(s[:, None] - 0.5)
        p, c, kappa = at.p[:, 0], at.c[:, 0], at.kappa[:, 0]
        tangent = np.stack([c * c - p * p, 2.0 * p * c], axis=1)
        normal = np.stack([-tangent[:, 1], tangent[:, 0]], axis=1)
        return np.stack([at.along[:, 0], at.across[:, 0]], axis=1), tangent, kappa[:, None] * normal


class _RodBends:
    """Bounds between equidistant samples, shape (rods, samples)."""

    def __init__(self, bounds: Array) -> None:
        self._count = bounds.shape[1]
        self._bounds = bounds.ravel()
        turned = np.cumsum(bounds, axis=1) / self._count
        self._turned = np.concatenate([np.zeros((len(bounds), 1)), turned], axis=1).ravel()

    def greatest(self, curve: Indices, begin: Array, end: Array) -> Array:
        """A bound on the curvature between `begin` and `end`."""
        first = np.floor(begin * self._count).astype(np.intp)
        last = np.ceil(end * self._count).astype(np.intp)
        return greatest_between(self._bounds, first, last, curve * self._count, self._count)

    def turning(self, curve: Indices, s: Array) -> Array:
        """The angle the tangent has turned through from the start to `s`."""
        x = np.minimum(np.maximum(s * self._count, 0.0), float(self._count))
        below = np.minimum(np.floor(x).astype(np.intp), self._count - 1)
        start = curve * (self._count + 1) + below
        angle: Array = self._turned[start] + (x - below) * (self._turned[start + 1] - self._turned[start])
        return angle
