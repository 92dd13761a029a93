"""The self-gap of a tube: how much room is left where it passes by itself.

Two points of the centreline face each other where the distance D between them is critical: the chord between them is
normal to the tangent at both, or meets it at an end of the centreline, where any angle will do. Pairs nearer than pi r
along the centreline belong to one bend, which the condition kappa r < 1 judges. The self-gap is the least such D less
2 r: below zero the tube cuts into itself.

The least critical pair is found by branch and bound. All pairs (s, t) are cut into cells, and a cell with half-widths
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
from typing import NamedTuple

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

_FIRST_INTERVALS = 16
"""Intervals of the centreline to begin with."""

_BATCH = 1 << 16
"""Cells handled at once, in 40 MB; the rest waits on a stack, so that memory stays bounded whatever the curve."""

_PER_RADIAN, _LEAST_SAMPLES = 8.0, 256
"""Samples of the curvature a radian of the tightest bend, and for the whole of a gentle curve."""

_MOST_SAMPLES = 4_000_000
"""More samples of the curvature than this are not taken: 100 MB, and a curve that no tube's spline could follow."""

_STARTS = 24
"""Cells from which Newton's method begins in one round: those that may hold the least distances."""

_NEWTON_PARTS, _MANY = 64, 256
"""Newton's method waits for cells of this size: most of the larger ones hold no critical pair and are left out by the
next halving. So many of them are not halved without a smaller distance known."""

_NEWTON_STEPS = 8
"""Quadratic convergence from a cell takes 3 to 5; where that fails, smaller cells come up in the next round."""

_NORMAL = 1e-10
"""Cosine of chord and tangent below which the chord is normal: the distance is off by this share, at most, of the way
to the pair that is critical to the last digit."""


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
    apart = math.pi * radius
    kappa = curve.greatest_curvature()[0]
    if curve.length <= apart or kappa * radius >= 1.0 or _PER_RADIAN * kappa * curve.length > _MOST_SAMPLES:
        return None
    search = _Search(curve, apart, _TOUCHING * radius)
    search.run()
    return search.distance - 2.0 * radius


class _Cells(NamedTuple):
    """Cells of one size, by the numbers of their intervals of s and t out of 0 to parts - 1, shape (n,), s the later.

    Interval -1 is the curve's start alone, interval `parts` its end alone.
    """

    parts: int
    s: Indices
    t: Indices

    def halved(self) -> _Cells:
        """The same pairs in cells half as wide; an end stays itself."""
        s, t = 2 * self.s, np.where(self.t < 0, -1, 2 * self.t)
        s_wide, t_wide = self.s < self.parts, self.t >= 0
        both = s_wide & t_wide
        return _Cells(
            2 * self.parts,
            np.concatenate([s, s[s_wide] + 1, s[t_wide], s[both] + 1]),
            np.concatenate([t, t[s_wide], t[t_wide] + 1, t[both] + 1]),
        )

    def taken(self, which: Indices | Mask | slice) -> _Cells:
        """Some of the cells."""
        return _Cells(self.parts, self.s[which], self.t[which])


class _Pairs(NamedTuple):
    """The centres of cells: arclengths, distance, and what no critical distance in the cell is below, shape (n,)."""

    s: Array
    t: Array
    distance: Array
    least: Array

    def taken(self, which: Indices | Mask) -> _Pairs:
        """Some of the pairs."""
        return _Pairs(*(values[which] for values in self))


