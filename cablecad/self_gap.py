"""The self-gap of a tube: how much room is left where it passes by itself.

Two points of the centreline face each other where the distance between them is critical: the chord between them is
normal to the tangent at both, or meets it at an end of the centreline. Pairs nearer than pi r along the centreline
belong to one bend, which the condition kappa r < 1 judges. The self-gap is the least such distance less 2 r: below
zero the tube cuts into itself.

With f = (r(s) - r(t)) . T(s) and g = (r(s) - r(t)) . T(t) the critical pairs are the common zeros of f and g. They
are looked for on a grid fine against the curvature, in every cell where both change sign or where the distance has a
local minimum, and refined by Newton; the distance is also taken at the ends. A pair that is missed would need two
zeros of f or g inside one cell, a hundredth of the least bend's length.

Source: the doubly critical self-distance of R. A. Litherland, J. Simon, O. Durumeric, E. Rawdon, Thickness of knots,
Topology Appl. 91 (1999) 233-244.
"""

from __future__ import annotations

import math

import numpy as np

from cablecad.centreline import Array, Curve

_PER_RADIAN = 12.0
"""Grid points a radian of turning: cells of 5 degrees."""

_LEAST, _MOST = 48, 1500
"""Grid points of the gentlest curve and of the longest: 1500 take 30 MB and about 0.1 s."""

_NEWTON_STEPS = 12
"""Quadratic convergence from a cell takes 4 to 6; the rest is for tangential contacts, which converge slowly."""


def self_gap(curve: Curve, radius: float) -> float | None:
    """The least critical distance between two points of a curve at least pi r apart along it, less 2 r.

    Args:
        curve: The centreline, or a fit of it.
        radius: Of the tube [mm].

    Returns:
        The gap [mm], negative where the tube cuts into itself; None where no two points face each other.

    Accuracy: to rounding at the pairs found; that none is missed is a matter of the grid (see the module).
    """
    apart = math.pi * radius
    if curve.length <= apart:
        return None
    grid = _grid(curve)
    s, t = _candidates(curve, grid, apart)
    s, t = _refine(curve, s, t, float(np.diff(grid).max()))
    a, b = curve.frames(s), curve.frames(t)
    chord = a.position - b.position
    distance = np.linalg.norm(chord, axis=1)
    end = 1e-9 * curve.length
    facing_s = (np.abs(_dot(chord, a.tangent)) <= 1e-6 * distance + 1e-12 * curve.length) | _at_end(s, curve, end)
    facing_t = (np.abs(_dot(chord, b.tangent)) <= 1e-6 * distance + 1e-12 * curve.length) | _at_end(t, curve, end)
    valid = facing_s & facing_t & (np.abs(s - t) >= apart * (1.0 - 1e-12))
    if not valid.any():
        return None
    return float(distance[valid].min()) - 2.0 * radius


def _dot(a: Array, b: Array) -> Array:
    return np.einsum("ni,ni->n", a, b)


def _at_end(s: Array, curve: Curve, room: float) -> Array:
    return (s <= room) | (s >= curve.length - room)


def _grid(curve: Curve) -> Array:
    """Arclengths with steps short against the bend radius, the breaks among them."""
    rough = np.unique(np.concatenate([np.linspace(0.0, curve.length, 129), curve.breaks]))
    kappa = np.linalg.norm(curve.bishop(rough)[0], axis=1)
    density = np.maximum(_PER_RADIAN * kappa, _LEAST / curve.length)
    density = np.maximum(density, 0.25 * density.max())  # a gentle stretch may still pass close by a tight one
    count = np.concatenate([[0.0], np.cumsum((density[1:] + density[:-1]) / 2.0 * np.diff(rough))])
    points = int(min(max(_LEAST, math.ceil(count[-1])), _MOST))
    even = np.interp(np.linspace(0.0, count[-1], points + 1), count, rough)
    return np.unique(np.concatenate([even, curve.breaks]))


