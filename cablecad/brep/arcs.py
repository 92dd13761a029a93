"""Round edges and faces of a part, body by body, and which of them are pieces of one circle or cylinder.

Halves and thirds of a circle or cylinder, as many CAD packages write them, count as one; pieces of less than half a
turn in all are fillets and count as none. Bodies are looked at one by one, wherever an assembly places them. Ways out
of the material are told from the faces' own parameters and orientations, so that mirrored parts are right too.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from cablecad.brep.kernel import IndexedMap_TopoDS_Shape, TopoDS

# isort: split
from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Curve2d, BRepAdaptor_Surface
from OCP.gp import gp_Pnt, gp_Pnt2d, gp_Vec, gp_Vec2d
from OCP.TopAbs import TopAbs_Orientation, TopAbs_ShapeEnum
from OCP.TopExp import TopExp_Explorer
from OCP.TopoDS import TopoDS_Edge, TopoDS_Face, TopoDS_Shape

from cablecad.brep.rounds import Round, circle_of, cylinder_of, xyz
from cablecad.centreline import Array

_SOLID, _SHELL, _FACE, _EDGE = (
    TopAbs_ShapeEnum.TopAbs_SOLID,
    TopAbs_ShapeEnum.TopAbs_SHELL,
    TopAbs_ShapeEnum.TopAbs_FACE,
    TopAbs_ShapeEnum.TopAbs_EDGE,
)
_FORWARD, _REVERSED = TopAbs_Orientation.TopAbs_FORWARD, TopAbs_Orientation.TopAbs_REVERSED

SAME_PLACE = 1e-5
"""Centres, axes and radii closer than this belong to one circle [mm]: more than CAD packages round in STEP files, and
less than any two circles that are meant to be two."""

_SAME_ANGLE = 1e-6
"""Axes closer than this are one [rad]; of splines ten times their error as an angle."""

_TRUE = 1e-9
"""A circle this close to a true one, as a share of its radius, is one."""

_ALONG = (0.1, 0.3, 0.5, 0.7, 0.9)
"""Where along an edge the bend of a face is looked at: that of an elbow has two signs."""

_BENT = 1e-3
"""Least curvature of a bend, over that of the edge."""

_HALF_TURN = math.pi * (1.0 - 1e-4)


@dataclass(frozen=True, eq=False)
class Side:
    """A face beside an edge, at a point of the edge.

    Attributes:
        inward: Unit vector along the face away from the edge.
        normal: Unit vector out of the material.
        is_convex: Whether the material beneath it is on the axis' side.
        is_cylinder: Whether the face is a cylinder.
        find_bend: Finds `bend` when someone asks.
    """

    inward: Array
    normal: Array
    is_convex: bool
    is_cylinder: bool
    find_bend: Callable[[], float]

    @cached_property
    def bend(self) -> float:
        """How the face bends away from the edge all along it: +1 towards the material, -1 away from it, 0 neither."""
        return self.find_bend()


@dataclass(eq=False)
class Arc:
    """An edge on a circle, or a face on a cylinder, as far as it goes.

    Attributes:
        shape: The edge or face.
        body: Index of the body it belongs to.
        round: Its circle or cylinder.
        is_hole: Of a cylinder, whether the material is outside.
        sides: Of an edge, how the faces lie that it bounds.
        bounds: These faces.
    """

    shape: TopoDS_Shape
    body: int
    round: Round
    is_hole: bool = False
    sides: list[Side] = field(default_factory=list)
    bounds: list[TopoDS_Shape] = field(default_factory=list)


def bodies(shape: TopoDS_Shape) -> Iterator[list[TopoDS_Face]]:
    """The faces of each solid, of each shell without a solid, and of all that is in no shell."""
    for solid in explored(shape, _SOLID):
        yield [TopoDS.Face(face) for face in explored(solid, _FACE)]
    for shell in explored(shape, _SHELL, _SOLID):
        yield [TopoDS.Face(face) for face in explored(shell, _FACE)]
    yield [TopoDS.Face(face) for face in explored(shape, _FACE, _SHELL)]


def explored(
    shape: TopoDS_Shape, kind: TopAbs_ShapeEnum, beyond: TopAbs_ShapeEnum = TopAbs_ShapeEnum.TopAbs_SHAPE
) -> Iterator[TopoDS_Shape]:
    """Every occurrence of a kind of subshape, oriented as it is in the shape; none within a shape of kind `beyond`."""
    explorer = TopExp_Explorer(shape, kind, beyond)
    while explorer.More():
        yield explorer.Current()
        explorer.Next()


def round_arcs(body: int, faces: Sequence[TopoDS_Face]) -> tuple[list[Arc], list[Arc]]:
    """The circular edges of a body, each with the faces beside it, and its cylindrical faces."""
    cylinders = [cylinder_of(face) for face in faces]
    walls = [
        Arc(face, body, found, _is_hole(face, found))
        for face, found in zip(faces, cylinders, strict=True)
        if found is not None
    ]
    seen = IndexedMap_TopoDS_Shape()
    arcs: dict[int, Arc | None] = {}
    for face, cylinder in zip(faces, cylinders, strict=True):
        # Edges of the forward face run so that the face is on their left in its parameters.
        forward = TopoDS.Face(face.Oriented(_FORWARD))
        surface = BRepAdaptor_Surface(forward, False)  # with the face's bounds it would go over all its edges
        for found_edge in explored(forward, _EDGE):
            edge = TopoDS.Edge(found_edge)
            if BRep_Tool.Degenerated_s(edge) or BRep_Tool.IsClosed_s(edge, forward):  # a seam bounds nothing
                continue
            index = seen.Add(edge)
            if index not in arcs:
                circle = circle_of(edge)
                arcs[index] = None if circle is None else Arc(edge, body, circle)
            arc = arcs[index]
            if arc is not None:
                arc.bounds.append(face)
                curve = BRepAdaptor_Curve2d(edge, forward)
                side = _side(curve, edge, surface, face, arc.round, is_cylinder=cylinder is not None)
                if side is not None:
                    arc.sides.append(side)
    return [arc for arc in arcs.values() if arc is not None], walls


def _side(
    curve: BRepAdaptor_Curve2d,
    edge: TopoDS_Edge,
    surface: BRepAdaptor_Surface,
    face: TopoDS_Face,
    circle: Round,
    *,
    is_cylinder: bool,
) -> Side | None:
    """How a face lies beside an edge, at the edge's middle; None where the face has no normal there."""
    place, along = gp_Pnt2d(), gp_Vec2d()
    curve.D1(0.5 * (curve.FirstParameter() + curve.LastParameter()), place, along)
    point, du, dv = gp_Pnt(), gp_Vec(), gp_Vec()
    surface.D1(place.X(), place.Y(), point, du, dv)
    by_u, by_v = xyz(du), xyz(dv)
    normal = outward_of(face, by_u, by_v)
    inward = _inward(edge, along, by_u, by_v)
    if inward is None or not normal.any():
        return None

    def find_bend() -> float:
        return _bend(curve, edge, surface, face, circle.radius)

    return Side(inward, normal, float(normal @ (xyz(point) - circle.centre)) > 0.0, is_cylinder, find_bend)


