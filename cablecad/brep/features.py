"""Features of a shape where a cable may end: circular edges, cylindrical faces and plane faces, each with its port.

A feature's port is its centre and its axis out of the material:

* a circular edge: the circle's centre, and of the two ways along its axis the one that leads away from the material
  beside the edge: out of a hole at its mouth and at its bottom, off a boss at its top. Where both are as free, for the
  faces meet without a corner, their bend decides: at the inner rim of a rounded mouth it is the way out of the cylinder
  the edge ends, and back through it where a rounded floor begins;
* a cylindrical face: the middle of its axis; out of the open end of a blind hole, off the free end of a boss, where
  both ends are open to the end that is nearer to the point that was given, and where both are closed neither;
* a plane face: the middle of its area (of its circle, if one circle bounds it), and its normal out of the material.

Arcs of less than half a turn are no features (they are fillets), nor is the foot of a boss, which leads into it.
Circles, cylinders and planes written as splines are seen too (`rounds`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, get_args

import numpy as np

from cablecad.brep.arcs import (
    SAME_PLACE,
    Arc,
    Side,
    bodies,
    circles,
    cylinders,
    explored,
    outward_of,
    round_arcs,
    unit_of,
)
from cablecad.brep.kernel import occ_errors, silence

# isort: split
from OCP.Bnd import Bnd_Box
from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.BRepBndLib import BRepBndLib
from OCP.BRepClass3d import BRepClass3d_SolidClassifier
from OCP.BRepGProp import BRepGProp
from OCP.BRepTools import BRepTools
from OCP.gp import gp_Dir, gp_Lin, gp_Pnt, gp_Vec
from OCP.GProp import GProp_GProps
from OCP.IntCurvesFace import IntCurvesFace_ShapeIntersector
from OCP.TopAbs import TopAbs_ShapeEnum, TopAbs_State
from OCP.TopoDS import TopoDS_Face, TopoDS_Shape

from cablecad.brep.rounds import Round, circle_of, is_plane, xyz
from cablecad.centreline import Array
from cablecad.errors import GeometryError

Kind = Literal["circular edge", "cylindrical face", "plane face"]

_FLAT = 0.999
"""The cosine from which on a face lies square to an axis."""

_BESIDE = 1e-4
"""A direction this close to a face [rad] runs along it: fillets meet their neighbours no better in many files."""

_DEEP = 8.0
"""The bottom of a hole is at most so many radii behind its wall: that of a cone of 14 degrees."""

_REMEDY = "give the end by position and outward"

_AREA_TOLERANCE = 1e-9
"""Relative tolerance of Open Cascade's adaptive integration; without one a middle is off by 2e-7 mm and more."""


@dataclass(frozen=True, eq=False)
class Feature:
    """A feature with its port.

    Attributes:
        kind: What it is.
        position: Its centre, shape (3,) [mm].
        axis: Unit vector, shape (3,).
        find_ways: Tells `ways`, or finds it when someone asks, which takes time for a cylinder; Open Cascade may fail.
        radius: [mm]; None for a plane face.
        extent: Length of a cylinder [mm], else 0.
        shapes: The edges or faces it is made of.
        bounds: Of an edge, the faces beside it.
    """

    kind: Kind
    position: Array
    axis: Array
    find_ways: tuple[int, ...] | Callable[[], tuple[int, ...]]
    radius: float | None
    extent: float
    shapes: tuple[TopoDS_Shape, ...]
    bounds: tuple[TopoDS_Shape, ...] = ()

    @cached_property
    def ways(self) -> tuple[int, ...]:
        """Out of the material along the axis: +1, -1, both where it cannot be told or both ends are open, or none.

        Raises:
            GeometryError: Open Cascade failed.
        """
        if not callable(self.find_ways):
            return self.find_ways
        with silence(), occ_errors(GeometryError, "looking for the open end of a cylinder", _REMEDY):
            return self.find_ways()


def find_features(shape: TopoDS_Shape, kinds: Collection[Kind] = get_args(Kind)) -> list[Feature]:
    """Every feature of a shape: edges first, then cylinders, then planes.

    Args:
        shape: A part, all its bodies placed.
        kinds: Of the features that are wanted; planes take the most time.

    Raises:
        GeometryError: Open Cascade failed.
    """
    with silence(), occ_errors(GeometryError, "looking for features of a part", _REMEDY):
        every = list(bodies(shape))
        found = [round_arcs(body, faces) for body, faces in enumerate(every)]
        edges = [arc for arcs, _ in found for arc in arcs]
        walls = [arc for _, arcs in found for arc in arcs]
        material = _Material(shape)
        features: list[Feature] = []
        if "circular edge" in kinds:
            rims = (_edge_feature(whole, group) for whole, group in circles(edges))
            features += (rim for rim in rims if rim is not None)
        if "cylindrical face" in kinds:
            features += (_cylinder_feature(whole, group, edges, material) for whole, group in cylinders(walls))
        if "plane face" in kinds:
            features += (plane for faces in every for plane in _planes(faces))
        return features