def _candidates(curve: Curve, grid: Array, apart: float) -> tuple[Array, Array]:
    """Pairs s > t from which Newton may reach every critical pair."""
    at = curve.frames(grid)
    position = at.position - at.position.mean(axis=0)  # far from the origin the differences would lose digits
    along = np.einsum("ni,ni->n", position, at.tangent)
    cross = at.tangent @ position.T  # cross[i, j] = T_i . r_j
    f = along[:, None] - cross  # (r_i - r_j) . T_i
    g = cross.T - along[None, :]  # (r_i - r_j) . T_j
    squared = np.einsum("ni,ni->n", position, position)
    square = squared[:, None] + squared[None, :] - 2.0 * position @ position.T
    far = grid[1:, None] - grid[None, :-1] >= apart  # cells with a corner far enough apart
    both = far & _changes_sign(f) & _changes_sign(g)
    i, j = np.nonzero(both)
    s, t = (grid[i] + grid[i + 1]) / 2.0, (grid[j] + grid[j + 1]) / 2.0
    least = _local_minima(square) & (grid[:, None] - grid[None, :] >= apart)
    k, m = np.nonzero(least)
    ends_s, ends_t = [np.array([curve.length])], [np.array([0.0])]
    # One point at an end: where the other's tangent is normal to the chord.
    for row, end in ((g[-1], curve.length), (f[:, 0], 0.0)):
        turn = np.nonzero(row[1:] * row[:-1] <= 0.0)[0]
        inner = (grid[turn] + grid[turn + 1]) / 2.0
        outer = np.full(len(turn), end)
        ends_s.append(np.maximum(inner, outer))
        ends_t.append(np.minimum(inner, outer))
    return np.concatenate([s, grid[k], *ends_s]), np.concatenate([t, grid[m], *ends_t])


def _changes_sign(values: Array) -> Array:
    """For each cell of a grid, whether `values` at its corners are not all of one sign."""
    corners = np.stack([values[1:, 1:], values[1:, :-1], values[:-1, 1:], values[:-1, :-1]])
    return (corners.max(axis=0) >= 0.0) & (corners.min(axis=0) <= 0.0)


def _local_minima(square: Array) -> Array:
    """Grid points at which the distance is not greater than at their four neighbours."""
    padded = np.pad(square, 1, constant_values=np.inf)
    inner = padded[1:-1, 1:-1]
    neighbours = (padded[2:, 1:-1], padded[:-2, 1:-1], padded[1:-1, 2:], padded[1:-1, :-2])
    return np.all([inner <= other for other in neighbours], axis=0)


def _refine(curve: Curve, s: Array, t: Array, cell: float) -> tuple[Array, Array]:
    """Newton on f = g = 0 with both points kept on the curve; a coordinate at an end stays there while it pushes out."""
    length = curve.length
    for _ in range(_NEWTON_STEPS):
        a, b = curve.frames(s), curve.frames(t)
        ka, kb = curve.bishop(s)[0], curve.bishop(t)[0]
        chord = a.position - b.position
        f, g = _dot(chord, a.tangent), _dot(chord, b.tangent)
        bend_a = ka[:, :1] * a.normal + ka[:, 1:] * a.binormal
        bend_b = kb[:, :1] * b.normal + kb[:, 1:] * b.binormal
        cosine = _dot(a.tangent, b.tangent)
        f_s, f_t, g_s, g_t = 1.0 + _dot(chord, bend_a), -cosine, cosine, _dot(chord, bend_b) - 1.0
        fixed_s, fixed_t = _at_end(s, curve, 0.0), _at_end(t, curve, 0.0)
        f, f_s, f_t = np.where(fixed_s, 0.0, f), np.where(fixed_s, 1.0, f_s), np.where(fixed_s, 0.0, f_t)
        g, g_s, g_t = np.where(fixed_t, 0.0, g), np.where(fixed_t, 0.0, g_s), np.where(fixed_t, 1.0, g_t)
        # Least squares with a hair of damping: facing parallel stretches make the system singular.
        aa, ab, bb = f_s**2 + g_s**2 + 1e-14, f_s * f_t + g_s * g_t, f_t**2 + g_t**2 + 1e-14
        ra, rb = f_s * f + g_s * g, f_t * f + g_t * g
        determinant = aa * bb - ab * ab
        ds, dt = -(bb * ra - ab * rb) / determinant, -(aa * rb - ab * ra) / determinant
        s = np.clip(s + np.clip(ds, -cell, cell), 0.0, length)
        t = np.clip(t + np.clip(dt, -cell, cell), 0.0, length)
    return s, t
