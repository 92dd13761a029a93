"""Ports of features: where cables leave holes, bosses and planes, on parts as CAD packages write them."""

from __future__ import annotations

import dataclasses
import math
from functools import cache, partial

import numpy as np
import pytest

pytest.importorskip("OCP", reason="solids need the kernel")

from cablecad.brep.kernel import subshapes

# isort: split
from OCP.BRep import BRep_Builder, BRep_Tool
from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut, BRepAlgoAPI_Fuse
from OCP.BRepBuilderAPI import (
    BRepBuilderAPI_MakeEdge,
    BRepBuilderAPI_MakeFace,
    BRepBuilderAPI_MakeWire,
    BRepBuilderAPI_NurbsConvert,
    BRepBuilderAPI_Transform,
)
from OCP.BRepClass3d import BRepClass3d_SolidClassifier
from OCP.BRepFilletAPI import BRepFilletAPI_MakeChamfer, BRepFilletAPI_MakeFillet
from OCP.BRepPrimAPI import (
    BRepPrimAPI_MakeBox,
    BRepPrimAPI_MakeCone,
    BRepPrimAPI_MakeCylinder,
    BRepPrimAPI_MakePrism,
    BRepPrimAPI_MakeSphere,
    BRepPrimAPI_MakeTorus,
)
from OCP.gp import gp_Ax1, gp_Ax2, gp_Circ, gp_Dir, gp_Pln, gp_Pnt, gp_Trsf, gp_Vec
from OCP.TopAbs import TopAbs_ShapeEnum, TopAbs_State
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS, TopoDS_Compound

from cablecad.brep.features import find_features
from cablecad.brep.ports import edge_port, face_port, nearest_port
from cablecad.errors import GeometryError, SceneError

UP, DOWN = (0.0, 0.0, 1.0), (0.0, 0.0, -1.0)


def axes(x, y, z, direction=UP):
    return gp_Ax2(gp_Pnt(x, y, z), gp_Dir(*direction))


def cylinder(x, y, z, radius, height, direction=UP):
    return BRepPrimAPI_MakeCylinder(axes(x, y, z, direction), radius, height).Shape()


def cut(shape, *tools):
    for tool in tools:
        shape = BRepAlgoAPI_Cut(shape, tool).Shape()
    return shape


def fuse(shape, *others):
    for other in others:
        shape = BRepAlgoAPI_Fuse(shape, other).Shape()
    return shape


def block():
    return BRepPrimAPI_MakeBox(gp_Pnt(-30, -20, 0), gp_Pnt(30, 20, 10)).Shape()


def rim(shape, z, radius):
    """The circular edge at a height."""
    for edge in subshapes(shape, TopAbs_ShapeEnum.TopAbs_EDGE):
        from OCP.BRepAdaptor import BRepAdaptor_Curve
        from OCP.GeomAbs import GeomAbs_CurveType

        curve = BRepAdaptor_Curve(TopoDS.Edge(edge))
        if curve.GetType() == GeomAbs_CurveType.GeomAbs_Circle:
            circle = curve.Circle()
            if abs(circle.Location().Z() - z) < 1e-9 and abs(circle.Radius() - radius) < 1e-9:
                return TopoDS.Edge(edge)
    raise AssertionError((z, radius))


def drilled():
    """A through hole of radius 3, a blind one of 2 with a drill's cone below it, and a flat one of 2.5, 4 deep."""
    cone = BRepPrimAPI_MakeCone(axes(0, 0, 4, DOWN), 2.0, 0.0, 1.2).Shape()
    return cut(block(), cylinder(-20, 0, -1, 3, 12), cylinder(0, 0, 4, 2, 7), cone, cylinder(20, 0, 6, 2.5, 5))


def bossed():
    """A boss of radius 5, 8 high, and a tube of radii 4 and 3, 6 high."""
    tube = cut(cylinder(15, 0, 9, 4, 7), cylinder(15, 0, 9, 3, 8))
    return fuse(block(), cylinder(-10, 0, 9, 5, 9), tube)