class _Search:
    """Branch and bound for the least critical distance of pairs at least `apart` along the curve [mm].

    Attributes:
        distance: The least one known; after `run`, the answer [mm].
    """

    def __init__(self, curve: Curve, apart: float, touching: float) -> None:
        self.curve, self.apart, self.bends = curve, apart, _Bends(curve)
        ends = curve.frames([0.0, curve.length]).position
        self.distance = float(np.linalg.norm(ends[1] - ends[0]))
        self.rounding = 1e-14 * (curve.length + float(np.abs(ends).max()))
        self.touching = max(touching, self.rounding)

    @property
    def enough(self) -> float:
        """No critical distance above this need be looked for [mm]."""
        return self.distance - max(TOLERANCE * self.distance, self.touching)

    def run(self) -> None:
        """Bring `distance` down to the answer."""
        parts = _FIRST_INTERVALS
        s, t = np.tril_indices(parts)
        each, one = np.arange(parts), np.ones(parts, dtype=np.intp)
        stack = [_Cells(parts, np.concatenate([s, parts * one, each]), np.concatenate([t, each, -one]))]
        passed = []
        while stack:
            cells, pairs = self._critical(stack.pop())
            approached = cells.parts >= _NEWTON_PARTS or len(cells.s) > _MANY
            if approached:
                self._approach(pairs, self.curve.length / cells.parts)
            if not approached or len(pairs.s) > _STARTS:  # else Newton's method began from all of them already
                passed.append(_lowest(pairs.taken((pairs.least >= self.enough) & (pairs.least < self.distance))))
            cells = cells.taken(pairs.least < self.enough).halved()
            stack += [cells.taken(slice(begin, begin + _BATCH)) for begin in range(0, len(cells.s), _BATCH)]
        # What was passed over within the tolerance is most of all a family of one distance; the exact least is found
        # from the lowest of it.
        if passed:
            self._approach(_Pairs(*map(np.concatenate, zip(*passed, strict=True))), math.inf)

    def _critical(self, cells: _Cells) -> tuple[_Cells, _Pairs]:
        """The cells that may hold a critical pair, and their centres."""
        width = self.curve.length / cells.parts
        numbers, where = np.unique(np.concatenate([cells.s, cells.t]), return_inverse=True)
        at = _between((numbers + 0.5) * width, 0.0, self.curve.length)
        half = np.where((numbers >= 0) & (numbers < cells.parts), width / 2.0, 0.0)
        position, tangent = self.curve.frames(at)[:2]
        bend = self.bends.greatest(at - half, at + half)
        begun, ended = self.bends.turning(at - half), self.bends.turning(at + half)

        i, j = where[: len(cells.s)], where[len(cells.s) :]
        far = (at[i] + half[i]) - (at[j] - half[j]) >= self.apart
        far &= ended[i] - begun[j] >= math.pi / 2.0
        cells, i, j = cells.taken(far), i[far], j[far]

        chord = position[i] - position[j]
        distance = np.sqrt(_dot(chord, chord))
        reach = half[i] + half[j]
        apex = np.maximum(distance, np.maximum(reach, self.rounding))
        swing = np.where(reach < distance, np.arcsin(reach / apex), math.pi)
        facing = np.ones(len(i), dtype=bool)
        for k in (i, j):
            lean = np.arcsin(np.abs(_dot(chord, tangent[k])) / (apex * (1.0 + 1e-15)))
            facing &= (lean <= swing + bend[k] * half[k]) | (half[k] == 0.0)
        nearest = np.maximum(distance - reach, 0.0)
        growth = reach**2 / np.maximum(nearest, self.rounding) + bend[i] * half[i] ** 2 + bend[j] * half[j] ** 2
        least = np.maximum(nearest, distance - growth / 2.0)
        pairs = _Pairs(at[i], at[j], distance, least)
        return cells.taken(facing), pairs.taken(facing)

    def _approach(self, pairs: _Pairs, width: float) -> None:
        """Lower `distance` from the lowest of the pairs: by Newton's method, or as they are in cells small enough."""
        pairs = _lowest(pairs.taken(pairs.least < self.distance))
        if not len(pairs.s):
            return
        if 2.0 * width <= self.distance - self.enough:
            self.distance = min(self.distance, float(pairs.distance.min()))
        self.distance = min(self.distance, *self._newton(pairs.s, pairs.t, width).tolist(), math.inf)

    def _newton(self, s: Array, t: Array, width: float) -> Array:
        """The distances of critical pairs that Newton's method finds; a pair at an end of the curve stays there.

        With the chord c from t to s, f = c . T(s) and g = c . T(t) are to vanish. The steps are those of damped least
        squares, for stretches that run parallel make the system singular; elsewhere the damping is not felt.
        """
        s_fixed, t_fixed, half = s >= self.curve.length, t <= 0.0, len(s)
        for step in range(_NEWTON_STEPS + 1):
            both = np.concatenate([s, t])
            frames, bend = self.curve.states(both)
            t_s, t_t = frames.tangent[:half], frames.tangent[half:]
            chord = frames.position[:half] - frames.position[half:]
            f, g = np.where(s_fixed, 0.0, _dot(chord, t_s)), np.where(t_fixed, 0.0, _dot(chord, t_t))
            distance = np.sqrt(_dot(chord, chord))
            normal = np.maximum(np.abs(f), np.abs(g)) <= _NORMAL * distance + self.rounding
            if step == _NEWTON_STEPS or normal.all():
                break
            turning = bend[:, :1] * frames.normal + bend[:, 1:] * frames.binormal
            bend_s, bend_t = turning[:half], turning[half:]
            cosine = _dot(t_s, t_t)
            f_s, f_t = 1.0 + _dot(chord, bend_s), np.where(s_fixed, 0.0, -cosine)
            g_s, g_t = np.where(t_fixed, 0.0, cosine), _dot(chord, bend_t) - 1.0
            size = f_s**2 + g_s**2 + f_t**2 + g_t**2
            determinant, damping = f_s * g_t - f_t * g_s, 1e-16 * size
            scale = determinant**2 + damping * size
            ds = (determinant * (g_t * f - f_t * g) + damping * (f_s * f + g_s * g)) / scale
            dt = (determinant * (f_s * g - g_s * f) + damping * (f_t * f + g_t * g)) / scale
            s, t = (
                np.where(fixed, at, _between(at - _between(step, -width, width), 0.0, self.curve.length))
                for fixed, at, step in ((s_fixed, s, ds), (t_fixed, t, dt))
            )
        found: Array = distance[normal & (s - t >= self.apart * (1.0 - 1e-12))]
        return found


