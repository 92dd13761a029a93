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
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cablecad.brep.bspline import powers_of
from cablecad.brep.knots import DEGREE
from cablecad.brep.spline import FittedCentreline, FittedPiece
from cablecad.centreline import Array, Line

_POINTS = 14
"""Gauss points a span: exact for degree 27, three splines of degree nine and a derivative less."""

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(_POINTS)
_AT_NODES = powers_of((1.0 + _NODES) / 2.0, DEGREE, 1)

_ANGLES = np.linspace(0.0, 2.0 * math.pi, 8, endpoint=False)
"""Four do for an exact tube; of a thick one fitted coarsely they leave 3e-6 of the area, eight a tenth of that."""

_BLOCK = 256
"""Spans worked on at once: 2 MB. More are no faster."""


class Measured(NamedTuple):
    """Of a tube, caps included: volume [mm^3] and area [mm^2]."""

    volume: float
    area: float


def measure_tube(fit: FittedCentreline, radius: float) -> Measured:
    """Volume and area of the tube of `radius` [mm] around a fit."""
    (measured,) = measure_tubes([fit], [radius])
    return measured


def measure_tubes(fits: Sequence[FittedCentreline], radii: Sequence[float]) -> list[Measured]:
    """`measure_tube` for many, together: a call for each takes longer than the arithmetic of its spans."""
    straight = [sum(piece.length for piece in fit.pieces if isinstance(piece, Line)) for fit in fits]
    curved = [(i, piece) for i, fit in enumerate(fits) for piece in fit.pieces if isinstance(piece, FittedPiece)]
    inside, side = np.zeros((2, len(fits)))
    if curved:
        owners = np.repeat([i for i, _ in curved], [piece.spans for _, piece in curved])
        spans = _spans([piece for _, piece in curved], np.asarray(radii, dtype=float)[owners])
        np.add.at(inside, owners, spans[0])
        np.add.at(side, owners, spans[1])
    return [
        Measured(math.pi * (volume + radius**2 * length), 2.0 * math.pi * (area + radius * (length + radius)))
        for volume, area, length, radius in zip(inside.tolist(), side.tolist(), straight, radii, strict=True)
    ]


def _spans(pieces: Sequence[FittedPiece], radii: Array) -> tuple[Array, Array]:
    """Of all spans of some pieces, around which the tubes have the `radii`, volume over pi and area over 2 pi."""
    polynomials = np.concatenate([piece.spline.polynomials for piece in pieces])
    steps = np.concatenate([piece.spline.knots.steps for piece in pieces])
    inside, side = np.empty((2, len(steps)))
    for low in range(0, len(steps), _BLOCK):
        own = slice(low, low + _BLOCK)
        values, slopes = (_AT_NODES[:, None] @ polynomials[own]).transpose(0, 3, 1, 2)  # (9, spans, nodes)
        step, radius = steps[own, None], radii[own, None]
        slopes = slopes / step
        n, b, n_slope, b_slope = (vector * radius for vector in (values[3:6], values[6:], slopes[3:6], slopes[6:]))
        (n1, n2, n3), (b1, b2, b3), (t1, t2, t3) = n, b, slopes[:3]
        section = (n2 * b3 - n3 * b2) * t1 + (n3 * b1 - n1 * b3) * t2 + (n1 * b2 - n2 * b1) * t3
        vectors = np.stack([n, b, slopes[:3], n_slope, b_slope]).reshape(5, 3, -1)
        products = np.concatenate([np.einsum("cn,jcn->jn", vectors[i], vectors[i:]) for i in range(5)])
        around, along, both = (_SIDE_FORMS @ products).reshape(3, len(_ANGLES), *section.shape)
        size = np.sqrt(around * along - both**2).mean(axis=0)
        weights = step / 2.0 * _WEIGHTS
        inside[own], side[own] = (weights * section).sum(axis=1), (weights * size).sum(axis=1)
    return inside, side


def _side_forms() -> Array:
    """What the scalar products of N, B, P', N', B' count in those of dS/dphi and dS/dv, N and B times the radius.

    By dS/dphi = cos B - sin N and dS/dv = P' + cos N' + sin B'.

    Returns:
        Shape (3 angles, 15): of the one with itself, of the other with itself, of the two; products of each of the
        five with itself and those behind it.
    """
    cosine, sine, zero = np.cos(_ANGLES), np.sin(_ANGLES), np.zeros(len(_ANGLES))
    around = np.stack([-sine, cosine, zero, zero, zero])
    along = np.stack([zero, zero, zero + 1.0, cosine, sine])
    pairs = ((around, around), (along, along), (around, along))
    full = np.concatenate([np.einsum("ia,ja->aij", one, other) for one, other in pairs])
    first, second = np.triu_indices(5)
    forms: Array = np.where(first == second, 0.5, 1.0) * (full[:, first, second] + full[:, second, first])
    return forms


_SIDE_FORMS = _side_forms()
