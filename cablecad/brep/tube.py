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
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge, BRepBuilderAPI_MakeWire
from OCP.BRepOffsetAPI import BRepOffsetAPI_MakePipeShell
from OCP.Geom import Geom_BSplineCurve, Geom_Circle
from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt
from OCP.TopoDS import TopoDS, TopoDS_Edge, TopoDS_Solid

from cablecad.brep.binary import (
    Axes,
    KnotVector,
    Topology,
    circle,
    circle2d,
    cylinder,
    line,
    line2d,
    plane,
    spline,
    spline_surface,
)
from cablecad.brep.kernel import array1_of_doubles, array1_of_ints, array1_of_points, occ_errors, silence
from cablecad.brep.knots import DEGREE
from cablecad.brep.spline import FittedCentreline, FittedPiece
from cablecad.centreline import Array, Line
from cablecad.errors import GeometryError, UsageError

Method = Literal["direct", "pipe_shell"]

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
    curves, in one of a hundred of steep helices, and in all of cables between two lead-outs that were shelled. Offset
    surfaces mesh rightly once they are B-splines, by `ShapeCustom.ConvertToBSpline_s(shape, False, False, True)`.
    """
    if method not in get_args(Method):
        raise UsageError(f"no method {method!r} to make a tube; take one of {', '.join(get_args(Method))}")
    with occ_errors(GeometryError, "making the tube", "try another tolerance or report the scene"):
        return _direct(fit, radius) if method == "direct" else _pipe_shell(fit, radius)


# --- the direct construction --------------------------------------------------------------------------------------


def _direct(fit: FittedCentreline, radius: float) -> TopoDS_Solid:
    corners = _corners(fit)
    reach = max(abs(x) for position, _, _ in corners for x in position) + fit.length
    axes = [Axes(*corner) for corner in corners]
    points = [tuple(p + radius * n for p, n in zip(at, normal, strict=True)) for at, _, normal in corners]
    decimals = _decimals(fit.tolerance)
    circles = [circle(one, radius) for one in axes]
    seams, surfaces = [], []
    for i, piece in enumerate(fit.pieces):
        if isinstance(piece, Line):
            surfaces.append(cylinder(axes[i], radius))
            seams.append(line(points[i], axes[i].main))
        else:
            surface, seam = _spline_side(piece, radius, decimals)
            surfaces.append(surface)
            seams.append(seam)
    tops = tuple(piece.length if isinstance(piece, Line) else None for piece in fit.pieces)
    topology = _topology(tops, radius, max(_EDGE_TOLERANCE, 1e-14 * reach))
    solid = topology.with_geometry(points, circles + seams, [*surfaces, plane(axes[0]), plane(axes[-1])])
    return TopoDS.Solid(solid)


def _corners(fit: FittedCentreline) -> list[list[list[float]]]:
    """Position [mm], tangent and normal where pieces begin and end."""
    ends = [_end_frames(piece) for piece in fit.pieces]
    return [ends[0][0].tolist(), *(end.tolist() for _, end in ends)]


def _end_frames(piece: Line | FittedPiece) -> tuple[Array, Array]:
    """Position, tangent and normal at both ends of a piece, shape (3, 3) each."""
    if isinstance(piece, FittedPiece):
        return piece.ends[0], piece.ends[1]
    at = piece.frames(np.array([0.0, piece.length]))
    start, end = np.stack([at.position, at.tangent, at.normal], axis=1)
    return start, end


@lru_cache(maxsize=64)
def _topology(tops: tuple[float | None, ...], radius: float, tolerance: float) -> Topology:
    """What tubes of as many pieces share; each piece has a side, with a circle at either end and a seam between them.

    Curves are the circles, one after the other, then the seams; surfaces the sides, then the planes of start and end.

    Args:
        tops: Where the v of each side ends: at the length of a cylinder [mm]; None on a spline, where it is 1.
        radius: Of the tube [mm].
        tolerance: Of Open Cascade's [mm].
    """
    shapes, count = Topology(tolerance), len(tops)
    ranges = [1.0 if top is None else top for top in tops]
    start_plane, end_plane = count + 1, count + 2
    on: list[list[tuple[int, int]]] = [[] for _ in range(count + 1)]
    for i, top in enumerate(tops):
        for station, v in ((i, 0.0), (i + 1, ranges[i])):
            around = _circle_parameter(*_circle_form(radius), v) if top is None else line2d(0.0, v, 1.0, 0.0)
            on[station].append((i + 1, shapes.add_parameters(around)))
    for station, flat in ((0, start_plane), (-1, end_plane)):
        # Open Cascade would work it out whenever it is asked for.
        on[station].append((flat, shapes.add_parameters(circle2d(radius))))
    vertices = [shapes.vertex() for _ in on]
    circles = [
        shapes.edge(i, (0.0, 2.0 * math.pi), (vertex, vertex), faces)
        for i, (vertex, faces) in enumerate(zip(vertices, on, strict=True), 1)
    ]
    sides = []
    for i, top in enumerate(tops):
        turn = 1.0 if top is None else 2.0 * math.pi
        forward, back = (shapes.add_parameters(line2d(u, 0.0, 0.0, 1.0)) for u in (turn, 0.0))
        ends = vertices[i], vertices[i + 1]
        seam = shapes.edge(count + 2 + i, (0.0, ranges[i]), ends, seam=(i + 1, forward, back))
        # Counterclockwise in (u, v): along the start, up the seam, back along the end, down the seam.
        sides.append(shapes.face(i + 1, shapes.wire(circles[i], seam, -circles[i + 1], -seam)))
    start, end = (
        shapes.face(flat, shapes.wire(edge)) for flat, edge in ((start_plane, circles[0]), (end_plane, circles[-1]))
    )
    # The tangent points inward at the start.
    shapes.solid(shapes.shell(*sides, -start, end))
    return shapes


def _spline_side(piece: FittedPiece, radius: float, decimals: int) -> tuple[bytes, bytes]:
    """The surface spline times circle, and its seam at u = 0."""
    poles = _rounded(np.swapaxes(_circle_poles(radius) @ piece.poles.reshape(-1, 3, 3), 0, 1), decimals)
    along = KnotVector(DEGREE, piece.knots, _clamped_multiplicities(len(piece.knots), DEGREE))
    return spline_surface(poles, _CIRCLE_WEIGHTS, _CIRCLE_KNOTS, along), spline(poles[0], along)


@lru_cache(maxsize=64)
def _circle_poles(radius: float) -> Array:
    """A circle's poles, shape (8, 3), by its middle, the normal and the binormal."""
    return np.column_stack([np.ones(len(_CIRCLE_POLES)), radius * _CIRCLE_POLES])


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


@lru_cache(maxsize=16)
def _circle_parameter(arcs: int, degree: int, v: float) -> bytes:
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
    return spline(points, KnotVector(degree, np.linspace(0.0, 2.0 * math.pi, arcs + 1), multiplicities))


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


@lru_cache(maxsize=256)
def _clamped_multiplicities(count: int, degree: int) -> NDArray[np.int_]:
    """Of the knots of a spline that begins and ends in a pole."""
    multiplicities = np.ones(count, dtype=int)
    multiplicities[[0, -1]] = degree + 1
    return multiplicities


# --- Open Cascade's own sweep, as an oracle -----------------------------------------------------------------------

_SWEEP_TOLERANCE = 1e-6
"""[mm]; at 1e-8 the sweep fails silently on some curves."""


def _point(position: Array) -> gp_Pnt:
    return gp_Pnt(*position.tolist())


def _direction(vector: Array) -> gp_Dir:
    return gp_Dir(*vector.tolist())


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
