"""The self-gap of a tube: how much room is left where it passes by itself.

Two points of the centreline face each other where the distance D between them is critical: the chord between them is
normal to the tangent at both, or meets it at an end of the centreline, where any angle will do. Pairs nearer than pi r
along the centreline belong to one bend, which the condition kappa r < 1 judges. The self-gap is the least such D less
2 r: below zero the tube cuts into itself.

The least critical pair is found by branch and bound, of one curve or of many curves together: at this size calls of
numpy cost more than the arithmetic. All pairs (s, t) are cut into cells, and a cell with half-widths
h_s, h_t and the chord D at its centre is left out where no critical pair in it can count:

* the chord cannot be normal to a tangent: it swings by asin((h_s + h_t) / D) at most, the tangent by kappa h;
* from the one end of the cell to the other the centreline turns by less than a right angle: a bend faces nothing;
* no critical distance in it can be below the least one known, less a tolerance. From a critical pair the distance
  grows with the square of the way, so that none in the cell is below

      D - ((h_s + h_t)^2 / (D - h_s - h_t) + kappa_s h_s^2 + kappa_t h_t^2) / 2.

The cells left are halved, and Newton's method from the nearest of them supplies ever smaller known distances. Nothing
is sampled but the curvature, between whose samples a margin is allowed for.

Source: the doubly critical self-distance of R. A. Litherland, J. Simon, O. Durumeric, E. Rawdon, Thickness of knots,
Topology Appl. 91 (1999) 233-244.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from cablecad.centreline import Array, Curve

Indices = NDArray[np.intp]
Mask = NDArray[np.bool_]

TOLERANCE = 1e-3
"""Share of the distance by which a pair that was passed over may be nearer than the one found: along stretches that
run parallel, the only places where that can happen, the number of cells grows as 1 / sqrt(tolerance)."""

_TOUCHING = 1e-6
"""Share of the radius below which a distance counts as none."""

_FIRST_INTERVALS = 12
"""Intervals of the centreline to begin with: 8 and 16 took a tenth to a quarter longer on the random cables of
tests/rod/test_room.py."""

_BATCH = 1 << 16
"""Cells handled at once, in 40 MB; the rest waits on a stack, so that memory stays bounded whatever the curve."""

_PER_RADIAN, _LEAST_SAMPLES = 8.0, 256
"""Samples of the curvature a radian of the tightest bend, and for the whole of a gentle curve."""

_MOST_SAMPLES = 4_000_000
"""More samples of the curvature than this are not taken: 100 MB, and a curve that no tube's spline could follow."""

_STARTS, _LAST_STARTS = 1, 24
"""Cells from which Newton's method begins in one round, and in the last, to find the least of a family: those that may
hold the least distances."""

_NEWTON_STEPS = 8
"""Quadratic convergence from a cell takes 3 to 5; where that fails, smaller cells come up in the next round."""

_NORMAL = 1e-10
"""Cosine of chord and tangent below which the chord is normal: the distance is off by this share, at most, of the way
to the pair that is critical to the last digit."""


class Bends(Protocol):
    """Bounds on the curvature of stretches of curves and on the turning of their tangents."""

    def greatest(self, curve: Indices, begin: Array, end: Array) -> Array:
        """A bound on the curvature between `begin` and `end`, shape (n,) each."""
        ...

    def turning(self, curve: Indices, s: Array) -> Array:
        """The angle the tangent has turned through from the start to `s`; its differences are bounds [rad]."""
        ...


class Curves(Protocol):
    """Curves that are searched together, by their numbers.

    Attributes:
        lengths: Shape (curves,).
        bends: Bounds of their bending.
    """

    @property
    def lengths(self) -> Array: ...  # noqa: D102
    @property
    def bends(self) -> Bends: ...  # noqa: D102

    def states(self, curve: Indices, s: Array) -> tuple[Array, Array, Array]:
        """Positions, unit tangents and curvature vectors, shape (dimensions, n) each."""
        ...


