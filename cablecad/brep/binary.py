"""Shapes as Open Cascade's binary BREP format has them: geometry and topology as records, read by it in one go.

A call of Open Cascade's from Python takes half a microsecond at least, and a tube means a hundred and forty poles and
sixty calls more. Records are read in C++: a tube takes six tenths of the time.

Points and directions are triples of floats, parameters pairs; lengths are in mm.

Source: Open Cascade, BinTools_ShapeSet, _SurfaceSet, _CurveSet and _Curve2dSet, format 4 (from 7.6 on): little-endian,
no padding.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property
from struct import Struct

import numpy as np
from numpy.typing import ArrayLike
from OCP.BinTools import BinTools, BinTools_FormatVersion
from OCP.TopoDS import TopoDS_Shape

from cablecad.centreline import Array

Triple = Sequence[float]

_LINE, _CIRCLE, _BSPLINE_CURVE = 1, 2, 7  # the format's kinds of curves
_PLANE, _CYLINDER, _BSPLINE_SURFACE = 1, 2, 9  # and of surfaces

_KNOT = np.dtype([("knot", "<f8"), ("multiplicity", "<i4")])

_LINE2D, _CIRCLE2D = Struct("<B4d"), Struct("<B7d")
_LINE3D, _AXES, _AXES_AND_RADIUS = Struct("<B6d"), Struct("<B12d"), Struct("<B13d")
_SPLINE_CURVE = Struct("<B2?h2i")  # kind; rational, periodic; degree; counts of poles and of knots
_SPLINE_SURFACE = Struct("<B4?2h4i")  # the same for two parameters


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

    @property
    def count(self) -> int:
        """Number of distinct knots."""
        return len(self.packed) // _KNOT.itemsize


@dataclass(frozen=True, slots=True)
class Axes:
    """A place and two directions across each other.

    Attributes:
        origin: [mm].
        main: The axis of a circle or cylinder, the normal of a plane.
        x: Where angles begin.
    """

    origin: Triple
    main: Triple
    x: Triple

    @property
    def numbers(self) -> tuple[float, ...]:
        """With the third direction, as the format wants it."""
        (a, b, c), (d, e, f) = self.main, self.x
        return (*self.origin, a, b, c, d, e, f, b * f - c * e, c * d - a * f, a * e - b * d)


# --- geometry -------------------------------------------------------------------------------------------------------


def line2d(u: float, v: float, du: float, dv: float) -> bytes:
    """A line of a surface's parameters, from a point on in a direction."""
    return _LINE2D.pack(_LINE, u, v, du, dv)


def circle2d(radius: float) -> bytes:
    """The circle around the origin of a surface's parameters, from the u axis towards the v axis."""
    return _CIRCLE2D.pack(_CIRCLE, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, radius)


def line(start: Triple, direction: Triple) -> bytes:
    """A line in space."""
    return _LINE3D.pack(_LINE, *start, *direction)


def circle(axes: Axes, radius: float) -> bytes:
    """A circle in space."""
    return _AXES_AND_RADIUS.pack(_CIRCLE, *axes.numbers, radius)


def spline(poles: Array, knots: KnotVector) -> bytes:
    """A polynomial B-spline of pairs or triples, shape (n, 2) or (n, 3): a curve of parameters or in space."""
    head = _SPLINE_CURVE.pack(_BSPLINE_CURVE, False, False, knots.degree, len(poles), knots.count)
    return b"".join((head, poles.astype("<f8").tobytes(), knots.packed))


def plane(axes: Axes) -> bytes:
    """A plane."""
    return _AXES.pack(_PLANE, *axes.numbers)


def cylinder(axes: Axes, radius: float) -> bytes:
    """A cylinder without ends."""
    return _AXES_AND_RADIUS.pack(_CYLINDER, *axes.numbers, radius)


def spline_surface(poles: Array, weights: ArrayLike, u: KnotVector, v: KnotVector) -> bytes:
    """A rational B-spline surface without a period.

    Args:
        poles: Shape (rows, columns, 3) [mm], u along the rows.
        weights: Of the poles, any shape that broadcasts to (rows, columns).
        u: The knots along the rows.
        v: The knots along the columns.
    """
    rows, columns, _ = poles.shape
    head = _SPLINE_SURFACE.pack(
        _BSPLINE_SURFACE, True, True, False, False, u.degree, v.degree, rows, columns, u.count, v.count
    )
    body = np.empty((rows, columns, 4), "<f8")
    body[:, :, :3], body[:, :, 3] = poles, weights
    return b"".join((head, body.tobytes(), u.packed, v.packed))


# --- whole shapes ---------------------------------------------------------------------------------------------------


def pack_shape(shape: TopoDS_Shape) -> bytes:
    """A shape with its geometry, to be `unpack_shape`d in another process."""
    stream = io.BytesIO()
    # Without triangles, which a picture has made and which are a hundred times as much.
    BinTools.Write_s(shape, stream, False, False, BinTools_FormatVersion.BinTools_FormatVersion_CURRENT)
    return stream.getvalue()


def unpack_shape(data: bytes) -> TopoDS_Shape:
    """The shape that `pack_shape` packed."""
    shape = TopoDS_Shape()
    BinTools.Read_s(shape, io.BytesIO(data))
    return shape


# --- topology -------------------------------------------------------------------------------------------------------


class _Kind(IntEnum):
    SOLID = 2
    SHELL = 3
    FACE = 4
    WIRE = 5
    EDGE = 6
    VERTEX = 7


_FREE, _PLAIN, _CLOSED, _POINT = (bytes(map(int, flags)) for flags in ("1101000", "0101000", "0101100", "0101101"))
"""Flags of a shape: free, modified, checked, orientable, closed, infinite, convex. What is in another is not free."""

