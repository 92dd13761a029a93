"""Splines of odd degree through given points, as smooth as can be: interpolation and evaluation.

`scipy.interpolate` does the same, but loading it takes as long as a third of Open Cascade: more than all the rest of a
small build. tests/brep/test_bspline.py holds the two against each other.

The B-spline coefficients follow from the values at the knots and odd derivatives at either end. Their system is banded;
a long one is cut into blocks and eliminated block by block, without exchanges between blocks: the matrix of values is
totally positive. A spline is evaluated from its polynomials, one a span.

Arrays may have more axes in front: for many splines of as many spans each, in little more time than one of a few.

Source: L. Piegl, W. Tiller, The NURBS Book, 2nd ed., A2.2 and 3.3; C. de Boor, A Practical Guide to Splines, chapters X
and XIII.
"""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np

from cablecad.centreline import Array

_BLOCK = 64
"""Equations eliminated at once."""


def end_orders(degree: int) -> range:
    """The derivatives given at either end: 1, 3, 5, ... below the degree by two."""
    return range(1, degree - 1, 2)


class Knots:
    """Distinct knots, shape (..., spans + 1), increasing, of which the first and last count degree + 1 times."""

    def __init__(self, distinct: Array, degree: int) -> None:
        self.distinct, self.degree = distinct, degree
        self.spans = distinct.shape[-1] - 1

    @cached_property
    def steps(self) -> Array:
        """Lengths of the spans, shape (..., spans)."""
        steps: Array = self.distinct[..., 1:] - self.distinct[..., :-1]
        return steps

    @cached_property
    def near(self) -> Array:
        """The knots that count at each distinct one, degree on either side, shape (..., spans + 1, 2 degree).

        Those of a span in its left one's row; of the last knot, those of the span before it.
        """
        first = np.minimum(np.arange(self.spans + 1), self.spans - 1)
        place = first[:, None] + np.arange(1 - self.degree, self.degree + 1)
        return np.asarray(self.distinct[..., np.minimum(np.maximum(place, 0), self.spans)])

    @cached_property
    def bases(self) -> list[Array]:
        """The nonzero B-splines of degrees 0, 1, ... at each knot from its right, the last one's from its left.

        Of degree d, shape (..., spans + 1, d + 1).
        """
        x, near, degree = self.distinct[..., None], self.near, self.degree
        left, right = x - near[..., degree - 1 :: -1], near[..., degree:] - x
        bases = [np.ones(x.shape)]
        for r in range(1, degree + 1):
            ahead, behind = right[..., :r], left[..., r - 1 :: -1]
            share = bases[-1] / (ahead + behind)
            basis = np.zeros((*x.shape[:-1], r + 1))
            basis[..., :-1] = ahead * share
            basis[..., 1:] += behind * share
            bases.append(basis)
        return bases


class Spline:
    """A spline with simple inner knots.

    Attributes:
        knots: Of the spline.
        poles: B-spline coefficients, shape (..., spans + degree, columns).
    """

    def __init__(self, knots: Knots, poles: Array) -> None:
        self.knots, self.poles = knots, poles

    def __call__(self, x: Array, derivatives: int = 0) -> Array:
        """Derivatives 0..`derivatives` of one spline at `x` within its knots, shape (derivatives + 1, n, columns)."""
        distinct, last = self.knots.distinct, self.knots.spans - 1
        span = np.minimum(np.maximum(np.searchsorted(distinct, x, side="right") - 1, 0), last)
        steps = self.knots.steps[span]
        powers = powers_of((x - distinct[span]) / steps, self.knots.degree, derivatives)
        values: Array = np.einsum("dnk,nkc->dnc", powers, self.polynomials[span])
        for order in range(1, derivatives + 1):
            values[order] /= (steps**order)[:, None]
        return values

    def sampled(self, powers: Array, spans: slice = slice(None)) -> Array:
        """Derivatives at the same shares of every span, in order of the span.

        Args:
            powers: Of the shares, by `powers_of`.
            spans: Which of them.

        Returns:
            Shape (derivatives + 1, ..., spans times samples, columns).
        """
        derivatives, *front, columns = len(powers) - 1, *self.poles.shape[:-2], self.poles.shape[-1]
        each = powers.reshape(derivatives + 1, *[1] * (len(front) + 1), *powers.shape[1:])
        values: Array = np.matmul(each, self.polynomials[..., spans, :, :])
        for order in range(1, derivatives + 1):
            values[order] /= self.knots.steps[..., spans, None, None] ** order
        flat: Array = values.reshape(derivatives + 1, *front, -1, columns)
        return flat

    @cached_property
    def polynomials(self) -> Array:
        """Coefficients by powers of the share of a span, shape (..., spans, degree + 1, columns)."""
        knots, degree = self.knots, self.knots.degree
        near, steps = knots.near[..., :-1, :], knots.steps[..., None]
        # The poles that count in each span, then those of its derivatives over k!, as steps over the span.
        control: Array = self.poles[..., np.arange(knots.spans)[:, None] + np.arange(degree + 1), :]
        found = np.empty(control.shape)
        for k in range(degree + 1):
            if k:
                width = near[..., degree : 2 * degree - k + 1] - near[..., k - 1 : degree]
                ratio = (degree + 1 - k) / k * steps / width
                control = (control[..., 1:, :] - control[..., :-1, :]) * ratio[..., None]
            found[..., k, :] = (knots.bases[degree - k][..., :-1, None, :] @ control)[..., 0, :]
        return found

    def one(self, i: int) -> Spline:
        """One of many, with the polynomials that all have found."""
        spline = Spline(Knots(self.knots.distinct[i], self.knots.degree), self.poles[i])
        spline.__dict__["polynomials"] = self.polynomials[i]
        return spline