def self_gap(curve: Curve, radius: float) -> float | None:
    """The least critical distance between two points of a curve at least pi r apart along it, less 2 r.

    Args:
        curve: The centreline, or a fit of it.
        radius: Of the tube [mm].

    Returns:
        The gap [mm], negative where the tube cuts into itself; None where no two points are so far apart, and where
        the curve bends more tightly than the tube allows (kappa r >= 1) or than four million samples of it could tell:
        such a tube is refused for its bends, and its gap says nothing.

    Accuracy: to rounding where critical pairs are isolated or run in families of one distance; never more than 0.1 %
    of the distance too large (`TOLERANCE`).
    """
    if not is_measurable(curve.length, curve.greatest_curvature()[0], radius):
        return None
    return float(self_gaps(_OneCurve(curve), np.array([radius]))[0])


def is_measurable(length: Any, kappa: Any, radius: Any) -> Any:
    """Whether a curve of this length and greatest curvature has a self-gap, see `self_gap`; or curves, in arrays."""
    return (length > math.pi * radius) & (kappa * radius < 1.0) & (_PER_RADIAN * kappa * length <= _MOST_SAMPLES)


def samples_of(length: float, kappa: float) -> int:
    """How many samples of its curvature a curve needs."""
    return max(_LEAST_SAMPLES, math.ceil(_PER_RADIAN * kappa * length))


def self_gaps(curves: Curves, radii: Array) -> Array:
    """`self_gap` of many curves, every one of which `is_measurable`, shape (curves,)."""
    search = _Search(curves, math.pi * radii, _TOUCHING * radii)
    search.run()
    gaps: Array = search.distance - 2.0 * radii
    return gaps


class _Cells(NamedTuple):
    """Cells of one size, by the numbers of their intervals of s and t out of 0 to parts - 1, shape (n,), s the later.

    Interval -1 is the curve's start alone, interval `parts` its end alone.
    """

    parts: int
    curve: Indices
    s: Indices
    t: Indices

    def halved(self) -> _Cells:
        """The same pairs in cells half as wide; an end stays itself."""
        s, t = 2 * self.s, np.where(self.t < 0, -1, 2 * self.t)
        s_wide, t_wide = self.s < self.parts, self.t >= 0
        both = s_wide & t_wide
        return _Cells(
            2 * self.parts,
            np.concatenate([self.curve, self.curve[s_wide], self.curve[t_wide], self.curve[both]]),
            np.concatenate([s, s[s_wide] + 1, s[t_wide], s[both] + 1]),
            np.concatenate([t, t[s_wide], t[t_wide] + 1, t[both] + 1]),
        )

    def taken(self, which: Indices | Mask | slice) -> _Cells:
        """Some of the cells."""
        return _Cells(self.parts, self.curve[which], self.s[which], self.t[which])


class _Pairs(NamedTuple):
    """The centres of cells: arclengths, distance, and what no critical distance in the cell is below, shape (n,)."""

    curve: Indices
    s: Array
    t: Array
    distance: Array
    least: Array

    def taken(self, which: Indices | Mask) -> _Pairs:
        """Some of the pairs."""
        return _Pairs(self.curve[which], self.s[which], self.t[which], self.distance[which], self.least[which])


