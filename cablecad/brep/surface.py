"""B-spline surfaces out of numpy's arrays, by way of Open Cascade's binary BREP format.

Open Cascade's own arrays are filled pole by pole from Python, half a microsecond each call; a stream is read in C++. A
side of a hundred and forty poles takes 10 us in place of 100.

Source: Open Cascade, BinTools_SurfaceSet: little-endian, a digit for each pair of values that follow, no padding.
"""

from __future__ import annotations

import io
from dataclasses import dataclass
from functools import cached_property
from struct import Struct
from typing import cast

import numpy as np
from numpy.typing import ArrayLike
from OCP.BinTools import BinTools_SurfaceSet
from OCP.Geom import Geom_BSplineSurface

from cablecad.centreline import Array

_BSPLINE = 9  # of the format's kinds of surfaces

_HEAD = Struct("<B4?2h4i")  # kind; rational, periodic; degrees; counts of poles and of knots
_KNOT = np.dtype([("knot", "<f8"), ("multiplicity", "<i4")])


@dataclass(frozen=True, eq=False)
class KnotVector:
    """The knots of one parameter.

    Attributes:
        degree: Of the polynomials between them.
        knots: Distinct and increasing, shape (n,).
        multiplicities: How often each counts, shape (n,).
    """

    degree: int
    knots: ArrayLike
    multiplicities: ArrayLike

    @cached_property
    def packed(self) -> bytes:
        """In the format's order."""
        packed = np.empty(len(np.asarray(self.knots)), _KNOT)
        packed["knot"], packed["multiplicity"] = self.knots, self.multiplicities
        return packed.tobytes()


def bspline_surface(poles: Array, weights: ArrayLike, u: KnotVector, v: KnotVector) -> Geom_BSplineSurface:
    """A rational B-spline surface without a period.

    Args:
        poles: Shape (rows, columns, 3) [mm], u along the rows.
        weights: Of the poles, any shape that broadcasts to (rows, columns).
        u: The knots along the rows.
        v: The knots along the columns.
    """
    rows, columns, _ = poles.shape
    knots = (len(one.packed) // _KNOT.itemsize for one in (u, v))
    head = _HEAD.pack(_BSPLINE, True, True, False, False, u.degree, v.degree, rows, columns, *knots)
    body = np.empty((rows, columns, 4), "<f8")
    body[:, :, :3], body[:, :, 3] = poles, weights
    surfaces = BinTools_SurfaceSet()
    surfaces.Read(io.BytesIO(b"".join((b"Surfaces 1\n", head, body.tobytes(), u.packed, v.packed))))
    return cast(Geom_BSplineSurface, surfaces.Surface(1))
