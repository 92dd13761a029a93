"""Volume and area of a fitted tube, integrated over its own splines.

By position P, normal N and binormal B of a fit the solid is P + rho (cos(phi) N + sin(phi) B), rho from 0 to r. What is
odd in phi drops out of its volume,

    pi r^2 int (N x B) . P' dv,

and on every span the integrand is a polynomial of degree 26 at most, for which fourteen Gauss points are exact. The
area of the side is |dS/dphi x dS/dv|, integrated by the same points along it and by equal steps around it, where it is
a trigonometric polynomial but for the deviation of the fit. Open Cascade integrates the solid itself adaptively, to
1e-6, in twenty times the time: tests/brep/test_measure.py holds the two against each other.

Nothing here needs Open Cascade.
"""

from __future__ import annotations

import math

import numpy as np

from cablecad.brep.spline import FittedCentreline, FittedPiece
from cablecad.centreline import Array

_POINTS = 14
"""Gauss points a span: exact for degree 27, three splines of degree nine and a derivative less."""

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(_POINTS)
_SHARES = (1.0 + _NODES) / 2.0

_ANGLES = np.linspace(0.0, 2.0 * math.pi, 16, endpoint=False)
_COSINES, _SINES = np.cos(_ANGLES)[:, None, None], np.sin(_ANGLES)[:, None, None]

_BLOCK = 1024
"""Spans worked on at once: 30 MB."""


def measure_tube(fit: FittedCentreline, radius: float) -> tuple[float, float]:
    """Volume [mm^3] and area [mm^2], caps included, of the tube of `radius` [mm] around a fit."""
    volume, area = 0.0, 2.0 * math.pi * radius**2
    for piece in fit.pieces:
        if isinstance(piece, FittedPiece):
            for low in range(0, piece.spans, _BLOCK):
                inside, side = _spans(piece, slice(low, low + _BLOCK), radius)
                volume, area = volume + inside, area + side
        else:
            volume += math.pi * radius**2 * piece.length
            area += 2.0 * math.pi * radius * piece.length
    return volume, area


def _spans(piece: FittedPiece, spans: slice, radius: float) -> tuple[float, float]:
    """Volume and area of the side over some spans."""
    weights = (np.diff(piece.knots)[spans, None] / 2.0 * _WEIGHTS).ravel()
    values, slopes = piece.spline.sampled(_SHARES, 1, spans)
    _, normal, binormal = np.split(values, 3, axis=1)
    advance, normal_turn, binormal_turn = np.split(slopes, 3, axis=1)
    section = _triple(normal, binormal, advance)
    around = _COSINES * binormal - _SINES * normal
    along = advance + radius * (_COSINES * normal_turn + _SINES * binormal_turn)
    size = np.sqrt(_square(around) * _square(along) - np.einsum("anc,anc->an", around, along) ** 2)
    volume = math.pi * radius**2 * float(weights @ section)
    return volume, 2.0 * math.pi * radius * float(np.mean(size @ weights))


def _triple(a: Array, b: Array, c: Array) -> Array:
    """(a x b) . c, shape (n,)."""
    (ax, ay, az), (bx, by, bz), (cx, cy, cz) = a.T, b.T, c.T
    product: Array = (ay * bz - az * by) * cx + (az * bx - ax * bz) * cy + (ax * by - ay * bx) * cz
    return product


def _square(a: Array) -> Array:
    squares: Array = np.einsum("anc,anc->an", a, a)
    return squares
