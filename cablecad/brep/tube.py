"""From a fitted centreline to a solid: the tube's faces built directly, without Open Cascade's sweeps.

A side face is the piece's spline of (position, normal, binormal) times an exact rational circle of eight poles, which
are rounded to decimals that nobody can measure: as text they take three quarters of the room. A straight piece's is a
true cylinder. The circles at the caps and between pieces are true circles, so other CAD finds the connector's axis; on
a spline side they need a parameter curve, u(angle), which is the same for every tube.

`method="pipe_shell"` hands the spine to Open Cascade's sweep instead: an independent oracle, slower, for tests and for
the report of speed against error.

Source: for the circle, J. J. Chou, Higher order Bezier circles, Computer-Aided Design 27 (1995) 303-309.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Literal, NamedTuple, cast, get_args

import numpy as np
from numpy.typing import NDArray
from OCP.BRep import BRep_Builder, BRep_Tool
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge, BRepBuilderAPI_MakeWire
from OCP.BRepOffsetAPI import BRepOffsetAPI_MakePipeShell
from OCP.Geom import (
    Geom_BSplineCurve,
    Geom_Circle,
    Geom_Curve,
    Geom_CylindricalSurface,
    Geom_Line,
    Geom_Plane,
    Geom_Surface,
)
from OCP.Geom2d import Geom2d_BSplineCurve, Geom2d_Circle, Geom2d_Curve, Geom2d_Line
from OCP.GeomAbs import GeomAbs_CN
from OCP.gp import gp_Ax2, gp_Ax3, gp_Ax22d, gp_Dir, gp_Dir2d, gp_Pnt, gp_Pnt2d
from OCP.TopAbs import TopAbs_Orientation
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS, TopoDS_Edge, TopoDS_Face, TopoDS_Shell, TopoDS_Solid, TopoDS_Vertex, TopoDS_Wire

from cablecad.brep.kernel import (
    array1_of_doubles,
    array1_of_ints,
    array1_of_points,
    array1_of_points2d,
    occ_errors,
    silence,
)
from cablecad.brep.knots import DEGREE
from cablecad.brep.spline import FittedCentreline, FittedPiece
from cablecad.brep.surface import KnotVector, bspline_surface
from cablecad.centreline import Array, Line
from cablecad.errors import GeometryError, UsageError

Method = Literal["direct", "pipe_shell"]

_HERE = TopLoc_Location()
_REVERSED = TopAbs_Orientation.TopAbs_REVERSED  # what is not, is forward

# The unit circle as one rational curve of degree five, the least with positive weights: as smooth around as along, as
# Open Cascade's offsets want it; three quadratic arcs are no more than C0 to it. Two knots bring the poles, else up to
# four radii away, to two: Open Cascade's boxes are those of the poles, unless it is told to look closer.
_CIRCLE_WEIGHTS = np.array([45.0, 33.0, 17.0, 9.0, 9.0, 17.0, 33.0, 45.0])[:, None]
_CIRCLE_POLES = (
    np.array([[45, 0], [33, 12], [9, 24], [-19, 14], [-19, -14], [9, -24], [33, -12], [45, 0]]) / _CIRCLE_WEIGHTS
)
_CIRCLE_KNOTS = KnotVector(5, [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0], [6, 1, 1, 6])

_CIRCLE_SLIP = 1e-8
"""How far a cap's parameter curve may slip along the true circle [mm]: a tenth of Open Cascade's edge tolerance. The
shape is not touched by it, for both curves lie on the same circle."""

_CIRCLE_ERRORS = (1.25, 2.1, 1.5)
"""The error of a parameter curve of one, two or three arcs n [rad] is below these by base^degree, for odd degrees, with
the base n + 1 + sqrt((n + 1)^2 - 1): tan(psi / 4) has its poles at psi = +-360 degrees, which from the middle of an
outer arc is n + 1 times as far as its ends."""

_CIRCLE_DEGREES = 5, 17
"""Least and greatest degree of a parameter curve; a higher one would be rounded away in Open Cascade, which evaluates
it by its powers."""

_WHOLE = 2.0**52
"""Doubles below this have all whole numbers, and the halves between them."""

_EDGE_TOLERANCE = 1e-7
"""Open Cascade's own confusion distance [mm]; never less, more only where coordinates are so large that they round."""