class _Bends:
    """Bounds on the curvature of intervals and on the turning of the tangent, from samples and a margin."""

    def __init__(self, curve: Curve) -> None:
        greatest = curve.greatest_curvature()[0]
        samples = max(_LEAST_SAMPLES, math.ceil(_PER_RADIAN * greatest * curve.length))
        edges, bounds = [np.zeros(1)], []
        for begin, end in pairwise(curve.breaks):
            at = np.linspace(begin, end, 2 + math.ceil(samples * (end - begin) / curve.length))
            kappa = np.linalg.norm(curve.bishop(at)[0], axis=1)
            kappa[-1] = np.linalg.norm(curve.bishop(end, side="left")[0])
            # A curvature that changes over its own bend radius changes by an eighth from sample to sample.
            bounds.append(np.minimum(1.15 * np.maximum(kappa[1:], kappa[:-1]) + 0.02 * greatest, 1.01 * greatest))
            edges.append(at[1:])
        self.edges, self.bounds = np.concatenate(edges), np.concatenate(bounds)
        self.turned = np.concatenate([[0.0], np.cumsum(self.bounds * np.diff(self.edges))])

    def greatest(self, begin: Array, end: Array) -> Array:
        """A bound on the curvature between `begin` and `end`, shape (n,) each."""
        first = np.searchsorted(self.edges, begin, side="right") - 1
        last = np.searchsorted(self.edges, end, side="left")
        first = np.minimum(np.maximum(first, 0), len(self.bounds) - 1)
        last = np.minimum(np.maximum(last, first + 1), len(self.bounds))
        padded = np.append(self.bounds, 0.0)
        bound: Array = np.maximum.reduceat(padded, np.stack([first, last], axis=1).ravel())[::2]
        return bound

    def turning(self, s: Array) -> Array:
        """The angle the tangent has turned through from the start to `s`; its differences are bounds [rad]."""
        angle: Array = np.interp(s, self.edges, self.turned)
        return angle


def _lowest(pairs: _Pairs) -> _Pairs:
    """Those that may hold the least distances."""
    return pairs if len(pairs.least) <= _STARTS else pairs.taken(np.argpartition(pairs.least, _STARTS)[:_STARTS])


def _between(values: Array, least: float, most: float) -> Array:
    """`np.clip` at a tenth of its cost for a few values."""
    clipped: Array = np.minimum(np.maximum(values, least), most)
    return clipped


def _dot(a: Array, b: Array) -> Array:
    products: Array = np.einsum("ni,ni->n", a, b)
    return products