class _Search:
    """Branch and bound for the least critical distances of pairs at least `apart` along their curve.

    Attributes:
        distance: The least one known of each curve; after `run`, the answers.
    """

    def __init__(self, curves: Curves, apart: Array, touching: Array) -> None:
        self.curves, self.apart = curves, apart
        count = len(curves.lengths)
        each = np.arange(count)
        ends = curves.states(np.tile(each, 2), np.concatenate([np.zeros(count), curves.lengths]))[0]
        chord = ends[:, count:] - ends[:, :count]
        self.distance = np.sqrt(_dot(chord, chord))
        reach = np.abs(ends).max(axis=0)
        self.rounding = 1e-14 * (curves.lengths + np.maximum(reach[:count], reach[count:]))
        self.touching = np.maximum(touching, self.rounding)

    @property
    def enough(self) -> Array:
        """No critical distance above this need be looked for, shape (curves,)."""
        least: Array = self.distance - np.maximum(TOLERANCE * self.distance, self.touching)
        return least

    def run(self) -> None:
        """Bring `distance` down to the answers."""
        parts, count = _FIRST_INTERVALS, len(self.distance)
        s, t = np.tril_indices(parts)
        each, one = np.arange(parts), np.ones(parts, dtype=np.intp)
        s, t = np.concatenate([s, parts * one, each]), np.concatenate([t, each, -one])
        first = _Cells(parts, np.repeat(np.arange(count), len(s)), np.tile(s, count), np.tile(t, count))
        stack = [first.taken(slice(begin, begin + _BATCH)) for begin in range(0, len(first.s), _BATCH)]
        passed: list[_Pairs] = []
        while stack:
            cells, pairs = self._critical(stack.pop())
            many = np.bincount(pairs.curve, minlength=count)
            before = self.enough
            self._approach(pairs, self.curves.lengths / cells.parts, starts=_STARTS)
            # Beside the critical pair that was found just now its cell may hold another: that takes one more halving.
            enough = np.maximum(self.enough, np.minimum(before, self.distance))
            here = pairs.curve
            # From all of a few Newton's method has begun already.
            over = (many > _STARTS)[here] & (pairs.least >= enough[here]) & (pairs.least < self.distance[here])
            passed.append(_lowest(pairs.taken(over), _LAST_STARTS))
            cells = cells.taken(pairs.least < enough[here]).halved()
            stack += [cells.taken(slice(begin, begin + _BATCH)) for begin in range(0, len(cells.s), _BATCH)]
        # What was passed over within the tolerance is most of all a family of one distance; the exact least is found
        # from the lowest of it.
        last = _Pairs(*map(np.concatenate, zip(*passed, strict=True)))
        self._approach(last, np.full(count, math.inf), starts=_LAST_STARTS)

    def _critical(self, cells: _Cells) -> tuple[_Cells, _Pairs]:
        """The cells that may hold a critical pair nearer than the known ones, and their centres."""
        count = len(cells.s)
        # Numbers from -1 to parts, of each curve.
        keys = np.concatenate([cells.s, cells.t]) + np.tile(cells.curve * (cells.parts + 2) + 1, 2)
        keys, where = _distinct(keys, len(self.distance) * (cells.parts + 2))
        curve, numbers = np.divmod(keys, cells.parts + 2)
        numbers -= 1
        lengths = self.curves.lengths[curve]
        width = lengths / cells.parts
        at = np.minimum(np.maximum((numbers + 0.5) * width, 0.0), lengths)
        half = np.where((numbers >= 0) & (numbers < cells.parts), width / 2.0, 0.0)
        position, tangent, _ = self.curves.states(curve, at)
        bends = self.curves.bends
        low, high = at - half, at + half
        bend = bends.greatest(curve, low, high)
        begun, ended = bends.turning(curve, low), bends.turning(curve, high)

        i, j = where[:count], where[count:]
        far = high[i] - low[j] >= self.apart[cells.curve]
        far &= ended[i] - begun[j] >= math.pi / 2.0
        cells, i, j = cells.taken(far), i[far], j[far]

        chord = position[:, i] - position[:, j]
        distance = np.sqrt(_dot(chord, chord))
        rounding = self.rounding[cells.curve]
        reach = half[i] + half[j]
        nearest = np.maximum(distance - reach, 0.0)
        growth = reach**2 / np.maximum(nearest, rounding) + bend[i] * half[i] ** 2 + bend[j] * half[j] ** 2
        pairs = _Pairs(cells.curve, at[i], at[j], distance, np.maximum(nearest, distance - growth / 2.0))
        near = np.flatnonzero(pairs.least < self.distance[cells.curve])
        cells, pairs, i, j, chord = cells.taken(near), pairs.taken(near), i[near], j[near], chord[:, near]

        distance, reach = pairs.distance, reach[near]
        apex = np.maximum(distance, np.maximum(reach, rounding[near]))
        swing = np.where(reach < distance, np.arcsin(reach / apex), math.pi)
        facing = np.ones(len(i), dtype=bool)
        for k in (i, j):
            lean = np.arcsin(np.minimum(np.abs(_dot(chord, tangent[:, k])) / (apex * (1.0 + 1e-15)), 1.0))
            facing &= (lean <= swing + bend[k] * half[k]) | (half[k] == 0.0)
        return cells.taken(facing), pairs.taken(facing)

    def _approach(self, pairs: _Pairs, width: Array, *, starts: int) -> None:
        """Lower `distance` from the lowest of the pairs: by Newton's method, or as they are in cells small enough."""
        pairs = _lowest(pairs.taken(pairs.least < (self.distance - self.rounding)[pairs.curve]), starts)
        if not len(pairs.s):
            return
        # Small beside its own distance: a cell that is wide for what lies in it may face nothing.
        small = 2.0 * width[pairs.curve] <= np.maximum(TOLERANCE * pairs.distance, self.touching[pairs.curve])
        curve, found = self._newton(pairs.curve, pairs.s, pairs.t, width)
        np.minimum.at(self.distance, pairs.curve[small], pairs.distance[small])
        np.minimum.at(self.distance, curve, found)

    def _newton(self, curve: Indices, s: Array, t: Array, width: Array) -> tuple[Indices, Array]:
        """The distances of critical pairs that Newton's method finds; a pair at an end of the curve stays there.

        With the chord c from t to s, f = c . T(s) and g = c . T(t) are to vanish. The steps are those of damped least
        squares, for stretches that run parallel make the system singular; elsewhere the damping is not felt.
        """
        found = [(curve[:0], s[:0])]
        for step in range(_NEWTON_STEPS + 1):
            half, lengths, widest = len(s), self.curves.lengths[curve], width[curve]
            s_fixed, t_fixed = s >= lengths, t <= 0.0
            position, tangent, turning = self.curves.states(np.tile(curve, 2), np.concatenate([s, t]))
            t_s, t_t = tangent[:, :half], tangent[:, half:]
            chord = position[:, :half] - position[:, half:]
            f, g = np.where(s_fixed, 0.0, _dot(chord, t_s)), np.where(t_fixed, 0.0, _dot(chord, t_t))
            distance = np.sqrt(_dot(chord, chord))
            normal = np.maximum(np.abs(f), np.abs(g)) <= _NORMAL * distance + self.rounding[curve]
            good = normal & (s - t >= self.apart[curve] * (1.0 - 1e-12))
            found.append((curve[good], distance[good]))
            if step == _NEWTON_STEPS or normal.all():
                break
            cosine = _dot(t_s, t_t)
            f_s, f_t = 1.0 + _dot(chord, turning[:, :half]), np.where(s_fixed, 0.0, -cosine)
            g_s, g_t = np.where(t_fixed, 0.0, cosine), _dot(chord, turning[:, half:]) - 1.0
            size = f_s**2 + g_s**2 + f_t**2 + g_t**2
            determinant, damping = f_s * g_t - f_t * g_s, 1e-16 * size
            scale = determinant**2 + damping * size
            ds = (determinant * (g_t * f - f_t * g) + damping * (f_s * f + g_s * g)) / scale
            dt = (determinant * (f_s * g - g_s * f) + damping * (f_t * f + g_t * g)) / scale
            # What is predicted to lead to more than is known already is left to the cells.
            farther = distance**2 - (f * ds - g * dt) > self.distance[curve] ** 2
            going = ~(normal | (farther & (np.maximum(np.abs(ds), np.abs(dt)) <= widest)))
            if not going.any():
                break
            s, t = (
                np.where(fixed, at, _between(at - _between(way, -widest, widest), 0.0, lengths))[going]
                for fixed, at, way in ((s_fixed, s, ds), (t_fixed, t, dt))
            )
            curve = curve[going]
        curves, distances = zip(*found, strict=True)
        return np.concatenate(curves), np.concatenate(distances)


