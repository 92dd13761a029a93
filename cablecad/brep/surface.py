"""B-spline surfaces out of numpy's arrays, by way of Open Cascade's binary BREP format.

Open Cascade's own arrays are filled pole by pole from Python, half a microsecond each call; a stream is read in C++. A
side of a hundred and forty poles takes 10 us in place of 100.

Source: Open Cascade, BinTools_SurfaceSet: little-endian, a digit for each pair of values that follow, no padding.
"""

from __future__ import annotations

import io
from typing import NamedTuple, cast

import numpy as np
from numpy.typing import ArrayLike
from OCP.BinTools import BinTools_SurfaceSet
from OCP.Geom import Geom_BSplineSurface

from cablecad.centreline import Array

_BSPLINE = 9  # of the format's kinds of surfaces

_HEAD = np.dtype(
    [("kind", "u1"), ("rational", "?", 2), ("periodic", "?", 2), ("degrees", "<i2", 2), ("counts", "<i4", 4)]
)
_KNOT = np.dtype([("knot", "<f8"), ("multiplicity", "<i4")])


class KnotVector(NamedTuple):
    """The knots of one parameter.

    Attributes:
        degree: Of the polynomials between them.
        knots: Distinct and increasing, shape (n,).
        multiplicities: How often each counts, shape (n,).
    """

    degree: int
    knots: ArrayLike
    multiplicities: ArrayLike

    def packed(self) -> np.ndarray[tuple[int], np.dtype[np.void]]:
        """In the format's order."""
        packed = np.empty(len(np.asarray(self.knots)), _KNOT)
        packed["knot"], packed["multiplicity"] = self.knots, self.multiplicities
        return packed


def bspline_surface(poles: Array, weights: ArrayLike, u: KnotVector, v: KnotVector) -> Geom_BSplineSurface:
    """A rational B-spline surface without a period.

    Args:
        poles: Shape (rows, columns, 3) [mm], u along the rows.
        weights: Of the poles, any shape that broadcasts to (rows, columns).
        u: The knots along the rows.
        v: The knots along the columns.
    """
    rows, columns, _ = poles.shape
    around, along = u.packed(), v.packed()
    head = np.zeros((), _HEAD)
    head["kind"], head["rational"] = _BSPLINE, True
    head["degrees"], head["counts"] = (u.degree, v.degree), (rows, columns, len(around), len(along))
    body = np.empty((rows, columns, 4), "<f8")
    body[:, :, :3], body[:, :, 3] = poles, weights
    surfaces = BinTools_SurfaceSet()
    parts = (head, body, around, along)
    surfaces.Read(io.BytesIO(b"Surfaces 1\n" + b"".join(part.tobytes() for part in parts)))
    return cast(Geom_BSplineSurface, surfaces.Surface(1))