def pegs():
    return fuse(block(), *[cylinder(x, 0, 9, 5, 9) for x in (-10, 10)])


def countersunk():
    return cut(block(), cylinder(0, 0, -1, 2, 12), BRepPrimAPI_MakeCone(axes(0, 0, 8), 2.0, 4.0, 2.0).Shape())


def counterbored():
    return cut(block(), cylinder(0, 0, -1, 2, 12), cylinder(0, 0, 7, 5, 4))


def rounded():
    """The mouth of a hole of radius 3 rounded by 1, and the top of a boss of radius 6 chamfered by 1."""
    part = fuse(cut(block(), cylinder(-15, 0, -1, 3, 12)), cylinder(10, 0, 9, 6, 9))
    fillet = BRepFilletAPI_MakeFillet(part)
    fillet.Add(1.0, rim(part, 10, 3))
    part = fillet.Shape()
    chamfer = BRepFilletAPI_MakeChamfer(part)
    chamfer.Add(1.0, rim(part, 18, 6))
    return chamfer.Shape()


def fillet(shape, z, radius, by):
    rounding = BRepFilletAPI_MakeFillet(shape)
    rounding.Add(by, rim(shape, z, radius))
    return rounding.Shape()


def smooth():
    """Holes that end in a ball, in a cone of 60 degrees and in a floor with a rounded corner; a boss with a round foot
    and one with a round top."""
    deep = BRepPrimAPI_MakeBox(gp_Pnt(-60, -20, 0), gp_Pnt(60, 20, 20)).Shape()
    ball = fuse(cylinder(-40, 0, 10, 4, 15), BRepPrimAPI_MakeSphere(gp_Pnt(-40, 0, 10), 4).Shape())
    cone = BRepPrimAPI_MakeCone(axes(-20, 0, 10, DOWN), 4.0, 0.0, 4.0 * math.sqrt(3.0)).Shape()
    part = cut(deep, ball, cone, cylinder(-20, 0, 10, 4, 15), cylinder(0, 0, 8, 4.5, 15))
    part = fuse(part, cylinder(20, 0, 19, 5, 11), cylinder(45, 0, 19, 6, 11))
    part = fuse(part, BRepPrimAPI_MakeSphere(gp_Pnt(45, 0, 30), 6).Shape())
    return fillet(fillet(part, 8, 4.5, 2), 20, 5, 2)


def hollow():
    """A block with a cavity of radius 4 that is closed all around."""
    return cut(block(), cylinder(0, 0, 3, 4, 5))


def stepped():
    """A shaft along z: a flange of radius 8, a step of radius 5 and a thinner one of 3; and a hole that narrows."""
    shaft = fuse(cylinder(0, 0, 0, 8, 2), cylinder(0, 0, 2, 5, 6), cylinder(0, 0, 8, 3, 10))
    wide = cut(block(), cylinder(20, 0, -1, 2, 12), cylinder(20, 0, 6, 4, 5))
    return fuse(shaft, wide.Moved(TopLoc_Location(moving(0, 40, 0))))


def elbow():
    """A bent pipe of radii 5 and 4: 20 mm up along z, around a quarter, 20 mm along x."""

    def bent(radius):
        quarter = BRepPrimAPI_MakeTorus(
            gp_Ax2(gp_Pnt(15, 0, 20), gp_Dir(0, 1, 0), gp_Dir(-1, 0, 0)), 15, radius, math.pi / 2
        )
        return fuse(cylinder(0, 0, 0, radius, 20), quarter.Shape(), cylinder(15, 0, 35, radius, 20, (1, 0, 0)))

    return cut(bent(5.0), bent(4.0))


def moving(x, y, z):
    trsf = gp_Trsf()
    trsf.SetTranslation(gp_Vec(x, y, z))
    return trsf


