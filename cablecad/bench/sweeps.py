"""The tube's rivals: spines and sweeps of Open Cascade, and of CadQuery and build123d where they are installed.

Each is what a user of them would write. All give a solid of a tube along the points or the fitted spline of an exact
centreline, in the plane of x and y.
"""

from __future__ import annotations

from importlib.util import find_spec
from typing import Any

import numpy as np
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge, BRepBuilderAPI_MakeFace, BRepBuilderAPI_MakeWire
from OCP.BRepOffsetAPI import BRepOffsetAPI_MakePipe, BRepOffsetAPI_MakePipeShell
from OCP.Geom import Geom_BSplineCurve
from OCP.GeomAPI import GeomAPI_Interpolate
from OCP.gp import gp_Ax2, gp_Circ, gp_Dir, gp_Pnt
from OCP.TopoDS import TopoDS, TopoDS_Shape, TopoDS_Wire

from cablecad.bench.scenes import Array
from cablecad.brep.kernel import HArray1_gp_Pnt, array1_of_doubles, array1_of_ints, array1_of_points, silence
from cablecad.brep.knots import DEGREE
from cablecad.brep.spline import FittedCentreline, FittedPiece
from cablecad.centreline import Centreline
from cablecad.errors import GeometryError

CONFUSION = 1e-7
"""Open Cascade's own least distance of points [mm]."""


def interpolated_spine(points: Array) -> TopoDS_Wire:
    """A cubic spline through points, shape (n, 3) [mm], by `GeomAPI_Interpolate`."""
    array = HArray1_gp_Pnt(1, len(points))
    for i, point in enumerate(points.tolist()):
        array.SetValue(i + 1, gp_Pnt(*point))
    maker = GeomAPI_Interpolate(array, False, CONFUSION)
    maker.Perform()
    return _wire(maker.Curve())


def fitted_spine(fit: FittedCentreline) -> TopoDS_Wire:
    """Our own fit of one smooth piece, by arclength [mm]."""
    piece = fit.pieces[0]
    if not isinstance(piece, FittedPiece) or len(fit.pieces) != 1:
        raise GeometryError("the sweep is measured on one smooth piece; give a centreline without lead-outs")
    multiplicities = np.ones(len(piece.knots), dtype=int)
    multiplicities[[0, -1]] = DEGREE + 1
    knots = array1_of_doubles(piece.knots * piece.length)
    poles = array1_of_points(piece.poles[:, :3])
    return _wire(Geom_BSplineCurve(poles, knots, array1_of_ints(multiplicities), DEGREE, False))


def quintic_spine(centreline: Centreline, spans: int) -> TopoDS_Wire:
    """A C4 quintic spline of equal spans by arclength [mm], tangent and curvature given at its ends.

    The best spine for a sweep if its spans are many: no ripple of a spline at its limit has to be followed.
    """
    from scipy.interpolate import make_interp_spline

    s = np.linspace(0.0, centreline.length, spans + 1)
    ends = centreline.frames([0.0, centreline.length])
    bend = centreline.bishop([0.0, centreline.length])[0]
    second = bend[:, :1] * ends.normal + bend[:, 1:] * ends.binormal
    conditions: Any = tuple([(1, ends.tangent[i]), (2, second[i])] for i in range(2))
    poles = make_interp_spline(s, centreline.position(s), k=5, bc_type=conditions).c
    multiplicities = np.ones(spans + 1, dtype=int)
    multiplicities[[0, -1]] = 6
    knots = array1_of_doubles(s)
    return _wire(Geom_BSplineCurve(array1_of_points(poles), knots, array1_of_ints(multiplicities), 5, False))


def sweep_pipe(spine: TopoDS_Wire, start: Array, tangent: Array, radius: float) -> TopoDS_Shape:
    """`BRepOffsetAPI_MakePipe`, which has no tolerance to set.

    Raises:
        GeometryError: It failed and said so.
    """
    with silence():
        face = BRepBuilderAPI_MakeFace(_circle(start, tangent, radius)).Face()
        sweep = BRepOffsetAPI_MakePipe(spine, face)
        if not sweep.IsDone():
            raise GeometryError("Open Cascade's pipe failed")
        return sweep.Shape()


def sweep_pipe_shell(
    spine: TopoDS_Wire, start: Array, tangent: Array, radius: float, *, tolerance: float
) -> TopoDS_Shape:
    """`BRepOffsetAPI_MakePipeShell` with the corrected Frenet frame, to a tolerance [mm].

    Raises:
        GeometryError: It failed and said so.
    """
    with silence():
        sweep = BRepOffsetAPI_MakePipeShell(spine)
        sweep.SetMode(False)
        sweep.SetTolerance(tolerance)
        sweep.Add(_circle(start, tangent, radius))
        sweep.Build()
        if not sweep.IsDone() or not sweep.MakeSolid():
            raise GeometryError(f"Open Cascade's pipe shell failed at a tolerance of {tolerance:g} mm")
        return TopoDS.Solid(sweep.Shape())


def installed_hosts() -> list[str]:
    """Of CadQuery and build123d those that are there."""
    return [name for name in ("cadquery", "build123d") if find_spec(name) is not None]


def sweep_by_host(host: str, points: Array, tangents: Array, radius: float) -> TopoDS_Shape:
    """A host's own spline through points [mm], tangents given at its ends, and its own sweep of a circle."""
    if host == "cadquery":
        return _sweep_by_cadquery(points, tangents, radius)
    return _sweep_by_build123d(points, tangents, radius)


def _sweep_by_cadquery(points: Array, tangents: Array, radius: float) -> TopoDS_Shape:
    import cadquery

    vectors = [cadquery.Vector(*point) for point in points.tolist()]
    path = cadquery.Edge.makeSpline(vectors, tangents=[cadquery.Vector(*tangents[i].tolist()) for i in (0, -1)])
    plane = cadquery.Plane(origin=tuple(points[0].tolist()), normal=tuple(tangents[0].tolist()))
    swept: Any = cadquery.Workplane(plane).circle(radius).sweep(cadquery.Workplane(path))
    shape: TopoDS_Shape = swept.val().wrapped
    return shape


def _sweep_by_build123d(points: Array, tangents: Array, radius: float) -> TopoDS_Shape:
    import build123d

    path = build123d.Spline(
        *[tuple(point) for point in points.tolist()], tangents=[tuple(tangents[i].tolist()) for i in (0, -1)]
    )
    plane = build123d.Plane(origin=tuple(points[0].tolist()), z_dir=tuple(tangents[0].tolist()))
    swept: Any = build123d.sweep(plane * build123d.Circle(radius), path=path)
    shape: TopoDS_Shape = swept.wrapped
    return shape


def _circle(start: Array, tangent: Array, radius: float) -> TopoDS_Wire:
    axes = gp_Ax2(gp_Pnt(*start.tolist()), gp_Dir(*tangent.tolist()))
    return BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(gp_Circ(axes, radius)).Edge()).Wire()


def _wire(curve: Any) -> TopoDS_Wire:
    return BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(curve).Edge()).Wire()