_SUBSHAPE = Struct("<Bii")  # orientation; number, counted from the last; location
_NO_MORE = b"*"  # of subshapes
_FORWARD, _REVERSED = 0, 1

_TO_POINT, _PLACE, _NOWHERE_ELSE = Struct("<Bd"), Struct("<3d"), b"\0"  # kind, tolerance; point; on no curve or surface
_EDGE = Struct("<Bd3?")  # kind; tolerance; same parameter, same range, degenerated
_ON_CURVE = Struct("<B2i2d")  # 1; curve, location; range
_ON_SURFACE = Struct("<B3i2d")  # 2; curve of parameters, surface, location; range
_ON_SEAM = Struct("<B2iB2i2d")  # 3; the curves of both sides, their continuity, surface, location; range
_CN = 6  # the greatest continuity
_FACE = Struct("<B?d2iB")  # kind; bounded by the surface's own bounds; tolerance; surface, location; no triangles

_HEAD = b"\nOpen CASCADE Topology V4, (c) Open Cascade\nLocations 0\n"


class Topology:
    """How shapes hang together, and the curves of parameters: what many share whose geometry differs.

    Each method adds one and gives its number, by which later ones refer to it, reversed with a minus before it. Curves
    in space and surfaces are referred to by their number, from 1 on, in the lists that `with_geometry` takes.

    Args:
        tolerance: Of all vertices, edges and faces [mm].
    """

    def __init__(self, tolerance: float) -> None:
        self._tolerance = tolerance
        self._parameters: list[bytes] = []
        self._shapes: list[tuple[list[bytes], tuple[int, ...]]] = []

    def add_parameters(self, record: bytes) -> int:
        """Add a curve of a surface's parameters."""
        self._parameters.append(record)
        return len(self._parameters)

    def vertex(self) -> int:
        """Add a vertex."""
        return self._added((), _TO_POINT.pack(_Kind.VERTEX, self._tolerance), _NOWHERE_ELSE + _POINT)

    def edge(
        self,
        curve: int,
        span: tuple[float, float],
        ends: tuple[int, int],
        on: Sequence[tuple[int, int]] = (),
        seam: tuple[int, int, int] | None = None,
    ) -> int:
        """Add an edge.

        Args:
            curve: That it lies on.
            span: Of that curve's parameter, from end to end; the same on all surfaces.
            ends: Its vertices.
            on: Surfaces it lies on, each with the curve of its parameters.
            seam: The surface that it closes, with the curves of the parameters as it runs forward and back.
        """
        parts = [_EDGE.pack(_Kind.EDGE, self._tolerance, True, True, False), _ON_CURVE.pack(1, curve, 0, *span)]
        parts += [_ON_SURFACE.pack(2, parameters, surface, 0, *span) for surface, parameters in on]
        if seam:
            surface, forward, back = seam
            parts.append(_ON_SEAM.pack(3, forward, back, _CN, surface, 0, *span))
        start, end = ends
        return self._added((start, -end), b"".join((*parts, b"\0", _PLAIN)))

    def wire(self, *edges: int) -> int:
        """Add a closed wire."""
        return self._added(edges, bytes((_Kind.WIRE,)) + _CLOSED)

    def face(self, surface: int, wire: int) -> int:
        """Add the part of a surface within a wire."""
        return self._added((wire,), _FACE.pack(_Kind.FACE, False, self._tolerance, surface, 0, 1) + _PLAIN)

    def shell(self, *faces: int) -> int:
        """Add a closed shell."""
        return self._added(faces, bytes((_Kind.SHELL,)) + _CLOSED)

    def solid(self, shell: int) -> int:
        """Add a solid; it is what `with_geometry` gives."""
        return self._added((shell,), bytes((_Kind.SOLID,)) + _FREE)

    def with_geometry(
        self, points: Sequence[Triple], curves: Sequence[bytes], surfaces: Sequence[bytes]
    ) -> TopoDS_Shape:
        """Let Open Cascade make the shapes.

        Args:
            points: Of the vertices [mm].
            curves: In space.
            surfaces: That faces and edges lie on.
        """
        first, *others = self._between_points
        parts = [
            self._before_curves,
            *_table(b"Curves", curves),
            *_table(b"Polygon3D"),
            *_table(b"PolygonOnTriangulations"),
            *_table(b"Surfaces", surfaces),
            *_table(b"Triangulations"),
            first,
        ]
        for point, behind in zip(points, others, strict=True):
            parts += (_PLACE.pack(*point), behind)
        return unpack_shape(b"".join(parts))

    @cached_property
    def _before_curves(self) -> bytes:
        return b"".join((_HEAD, *_table(b"Curve2ds", self._parameters)))

    @cached_property
    def _between_points(self) -> list[bytes]:
        """The records of all shapes, in pieces, between which the points of the vertices go."""
        count = len(self._shapes)
        pieces = [b"\nTShapes %d\n" % count]
        for record, members in self._shapes:
            pieces[-1] += record[0]
            pieces += record[1:]
            for one in members:
                pieces[-1] += _SUBSHAPE.pack(_REVERSED if one < 0 else _FORWARD, count + 1 - abs(one), 0)
            pieces[-1] += _NO_MORE
        pieces[-1] += _SUBSHAPE.pack(_FORWARD, 1, 0)
        return pieces

    def _added(self, members: tuple[int, ...], *record: bytes) -> int:
        self._shapes.append((list(record), members))
        return len(self._shapes)


def _table(name: bytes, records: Sequence[bytes] = ()) -> tuple[bytes, ...]:
    return (b"%s %d\n" % (name, len(records)), *records)