class _OneCurve:
    """A single curve as the search takes many."""

    def __init__(self, curve: Curve) -> None:
        self._curve = curve
        self.lengths = np.array([curve.length])
        self.bends = _SampledBends(curve)

    def states(self, _curve: Indices, s: Array) -> tuple[Array, Array, Array]:
        """Positions, tangents and curvature vectors."""
        frames, bend = self._curve.states(s)
        turning = bend[:, :1] * frames.normal + bend[:, 1:] * frames.binormal
        return frames.position.T, frames.tangent.T, turning.T


class _SampledBends:
    """Bounds from samples and a margin, of a curve whose curvature may jump at its breaks."""

    def __init__(self, curve: Curve) -> None:
        greatest = curve.greatest_curvature()[0]
        samples = samples_of(curve.length, greatest)
        edges, bounds = [np.zeros(1)], []
        for begin, end in pairwise(curve.breaks):
            at = np.linspace(begin, end, 2 + math.ceil(samples * (end - begin) / curve.length))
            kappa = np.linalg.norm(curve.bishop(at)[0], axis=1)
            kappa[-1] = np.linalg.norm(curve.bishop(end, side="left")[0])
            # A curvature that changes over its own bend radius changes by an eighth from sample to sample.
            higher = np.maximum(kappa[1:], kappa[:-1])
            bounds.append(np.minimum(1.15 * higher + 0.02 * greatest, 1.01 * greatest))
            edges.append(at[1:])
        self.edges, self.bounds = np.concatenate(edges), np.concatenate(bounds)
        self.turned = np.concatenate([[0.0], np.cumsum(self.bounds * np.diff(self.edges))])

    def greatest(self, _curve: Indices, begin: Array, end: Array) -> Array:
        """A bound on the curvature between `begin` and `end`, shape (n,) each."""
        first = np.searchsorted(self.edges, begin, side="right") - 1
        last = np.searchsorted(self.edges, end, side="left")
        return greatest_between(self.bounds, first, last, np.zeros_like(first), len(self.bounds))

    def turning(self, _curve: Indices, s: Array) -> Array:
        """The angle the tangent has turned through from the start to `s`; its differences are bounds [rad]."""
        angle: Array = np.interp(s, self.edges, self.turned)
        return angle