def build_tube(fit: FittedCentreline, radius: float, *, method: Method = "direct") -> TopoDS_Solid:
    """Make the solid of a tube around a fitted centreline.

    Args:
        fit: Lines and splines; the caller has seen to it that the tube does not cut into itself.
        radius: Of the tube [mm].
        method: "direct", or "pipe_shell" for Open Cascade's own sweep to 1e-6 mm.

    Returns:
        A closed solid: one side face a piece, a plane with a true circle at each end ("direct").

    Raises:
        UsageError: There is no such method.
        GeometryError: Open Cascade failed.

    Limits: Open Cascade's own use of the solid, healing and reading STEP among it, is right for lengths up to 1e8 radii
    (tests/brep/test_tube.py), as long as radii are above its confusion of 1e-7 mm: from 1e-6 mm on. Its mesher may join
    the seam to itself straight across a side face and leave the strip out: it did so in none of 1500 meshes of plane
    curves, in one of a hundred of steep helices.
    """
    if method not in get_args(Method):
        raise UsageError(f"no method {method!r} to make a tube; take one of {', '.join(get_args(Method))}")
    with occ_errors(GeometryError, "making the tube", "try another tolerance or report the scene"):
        return _direct(fit, radius) if method == "direct" else _pipe_shell(fit, radius)


# --- the direct construction --------------------------------------------------------------------------------------


class _Station(NamedTuple):
    """The circle at an end of a piece, running from the normal towards the binormal.

    Attributes:
        axes: Its middle, the tangent and the normal.
        vertex: Where it begins and ends.
        circle: The edge.
    """

    axes: gp_Ax3
    vertex: TopoDS_Vertex
    circle: TopoDS_Edge


def _direct(fit: FittedCentreline, radius: float) -> TopoDS_Solid:
    builder = BRep_Builder()
    frames = [_end_frames(piece) for piece in fit.pieces]
    corners = [frames[0][0]] + [ends[1] for ends in frames]
    reach = max(abs(x) for corner in corners for x in corner[0].tolist()) + fit.length
    tolerance = max(_EDGE_TOLERANCE, 1e-14 * reach)
    stations = [_station(builder, corner, radius, tolerance) for corner in corners]
    shell = TopoDS_Shell()
    builder.MakeShell(shell)
    decimals = _decimals(fit.tolerance)
    for piece, start, end in zip(fit.pieces, stations, stations[1:], strict=False):
        builder.Add(shell, _side(builder, piece, start, end, radius, decimals, tolerance))
    builder.Add(shell, _cap(builder, stations[0], radius, tolerance, at_end=False))
    builder.Add(shell, _cap(builder, stations[-1], radius, tolerance, at_end=True))
    shell.Closed(True)
    solid = TopoDS_Solid()
    builder.MakeSolid(solid)
    builder.Add(solid, shell)
    return solid


def _end_frames(piece: Line | FittedPiece) -> tuple[Array, Array]:
    """Position, tangent and normal at both ends of a piece, shape (3, 3) each."""
    if isinstance(piece, FittedPiece):
        return piece.ends[0], piece.ends[1]
    at = piece.frames(np.array([0.0, piece.length]))
    start, end = np.stack([at.position, at.tangent, at.normal], axis=1)
    return start, end


def _station(builder: BRep_Builder, frame: Array, radius: float, tolerance: float) -> _Station:
    """The station with a frame: position, tangent and normal, shape (3, 3)."""
    position, tangent, normal = frame.tolist()
    axes = gp_Ax3(gp_Pnt(*position), gp_Dir(*tangent), gp_Dir(*normal))
    vertex = TopoDS_Vertex()
    builder.MakeVertex(vertex, gp_Pnt(*(p + radius * n for p, n in zip(position, normal, strict=True))), tolerance)
    edge = TopoDS_Edge()
    builder.MakeEdge(edge, Geom_Circle(axes.Ax2(), radius), tolerance)
    builder.Add(edge, vertex)
    builder.Add(edge, vertex.Oriented(_REVERSED))
    builder.Range(edge, 0.0, 2.0 * math.pi)
    return _Station(axes, vertex, edge)