def _planes(faces: Sequence[TopoDS_Face]) -> Iterator[Feature]:
    for face in faces:
        surface = BRepAdaptor_Surface(face)
        if is_plane(face):
            point, du, dv = gp_Pnt(), gp_Vec(), gp_Vec()
            surface.D1(surface.FirstUParameter(), surface.FirstVParameter(), point, du, dv)
            normal = outward_of(face, xyz(du), xyz(dv))
            yield Feature("plane face", _middle(face), normal, (1,), None, 0.0, (face,))


def _middle(face: TopoDS_Face) -> Array:
    """The centre of the circle that bounds a plane face, or the middle of its area."""
    edges = explored(BRepTools.OuterWire_s(face), TopAbs_ShapeEnum.TopAbs_EDGE)
    rounds = [circle_of(edge) for edge in edges]
    truest = min((one for one in rounds if one is not None), key=lambda one: one.error, default=None)
    if truest is not None and all(_is_same(one, truest) for one in rounds):
        return truest.centre
    properties = GProp_GProps()
    BRepGProp.SurfaceProperties_s(face, properties, _AREA_TOLERANCE, False)
    return xyz(properties.CentreOfMass())


def _is_same(one: Round | None, truest: Round) -> bool:
    slack = SAME_PLACE + (10.0 * one.error if one is not None else 0.0)
    return one is not None and float(np.linalg.norm(one.centre - truest.centre)) < slack


# --- which way is out ---------------------------------------------------------------------------------------------


def _edge_feature(circle: Round, group: list[Arc]) -> Feature | None:
    """The circle its arcs make; None where it is no feature."""
    sides = [side for arc in group for side in arc.sides]
    if not sides or (len(sides) == 2 * len(group) and all(side.is_cylinder for side in sides)):
        return None  # of no face, or a line drawn around one cylinder
    free = {way: sum(_freedom(arc, way * circle.axis) for arc in group) for way in (1, -1)}
    ways: tuple[int, ...] = (1, -1)
    if free[1] != free[-1]:
        ways = (1,) if free[1] > free[-1] else (-1,)
    else:
        if any(_is_smooth_foot(arc) for arc in group):
            return None
        walls = {way for arc in group for way in _ways_past_walls(arc, circle.axis)}
        # A disc in no solid has its edge in the open on both sides; its normal tells which one is meant.
        tops = {int(np.sign(side.normal @ circle.axis)) for side in sides if abs(side.normal @ circle.axis) > _FLAT}
        if len(walls or tops) == 1 and 0 not in walls:
            ways = tuple(walls or tops)
    if len(ways) == 1 and any(_is_foot(arc, ways[0] * circle.axis) for arc in group):
        return None
    shapes, bounds = tuple(arc.shape for arc in group), tuple(face for arc in group for face in arc.bounds)
    return Feature("circular edge", circle.centre, circle.axis, ways, circle.radius, 0.0, shapes, bounds)


def _ways_past_walls(arc: Arc, axis: Array) -> Iterator[int]:
    """Out of each cylinder that ends at an edge without a corner; back through it where a hole's floor begins there."""
    for side in arc.sides:
        if side.is_cylinder:
            is_floor = not side.is_convex and _bend_beside(arc, side) < 0.0
            yield int(np.sign(side.inward @ axis) * (1 if is_floor else -1))


def _is_smooth_foot(arc: Arc) -> bool:
    """Whether a boss widens at its end without a corner, into what it stands on."""
    return any(side.is_cylinder and side.is_convex and _bend_beside(arc, side) < 0.0 for side in arc.sides)


def _bend_beside(arc: Arc, wall: Side) -> float:
    """How the face beyond the edge of a wall bends, where they meet without a corner."""
    return next((side.bend for side in arc.sides if side is not wall and side.normal @ wall.normal > _FLAT), 0.0)


def _freedom(arc: Arc, way: Array) -> float:
    """How free of material a way along the axis is at the rim: 2 in the open, 1 along a face, 0 into material."""
    if len(arc.sides) == 1:  # the rim of a sheet: away from the sheet
        return float(1 - np.sign(arc.sides[0].inward @ way))
    if len(arc.sides) != 2:
        return 1.0
    one = arc.sides[0]
    sweep = _material_angle(arc)
    at = _angle(one.inward, way, np.cross(one.normal, one.inward))
    if min(at, 2.0 * math.pi - at) < _BESIDE or abs(at - sweep) < _BESIDE:
        return 1.0
    return 0.0 if at < sweep else 2.0