def in_halves(parts=2):
    """A plate with a hole whose circle is written as several arcs, and so its wall as several faces."""
    whole = [gp_Pnt(-10, -10, 0), gp_Pnt(10, -10, 0), gp_Pnt(10, 10, 0), gp_Pnt(-10, 10, 0)]
    outline = BRepBuilderAPI_MakeWire()
    for one, other in zip(whole, [*whole[1:], whole[0]], strict=True):
        outline.Add(BRepBuilderAPI_MakeEdge(one, other).Edge())
    hole = BRepBuilderAPI_MakeWire()
    circle = gp_Circ(axes(2, 1, 0), 3.0)
    for i in range(parts):
        step = 2 * math.pi / parts
        hole.Add(BRepBuilderAPI_MakeEdge(circle, i * step, (i + 1) * step).Edge())
    face = BRepBuilderAPI_MakeFace(outline.Wire(), True)
    face.Add(TopoDS.Wire(hole.Wire().Reversed()))
    return BRepPrimAPI_MakePrism(face.Face(), gp_Vec(0, 0, 5)).Shape()


in_thirds = partial(in_halves, 3)


def slotted():
    """A plate with rounded corners of radius 2 and a slot that ends in half circles of radius 1.5."""
    plate = block()
    fillet = BRepFilletAPI_MakeFillet(plate)
    for edge in subshapes(plate, TopAbs_ShapeEnum.TopAbs_EDGE):
        first, last = (BRep_Tool.Pnt_s(TopoDS.Vertex(v)) for v in subshapes(edge, TopAbs_ShapeEnum.TopAbs_VERTEX))
        if abs(first.Z() - last.Z()) > 5:
            fillet.Add(2.0, TopoDS.Edge(edge))
    slot = BRepPrimAPI_MakeBox(gp_Pnt(-8, -1.5, -1), gp_Pnt(8, 1.5, 11)).Shape()
    return cut(fillet.Shape(), fuse(slot, cylinder(-8, 0, -1, 1.5, 12), cylinder(8, 0, -1, 1.5, 12)))


def channel():
    """A U with a hole of radius 2 through each of its walls, in one line along x."""
    body = cut(block(), BRepPrimAPI_MakeBox(gp_Pnt(-20, -21, 3), gp_Pnt(20, 21, 11)).Shape())
    return cut(body, cylinder(-31, 0, 6, 2, 62, (1, 0, 0)))