def _side(
    builder: BRep_Builder,
    piece: Line | FittedPiece,
    start: _Station,
    end: _Station,
    radius: float,
    decimals: int,
    tolerance: float,
) -> TopoDS_Face:
    """The side face of one piece: around it u from 0 to `turn`, along it v from 0 to `top`."""
    if isinstance(piece, Line):
        surface: Geom_Surface = Geom_CylindricalSurface(start.axes, radius)
        seam_curve: Geom_Curve = Geom_Line(BRep_Tool.Pnt_s(start.vertex), start.axes.Direction())
        turn, top = 2.0 * math.pi, piece.length
    else:
        surface, seam_curve = _spline_side(piece, radius, decimals)
        turn, top = 1.0, 1.0
    face = TopoDS_Face()
    builder.MakeFace(face, surface, _HERE, tolerance)
    seam = TopoDS_Edge()
    builder.MakeEdge(seam, seam_curve, tolerance)
    builder.Add(seam, start.vertex)
    builder.Add(seam, end.vertex.Oriented(_REVERSED))
    builder.Range(seam, 0.0, top)
    builder.UpdateEdge(seam, _line2d(turn, 0.0, 0.0, 1.0), _line2d(0.0, 0.0, 0.0, 1.0), face, tolerance)
    builder.Continuity(seam, face, face, GeomAbs_CN)
    for station, v in ((start, 0.0), (end, top)):
        around = (
            _line2d(0.0, v, 1.0, 0.0)
            if isinstance(piece, Line)
            else cast(Geom2d_Curve, _circle_parameter(*_circle_form(radius), v).Copy())
        )
        builder.UpdateEdge(station.circle, around, face, tolerance)
    wire = TopoDS_Wire()
    builder.MakeWire(wire)
    # Counterclockwise in (u, v): along the start, up the seam, back along the end, down the seam.
    builder.Add(wire, start.circle)
    builder.Add(wire, seam)
    builder.Add(wire, end.circle.Oriented(_REVERSED))
    builder.Add(wire, seam.Oriented(_REVERSED))
    wire.Closed(True)
    builder.Add(face, wire)
    return face


def _spline_side(piece: FittedPiece, radius: float, decimals: int) -> tuple[Geom_Surface, Geom_Curve]:
    """The surface spline times circle, and its seam at u = 0."""
    position, normal, binormal = piece.poles[:, 0:3], piece.poles[:, 3:6], piece.poles[:, 6:9]
    a, b = radius * _CIRCLE_POLES[:, 0, None, None], radius * _CIRCLE_POLES[:, 1, None, None]
    poles = _rounded(position + a * normal + b * binormal, decimals)  # (8, spans + 9, 3)
    along = KnotVector(DEGREE, piece.knots, _clamped_multiplicities(len(piece.knots), DEGREE))
    surface = bspline_surface(poles, _CIRCLE_WEIGHTS, _CIRCLE_KNOTS, along)
    return surface, surface.UIso(0.0)


def _decimals(tolerance: float) -> int:
    """Decimals of poles [mm], which move a side by a hundred-thousandth of its tolerance at most, and by 1e-9 mm.

    A fit keeps a hundredth of its tolerance free.
    """
    return max(9, math.ceil(5.0 - math.log10(tolerance) - 1e-9))


def _rounded(poles: Array, decimals: int) -> Array:
    """Poles to so many decimals, or as they are where doubles have no room for them."""
    scale = 10.0**decimals
    # Adding zero takes the sign from zeros, which is rounding.
    return np.rint(poles * scale) / scale + 0.0 if float(np.abs(poles).max()) * scale < _WHOLE else poles


def _cap(builder: BRep_Builder, station: _Station, radius: float, tolerance: float, *, at_end: bool) -> TopoDS_Face:
    """The plane at an end, bounded by the true circle; reversed at the start, where the tangent points inward."""
    face = TopoDS_Face()
    builder.MakeFace(face, Geom_Plane(station.axes), _HERE, tolerance)
    # Open Cascade would work it out whenever it is asked for.
    builder.UpdateEdge(station.circle, Geom2d_Circle(gp_Ax22d(), radius), face, tolerance)
    wire = TopoDS_Wire()
    builder.MakeWire(wire)
    builder.Add(wire, station.circle)
    wire.Closed(True)
    builder.Add(face, wire)
    return face if at_end else TopoDS.Face(face.Oriented(_REVERSED))