def greatest_between(bounds: Array, first: Indices, last: Indices, offset: Indices, count: int) -> Array:
    """The greatest of `bounds[offset + first : offset + last]`, at least one of each `count`, shape (n,)."""
    first = np.minimum(np.maximum(first, 0), count - 1)
    last = np.minimum(np.maximum(last, first + 1), count)
    padded = np.append(bounds, 0.0)
    pairs = np.stack([offset + first, offset + last], axis=1).ravel()
    found: Array = np.maximum.reduceat(padded, pairs)[::2]
    return found


def _distinct(keys: Indices, count: int) -> tuple[Indices, Indices]:
    """`np.unique` with the inverse, of numbers below `count`; without sorting where there are not many more of them."""
    if count > 8 * len(keys):
        return np.unique(keys, return_inverse=True)
    there = np.zeros(count, dtype=bool)
    there[keys] = True
    return np.flatnonzero(there), (np.cumsum(there) - 1)[keys]


def _lowest(pairs: _Pairs, count: int) -> _Pairs:
    """As many of each curve, those that may hold its least distances."""
    if len(pairs.s) <= count:
        return pairs
    # Next to a crossing many cells may hold a distance of zero; it is in the nearest.
    order = np.lexsort((pairs.least + 0.01 * pairs.distance, pairs.curve))
    curve = pairs.curve[order]
    rank = np.arange(len(order)) - np.searchsorted(curve, curve, side="left")
    return pairs.taken(order[rank < count])


def _between(values: Array, least: Array | float, most: Array | float) -> Array:
    """`np.clip` at a tenth of its cost for a few values."""
    clipped: Array = np.minimum(np.maximum(values, least), most)
    return clipped


def _dot(a: Array, b: Array) -> Array:
    """Scalar products, of shapes (dimensions, n); at a third of the cost of `np.einsum` for so few dimensions."""
    total: Array = a[0] * b[0]
    for one, other in zip(a[1:], b[1:], strict=True):
        total += one * other
    return total