# Part, point, the port that must be found: kind, position, outward, radius.
FOUND = {
    "mouth of a through hole": (drilled, (-20, 0, 10), ("edge", (-20, 0, 10), UP, 3)),
    "its other mouth": (drilled, (-20, 0, 0), ("edge", (-20, 0, 0), DOWN, 3)),
    "a point on its rim": (drilled, (-17, 0, 10), ("edge", (-20, 0, 10), UP, 3)),
    "a point a little beside its rim": (drilled, (-16.9, 0, 10), ("edge", (-20, 0, 10), UP, 3)),
    "a point in its mouth": (drilled, (-18.6, 0.5, 10), ("edge", (-20, 0, 10), UP, 3)),
    "a point before its mouth": (drilled, (-20, 0, 13), ("edge", (-20, 0, 10), UP, 3)),
    "its wall, nearer to the top": (drilled, (-17, 0, 6), ("cylinder", (-20, 0, 5), UP, 3)),
    "its wall, nearer to the bottom": (drilled, (-20, -3, 4), ("cylinder", (-20, 0, 5), DOWN, 3)),
    "mouth of a drilled hole": (drilled, (0, 0, 10), ("edge", (0, 0, 10), UP, 2)),
    "wall of a drilled hole, near its cone": (drilled, (2, 0, 4.9), ("cylinder", (0, 0, 7), UP, 2)),
    "rim where the cone begins": (drilled, (0, 0, 4), ("edge", (0, 0, 4), UP, 2)),
    "floor of a flat hole": (drilled, (20, 0, 6), ("edge", (20, 0, 6), UP, 2.5)),
    "wall of a flat hole, near its floor": (drilled, (22.5, 0, 7), ("cylinder", (20, 0, 8), UP, 2.5)),
    "a point on the plate's end": (drilled, (30, 5, 5), ("plane", (30, 0, 5), (1, 0, 0), None)),
    "top of a boss": (bossed, (-10, 0, 18), ("edge", (-10, 0, 18), UP, 5)),
    "side of a boss, near its foot": (bossed, (-10, 5, 11), ("cylinder", (-10, 0, 14), UP, 5)),
    "mouth of a tube": (bossed, (15, 0, 16), ("edge", (15, 0, 16), UP, None)),
    "side of a tube": (bossed, (19, 0, 14), ("cylinder", (15, 0, 13), UP, 4)),
    "floor of a tube": (bossed, (15, 0, 10), ("edge", (15, 0, 10), UP, 3)),
    "mouth of a countersink": (countersunk, (4, 0, 10), ("edge", (0, 0, 10), UP, 4)),
    "where a countersink meets its hole": (countersunk, (0, 0, 8), ("edge", (0, 0, 8), UP, 2)),
    "mouth of a counterbore": (counterbored, (0, 0, 10), ("edge", (0, 0, 10), UP, 5)),
    "floor of a counterbore": (counterbored, (2, 0, 7), ("edge", (0, 0, 7), UP, None)),
    "behind a counterbore": (counterbored, (0, 0, 0), ("edge", (0, 0, 0), DOWN, 2)),
    "outer rim of a rounded mouth": (rounded, (-15, 0, 10), ("edge", (-15, 0, 10), UP, 4)),
    "inner rim of a rounded mouth": (rounded, (-12, 0, 9), ("edge", (-15, 0, 9), UP, 3)),
    "upper rim of a chamfered boss": (rounded, (10, 0, 18), ("edge", (10, 0, 18), UP, 5)),
    "lower rim of a chamfered boss": (rounded, (16, 0, 17), ("edge", (10, 0, 17), UP, 6)),
    "mouth in two halves": (in_halves, (2, 1, 5), ("edge", (2, 1, 5), UP, 3)),
    "a point on one of the halves": (in_halves, (2, -2, 0), ("edge", (2, 1, 0), DOWN, 3)),
    "wall in two halves": (in_halves, (5, 1, 3), ("cylinder", (2, 1, 2.5), UP, 3)),
    "mouth in three thirds": (in_thirds, (2, 1, 5), ("edge", (2, 1, 5), UP, 3)),
    "wall in three thirds": (in_thirds, (5, 1, 2), ("cylinder", (2, 1, 2.5), DOWN, 3)),
    "end of a slot": (slotted, (8, 0, 10), ("edge", (8, 0, 10), UP, 1.5)),
    "other end of a slot": (slotted, (-8, 0, 0), ("edge", (-8, 0, 0), DOWN, 1.5)),
    "a hole in the left wall of a channel, outside": (channel, (-30, 0, 6), ("edge", (-30, 0, 6), (-1, 0, 0), 2)),
    "the same, inside": (channel, (-20, 0, 6), ("edge", (-20, 0, 6), (1, 0, 0), 2)),
    "the same, its wall": (channel, (-27, 2, 6), ("cylinder", (-25, 0, 6), (-1, 0, 0), 2)),
    "where a ball ends a hole": (smooth, (-36, 0, 10), ("edge", (-40, 0, 10), UP, 4)),
    "wall of a hole that ends in a ball": (smooth, (-36, 0, 11), ("cylinder", (-40, 0, 15), UP, 4)),
    "wall of a hole that ends in a steep cone": (smooth, (-16, 0, 12), ("cylinder", (-20, 0, 15), UP, 4)),
    "where a rounded floor begins": (smooth, (4.5, 0, 10), ("edge", (0, 0, 10), UP, 4.5)),
    "wall above a rounded floor": (smooth, (4.5, 0, 11.5), ("cylinder", (0, 0, 15), UP, 4.5)),
    "side of a boss with a rounded foot": (smooth, (25, 0, 23), ("cylinder", (20, 0, 26), UP, 5)),
    "top of a boss with a rounded foot": (smooth, (25, 0, 30), ("edge", (20, 0, 30), UP, 5)),
    "side of a boss with a round top": (smooth, (51, 0, 21), ("cylinder", (45, 0, 25), UP, 6)),
    "where a round top begins": (smooth, (51, 0, 30), ("edge", (45, 0, 30), UP, 6)),
    "a step of a shaft, near its flange": (stepped, (5, 0, 3), ("cylinder", (0, 0, 5), UP, 5)),
    "its thinner step": (stepped, (3, 0, 10), ("cylinder", (0, 0, 13), UP, 3)),
    "its narrow part, near its mouth": (stepped, (22, 40, 1), ("cylinder", (20, 40, 3), DOWN, 2)),
    "mouth of a bent pipe": (elbow, (0, 0, 0), ("edge", (0, 0, 0), DOWN, None)),
    "its inside, near that mouth": (elbow, (4, 0, 3), ("cylinder", (0, 0, 10), DOWN, 4)),
}