@lru_cache(maxsize=16)
def _circle_parameter(arcs: int, degree: int, v: float) -> Geom2d_BSplineCurve:
    """A circle on a spline side at constant `v`: u as a function of the angle on the true circle [rad].

    The rational curve with parameter t runs through the angle psi from its middle by t = (1 + tan(psi / 4)) / 2. Here
    each of some equal arcs of that is a Bezier curve, through Chebyshev's points.
    """
    share = (1.0 - np.cos(np.linspace(0.0, math.pi, degree + 1))) / 2.0
    t = (1.0 + np.tan(((np.arange(arcs)[:, None] + share) / arcs - 0.5) * (math.pi / 2.0))) / 2.0
    t[0, 0], t[-1, -1] = 0.0, 1.0
    powers = np.arange(degree + 1)
    choose = [math.comb(degree, k) for k in range(degree + 1)]
    bernstein = choose * share[:, None] ** powers * (1.0 - share[:, None]) ** powers[::-1]
    each = np.linalg.solve(bernstein, t.T).T
    each[:, [0, -1]] = t[:, [0, -1]]
    poles = np.append(each[:, :-1], 1.0)
    multiplicities = np.full(arcs + 1, degree)
    multiplicities[[0, -1]] = degree + 1
    points = np.stack([poles, np.full(len(poles), v)], axis=1)
    knots = np.linspace(0.0, 2.0 * math.pi, arcs + 1)
    return Geom2d_BSplineCurve(
        array1_of_points2d(points), array1_of_doubles(knots), array1_of_ints(multiplicities), degree, False
    )


@lru_cache(maxsize=64)
def _circle_form(radius: float) -> tuple[int, int]:
    """Arcs and degree of the parameter curve that lets it slip by `_CIRCLE_SLIP` at most: the fewest arcs that do."""
    least, greatest = _CIRCLE_DEGREES
    for arcs, error in enumerate(_CIRCLE_ERRORS, 1):
        base = arcs + 1.0 + math.sqrt((arcs + 1.0) ** 2 - 1.0)
        degree = math.ceil(math.log(error * radius / _CIRCLE_SLIP, base)) | 1
        if degree <= greatest:
            return arcs, max(degree, least)
    return len(_CIRCLE_ERRORS), greatest


def _clamped_multiplicities(count: int, degree: int) -> NDArray[np.int_]:
    """Of the knots of a spline that begins and ends in a pole."""
    multiplicities = np.ones(count, dtype=int)
    multiplicities[[0, -1]] = degree + 1
    return multiplicities


def _line2d(u: float, v: float, du: float, dv: float) -> Geom2d_Curve:
    return Geom2d_Line(gp_Pnt2d(u, v), gp_Dir2d(du, dv))


def _point(position: Array) -> gp_Pnt:
    return gp_Pnt(*position.tolist())


def _direction(vector: Array) -> gp_Dir:
    return gp_Dir(*vector.tolist())


# --- Open Cascade's own sweep, as an oracle -----------------------------------------------------------------------

_SWEEP_TOLERANCE = 1e-6
"""[mm]; at 1e-8 the sweep fails silently on some curves."""


def _pipe_shell(fit: FittedCentreline, radius: float) -> TopoDS_Solid:
    wire = BRepBuilderAPI_MakeWire()
    for piece in fit.pieces:
        wire.Add(_spine_edge(piece))
    position, tangent, normal = _end_frames(fit.pieces[0])[0]
    circle = Geom_Circle(gp_Ax2(_point(position), _direction(tangent), _direction(normal)), radius)
    profile = BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(circle).Edge()).Wire()
    sweep = BRepOffsetAPI_MakePipeShell(wire.Wire())
    sweep.SetMode(False)  # corrected Frenet: plain Frenet flips at inflections
    sweep.SetTolerance(_SWEEP_TOLERANCE)
    sweep.Add(profile)
    with silence():
        sweep.Build()
    if not sweep.IsDone() or not sweep.MakeSolid():
        raise GeometryError("Open Cascade's pipe shell failed on this centreline; use the direct method")
    return TopoDS.Solid(sweep.Shape())


def _spine_edge(piece: Line | FittedPiece) -> TopoDS_Edge:
    if isinstance(piece, Line):
        ends = piece.frames(np.array([0.0, piece.length])).position
        return BRepBuilderAPI_MakeEdge(_point(ends[0]), _point(ends[1])).Edge()
    multiplicities = _clamped_multiplicities(len(piece.knots), DEGREE)
    # Parametrised by arclength in mm: the sweep's tolerances count in it.
    knots = array1_of_doubles(piece.knots * piece.length)
    curve = Geom_BSplineCurve(
        array1_of_points(piece.poles[:, :3]), knots, array1_of_ints(multiplicities), DEGREE, False
    )
    return BRepBuilderAPI_MakeEdge(curve).Edge()
