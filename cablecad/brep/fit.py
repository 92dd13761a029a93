"""Fitting lines and splines to a centreline and its frame, to a tolerance: of one cable or of many together.

Each smooth piece becomes one C8 spline of degree nine through (position, normal, binormal) at its knots, with odd
derivatives given at both ends; a straight piece stays a line. The knots follow from a formula (`knots`); the result is
measured between them against the exact curve, and refined until it keeps the tolerance.

A short spline costs more in calls of numpy than in arithmetic: pieces of one kind that take as many spans go through
together, in a quarter of the time.

Nothing here needs Open Cascade.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cablecad.brep.bspline import interpolate, powers_of
from cablecad.brep.knots import DEGREE, ORDER, KnotCount, count_knots
from cablecad.brep.spline import FittedCentreline, FittedPiece, dots
from cablecad.bundle import Bundle, bundled
from cablecad.centreline import Array, Centreline, Frames, Line, Piece
from cablecad.errors import GeometryError, UsageError

SAMPLES_A_SPAN = 16
"""Where the deviation is measured: the error of a span has one crest, in its middle, which 16 points find to 1 %."""

_SHARES = np.arange(SAMPLES_A_SPAN) / SAMPLES_A_SPAN
_AT_SHARES = powers_of(_SHARES, DEGREE, 0)

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
    (fit,) = fit_centrelines([centreline], [radius], [tolerance])
    if isinstance(fit, GeometryError):
        raise fit
    return fit


def fit_centrelines(
    centrelines: Sequence[Centreline], radii: Sequence[float], tolerances: Sequence[float]
) -> list[FittedCentreline | GeometryError]:
    """`fit_centreline` for many, together: of each its fit, or the error for one that cannot be fitted.

    Raises:
        UsageError: A radius or tolerance is not a positive number.
    """
    for radius, tolerance in zip(radii, tolerances, strict=True):
        if not (0.0 < radius < math.inf and 0.0 < tolerance < math.inf):
            raise UsageError(f"a fit needs a positive radius and tolerance; got {radius!r} mm and {tolerance!r} mm")
    curved = [
        _Curved(i, piece, float(start), radius, tolerance)
        for i, (centreline, radius, tolerance) in enumerate(zip(centrelines, radii, tolerances, strict=True))
        for start, piece in zip(centreline.breaks, centreline.pieces, strict=False)
        if not isinstance(piece, Line)
    ]
    fitted: list[list[FittedPiece]] = [[] for _ in centrelines]
    failed: dict[int, GeometryError] = {}
    for one, result in zip(curved, _fit_pieces(curved), strict=True):
        if isinstance(result, GeometryError):
            failed.setdefault(one.owner, result)
        else:
            fitted[one.owner].append(result)
    fits: list[FittedCentreline | GeometryError] = []
    for i, (centreline, tolerance) in enumerate(zip(centrelines, tolerances, strict=True)):
        if i in failed:
            fits.append(failed[i])
        else:
            splines = iter(fitted[i])
            pieces = [piece if isinstance(piece, Line) else next(splines) for piece in centreline.pieces]
            fits.append(FittedCentreline(tuple(pieces), tolerance))
    return fits


class _Curved(NamedTuple):
    """A piece to fit.

    Attributes:
        owner: Which centreline it is of.
        piece: The exact curve.
        start: Its arclength on the whole centreline, for messages [mm].
        radius: Of the tube [mm].
        tolerance: [mm].
    """

    owner: int
    piece: Piece
    start: float
    radius: float
    tolerance: float


def _fit_pieces(curved: Sequence[_Curved]) -> list[FittedPiece | GeometryError]:
    """Fit smooth pieces; those of one kind that take as many spans together."""
    errors = np.array([_AIM * one.tolerance for one in curved])
    wanted = count_knots([one.piece for one in curved], np.array([one.radius for one in curved]), errors)
    spans = [math.ceil(count.knots[-1] * (1.0 - 1e-12)) for count in wanted]
    results: list[FittedPiece | GeometryError | None] = [None] * len(curved)
    least = [math.inf] * len(curved)
    waiting = list(range(len(curved)))
    while waiting:
        alike: dict[tuple[type, int], list[int]] = defaultdict(list)
        for i in waiting:
            if spans[i] > _MOST_SPANS:
                results[i] = _too_many_spans(curved[i])
            else:
                alike[type(curved[i].piece), spans[i]].append(i)
        waiting = []
        for (_, count), members in alike.items():
            most = max(1, _BLOCK // count)
            for low in range(0, len(members), most):
                own = members[low : low + most]
                some = [curved[i] for i in own]
                for i, fit in zip(own, _interpolate(some, count, [wanted[i] for i in own]), strict=True):
                    one = curved[i]
                    if fit.deviation <= _SAMPLED * one.tolerance:
                        results[i] = fit
                    elif fit.deviation > 0.7 * least[i] and count > 64:
                        results[i] = _rounded_away(one, fit.deviation)
                    else:
                        least[i] = min(least[i], fit.deviation)
                        more = (fit.deviation / (_AIM * one.tolerance)) ** (1.0 / ORDER)
                        spans[i] = math.ceil(count * min(4.0, max(1.1, more)))
                        waiting.append(i)
    return [result for result in results if result is not None]


def _too_many_spans(one: _Curved) -> GeometryError:
    return GeometryError(
        f"the piece of the centreline at s = {one.start:g} mm needs more than {_MOST_SPANS} spans to keep "
        f"{one.tolerance:g} mm; ask for a larger tolerance"
    )


def _rounded_away(one: _Curved, deviation: float) -> GeometryError:
    """More knots stopped helping: the error is rounding, not interpolation."""
    return GeometryError(
        f"the piece of the centreline at s = {one.start:g} mm cannot be fitted to {one.tolerance:g} mm: "
        f"rounding leaves {deviation:.2g} mm; ask for a larger tolerance"
    )


def _interpolate(curved: Sequence[_Curved], spans: int, wanted: Sequence[KnotCount]) -> list[FittedPiece]:
    """The splines through pieces of one kind at their knots of [0, 1], and their measured deviations."""
    knots, even = np.ones((len(curved), spans + 1)), np.arange(spans)
    for own, count in zip(knots, wanted, strict=True):
        own[:-1] = np.interp(even * (count.knots[-1] / spans), count.knots, count.share)
    columns, ends = _sampled(bundled([one.piece for one in curved]), knots)
    radii = np.array([one.radius for one in curved])
    given = (np.array([count.ends for count in wanted]) @ ends[:, :, None, 1:]).reshape(len(curved), -1, 9)
    values, half = columns[:, ::SAMPLES_A_SPAN], given.shape[1] // 2
    spline = interpolate(knots, DEGREE, values, given[:, :half], given[:, half:])
    # The binormal of a plane curve: a constant has constant poles, to the last digit.
    level = (values == values[:, :1]).all(axis=1) & ~given.any(axis=1)
    np.copyto(spline.poles, values[:, :1], where=level[:, None])
    deviation = np.zeros(len(curved))
    for low in range(0, spans, _BLOCK):
        sampled = spline.sampled(_AT_SHARES, slice(low, low + _BLOCK))[0]
        error = sampled - columns[:, low * SAMPLES_A_SPAN :][:, : sampled.shape[1]]
        np.maximum(deviation, _deviation(error, radii), out=deviation)
    each = enumerate(zip(curved, deviation.tolist(), ends[:, :, :3], strict=True))
    return [FittedPiece(one.piece.length, spline.one(i), off, end) for i, (one, off, end) in each]


def _sampled(bundle: Bundle, knots: Array) -> tuple[Array, Array]:
    """Position, normal and binormal of pieces at the samples of their spans, and at both ends the tangent too.

    Args:
        bundle: The pieces, n of them.
        knots: Of each, shape (n, spans + 1).

    Returns:
        Shape (n, samples, 9); and of both ends position, tangent, normal and binormal, shape (n, 2, 4, 3).
    """
    length = np.array([[piece.length] for piece in bundle.pieces])
    inside = knots[:, :-1, None] + (knots[:, 1:] - knots[:, :-1])[:, :, None] * _SHARES
    at = np.concatenate([inside.reshape(len(knots), -1), knots[:, -1:]], axis=1) * length
    size = _BLOCK * SAMPLES_A_SPAN
    blocks = [bundle.frames(at[:, low : low + size]) for low in range(0, at.shape[1], size)]
    exact = Frames(*(np.concatenate(field, axis=1) for field in zip(*blocks, strict=True))) if blocks[1:] else blocks[0]
    columns = np.concatenate([exact.position, exact.normal, exact.binormal], axis=2)
    ends = np.concatenate([field[:, :: at.shape[1] - 1] for field in exact], axis=2)
    return columns, ends.reshape(len(knots), 2, 4, 3)


def _deviation(error: Array, radii: Array) -> Array:
    """Greatest errors of points of the sides [mm], from those of (position, normal, binormal), shape (n, samples, 9).

    With the errors p, n, b it is |p + r (n cos(u) + b sin(u))|, without b the greatest for cos(u) = 1 or -1.
    """
    scaled = radii[:, None, None]
    p, n, b = error[..., :3], scaled * error[..., 3:6], scaled * error[..., 6:]
    out, back = p + n, p - n
    plane = np.sqrt(np.maximum(dots(out, out), dots(back, back)).max(axis=1))
    left = np.abs(b).max(axis=(1, 2))
    # A plane curve's binormal is constant but for rounding.
    greatest: Array = plane + math.sqrt(3.0) * left
    for i in np.flatnonzero(left > _NO_SHARE * plane).tolist():
        own = p[i], n[i], b[i]
        greatest[i] = _greatest_around(*own)
    return greatest


def _greatest_around(p: Array, n: Array, b: Array) -> float:
    """The greatest of |p + n cos(u) + b sin(u)|."""
    nn, bb = dots(n, n) / 2.0, dots(b, b) / 2.0
    waves = np.array([dots(p, p) + nn + bb, 2.0 * dots(p, n), 2.0 * dots(p, b), nn - bb, dots(n, b)])
    return math.sqrt(float((_WAVES @ waves).max()))
