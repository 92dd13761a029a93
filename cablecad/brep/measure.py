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

from cablecad.brep.bspline import powers_of
from cablecad.brep.knots import DEGREE
from cablecad.brep.spline import FittedCentreline, FittedPiece
from cablecad.centreline import Array

_POINTS = 14
"""Gauss points a span: exact for degree 27, three splines of degree nine and a derivative less."""

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(_POINTS)
_AT_NODES = powers_of((1.0 + _NODES) / 2.0, DEGREE, 1)

_ANGLES = np.linspace(0.0, 2.0 * math.pi, 8, endpoint=False)
_COSINES, _SINES = np.cos(_ANGLES), np.sin(_ANGLES)
_WAVES = np.stack([np.ones(8), _COSINES, _SINES, _COSINES**2, _COSINES * _SINES, _SINES**2])

_BLOCK = 1024
"""Spans worked on at once: 10 MB."""


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
    values, slopes = piece.spline.sampled(_AT_NODES, spans)
    vectors = np.concatenate([values[:, 3:], slopes], axis=1).reshape(-1, 5, 3)  # N, B, P', N', B'
    section = np.linalg.det(vectors[:, :3])
    size = _side(vectors @ vectors.transpose(0, 2, 1), radius)
    volume = math.pi * radius**2 * float(weights @ section)
    return volume, 2.0 * math.pi * radius * float(np.mean(weights @ size))


def _side(products: Array, radius: float) -> Array:
    """|dS/dphi x dS/dv| over the radius, from the scalar products of N, B, P', N', B': shape (n, angles).

    By dS/dphi = r (cos B - sin N) and dS/dv = P' + r (cos N' + sin B').
    """
    (nn, nb, na, nn1, nb1), (_, bb, ba, bn1, bb1), (_, _, aa, an1, ab1), (*_, n1n1, n1b1), (*_, b1b1) = np.moveaxis(
        products, 0, 2
    )
    zero, r = np.zeros_like(nn), radius
    around = np.stack([zero, zero, zero, bb, -2.0 * nb, nn], axis=1) @ _WAVES
    along = np.stack([aa, 2 * r * an1, 2 * r * ab1, r * r * n1n1, 2 * r * r * n1b1, r * r * b1b1], axis=1) @ _WAVES
    both = np.stack([zero, ba, -na, r * bn1, r * (bb1 - nn1), -r * nb1], axis=1) @ _WAVES
    size: Array = np.sqrt(around * along - both**2)
    return size
