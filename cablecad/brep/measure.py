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
from functools import lru_cache

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
    vectors = np.concatenate([values[:, 3:], slopes], axis=1).T.reshape(5, 3, -1)  # N, B, P', N', B'
    (n1, n2, n3), (b1, b2, b3), (t1, t2, t3) = vectors[:3]
    section = (n2 * b3 - n3 * b2) * t1 + (n3 * b1 - n1 * b3) * t2 + (n1 * b2 - n2 * b1) * t3
    products = np.einsum("icn,jcn->ijn", vectors, vectors).reshape(25, -1)
    around, along, both = (_side_forms(radius) @ products).reshape(3, len(_ANGLES), -1)
    size = np.sqrt(around * along - both**2).mean(axis=0)
    return math.pi * radius**2 * float(weights @ section), 2.0 * math.pi * radius * float(weights @ size)


@lru_cache(maxsize=16)
def _side_forms(radius: float) -> Array:
    """What the scalar products of N, B, P', N', B' count in those of dS/dphi over the radius and dS/dv.

    By dS/dphi = r (cos B - sin N) and dS/dv = P' + r (cos N' + sin B').

    Returns:
        Shape (3 angles, 25): of the one with itself, of the other with itself, of the two.
    """
    cosine, sine, zero = np.cos(_ANGLES), np.sin(_ANGLES), np.zeros(len(_ANGLES))
    around = np.stack([-sine, cosine, zero, zero, zero])
    along = np.stack([zero, zero, zero + 1.0, radius * cosine, radius * sine])
    pairs = ((around, around), (along, along), (around, along))
    return np.concatenate([np.einsum("ia,ja->aij", one, other).reshape(-1, 25) for one, other in pairs])
