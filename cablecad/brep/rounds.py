"""Circles and cylinders in the geometry of a part: true ones, and splines that are ones but for rounding.

Many files hold no circle at all: the translator that wrote them knew only splines. A spline is taken for a circle or a
cylinder where points of it are as far from the axis as they should be, to 2e-5 of the radius; exact rational ones are,
to 1e-12, and approximations of translators to 5e-6 (as1-oc-214, which has both, in halves of the same holes).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cablecad.brep.kernel import TopoDS

# isort: split
from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Curve, BRepAdaptor_Surface
from OCP.GeomAbs import GeomAbs_CurveType, GeomAbs_SurfaceType
from OCP.GeomLib import GeomLib_IsPlanarSurface
from OCP.gp import gp_Dir, gp_Pnt, gp_Vec
from OCP.TopoDS import TopoDS_Face, TopoDS_Shape

from cablecad.centreline import Array

_ROUND = 2e-5
"""How far a spline may be from a circle or cylinder that it is taken for, as a share of the radius."""

_FLAT = 1e-6
"""How far a spline may be from a plane that it is taken for [mm]."""

_SAMPLES = 24
"""Points along a spline, and around and along a face; more than any approximation of a circle has spans to hide in."""

_SPLINES = (GeomAbs_CurveType.GeomAbs_BSplineCurve, GeomAbs_CurveType.GeomAbs_BezierCurve)
_PATCHES = (
    GeomAbs_SurfaceType.GeomAbs_BSplineSurface,
    GeomAbs_SurfaceType.GeomAbs_BezierSurface,
    GeomAbs_SurfaceType.GeomAbs_SurfaceOfExtrusion,
    GeomAbs_SurfaceType.GeomAbs_SurfaceOfRevolution,
)


@dataclass(frozen=True, eq=False)
class Round:
    """A circle, or a cylinder, as far as it goes.

    Attributes:
        centre: Of the circle, or the middle of the cylinder's axis, shape (3,) [mm].
        axis: Unit vector.
        radius: [mm].
        turn: How far it goes around [rad].
        length: Of the cylinder along its axis [mm]; 0 of a circle.
        error: How far it is from a true one [mm].
    """

    centre: Array
    axis: Array
    radius: float
    turn: float
    length: float = 0.0
    error: float = 0.0


def circle_of(edge: TopoDS_Shape) -> Round | None:
    """The circle an edge is on; its axis as the circle has it, right-handed about the way a spline runs."""
    curve = BRepAdaptor_Curve(TopoDS.Edge(edge))
    first, last = curve.FirstParameter(), curve.LastParameter()
    if curve.GetType() == GeomAbs_CurveType.GeomAbs_Circle:
        circle = curve.Circle()
        return Round(xyz(circle.Location()), xyz(circle.Axis().Direction()), circle.Radius(), last - first)
    if curve.GetType() not in _SPLINES:
        return None
    points = np.array([xyz(curve.Value(t)) for t in np.linspace(first, last, _SAMPLES + 1).tolist()])
    _, sizes, directions = np.linalg.svd(points - points.mean(axis=0))
    if sizes[2] > _ROUND * sizes[0]:
        return None  # not in a plane
    return _fitted(points, directions[2])


def cylinder_of(face: TopoDS_Face) -> Round | None:
    """The cylinder a face is on."""
    surface = BRepAdaptor_Surface(face)
    u0, u1 = surface.FirstUParameter(), surface.LastUParameter()
    v0, v1 = surface.FirstVParameter(), surface.LastVParameter()
    if surface.GetType() == GeomAbs_SurfaceType.GeomAbs_Cylinder:
        cylinder = surface.Cylinder()
        axis = xyz(cylinder.Axis().Direction())
        point, du, dv = gp_Pnt(), gp_Vec(), gp_Vec()
        surface.D1(u0, 0.5 * (v0 + v1), point, du, dv)
        # The foot of the middle on the axis: left-handed cylinders run against it.
        foot = xyz(cylinder.Location())
        centre = foot + ((xyz(point) - foot) @ axis) * axis
        return Round(centre, axis, cylinder.Radius(), u1 - u0, v1 - v0)
    if surface.GetType() not in _PATCHES:
        return None
    around, along = np.linspace(0.0, 1.0, _SAMPLES + 1).tolist(), (0.0, 0.63, 1.0)
    by_u = [(u0 + a * (u1 - u0), v0 + b * (v1 - v0)) for a in around for b in along]
    by_v = [(u0 + b * (u1 - u0), v0 + a * (v1 - v0)) for a in around for b in along]
    return _patch_cylinder(surface, by_u) or _patch_cylinder(surface, by_v)


def _patch_cylinder(surface: BRepAdaptor_Surface, places: Sequence[tuple[float, float]]) -> Round | None:
    """The cylinder of a face, asked at parameters in rows of three along its axis, if it is there."""
    rows = []
    for u, v in places:
        point, du, dv = gp_Pnt(), gp_Vec(), gp_Vec()
        surface.D1(u, v, point, du, dv)
        rows.append((xyz(point), xyz(du), xyz(dv)))
    points, by_u, by_v = np.array(rows).transpose(1, 0, 2)
    normals = np.cross(by_u, by_v)
    lengths = np.linalg.norm(normals, axis=1)
    if not lengths.all():
        return None
    _, sizes, directions = np.linalg.svd(normals / lengths[:, None])
    if sizes[2] > 10.0 * _ROUND * sizes[0] or sizes[1] < _ROUND * sizes[0]:
        return None  # normals all around are no cylinder's, and of one direction a plane's
    axis = directions[2]
    heights = points @ axis
    if np.ptp(heights[::3]) > _ROUND * np.ptp(heights):
        return None  # the first of each row are not on one circle about the axis
    flat = points - (heights - heights[0])[:, None] * axis
    ring = _fitted(flat[::3], axis)
    if ring is None:
        return None
    error = float(np.abs(np.linalg.norm(flat - ring.centre, axis=1) - ring.radius).max())
    if error > _ROUND * ring.radius:
        return None
    middle = 0.5 * (heights.max() + heights.min())
    centre = ring.centre + (middle - ring.centre @ axis) * axis
    return Round(centre, axis, ring.radius, ring.turn, float(np.ptp(heights)), error)


def _fitted(points: Array, normal: Array) -> Round | None:
    """The circle of points in order along an arc in a plane, or None where they are not on one.

    Least squares for the centre and for the power of the point in it, from which the radius follows.
    """
    middle = points.mean(axis=0)
    first = points[np.argmax(np.linalg.norm(points - middle, axis=1))] - middle
    x = first / np.linalg.norm(first)
    y = np.cross(normal, x)
    flat = (points - middle) @ np.stack([x, y], axis=1)
    matrix = np.column_stack([2.0 * flat, np.ones(len(flat))])
    (a, b, c), _, rank, _ = np.linalg.lstsq(matrix, (flat**2).sum(axis=1), rcond=1e-9)
    if rank < 3:
        return None  # on a line
    spokes = flat - (a, b)
    distances = np.linalg.norm(spokes, axis=1)
    radius = math.sqrt(max(0.0, c + a * a + b * b))
    error = float(np.abs(distances - radius).max())
    if not radius or error > _ROUND * radius:
        return None
    angles = np.diff(np.unwrap(np.arctan2(spokes[:, 1], spokes[:, 0])))
    turn = float(angles.sum())
    if not (np.all(angles > 0.0) or np.all(angles < 0.0)):
        return None
    axis = normal if turn > 0.0 else -normal
    return Round(middle + a * x + b * y, axis, radius, abs(turn), 0.0, error)


def is_plane(face: TopoDS_Face) -> bool:
    """Whether a face is plane, as a spline is to 1e-6 mm."""
    kind = BRepAdaptor_Surface(face).GetType()
    if kind in (GeomAbs_SurfaceType.GeomAbs_BSplineSurface, GeomAbs_SurfaceType.GeomAbs_BezierSurface):
        return bool(GeomLib_IsPlanarSurface(BRep_Tool.Surface_s(face), _FLAT).IsPlanar())
    return bool(kind == GeomAbs_SurfaceType.GeomAbs_Plane)


def xyz(value: gp_Pnt | gp_Dir | gp_Vec) -> Array:
    """The coordinates of a point, direction or vector, shape (3,)."""
    return np.array([value.X(), value.Y(), value.Z()])