KINDS = {"edge": "circular edge", "cylinder": "cylindrical face", "plane": "plane face"}


def rigid() -> gp_Trsf:
    turn, move = gp_Trsf(), gp_Trsf()
    turn.SetRotation(gp_Ax1(gp_Pnt(3, -2, 5), gp_Dir(1, 2, -3)), 2.1)
    move.SetTranslation(gp_Vec(-100, 40, 7))
    return move.Multiplied(turn)


def mirror() -> gp_Trsf:
    trsf = gp_Trsf()
    trsf.SetMirror(gp_Ax2(gp_Pnt(5, 0, 2), gp_Dir(1, -1, 0.5)))
    return rigid().Multiplied(trsf)


def as_it_is(shape):
    return shape, gp_Trsf()


def placed(shape):
    return shape.Moved(TopLoc_Location(rigid())), rigid()


def copied(shape):
    return BRepBuilderAPI_Transform(shape, rigid(), True).Shape(), rigid()


def mirrored(shape):
    return BRepBuilderAPI_Transform(shape, mirror(), True).Shape(), mirror()


def nested(shape):
    """As an assembly reads it: compounds in compounds, each placed, with a twin of the part elsewhere."""
    half = gp_Trsf()
    half.SetRotation(gp_Ax1(gp_Pnt(0, 0, 1), gp_Dir(0, 1, 1)), 0.7)
    inner, outer, builder = TopoDS_Compound(), TopoDS_Compound(), BRep_Builder()
    builder.MakeCompound(inner)
    builder.Add(inner, shape.Moved(TopLoc_Location(half)))
    aside = gp_Trsf()
    aside.SetTranslation(gp_Vec(0, 500, 0))
    builder.MakeCompound(outer)
    builder.Add(outer, inner.Moved(TopLoc_Location(rigid())))
    builder.Add(outer, shape.Moved(TopLoc_Location(aside)))
    return outer, rigid().Multiplied(half)


def splined(shape):
    """As translators write it that know no circles: everything a spline."""
    return BRepBuilderAPI_NurbsConvert(shape, True).Shape(), gp_Trsf()


@cache
def made(make, way):
    """A part in one of these ways, how it was moved, and its features."""
    shape, trsf = way(make())
    return shape, trsf, find_features(shape)


def moved(point, trsf):
    place = gp_Pnt(*point).Transformed(trsf)
    return place.X(), place.Y(), place.Z()


def turned(axis, trsf):
    way = gp_Vec(*axis).Transformed(trsf)
    return way.X(), way.Y(), way.Z()


@pytest.mark.parametrize("way", [as_it_is, placed, copied, mirrored, nested, splined])
@pytest.mark.parametrize("name", FOUND)
def test_the_port_nearest_to_a_point(name, way):
    make, near, (kind, position, outward, radius) = FOUND[name]
    shape, trsf, features = made(make, way)
    port = nearest_port(shape, moved(near, trsf), features)
    np.testing.assert_allclose(port.position, moved(position, trsf), atol=1e-9)
    np.testing.assert_allclose(port.outward, turned(outward, trsf), atol=1e-9)
    assert port.feature.kind == KINDS[kind]
    if radius is not None:
        assert port.feature.radius == pytest.approx(radius, rel=1e-11)