def _material_angle(arc: Arc) -> float:
    """The angle the material fills at the rim, in the plane of the radius and the axis, from one face to the other."""
    one, other = arc.sides
    return _angle(one.inward, other.inward, np.cross(one.normal, one.inward))  # which turns it into the material


def _is_foot(arc: Arc, way: Array) -> bool:
    """Whether the edge is an inner corner from which a boss rises along the way, so that the way leads into it."""
    rises = any(side.is_convex and float(side.inward @ way) > _BESIDE for side in arc.sides)
    return rises and len(arc.sides) == 2 and _material_angle(arc) > math.pi + _BESIDE


def _angle(start: Array, end: Array, about: Array) -> float:
    """From one unit vector to another about an axis normal to both, from 0 to 2 pi [rad]."""
    angle = math.atan2(float(np.cross(start, end) @ about), float(start @ end))
    return angle % (2.0 * math.pi)


class _Material:
    """Asks a shape whether there is material at a point, or a face across a short way."""

    def __init__(self, shape: TopoDS_Shape) -> None:
        self._shape = shape
        self._solids: list[tuple[Bnd_Box, TopoDS_Shape]] | None = None
        self._crossing: IntCurvesFace_ShapeIntersector | None = None

    def holds(self, point: Array) -> bool:
        if self._solids is None:
            solids = explored(self._shape, TopAbs_ShapeEnum.TopAbs_SOLID)
            self._solids = [(bounding_box(solid), solid) for solid in solids]
        place = gp_Pnt(*point.tolist())
        for box, solid in self._solids:
            if not box.IsOut(place):
                classifier = BRepClass3d_SolidClassifier(solid, place, 1e-7)
                if classifier.State() == TopAbs_State.TopAbs_IN:
                    return True
        return False

    def crosses(self, point: Array, way: Array, length: float) -> bool:
        if self._crossing is None:
            self._crossing = IntCurvesFace_ShapeIntersector()
            self._crossing.Load(self._shape, 1e-7)
        self._crossing.Perform(gp_Lin(gp_Pnt(*point.tolist()), gp_Dir(*way.tolist())), 0.0, length)
        return bool(self._crossing.NbPnt())


def _cylinder_feature(whole: Round, group: list[Arc], edges: Sequence[Arc], material: _Material) -> Feature:
    shapes = tuple(arc.shape for arc in group)

    def find_ways() -> tuple[int, ...]:
        is_hole = group[0].is_hole
        ways = tuple(way for way in (1, -1) if _is_open(whole, way * whole.axis, material, is_hole=is_hole))
        if ways or is_hole:
            return ways
        # A boss whose top is round, or that bears a thinner one: what is not its foot is its end.
        feet = {way for way in (1, -1) if _stands(whole, way, shapes, edges)}
        return tuple(way for way in (1, -1) if way not in feet) if len(feet) == 1 else ()

    return Feature("cylindrical face", whole.centre, whole.axis, find_ways, whole.radius, whole.length, shapes)


def _stands(boss: Round, way: int, walls: Sequence[TopoDS_Shape], edges: Sequence[Arc]) -> bool:
    """Whether a boss stands on something at one of its ends."""
    out = way * boss.axis
    at_end = [arc for arc in edges if float((arc.round.centre - boss.centre) @ out) > 0.0]
    ends = [arc for arc in at_end if any(wall.IsSame(face) for wall in walls for face in arc.bounds)]
    return any(_is_smooth_foot(arc) or _is_foot(arc, -out) for arc in ends)


def _is_open(whole: Round, out: Array, material: _Material, *, is_hole: bool) -> bool:
    """Whether a cable could leave a cylinder at its end."""
    end = whole.centre + 0.5 * whole.length * out
    little = 0.01 * whole.radius
    if material.holds(end + little * out):
        return False
    if not is_hole:
        return True
    # Beside the axis, for the tip of a cone is no place to hit. A drilled hole ends in one, 0.3 to 0.6 radii deep.
    across = unit_of(np.cross(out, np.eye(3)[int(np.argmin(np.abs(out)))]))
    beside = end - little * out + 0.1 * whole.radius * across
    if material.crosses(beside, out, whole.radius):
        return False
    if not material.crosses(beside, out, _DEEP * whole.radius):
        return True
    # Deeper bottoms narrow all around from the end of the wall on, while another wall across a gap leaves it open.
    other = np.cross(out, across)
    ways = (across, other, -across, -other)
    return not all(material.crosses(end + 5.0 * little * out, way, whole.radius) for way in ways)


# --- single values ------------------------------------------------------------------------------------------------


def bounding_box(shape: TopoDS_Shape) -> Bnd_Box:
    """A box around a shape, a little too large."""
    box = Bnd_Box()
    BRepBndLib.Add_s(shape, box, False)
    return box