def _inward(edge: TopoDS_Edge, along: gp_Vec2d, by_u: Array, by_v: Array) -> Array | None:
    """The unit vector along a face away from its edge, which runs `along` the parameters; None at a singular point."""
    way = -1.0 if edge.Orientation() == _REVERSED else 1.0
    tangent = way * (along.X() * by_u + along.Y() * by_v)
    left = way * (along.X() * by_v - along.Y() * by_u)  # in the parameters, the tangent turned left
    if not tangent.any():
        return None
    tangent = unit_of(tangent)
    inward = left - (left @ tangent) * tangent
    return unit_of(inward) if inward.any() else None


def _bend(
    curve: BRepAdaptor_Curve2d, edge: TopoDS_Edge, surface: BRepAdaptor_Surface, face: TopoDS_Face, radius: float
) -> float:
    """`Side.bend`, by the curvatures of normal sections across the edge, whose sign must be the same all along it."""
    first, last = curve.FirstParameter(), curve.LastParameter()
    place, along = gp_Pnt2d(), gp_Vec2d()
    point, du, dv, duu, dvv, duv = gp_Pnt(), *(gp_Vec() for _ in range(5))
    signs = set()
    for share in _ALONG:
        curve.D1(first + share * (last - first), place, along)
        surface.D2(place.X(), place.Y(), point, du, dv, duu, dvv, duv)
        by_u, by_v = xyz(du), xyz(dv)
        normal, inward = outward_of(face, by_u, by_v), _inward(edge, along, by_u, by_v)
        if inward is None or not normal.any():
            return 0.0
        a, b = np.linalg.lstsq(np.stack([by_u, by_v], axis=1), inward, rcond=None)[0].tolist()
        section = -float((a * a * xyz(duu) + 2.0 * a * b * xyz(duv) + b * b * xyz(dvv)) @ normal)
        signs.add(math.copysign(1.0, section) if abs(section) * radius > _BENT else 0.0)
    return signs.pop() if len(signs) == 1 else 0.0


def outward_of(face: TopoDS_Face, by_u: Array, by_v: Array) -> Array:
    """The unit normal out of the material, from the derivatives of the surface; zero where there is none.

    An axis of the surface would not do: it does not tell right-handed parameters from left-handed ones.
    """
    (x, y, z), (a, b, c) = by_u.tolist(), by_v.tolist()  # np.cross takes many times as long
    normal = np.array([y * c - z * b, z * a - x * c, x * b - y * a])
    if face.Orientation() == _REVERSED:
        normal = -normal
    if face.Location().Transformation().IsNegative():
        normal = -normal
    return unit_of(normal) if normal.any() else normal