@pytest.mark.parametrize("way", [as_it_is, placed, copied, mirrored, splined])
@pytest.mark.parametrize("make", [drilled, bossed, countersunk, counterbored, rounded, in_halves, slotted, channel])
def test_planes_face_out_of_the_material(make, way):
    """By Open Cascade's own classification of points on both sides."""
    shape, _, features = made(make, way)
    for feature in features:
        if feature.kind != "plane face":
            continue
        # The middle of a plane may lie in a hole of it: a point on the face itself, just inside one of its edges.
        from OCP.BRepAdaptor import BRepAdaptor_Surface
        from OCP.gp import gp_Pnt2d
        from OCP.IntTools import IntTools_FClass2d

        surface = BRepAdaptor_Surface(TopoDS.Face(feature.shapes[0]))
        us = np.linspace(surface.FirstUParameter(), surface.LastUParameter(), 23)[1:-1]
        vs = np.linspace(surface.FirstVParameter(), surface.LastVParameter(), 23)[1:-1]
        inside = IntTools_FClass2d(TopoDS.Face(feature.shapes[0]), 1e-7)
        u, v = next((u, v) for u in us for v in vs if inside.Perform(gp_Pnt2d(u, v)) == TopAbs_State.TopAbs_IN)
        point = surface.Value(u, v)
        states = []
        for side in (1e-4, -1e-4):
            x, y, z = (c + side * d for c, d in zip((point.X(), point.Y(), point.Z()), feature.axis, strict=True))
            states.append(BRepClass3d_SolidClassifier(shape, gp_Pnt(x, y, z), 1e-7).State())
        assert states == [TopAbs_State.TopAbs_OUT, TopAbs_State.TopAbs_IN]
        assert feature.ways == (1,)