def powers_of(shares: Array, degree: int, derivatives: int) -> Array:
    """What the coefficients of a polynomial count in its derivatives at shares of a span, shape (n,).

    Returns:
        Shape (derivatives + 1, n, degree + 1).
    """
    powers = np.zeros((derivatives + 1, len(shares), degree + 1))
    powers[0] = np.vander(shares, degree + 1, increasing=True)
    for order in range(1, derivatives + 1):
        falling = [math.perm(k, order) for k in range(order, degree + 1)]
        powers[order, :, order:] = powers[0, :, : degree + 1 - order] * falling
    return powers


def interpolate(distinct: Array, degree: int, values: Array, start: Array, end: Array) -> Spline:
    """The spline through values at its knots, with the derivatives `end_orders` given at either end.

    Args:
        distinct: The knots, shape (..., spans + 1), increasing.
        degree: Odd, 3 at least.
        values: Shape (..., spans + 1, columns).
        start: Derivatives at the first knot, shape (..., orders, columns).
        end: Those at the last.
    """
    knots, half = Knots(distinct, degree), (degree + 1) // 2
    front, count = distinct.shape[:-1], knots.spans + degree
    rows = np.zeros((*front, count, degree + 1))
    right = np.empty((*front, count, values.shape[-1]))
    rows[..., 0, 0] = rows[..., -1, -1] = 1.0
    at_start, at_end = _end_rows(knots)
    rows[..., 1:half, :], rows[..., -half:-1, :] = at_start, -at_end[..., ::-1, ::-1]
    rows[..., half:-half, :] = knots.bases[degree][..., 1:-1, :]
    first = np.zeros(count, dtype=int)
    first[half:-half] = np.arange(1, knots.spans)
    first[-half:] = knots.spans - 1
    # From the first value on: what all values share would be rounded many times, and comes back to the last digit.
    origin = values[..., :1, :]
    right[..., 0, :], right[..., -1:, :] = 0.0, values[..., -1:, :] - origin
    right[..., 1:half, :], right[..., -half:-1, :] = start, end[..., ::-1, :]
    right[..., half:-half, :] = values[..., 1:-1, :] - origin
    # Rows of one size: those of high derivatives would be taken for the weightiest of all.
    sizes = np.abs(rows).max(axis=-1, keepdims=True)
    poles = origin + _solve(first, rows / sizes, right / sizes)
    poles[..., [0, -1], :] = values[..., [0, -1], :]  # to the last digit: pieces meet there
    return Spline(knots, poles)


def _end_rows(knots: Knots) -> Array:
    """Coefficients of the poles near an end in the derivatives given there, shape (2, ..., orders, degree + 1).

    At the first knot of the first poles; at the last knot of the last poles, which is the same mirrored: the last pole
    comes first, and odd derivatives change their sign.
    """
    degree = knots.degree
    near = np.stack([knots.near[..., 0, :], -knots.near[..., -1, ::-1]])
    control = np.broadcast_to(np.eye(degree + 1), (*near.shape[:-1], degree + 1, degree + 1))
    rows, orders = [], end_orders(degree)
    for k in range(1, orders[-1] + 1):
        width = near[..., degree : 2 * degree - k + 1] - near[..., k - 1 : degree]
        control = (control[..., 1:, :] - control[..., :-1, :]) * ((degree + 1 - k) / width)[..., None]
        if k in orders:
            rows.append(control[..., 0, :])
    return np.stack(rows, axis=-2)


def _solve(first: np.ndarray, rows: Array, right: Array) -> Array:
    """Solve banded systems: row i has `rows[..., i, :]` from column `first[i]` on."""
    *front, count, width = rows.shape
    if count <= 2 * _BLOCK:
        matrix = np.zeros((*front, count, count))
        matrix[..., np.arange(count)[:, None], first[:, None] + np.arange(width)] = rows
        return np.asarray(np.linalg.solve(matrix, right), dtype=float)
    if front:
        return np.stack([_solve(first, *system) for system in zip(rows, right, strict=True)])
    blocks = -(-count // _BLOCK)
    number, place = np.divmod(np.arange(count), _BLOCK)
    system = np.zeros((blocks, _BLOCK, 3 * _BLOCK))
    columns = first[:, None] + np.arange(rows.shape[1]) - (number[:, None] - 1) * _BLOCK
    system[number[:, None], place[:, None], columns] = rows
    padded = np.zeros((blocks * _BLOCK, right.shape[1]))
    padded[:count] = right
    rest = np.arange(count, blocks * _BLOCK) - (blocks - 1) * _BLOCK
    system[-1, rest, _BLOCK + rest] = 1.0
    above: Array = np.zeros((_BLOCK, _BLOCK))
    solved: Array = np.zeros((_BLOCK, right.shape[1]))
    uppers, parts = [], []
    for block, own in zip(system, padded.reshape(blocks, _BLOCK, -1), strict=True):
        lower, middle, upper = np.split(block, 3, axis=1)
        both = np.asarray(
            np.linalg.solve(middle - lower @ above, np.hstack([upper, own - lower @ solved])), dtype=float
        )
        above, solved = both[:, :_BLOCK], both[:, _BLOCK:]
        uppers.append(above)
        parts.append(solved)
    for i in reversed(range(blocks - 1)):
        parts[i] = parts[i] - uppers[i] @ parts[i + 1]
    return np.concatenate(parts)[:count]
