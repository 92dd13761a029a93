"""A tube's centreline and frame as CAD gets them: lines, and splines that `fit` makes.

A spline has nine columns, (position, normal, binormal); times an exact rational circle it is the tube's side.

Nothing here needs Open Cascade.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate

import numpy as np
from numpy.typing import ArrayLike

from cablecad.brep.bspline import Spline, powers_of
from cablecad.brep.knots import DEGREE
from cablecad.centreline import Array, Frames, Line, Side, locate

_SHARES = np.linspace(0.0, 1.0, 17)
"""Where the curvature of a span is looked at first; its ends are shares of both spans that meet there."""

_CLOSER = np.linspace(-1.0, 1.0, 9)
"""Where it is looked at again, about the best so far, by steps to the best's neighbours; then by a quarter of these."""

_CLOSER_LOOKS = 4
"""Then nothing is left of what the first look may miss, 1e-3 of a curvature, but 1e-8."""

_RIVAL = 2e-3
"""Spans whose square of the curvature is less by this share may have the greatest."""

_FINE = np.linspace(0.0, 1.0, 129)
"""Where a side is looked at for folds."""

_BENDS_AT_SHARES = powers_of(_SHARES, DEGREE, 2)

_BLOCK = 512
"""Spans looked at at once: 2 MB."""


@dataclass(frozen=True)
class FittedPiece:
    """A C8 spline of degree nine over [0, 1] through position, normal and binormal of one piece.

    Attributes:
        length: Of the exact piece [mm]; the spline's parameter is arclength over length, up to the deviation.
        spline: Of nine columns: position [mm], normal and binormal.
        deviation: Greatest sampled distance between the tube's side and the exact one [mm].
        ends: Of the exact piece at both ends position [mm], tangent and normal, shape (2, 3, 3).
    """

    length: float
    spline: Spline
    deviation: float
    ends: Array

    @property
    def spans(self) -> int:
        """Number of polynomial spans."""
        return len(self.knots) - 1

    @property
    def knots(self) -> Array:
        """Distinct knots, shape (spans + 1,)."""
        return self.spline.knots.distinct

    @property
    def poles(self) -> Array:
        """Position [mm], normal and binormal, shape (spans + 9, 9)."""
        return self.spline.poles

    def evaluate(self, s: Array, derivatives: int = 0) -> Array:
        """The nine columns and their derivatives by s, shape (derivatives + 1, n, 9)."""
        values = self.spline(s / self.length, derivatives)
        for order in range(1, derivatives + 1):
            values[order] /= self.length**order
        return values

    def greatest_curvature(self) -> tuple[float, float]:
        """The greatest |curvature| [1/mm], to 1e-8 of itself, and its arclength [mm]."""
        if "_tightest" not in self.__dict__:
            find_tightest([self])
        tightest: tuple[float, float] = self.__dict__["_tightest"]
        return tightest


def find_tightest(pieces: Sequence[FittedPiece]) -> None:
    """Find the greatest curvatures of pieces together, which then have them at hand."""
    if not pieces:
        return
    polynomials = np.concatenate([piece.spline.polynomials[..., :3] for piece in pieces])
    steps = np.concatenate([piece.spline.knots.steps for piece in pieces])[:, None, None]
    bends, at = np.empty(len(steps)), np.empty(len(steps), dtype=np.intp)
    for low in range(0, len(steps), _BLOCK):
        own = slice(low, low + _BLOCK)
        bend = _squared_bends(_BENDS_AT_SHARES[1:, None] @ polynomials[own], steps[own])
        at[own] = bend.argmax(axis=1)
        bends[own] = bend.max(axis=1)
    shares = _SHARES[at]
    spans = np.array([piece.spans for piece in pieces])
    ends = np.cumsum(spans)
    greatest = np.repeat(np.maximum.reduceat(bends, ends - spans), spans)
    rivals = np.flatnonzero(bends >= (1.0 - _RIVAL) * greatest)
    shares[rivals], bends[rivals] = _looked_closer(polynomials[rivals], steps[rivals], shares[rivals])
    for piece, end in zip(pieces, ends.tolist(), strict=True):
        low = end - piece.spans
        best = int(np.argmax(bends[low:end]))
        left, right = piece.knots[best : best + 2].tolist()
        share = left + (right - left) * float(shares[low + best])
        piece.__dict__["_tightest"] = math.sqrt(bends[low + best]), share * piece.length


def _squared_bends(derivatives: Array, steps: Array) -> Array:
    """Squares of the curvatures, shape (spans, n), from first and second derivatives, shape (2, spans, n, 3)."""
    first, second = derivatives[0] / steps, derivatives[1] / steps**2
    square = dots(first, first)
    normal = second - (dots(second, first) / square)[..., None] * first
    return np.asarray(dots(normal, normal) / square**2)


