"""The B-spline of a tube's centreline and frame, to a tolerance.

Each smooth piece becomes one C8 spline of degree nine through (position, normal, binormal) at its knots, with odd
derivatives given at both ends; a straight piece stays a line. Times an exact rational circle that spline is the tube's
side. The knots follow from a formula (`knots`); the result is measured between them against the exact curve, and
refined until it keeps the tolerance.

Nothing here needs Open Cascade.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from cablecad.brep.bspline import Spline, interpolate, powers_of
from cablecad.brep.knots import DEGREE, ORDER, KnotCount, count_knots
from cablecad.centreline import Array, Centreline, Frames, Line, Side, locate
from cablecad.errors import GeometryError, UsageError

SAMPLES_A_SPAN = 16
"""Where the deviation is measured: the error of a span has one crest, in its middle, which 16 points find to 1 %."""

_SHARES = np.arange(SAMPLES_A_SPAN) / SAMPLES_A_SPAN
_CLOSED = np.append(_SHARES, 1.0)
_AT_SHARES, _BENDS_AT_CLOSED = powers_of(_SHARES, DEGREE, 0), powers_of(_CLOSED, DEGREE, 2)

_ANGLES = np.linspace(0.0, 2.0 * math.pi, 64, endpoint=False)
"""Where around the circle the deviation is measured: its square has two waves at most, whose crest 64 points find to
0.5 %."""

_WAVES = np.stack([np.ones(64), np.cos(_ANGLES), np.sin(_ANGLES), np.cos(2.0 * _ANGLES), np.sin(2.0 * _ANGLES)], axis=1)

_NO_SHARE = 1e-4
"""Share of the deviation below which an error of the binormal is added to it rather than looked into."""

_BLOCK = 512
"""Spans measured at once: 4 MB for all angles, whatever the number of spans."""

_SAMPLED = 0.985
"""Share of the tolerance the sampled deviation may reach, for the crests between the samples."""

_AIM = 0.1
"""Share of the tolerance aimed at: the first fit is the last, and a tenth of the error costs a quarter more knots."""

_MOST_SPANS = 100_000
"""A spline of more spans than this is refused: 70 MB of STEP."""


@dataclass(frozen=True)
class FittedPiece:
    """A C8 spline of degree nine over [0, 1] through position, normal and binormal of one piece.

    Attributes:
        length: Of the exact piece [mm]; the spline's parameter is arclength over length, up to the deviation.
        spline: Of nine columns: position [mm], normal and binormal.
        deviation: Greatest sampled distance between the tube's side and the exact one [mm].
        end_normal: Normals of the exact frame at both ends, shape (2, 3); likewise the next two.
        end_tangent: Tangents.
        end_position: Positions [mm].
    """

    length: float
    spline: Spline
    deviation: float
    end_position: Array
    end_tangent: Array
    end_normal: Array

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
        """The greatest sampled |curvature| [1/mm] and its arclength [mm]."""
        kappa, at = 0.0, 0.0
        for low in range(0, self.spans, _BLOCK):
            block = slice(low, low + _BLOCK)
            _, first, second = self.spline.sampled(_BENDS_AT_CLOSED, block)[:, :, :3]
            square = _dot(first, first)
            normal = second - (_dot(second, first) / square)[:, None] * first
            bend = _dot(normal, normal) / square**2
            i = int(np.argmax(bend))
            if bend[i] >= kappa:
                span, sample = divmod(i, len(_CLOSED))
                kappa = float(bend[i])
                left, right = self.knots[low + span : low + span + 2].tolist()
                at = left + (right - left) * float(_CLOSED[sample])
        return math.sqrt(kappa), at * self.length


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
        return np.concatenate([[0.0], np.cumsum([piece.length for piece in self.pieces])])

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
        """The greatest sampled |curvature| of the fit [1/mm] and its arclength [mm]."""
        best = (0.0, 0.0)
        for start, piece in zip(self.breaks, self.pieces, strict=False):
            if isinstance(piece, FittedPiece):
                kappa, at = piece.greatest_curvature()
                best = max(best, (kappa, float(start) + at))
        return best

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
    normal = values[:, 3:6] - _dot(values[:, 3:6], tangent)[:, None] * tangent
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    binormal = np.cross(tangent, normal)
    bend = np.stack([_dot(second[:, :3], normal), _dot(second[:, :3], binormal)], axis=1) / speed[:, None] ** 2
    return Frames(values[:, :3], tangent, normal, binormal), bend


def _dot(a: Array, b: Array) -> Array:
    products: Array = np.einsum("ni,ni->n", a, b)
    return products


def fit_centreline(centreline: Centreline, radius: float, *, tolerance: float) -> FittedCentreline:
    """Fit lines and splines of degree nine to a centreline and its frame.

    Args:
        centreline: The exact curve.
        radius: Of the tube whose side shall keep the tolerance [mm].
        tolerance: Bound on the distance between the side and the exact tube's [mm].

    Returns:
        The fit with its measured deviation. The distance is taken between points of equal parameters, which bounds
        the distance between the surfaces from above.

    Raises:
        UsageError: Radius or tolerance is not a positive number.
        GeometryError: The tolerance cannot be kept: below rounding, or more than 100 000 spans.
    """
    if not (0.0 < radius < math.inf and 0.0 < tolerance < math.inf):
        raise UsageError(f"a fit needs a positive radius and tolerance; got {radius!r} mm and {tolerance!r} mm")
    pieces: list[Line | FittedPiece] = []
    for start, piece in zip(centreline.breaks, centreline.pieces, strict=False):
        if isinstance(piece, Line):
            pieces.append(piece)
        else:
            alone = Centreline([piece]) if len(centreline.pieces) > 1 else centreline
            pieces.append(_fit_piece(alone, radius, tolerance, float(start)))
    return FittedCentreline(tuple(pieces), tolerance)


def _fit_piece(piece: Centreline, radius: float, tolerance: float, start: float) -> FittedPiece:
    """Fit one smooth piece; `start` is its arclength on the whole centreline, for messages."""
    wanted = count_knots(piece, radius, _AIM * tolerance)
    spans = math.ceil(wanted.knots[-1] * (1.0 - 1e-12))
    least = math.inf
    while spans <= _MOST_SPANS:
        knots = np.interp(np.linspace(0.0, wanted.knots[-1], spans + 1), wanted.knots, wanted.share)
        fitted = _interpolate(piece, radius, knots, wanted)
        if fitted.deviation <= _SAMPLED * tolerance:
            return fitted
        if fitted.deviation > 0.7 * least and spans > 64:
            # More knots stopped helping: the error is rounding, not interpolation.
            raise GeometryError(
                f"the piece of the centreline at s = {start:g} mm cannot be fitted to {tolerance:g} mm: "
                f"rounding leaves {fitted.deviation:.2g} mm; ask for a larger tolerance"
            )
        least = min(least, fitted.deviation)
        spans = math.ceil(spans * min(4.0, max(1.1, (fitted.deviation / (_AIM * tolerance)) ** (1.0 / ORDER))))
    raise GeometryError(
        f"the piece of the centreline at s = {start:g} mm needs more than {_MOST_SPANS} spans to keep "
        f"{tolerance:g} mm; ask for a larger tolerance"
    )


def _interpolate(piece: Centreline, radius: float, knots: Array, wanted: KnotCount) -> FittedPiece:
    """The spline through a piece at given knots of [0, 1], and its measured deviation."""
    at = np.append((knots[:-1, None] + np.diff(knots)[:, None] * _SHARES).ravel(), 1.0) * piece.length
    size = _BLOCK * SAMPLES_A_SPAN
    blocks = [piece.frames(at[low : low + size]) for low in range(0, len(at), size)]
    exact = Frames(*(np.concatenate(field) for field in zip(*blocks, strict=True))) if blocks[1:] else blocks[0]
    columns = np.hstack([exact.position, exact.normal, exact.binormal])
    ends = Frames(*(field[:: len(at) - 1].copy() for field in exact))
    start, end = (wanted.ends @ np.stack(ends[1:], axis=1)[:, None]).reshape(2, -1, 9)
    values = columns[::SAMPLES_A_SPAN]
    spline = interpolate(knots, DEGREE, values, start, end)
    # The binormal of a plane curve: a constant has constant poles, to the last digit.
    level = (values == values[0]).all(axis=0) & ~start.any(axis=0) & ~end.any(axis=0)
    spline.poles[:, level] = values[0, level]
    deviation = 0.0
    for low in range(0, len(knots) - 1, _BLOCK):
        sampled = spline.sampled(_AT_SHARES, slice(low, low + _BLOCK))[0]
        error = sampled - columns[low * SAMPLES_A_SPAN :][: len(sampled)]
        deviation = max(deviation, _deviation(error, radius))
    return FittedPiece(piece.length, spline, deviation, ends.position, ends.tangent, ends.normal)


def _deviation(error: Array, radius: float) -> float:
    """Greatest error of points of the side [mm], from those of (position, normal, binormal) at some stations, (n, 9).

    With the errors p, n, b it is |p + r (n cos(u) + b sin(u))|, without b the greatest for cos(u) = 1 or -1.
    """
    p, n, b = error[:, :3], radius * error[:, 3:6], radius * error[:, 6:]
    plane = math.sqrt(max(float(_dot(some, some).max()) for some in (p + n, p - n)))
    left = float(np.abs(b).max())
    if left <= _NO_SHARE * plane:  # a plane curve's binormal is constant but for rounding
        return plane + math.sqrt(3.0) * left
    nn, bb = _dot(n, n) / 2.0, _dot(b, b) / 2.0
    waves = np.array([_dot(p, p) + nn + bb, 2.0 * _dot(p, n), 2.0 * _dot(p, b), nn - bb, _dot(n, b)])
    return math.sqrt(float((_WAVES @ waves).max()))