REFUSED = {
    "the middle of a through hole": (
        drilled,
        (-20, 0, 5),
        "2 ports are as near",
        "outward [0, 0, 1]",
        "outward [0, 0, -1]",
    ),
    "between two pegs": (
        pegs,
        (0, 0.1, 18),
        "ports are as near, in the part's own coordinates: circular edge of radius 5 mm at [",
        "[10, 0, 18]",
    ),
    "an edge of the block": (block, (30, 20, 5), "2 ports are as near", "[30, 0, 5], outward [1, 0, 0]"),
    "the middle of the block": (
        block,
        (0, 0, 5),
        "2 ports are as near, in the part's own coordinates: plane face at [0, 0, 0]",
        "at [0, 0, 10]",
    ),
    "the wall of a closed cavity": (
        hollow,
        (4, 0, 4.5),
        "2 ports are as near",
        "cylindrical face of radius 4 mm at [0, 0, 5.5], outward [0, 0, 1]",
        "outward [0, 0, -1]",
    ),
    "far away": (block, (0, 0, 500), "is 490 mm away from every feature", "in the part's own coordinates"),
    "a ball": (lambda: BRepPrimAPI_MakeSphere(5).Shape(), (0, 0, 5), "the part has no circular edge, cylindrical or"),
    "a ring": (lambda: BRepPrimAPI_MakeTorus(10, 2).Shape(), (0, 0, 0), "the part has no circular edge"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_not_clear_is_refused_with_the_candidates(name):
    make, near, *words = REFUSED[name]
    with pytest.raises(SceneError) as caught:
        nearest_port(make(), near)
    (mistake,) = caught.value.mistakes
    assert mistake.path == "near"
    for word in words:
        assert word in str(mistake)
    assert "outward" in str(mistake)


def test_a_mistake_of_rounding_changes_nothing():
    """A point measured to 0.01 mm on the rim of a hole is meant for the hole, wherever it was rounded to."""
    shape = drilled()
    for angle in np.linspace(0.0, 2.0 * math.pi, 12, endpoint=False):
        for off in (-0.01, 0.0, 0.01):
            near = (-20 + (3 + off) * math.cos(angle), (3 + off) * math.sin(angle), 10 + 0.01 * math.sin(5 * angle))
            port = nearest_port(shape, near)
            assert (port.position, port.outward) == ((-20.0, 0.0, 10.0), UP)


def test_fillets_and_corners_are_no_features():
    features = find_features(slotted())
    assert {feature.radius for feature in features} == {None, 1.5}


def test_the_foot_of_a_boss_is_no_feature():
    heights = [feature.position[2] for feature in find_features(bossed()) if feature.kind == "circular edge"]
    assert sorted(np.round(heights, 9)) == [10.0, 16.0, 16.0, 18.0]  # the tube's floor, both its rims, the boss's top
    rims = [
        (f.radius, f.position[2]) for f in find_features(smooth()) if f.kind == "circular edge" and f.position[0] > 5
    ]
    np.testing.assert_allclose(sorted(rims), [(5, 30), (6, 30), (7, 20)], atol=1e-9)  # of the fillet only its outer rim


def test_selected_edges_and_faces():
    shape = drilled()
    assert edge_port(rim(shape, 10, 3), shape) == ((-20.0, 0.0, 10.0), UP)
    assert edge_port(rim(shape, 0, 3), shape) == ((-20.0, 0.0, 0.0), DOWN)
    walls = {feature.radius: feature.shapes[0] for feature in find_features(shape) if feature.extent}
    position, outward = face_port(walls[2.0], shape)
    np.testing.assert_allclose(position, (0, 0, 7), atol=1e-12)
    assert outward == UP
    with pytest.raises(GeometryError, match="open on both sides"):
        face_port(walls[3.0], shape)


def test_a_cylinder_closed_at_both_ends_has_no_axis():
    shape = hollow()
    cavity = next(feature for feature in find_features(shape) if feature.kind == "cylindrical face")
    assert cavity.ways == ()
    with pytest.raises(GeometryError, match="closed on both sides"):
        face_port(cavity.shapes[0], shape)


def test_what_open_cascade_fails_at_is_a_geometry_error_also_later():
    feature = find_features(block())[0]
    later = dataclasses.replace(feature, find_ways=lambda: (int(gp_Dir(0, 0, 0).X()),))
    with pytest.raises(GeometryError, match="open end of a cylinder"):
        later.ways  # noqa: B018


def test_a_circle_by_itself_has_its_own_axis():
    circle = BRepBuilderAPI_MakeEdge(gp_Circ(axes(1, 2, 3, (0, 1, 0)), 4.0)).Edge()
    assert edge_port(circle) == ((1.0, 2.0, 3.0), (0.0, 1.0, 0.0))
    disc = BRepBuilderAPI_MakeFace(
        gp_Pln(gp_Pnt(0, 0, 1), gp_Dir(0, 0, 1)),
        BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(gp_Circ(axes(0, 0, 1), 2.0)).Edge()).Wire(),
    ).Face()
    assert face_port(disc) == ((0.0, 0.0, 1.0), UP)
    (edge,) = subshapes(disc, TopAbs_ShapeEnum.TopAbs_EDGE)
    assert edge_port(edge, disc) == ((0.0, 0.0, 1.0), UP)
    assert face_port(disc.Reversed())[1] == DOWN


def test_what_has_no_axis_is_refused():
    line = BRepBuilderAPI_MakeEdge(gp_Pnt(0, 0, 0), gp_Pnt(1, 0, 0)).Edge()
    with pytest.raises(GeometryError, match="is no circle"):
        edge_port(line)
    ball = BRepPrimAPI_MakeSphere(5).Shape()
    (face,) = subshapes(ball, TopAbs_ShapeEnum.TopAbs_FACE)
    with pytest.raises(GeometryError, match="neither plane nor"):
        face_port(face, ball)
    with pytest.raises(GeometryError, match="neither"):
        edge_port(ball)