def _looked_closer(polynomials: Array, steps: Array, shares: Array) -> tuple[Array, Array]:
    """Where a span bends most, near a share of it, and the square of its curvature there, shape (spans,) each."""
    width, rows = float(_SHARES[1]), np.arange(len(shares))
    bends = np.empty(len(shares))
    for _ in range(_CLOSER_LOOKS):
        tried = np.clip(shares[:, None] + width * _CLOSER, 0.0, 1.0)
        powers = powers_of(tried.ravel(), DEGREE, 2)[1:].reshape(2, *tried.shape, -1)
        found = _squared_bends(powers @ polynomials, steps)
        best = found.argmax(axis=1)
        shares, bends, width = tried[rows, best], found[rows, best], width / 4.0
    return shares, bends


@dataclass(frozen=True)
class FittedCentreline:
    """A centreline as CAD gets it: lines and splines. It is a `Curve`, so all that measures curves measures it too.

    Attributes:
        pieces: In the order of travel.
        tolerance: Bound the deviation keeps [mm].
    """

    pieces: tuple[Line | FittedPiece, ...]
    tolerance: float

    @property
    def deviation(self) -> float:
        """Greatest sampled distance between the tube's side and the exact one [mm]."""
        return max((piece.deviation for piece in self.pieces if isinstance(piece, FittedPiece)), default=0.0)

    @property
    def spans(self) -> int:
        """Polynomial spans of all pieces; a line counts as one."""
        return sum(piece.spans if isinstance(piece, FittedPiece) else 1 for piece in self.pieces)

    @cached_property
    def breaks(self) -> Array:
        """Arclengths where pieces begin and end [mm]."""
        return np.array([0.0, *accumulate(piece.length for piece in self.pieces)])

    @property
    def length(self) -> float:
        """Length of the exact centreline [mm]."""
        return float(self.breaks[-1])

    def frames(self, s: ArrayLike, side: Side = "right") -> Frames:
        """Positions of the fit and orthonormal frames on it, shape (n, 3) each."""
        return self.states(s, side)[0]

    def bishop(self, s: ArrayLike, order: int = 0, side: Side = "right") -> Array:
        """The fit's curvature along normal and binormal, shape (1, n, 2) [1/mm]; no derivatives of it.

        Raises:
            ValueError: `order` above 0.
        """
        if order > 0:
            raise ValueError("a fit gives its curvature, not derivatives of it; ask the exact centreline")
        return self.states(s, side)[1][None]

    def greatest_curvature(self) -> tuple[float, float]:
        """The greatest |curvature| of the fit [1/mm], to 1e-8 of itself, and its arclength [mm]."""
        best = (0.0, 0.0)
        for start, piece in zip(self.breaks, self.pieces, strict=False):
            if isinstance(piece, FittedPiece):
                kappa, at = piece.greatest_curvature()
                best = max(best, (kappa, float(start) + at))
        return best

    def least_stretch(self, radius: float) -> tuple[float, float]:
        """The least sampled length of a tube's side over the fit's own, and its arclength [mm]: below 0 it folds.

        Of the exact tube that is 1 - kappa r. Here it is that of the side as it is built, whose normals have an
        interpolation of their own.
        """
        least = (1.0, 0.0)
        for start, piece in zip(self.breaks, self.pieces, strict=False):
            if not isinstance(piece, FittedPiece):
                continue
            inside = piece.knots[:-1, None] + piece.spline.knots.steps[:, None] * _FINE
            s = inside.ravel() * piece.length
            _, first = piece.evaluate(s, 1)
            along, n, b = first[:, :3], first[:, 3:6], first[:, 6:]
            stretch = 1.0 - radius * np.hypot(dots(n, along), dots(b, along)) / dots(along, along)
            i = int(np.argmin(stretch))
            least = min(least, (float(stretch[i]), float(start) + float(s[i])))
        return least

    def states(self, s: ArrayLike, side: Side = "right") -> tuple[Frames, Array]:
        """`frames`, and the curvature's components, shape (n, 2) [1/mm]."""
        at, index = locate(s, self.breaks, side)
        frames, bend = Frames(*(np.empty((len(at), 3)) for _ in range(4))), np.empty((len(at), 2))
        for i, piece in enumerate(self.pieces):
            own = index == i
            if own.any():
                local = np.clip(at[own] - self.breaks[i], 0.0, piece.length)
                found, bend[own] = _frames_and_bend(piece, local)
                for target, value in zip(frames, found, strict=True):
                    target[own] = value
        return frames, bend


def _frames_and_bend(piece: Line | FittedPiece, s: Array) -> tuple[Frames, Array]:
    """Frames of one piece made orthonormal, and the curvature's components in them, shape (n, 2)."""
    if isinstance(piece, Line):
        return piece.frames(s), np.zeros((len(s), 2))
    values, first, second = piece.evaluate(s, 2)
    speed = np.linalg.norm(first[:, :3], axis=1)
    tangent = first[:, :3] / speed[:, None]
    normal = values[:, 3:6] - dots(values[:, 3:6], tangent)[:, None] * tangent
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    binormal = np.cross(tangent, normal)
    bend = np.stack([dots(second[:, :3], normal), dots(second[:, :3], binormal)], axis=1) / speed[:, None] ** 2
    return Frames(values[:, :3], tangent, normal, binormal), bend


def dots(a: Array, b: Array) -> Array:
    """Scalar products of rows, shape (..., n) from (..., n, 3)."""
    products: Array = np.einsum("...i,...i->...", a, b)
    return products
