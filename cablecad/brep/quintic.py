"""C4 quintic splines through given points: interpolation and evaluation.

`scipy.interpolate` does the same, but loading it takes as long as a third of Open Cascade: more than all the rest of a
small build. tests/brep/test_quintic.py holds the two against each other.

The B-spline coefficients follow from the values at the knots and two derivatives at either end. Their system has three
diagonals to either side; it is cut into blocks and eliminated block by block, without exchanges between blocks: the
matrix of values is totally positive. A spline is evaluated from the Taylor coefficients at the left knot of each span.

Source: L. Piegl, W. Tiller, The NURBS Book, 2nd ed., A2.2 and 3.3; C. de Boor, A Practical Guide to Splines, chapters X
and XIII.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cablecad.centreline import Array

DEGREE = 5

_BLOCK = 64
"""Equations eliminated at once."""


@dataclass(frozen=True)
class QuinticSpline:
    """A spline of degree five with simple inner knots.

    Attributes:
        knots: Distinct knots, shape (spans + 1,), increasing; the first and last count six times.
        poles: B-spline coefficients, shape (spans + 5, columns).
    """

    knots: Array
    poles: Array

    def __call__(self, x: Array, derivative: int = 0) -> Array:
        """Values, or a derivative, at `x` within the knots, shape (n, columns)."""
        span = np.minimum(np.maximum(np.searchsorted(self.knots, x, side="right") - 1, 0), len(self.knots) - 2)
        ahead = (x - self.knots[span])[:, None]
        orders = range(derivative, DEGREE + 1)
        result = np.zeros((len(x), self.poles.shape[1]))
        for k in reversed(orders):
            result *= ahead
            result += (math.perm(k, derivative) * self._taylor[k])[span]
        return result

    @cached_property
    def _taylor(self) -> list[Array]:
        """Coefficients of order 0..5 at the left knot of each span, shape (spans, columns) each."""
        bases, control = _bases(self.knots), self.poles
        found = []
        for k in range(DEGREE + 1):
            if k:
                control = _derived(self.knots, control, k)
            window = np.lib.stride_tricks.sliding_window_view(control, DEGREE + 1 - k, axis=0)
            found.append(np.einsum("ni,nci->nc", bases[DEGREE - k][:-1], window) / math.factorial(k))
        return found


def interpolate(
    knots: Array, values: Array, orders: tuple[int, int], start: Sequence[Array], end: Sequence[Array]
) -> QuinticSpline:
    """The spline through values at its knots, with two derivatives given at either end.

    Args:
        knots: Shape (spans + 1,), increasing.
        values: Shape (spans + 1, columns).
        orders: Which derivatives, between 1 and 4, the lower first.
        start: Those at the first knot, shape (columns,) each.
        end: Those at the last.
    """
    spans = len(knots) - 1
    count = spans + DEGREE
    first = np.zeros(count, dtype=int)
    rows = np.zeros((count, DEGREE + 1))
    right = np.zeros((count, values.shape[1]))
    rows[0, 0] = rows[-1, -1] = 1.0
    first[-3:] = count - DEGREE - 1
    right[0], right[-1] = values[0], values[-1]
    if spans > 1:
        first[3:-3] = np.arange(1, spans)
        rows[3:-3] = _bases(knots)[DEGREE][1:-1]
        right[3:-3] = values[1:-1]
    wide = min(count, 2 * DEGREE)
    unit = np.eye(count, wide)
    mirrored = (knots[0] + knots[-1]) - knots[::-1]
    for i, order in enumerate(orders):
        rows[1 + i] = _end_row(knots, unit, order)
        rows[-2 - i] = (-1.0) ** order * _end_row(mirrored, unit, order)[::-1]
        right[1 + i], right[-2 - i] = start[i], end[i]
    poles = _solve(first, rows, right)
    poles[[0, -1]] = values[[0, -1]]  # to the last digit: pieces meet there
    return QuinticSpline(knots, poles)


def _end_row(knots: Array, unit: Array, order: int) -> Array:
    """Coefficients of the first six poles in a derivative at the first knot."""
    control = unit
    for k in range(1, order + 1):
        control = _derived(knots, control, k)
    return np.asarray(control[0, : DEGREE + 1])


def _derived(knots: Array, control: Array, k: int) -> Array:
    """The poles of the k-th derivative from those of the one before."""
    full = np.concatenate([np.full(DEGREE, knots[0]), knots, np.full(DEGREE, knots[-1])])
    count = len(control) - 1
    width = full[DEGREE + 1 : DEGREE + 1 + count] - full[k : k + count]
    poles: Array = (DEGREE + 1 - k) * np.diff(control, axis=0) / width[:, None]
    return poles


def _bases(knots: Array) -> list[Array]:
    """The nonzero B-splines of degrees 0..5 at each knot from its right, the last one's from its left.

    Returns:
        Of degree d, shape (spans + 1, d + 1).
    """
    full = np.concatenate([np.full(DEGREE, knots[0]), knots, np.full(DEGREE, knots[-1])])
    span = DEGREE + np.minimum(np.arange(len(knots)), len(knots) - 2)
    left = [knots - full[span + 1 - r] for r in range(DEGREE + 1)]
    right = [full[span + r] - knots for r in range(DEGREE + 1)]
    bases = [np.ones((len(knots), 1))]
    for r in range(1, DEGREE + 1):
        below, basis = bases[-1], np.zeros((len(knots), r + 1))
        for j in range(r):
            share = below[:, j] / (right[j + 1] + left[r - j])
            basis[:, j] += right[j + 1] * share
            basis[:, j + 1] += left[r - j] * share
        bases.append(basis)
    return bases


def _solve(first: np.ndarray, rows: Array, right: Array) -> Array:
    """Solve a banded system: row i has `rows[i]` from column `first[i]` on."""
    count = len(rows)
    blocks = -(-count // _BLOCK)
    size = min(count, _BLOCK)
    number, place = np.divmod(np.arange(count), size)
    system = np.zeros((blocks, size, 3 * size))
    columns = first[:, None] + np.arange(rows.shape[1]) - (number[:, None] - 1) * size
    np.add.at(system, (number[:, None], place[:, None], columns), rows)
    padded = np.zeros((blocks * size, right.shape[1]))
    padded[:count] = right
    rest = np.arange(count, blocks * size) - (blocks - 1) * size
    system[-1, rest, size + rest] = 1.0
    above: Array = np.zeros((size, size))
    solved: Array = np.zeros((size, right.shape[1]))
    uppers, parts = [], []
    for block, own in zip(system, padded.reshape(blocks, size, -1), strict=True):
        lower, middle, upper = block[:, :size], block[:, size : 2 * size], block[:, 2 * size :]
        both = np.asarray(
            np.linalg.solve(middle - lower @ above, np.hstack([upper, own - lower @ solved])), dtype=float
        )
        above, solved = both[:, :size], both[:, size:]
        uppers.append(above)
        parts.append(solved)
    for i in reversed(range(blocks - 1)):
        parts[i] = parts[i] - uppers[i] @ parts[i + 1]
    return np.concatenate(parts)[:count]