def _is_hole(face: TopoDS_Face, cylinder: Round) -> bool:
    surface = BRepAdaptor_Surface(face)
    point, du, dv = gp_Pnt(), gp_Vec(), gp_Vec()
    u = 0.5 * (surface.FirstUParameter() + surface.LastUParameter())
    v = 0.5 * (surface.FirstVParameter() + surface.LastVParameter())
    surface.D1(u, v, point, du, dv)
    off = xyz(point) - cylinder.centre
    spoke = off - (off @ cylinder.axis) * cylinder.axis
    return float(outward_of(face, xyz(du), xyz(dv)) @ spoke) < 0.0


# --- what belongs together ----------------------------------------------------------------------------------------


def circles(arcs: Sequence[Arc]) -> Iterator[tuple[Round, list[Arc]]]:
    """Each circle within a body as a whole, and its pieces; none of less than half a turn."""
    for group in _groups(arcs, along=False):
        truest = group[0].round
        turn = sum(arc.round.turn for arc in group)
        if turn >= _HALF_TURN:
            rough = [arc.round for arc in group] if truest.error > _TRUE * truest.radius else [truest]
            # Approximations of halves err to opposite sides.
            centre = np.average([one.centre for one in rough], axis=0, weights=[one.turn for one in rough])
            yield replace(truest, centre=centre, turn=turn), group


def cylinders(arcs: Sequence[Arc]) -> Iterator[tuple[Round, list[Arc]]]:
    """Each cylinder as a whole, and its pieces; none of less than half a turn."""
    for line in _groups(arcs, along=True):
        for group in _connected(line):
            whole = _whole(group)
            if whole is not None:
                yield whole, group


def _groups(arcs: Sequence[Arc], *, along: bool) -> Iterator[list[Arc]]:
    """Pieces with one centre, axis and radius, within a body; `along` the axis they may lie apart."""
    if not arcs:
        return
    arcs = sorted(arcs, key=lambda arc: arc.round.error)
    centres, axes = np.array([arc.round.centre for arc in arcs]), np.array([arc.round.axis for arc in arcs])
    radii, errors = np.array([arc.round.radius for arc in arcs]), np.array([arc.round.error for arc in arcs])
    kinds = np.array([(arc.body, arc.is_hole) for arc in arcs])
    left = np.ones(len(arcs), dtype=bool)
    for i in range(len(arcs)):
        if not left[i]:
            continue
        off = centres - centres[i]
        across = off - (off @ axes[i])[:, None] * axes[i] if along else off
        slack = SAME_PLACE + 1e-9 * (np.abs(centres[i]).max() + radii[i]) + 10.0 * errors
        same = (
            left
            & (kinds == kinds[i]).all(axis=1)
            & (np.linalg.norm(across, axis=1) < slack)
            & (np.abs(radii - radii[i]) < slack)
            & (np.linalg.norm(np.cross(axes, axes[i]), axis=1) < _SAME_ANGLE + 10.0 * errors / radii)
        )
        left &= ~same
        yield [arcs[j] for j in np.flatnonzero(same).tolist()]


def _spans(group: Sequence[Arc]) -> list[tuple[float, float, Arc]]:
    """Where each piece begins and ends along the axis of the first, in order."""
    origin, axis = group[0].round.centre, group[0].round.axis
    spans = []
    for arc in group:
        at, half = float((arc.round.centre - origin) @ axis), 0.5 * arc.round.length
        spans.append((at - half, at + half, arc))
    return sorted(spans, key=lambda span: span[0])


def _connected(line: list[Arc]) -> Iterator[list[Arc]]:
    """Coaxial cylinders that touch or overlap along the axis; those of opposite walls are two."""
    spans = _spans(line)
    gap = SAME_PLACE + 1e-9 * line[0].round.radius
    connected, top = [spans[0][2]], spans[0][1]
    for low, high, arc in spans[1:]:
        if low > top + gap:
            yield connected
            connected = []
        connected.append(arc)
        top = max(top, high)
    yield connected


def _whole(group: list[Arc]) -> Round | None:
    """The cylinder its pieces make; None for less than half a turn."""
    truest = min(group, key=lambda arc: arc.round.error).round
    at = [(float((arc.round.centre - truest.centre) @ truest.axis), 0.5 * arc.round.length) for arc in group]
    bottom, top = min(middle - half for middle, half in at), max(middle + half for middle, half in at)
    length = top - bottom
    turn = sum(arc.round.turn * arc.round.length for arc in group) / length if length > 0.0 else 0.0
    if turn < _HALF_TURN:
        return None
    centre = truest.centre + 0.5 * (bottom + top) * truest.axis
    return replace(truest, centre=centre, turn=turn, length=length)


def unit_of(vector: Array) -> Array:
    """The unit vector of one that is not zero."""
    scaled: Array = vector / np.abs(vector).max()
    return scaled / float(np.linalg.norm(scaled))
