"""Cables in CadQuery: solids of the host, with its own operations and exporters."""

from __future__ import annotations

import copy
import json
import math
import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from read_back import SAMPLES, check_loom, run_sample

pytest.importorskip("cadquery")

import cadquery as cq
from cadquery.occ_impl.assembly import toJSON

import cablecad as cc
from cablecad.adapters.cadquery import CableSolid, add_to, as_solid, cable, cable_from, port, to_assembly
from cablecad.brep.step import read_tree
from cablecad.errors import GeometryError, InfeasibleError, SceneError, UsageError

UP = (0.0, 0.0, 1.0)
VOLUME = math.pi * 4.0 * 350.0


@pytest.fixture(scope="module")
def plate():
    """A plate of 40 x 40 x 8 around the origin with a hole of radius 3 through it."""
    return cq.Workplane().box(40, 40, 8).faces(">Z").workplane().hole(6)


@pytest.fixture(scope="module")
def wire(plate):
    end = port(plate.faces(">Z").edges("%CIRCLE"), cq.Location((0, 120, 0)))
    start = plate.faces(">Z").edges("%CIRCLE")
    return cable(start, end, diameter=4, length=350, name="W1", color="#2b6cb080", tolerance=1e-6)


# --- ends ---------------------------------------------------------------------------------------------------------

ENDS = {
    "location": (lambda _: cq.Location((1, 2, 3), (0, 1, 0), 90), (1, 2, 3), (1, 0, 0)),
    "plane": (lambda _: cq.Plane((1, 2, 3), normal=(0, -2, 0)), (1, 2, 3), (0, -1, 0)),
    "top rim": (lambda plate: plate.faces(">Z").edges("%CIRCLE"), (0, 0, 4), UP),
    "bottom rim": (lambda plate: plate.faces("<Z").edges("%CIRCLE"), (0, 0, -4), (0, 0, -1)),
    "rim by itself in its solid": (
        lambda plate: (plate.edges("%CIRCLE").edges("<Z").val(), plate),
        (0, 0, -4),
        (0, 0, -1),
    ),
    "face in a workplane": (lambda plate: plate.faces(">X"), (20, 0, 0), (1, 0, 0)),
    "face": (lambda plate: plate.faces("<Y").val(), (0, -20, 0), (0, -1, 0)),
    "workplane on a face": (lambda plate: plate.faces(">Z").workplane(), (0, 0, 4), UP),
    "point on a workplane": (lambda _: cq.Workplane("YZ").pushPoints([(3, 4)]), (0, 3, 4), (1, 0, 0)),
    "location on a workplane": (
        lambda _: cq.Workplane("YZ", origin=(50, 0, 0)).pushPoints([cq.Location((3, 4, 0))]),
        (50, 3, 4),
        (1, 0, 0),
    ),
    "blind hole's wall": (
        lambda _: cq.Workplane().box(20, 20, 20).faces(">Z").workplane().hole(4, 10).faces("%CYLINDER"),
        (0, 0, 5),
        UP,
    ),
    "vertex": (lambda _: cq.Vertex.makeVertex(1, 2, 3), (1, 2, 3), None),
    "vector": (lambda _: cq.Vector(1, 2, 3), (1, 2, 3), None),
    "numbers": (lambda _: (1, 2, 3), (1, 2, 3), None),
    "an array": (lambda _: np.array([1, 2, 3]), (1, 2, 3), None),
    "position and outward": (lambda _: ((1, 2, 3), [0, 0, 1]), (1, 2, 3), UP),
    "port": (lambda _: cc.Port((1, 2, 3), UP), (1, 2, 3), UP),
    "pin": (lambda _: cc.Pin((1, 2, 3)), (1, 2, 3), None),
}


@pytest.mark.parametrize("name", ENDS)
def test_what_an_end_may_be(plate, name):
    make, position, outward = ENDS[name]
    end = port(make(plate))
    np.testing.assert_allclose(end.position, position, atol=1e-12)
    if outward is None:
        assert getattr(end, "outward", None) is None
    else:
        np.testing.assert_allclose(end.outward, outward, atol=1e-12)


NO_ENDS = {
    "edge by itself": (lambda plate: plate.edges("%CIRCLE").val(), UsageError, r"\(edge, solid\)"),
    "straight edge": (lambda plate: plate.edges(">X and >Y"), GeometryError, "is no circle"),
    "through hole's wall": (lambda plate: plate.faces("%CYLINDER"), GeometryError, "open on both sides"),
    "two faces": (lambda plate: plate.faces("|Z"), UsageError, "2 objects selected"),
    "all edges": (lambda plate: plate.faces(">Z").edges(), UsageError, "5 objects selected"),
    "solid": (lambda plate: plate, UsageError, "select one of its faces"),
    "text": (lambda _: "top", UsageError, "which is no end of a cable"),
    "two numbers": (lambda _: (1, 2), UsageError, "which is no end of a cable"),
    "part of a scene": (lambda _: cc.PartPort("plate", port="J1"), UsageError, "needs a scene"),
    "sketch": (
        lambda plate: plate.faces(">Z").workplane().placeSketch(cq.Sketch().circle(2)),
        UsageError,
        "is a Sketch; select",
    ),
    "edge with text": (lambda plate: (plate.edges("%CIRCLE").val(), "x"), UsageError, "a str, in which there is no"),
    "vertex with numbers": (lambda _: (cq.Vertex.makeVertex(1, 2, 3), UP), UsageError, "two times three numbers"),
    "edge with an assembly": (
        lambda plate: (plate.edges("%CIRCLE").val(), cq.Assembly(plate)),
        UsageError,
        "with a Assembly, in which there is no solid",
    ),
    "edge without a solid": (
        lambda plate: (plate.edges("%CIRCLE").val(), cq.Workplane()),
        UsageError,
        "Workplane, in which there is no solid",
    ),
    "matrix": (lambda _: np.eye(3), UsageError, "which is no end of a cable"),
    "column": (lambda _: np.ones((3, 1)), UsageError, "which is no end of a cable"),
    "single number": (lambda _: np.array(5.0), UsageError, "which is no end of a cable"),
    "bytes": (lambda _: b"abc", UsageError, "which is no end of a cable"),
    "set": (lambda _: {1, 2, 3}, UsageError, "which is no end of a cable"),
    "table": (lambda _: {1: 2, 2: 3, 3: 4}, UsageError, "which is no end of a cable"),
    "beyond all numbers": (lambda _: (10**400, 0, 0), UsageError, "which is no end of a cable"),
}


@pytest.mark.parametrize("name", NO_ENDS)
def test_what_no_end_may_be(plate, name):
    make, error, words = NO_ENDS[name]
    with pytest.raises(error, match=words):
        port(make(plate))


@pytest.mark.parametrize(
    "wrong",
    [
        {"equilibrium": None},
        {"allow_contact": None},
        {"bulge": np.array(5.0)},
        {"length": np.eye(3)},
        {"tolerance": None},
        {"tolerance": "x"},
        {"tolerance": True},
        {"tolerance": math.inf},
        {"tolerance": math.nan},
        {"tolerance": 10**400},
        {"tolerance": np.array(5.0)},
        {"tolerance": -1.0},
        {"start_straight": "5"},
        {"start_straight": None},
        {"end_straight": []},
        {"end_straight": np.eye(3)},
        {"end_straight": -1.0},
    ],
)
def test_nonsense_is_a_mistake_with_its_name(wrong):
    (key,) = wrong
    with pytest.raises(SceneError) as caught:
        cable(cq.Location(), cq.Location((0, 120, 0)), **({"diameter": 4, "length": 350} | wrong))
    (mistake,) = caught.value.mistakes
    assert mistake.path.split(".")[0] == key


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: port(cq.Location(), cq.Plane.XY()), "placed by a Location, not by a Plane"),
        (lambda: port(cq.Location(), (1, 2, 3)), "placed by a Location, not by a tuple"),
        (lambda: as_solid(None), "a NoneType is no cable"),
        (lambda: as_solid(cq.Solid.makeBox(1, 1, 1)), "a Solid is no cable"),
        (lambda: add_to(None), "a NoneType is no cq.Assembly"),
        (lambda: add_to(cq.Assembly(), None), "a NoneType is no cable"),
        (lambda: to_assembly(None), "a NoneType is no cablecad.Scene"),
    ],
)
def test_what_was_not_meant_is_told(call, words):
    with pytest.raises(UsageError, match=words):
        call()


def test_straight_parts_and_other_data_reach_the_cable(plate):
    made = cable(
        plate.faces(">Z").edges("%CIRCLE"), cc.Port((0, 120, 4), UP, straight=7.0),
        diameter=4, length=350, start_straight=5.0, min_bend_radius=20, bulge=cq.Vector(1, 0, 0),
        material=cc.Material(youngs_modulus=3890.0),
    )  # fmt: skip
    assert (made.cable.start.straight, made.cable.end.straight) == (5.0, 7.0)
    assert made.cable.bulge == (1.0, 0.0, 0.0)
    assert made.report["start"]["force"] is not None
    with pytest.raises(UsageError, match="a cable has no lenght; besides"):
        cable((0, 0, 0), (0, 100, 0), diameter=4, lenght=120)
    with pytest.raises(UsageError, match="needs an end with an axis"):
        cable((0, 0, 0), (0, 100, 0), diameter=4, length=120, end_straight=5)
    with pytest.raises(SceneError, match="diameter"):
        cable((0, 0, 0), (0, 100, 0), diameter=-4, length=120)
    with pytest.raises(InfeasibleError):
        cable((0, 0, 0), (0, 100, 0), diameter=4, length=90)


# --- a solid like any other ---------------------------------------------------------------------------------------


def test_it_is_a_solid_of_the_host(wire):
    assert isinstance(wire, cq.Solid)
    assert wire.ShapeType() == "Solid"
    assert wire.isValid()
    assert wire.label == "W1"
    assert wire.Volume() == pytest.approx(VOLUME, rel=1e-6)
    assert len(wire.Faces()) == 3


def test_the_hosts_operations(wire, plate):
    box = wire.BoundingBox()
    highest = wire.solution.points(2001)[:, 2].max()
    assert box.zmax == pytest.approx(highest + 2.0, abs=1e-2)
    half = wire.cut(cq.Solid.makeBox(200, 400, 400, cq.Vector(-100, -340, -100)))  # all on this side of y = 60
    assert type(half) is not CableSolid
    assert half.Volume() == pytest.approx(VOLUME / 2, rel=1e-6)
    ball = cq.Solid.makeSphere(5, cq.Vector(*wire.solution.position([175.0])[0]))
    assert wire.fuse(ball).Volume() == pytest.approx(VOLUME + ball.Volume() - wire.intersect(ball).Volume(), rel=1e-5)
    assert wire.distance(plate.val()) == pytest.approx(1.0, abs=1e-6)  # radius 2 in a hole of radius 3
    caps = cq.Workplane(obj=wire).faces("%PLANE")
    assert caps.size() == 2
    for wall in (-0.5, 0.5):  # a hollow cable, and a sleeve around it
        hollow = caps.shell(wall).val()
        assert hollow.isValid()
        assert hollow.Volume() == pytest.approx(VOLUME * abs((2.0 + wall) ** 2 - 4.0) / 4.0, rel=1e-5)
    assert cq.Compound.makeCompound([wire, plate.val()]).Volume() > VOLUME


def test_show_object_and_exporters_take_it(wire, tmp_path):
    vertices, triangles = wire.tessellate(0.1)
    assert len(triangles) > 100
    assert len(vertices) > 100
    edges_and_faces = toJSON(cq.Assembly(wire, color=cq.Color("blue")))  # what viewers of CadQuery are given
    assert all(len(shown["shape"]) > 1000 for shown in edges_and_faces)
    assert edges_and_faces[-1]["color"] == pytest.approx((0.0, 0.0, 1.0, 1.0))
    for name in ("w.step", "w.stl", "w.brep"):
        cq.exporters.export(cq.Workplane(obj=wire), str(tmp_path / name))
        assert (tmp_path / name).stat().st_size > 1000


MOVES = {
    "moved": lambda one: one.moved(cq.Location((1, 2, 3), (1, 1, 0), 30)),
    "moved by keywords": lambda one: one.moved(x=1, rz=20),
    "located": lambda one: one.located(cq.Location((1, 2, 3))),
    "copy": lambda one: one.copy(),
    "copy of a moved one": lambda one: one.moved(cq.Location((1, 2, 3))).copy(),
    "copy.copy": copy.copy,
    "copy.deepcopy": copy.deepcopy,
    "translate": lambda one: one.translate((1, 2, 3)),
    "rotate": lambda one: one.rotate((1, 2, 3), (2, 0, 1), 50),
    "move in place": lambda one: one.copy().move(cq.Location((1, 2, 3), (0, 1, 0), 10)),
}


@pytest.mark.parametrize("name", MOVES)
def test_results_travel_with_a_cable_that_moves_as_a_whole(wire, name):
    """As a plain solid moves, so does the cable; its numbers stay in a frame that the location tells."""
    moved, plain = MOVES[name](wire), MOVES[name](cq.Solid(wire.wrapped))
    assert isinstance(moved, CableSolid)
    assert moved.report is wire.report
    assert moved.solution is wire.solution
    np.testing.assert_allclose(moved.Center().toTuple(), plain.Center().toTuple(), atol=1e-9)
    frame = cq.Location(moved.built.solid.wrapped.Location())
    (x, y, z), _ = (frame * cq.Location(cq.Vector(*wire.solution.position([0.0])[0]))).toTuple()
    assert cq.Vertex.makeVertex(x, y, z).distance(plain) < 1e-6  # the start is on the solid


def test_an_end_that_moves_is_solved_again(wire):
    again = wire.moved(end=cq.Location((0, 125, 4)))
    assert isinstance(again, CableSolid)
    fresh = cable(cc.Port((0, 0, 4), UP), cc.Port((0, 125, 4), UP), diameter=4, length=350)
    assert again.solution.chord == pytest.approx(125.0, abs=1e-12)
    assert again.report["bend_radius_min"] == pytest.approx(fresh.report["bend_radius_min"], rel=1e-9)
    assert again.report["solid"]["tolerance"] == 1e-6  # that of the cable it was made from
    assert wire.solution.chord == pytest.approx(120.0, abs=1e-12)
    longer = wire.moved(length=360)
    assert longer.Volume() == pytest.approx(math.pi * 4 * 360, rel=1e-6)


def test_an_end_of_a_cable_that_was_moved_is_given_where_the_cable_is_now(wire):
    frame = cq.Location((10, 20, 30), (1, 2, 3), 40)
    there = wire.moved(frame).moved(end=frame * cq.Location((0, 125, 4)))
    here = wire.moved(end=cq.Location((0, 125, 4))).moved(frame)
    assert there.solution.chord == pytest.approx(125.0, abs=1e-9)
    np.testing.assert_allclose(there.Center().toTuple(), here.Center().toTuple(), atol=1e-6)


def test_straight_parts_stay_when_an_end_moves():
    first = cable(cc.Port((0, 0, 0), UP, straight=6), cc.Port((0, 100, 0), UP, straight=8), diameter=4, length=300)
    again = first.moved(start=cq.Location((0, -5, 0)), end=cc.Port((0, 105, 0), UP, straight=9))
    assert (again.cable.start.straight, again.cable.end.straight) == (6.0, 9.0)


@pytest.mark.parametrize(
    "frame",
    [
        cq.Location((1, 2, 3), (10, 20, 30)),
        cq.Plane((1, 2, 3), normal=(0.3, -0.2, 0.9)),
        cq.Location(cq.Plane((1, 2, 3), (1, 0, 0), (0.3, -0.2, 0.9))),
    ],
)
def test_frames_are_ports_to_the_api_itself(frame):
    """Their z axis is outward, without any adapter."""
    other = cq.Location((0, 120, 4))
    plain = cc.Cable("W", 4.0, frame, other, length=350.0)
    placed = frame if isinstance(frame, cq.Location) else frame.location
    outward = (placed * cq.Location((0, 0, 1))).toTuple()[0] - np.array([1, 2, 3])
    assert plain.start.position == pytest.approx((1, 2, 3))
    assert plain.start.outward == pytest.approx(tuple(outward))
    assert plain.end == cc.Port((0, 120, 4), UP)


def test_a_solution_follows_frames():
    solution = cc.solve(cc.Cable("W", 4.0, cq.Location((0, 0, 0)), cq.Location((0, 120, 0)), length=350.0))
    assert solution.moved(end=cq.Location((0, 125, 0))).chord == pytest.approx(125.0)


def test_a_frame_leaves_the_straight_part_as_it_is():
    ends = [cc.Port((0, y, 0), UP, 15.0) for y in (0, 120)]
    solution = cc.solve(cc.Cable("W", 4.0, *ends, length=350.0))
    moved = solution.moved(end=cq.Location((0, 125, 0)))
    assert moved.cable.end == cc.Port((0, 125, 0), UP, 15.0)
    assert solution.moved(end=cc.Port((0, 125, 0), UP)).cable.end.straight == 0.0


def test_a_meshed_cable_is_pickled_without_its_triangles(wire):
    before = len(pickle.dumps(wire.built))
    wire.tessellate(0.01)
    assert len(pickle.dumps(wire.built)) < 1.1 * before


@pytest.mark.parametrize(
    "change",
    [
        lambda wire: wire.clean(),
        lambda wire: cq.Workplane(obj=wire).clean().val(),
        lambda wire: cq.Workplane().pushPoints([(0, 0)]).eachpoint(lambda _: wire, useLocalCoordinates=True).val(),
        lambda wire: wire.moved([cq.Location((1, 2, 3))]),
        lambda wire: wire.moved(cq.Vertex.makeVertex(1, 2, 3)),
        lambda wire: wire.moved((1, 2, 3)),
    ],
)
def test_what_changes_nothing_keeps_the_results(wire, change):
    changed = change(wire)
    assert isinstance(changed, CableSolid)
    assert (changed.label, changed.report) == ("W1", wire.report)
    assert changed.isValid()
    assert changed.Volume() == pytest.approx(wire.Volume(), rel=1e-9)


def test_many_moves_at_once_are_a_compound_of_the_host(wire):
    assert isinstance(wire.moved([cq.Location(), cq.Location((9, 0, 0))]), cq.Compound)


def test_moves_that_cannot_be_meant(wire):
    with pytest.raises(UsageError, match="call it twice"):
        wire.moved(cq.Location((0, 0, 1)), end=cq.Location((0, 125, 4)))
    with pytest.raises(InfeasibleError):
        wire.moved(end=cq.Location((0, 500, 4)))


def test_what_is_no_longer_the_cable_says_so(wire):
    changed = [wire.scale(2), wire.mirror("XY"), wire.fillet(0.2, wire.Edges()[:1])]
    for one in changed:
        if isinstance(one, CableSolid):
            with pytest.raises(UsageError, match="no longer the cable"):
                one.report  # noqa: B018 - the access is the test
    with pytest.raises(UsageError, match="no longer the cable"):
        changed[0].moved(end=cq.Location((0, 125, 4)))


def test_pickled_it_is_still_the_cable(wire):
    back = pickle.loads(pickle.dumps(wire.moved(cq.Location((0, 0, 50)))))
    assert isinstance(back, CableSolid)
    assert back.label == "W1"
    assert back.report["solid"] == wire.report["solid"]
    assert back.BoundingBox().zmin == pytest.approx(wire.BoundingBox().zmin + 50.0)
    for other in (back.copy(), copy.deepcopy(back), back.translate((1, 0, 0)), cq.Workplane(obj=back).val()):
        assert other.report["name"] == "W1"
    assert back.moved(end=cq.Location((0, 125, 54))).solution.chord == pytest.approx(125.0)


def test_its_own_step_file(wire, tmp_path):
    wire.moved(cq.Location((0, 0, 50))).write_step(tmp_path / "w.step")
    (root,) = read_tree(tmp_path / "w.step")
    (node,) = root.children[0].children
    assert node.name == "W1"
    assert node.placement[2, 3] == pytest.approx(50.0)
    assert node.volume == pytest.approx(VOLUME, rel=1e-6)
    cc.write_step([as_solid(cc.build(wire.cable)).built], tmp_path / "plain.step")


# --- chains and assemblies ----------------------------------------------------------------------------------------


def test_a_factory_in_chains(plate):
    chain = plate.faces(">Z").edges("%CIRCLE").invoke(cable_from(cq.Location((0, 120, 4)), diameter=4, length=350))
    (made,) = chain.vals()
    assert made.report["start"]["position"] == [0.0, 0.0, 4.0]
    assert chain.end().size() == 1
    away = cable_from(lambda start: start * cq.Location((0, 50, 0)), diameter=4, length=120, name="lead")
    several = cq.Workplane("XZ").pushPoints([(0, 0), (30, 0), (60, 0)]).invoke(away)
    assert [one.label for one in several.vals()] == ["lead", "lead 2", "lead 3"]
    for one, x in zip(several.vals(), (0, 30, 60), strict=True):
        np.testing.assert_allclose(one.report["start"]["position"], [x, 0, 0], atol=1e-12)
        np.testing.assert_allclose(one.report["start"]["direction"], [0, -1, 0], atol=1e-12)
    each = cq.Workplane().pushPoints([(0, 0), (30, 0)]).eachpoint(away)
    assert [round(one.Volume()) for one in each.vals()] == [round(math.pi * 4 * 120)] * 2
    assert [one.BoundingBox().center.x for one in each.vals()] == pytest.approx([0.0, 30.0], abs=1e-6)


def starts(made):
    return [(w.report["start"]["position"], w.report["start"]["direction"]) for w in made.vals()]


def test_a_factory_starts_where_cadquery_has_its_own_features():
    """Of any plane, from points and from locations such as polarArray's."""
    make = cable_from(lambda start: start * cq.Location((0, 60, 0)), diameter=1, length=150)
    for plane in (cq.Workplane("YZ", origin=(50, 0, 0)), cq.Workplane("XZ", origin=(0, 1, 2)), cq.Workplane()):
        for points in (plane.polarArray(10, 0, 360, 3), plane.rarray(8, 8, 2, 2), plane.pushPoints([(3, 4)])):
            rims = points.circle(1).vals()
            for (position, direction), rim in zip(starts(points.invoke(make)), rims, strict=True):
                np.testing.assert_allclose(position, rim.Center().toTuple(), atol=1e-9)
                np.testing.assert_allclose(direction, plane.plane.zDir.toTuple(), atol=1e-12)


def test_a_factory_with_eachpoint_sees_the_plane_as_its_world():
    plane = cq.Workplane("YZ", origin=(50, 0, 0)).pushPoints([(3, 4)])
    make = cable_from(cq.Location((3, 64, 0)), diameter=1, length=150, name="E")
    (one,) = plane.eachpoint(make, useLocalCoordinates=True).vals()
    assert one.report["start"]["position"] == [3.0, 4.0, 0.0]
    assert one.label == "E"
    ends = [tuple(circle.arcCenter().toTuple()) for circle in one.Edges() if circle.geomType() == "CIRCLE"]
    np.testing.assert_allclose(sorted(ends, key=lambda end: end[2]), [(50, 3, 4), (50, 3, 64)], atol=1e-9)


def test_a_body_is_looked_at_once_for_all_that_was_selected(monkeypatch):
    from cablecad.adapters import cadquery_ends

    looked = []
    find = cadquery_ends.find_features
    monkeypatch.setattr(cadquery_ends, "find_features", lambda *given: looked.append(given) or find(*given))
    holes = cq.Workplane().box(80, 80, 8).faces(">Z").workplane().rarray(20, 20, 3, 3).hole(6)
    make = cable_from(lambda start: start * cq.Location((0, 60, 0)), diameter=3, length=150)
    for selected in (holes.faces(">Z").edges("%CIRCLE"), holes.faces(">Z or <Z")):
        looked.clear()
        assert len(selected.invoke(make).vals()) == selected.size()
        assert len(looked) == 1


def test_cables_are_added_all_or_none(wire):
    other = cable(cq.Location(), cq.Location((0, 121, 0)), diameter=4, length=350, name="B")
    whole = add_to(cq.Assembly(name="x"), wire)
    with pytest.raises(UsageError, match="'W1' already"):
        add_to(whole, other, wire)
    with pytest.raises(UsageError, match="'B' already"):
        add_to(whole, other, other)
    assert list(whole.objects) == ["x", "W1"]
    add_to(whole, other, loc=cq.Location((1, 2, 3)))
    assert whole.objects["B"].loc.toTuple()[0] == (1, 2, 3)


def test_an_assembly_keeps_name_colour_and_report(wire, plate, tmp_path):
    loom = cq.Assembly(plate, name="plate", color=cq.Color("gray"))
    assert add_to(loom, wire) is loom
    assert loom.objects["W1"].metadata["cablecad"] is wire.report
    loom.export(str(tmp_path / "loom.step"))
    (root,) = read_tree(tmp_path / "loom.step")
    (node,) = (node for node in root.walk() if node.name == "W1")
    np.testing.assert_allclose(node.color, (0x2B / 255, 0x6C / 255, 0xB0 / 255, 0x80 / 255), atol=1e-6)
    with pytest.raises(UsageError, match="has a 'W1' already"):
        add_to(loom, wire)
    with pytest.raises(UsageError, match="is no cable of cablecad"):
        add_to(loom, plate.val())


def test_a_scene_as_an_assembly(tmp_path):
    """What the host's exporter writes of it holds what `build` writes: names, colours, places, volumes."""
    loom = to_assembly(SAMPLES / "connectors.toml")
    assert loom.metadata["cablecad"]["cables"][0]["name"] == "W1"
    loom.export(str(tmp_path / "host.step"))
    cc.build_scene(cc.load_scene(SAMPLES / "connectors.toml"), tmp_path / "own.step")
    (host,), (own,) = read_tree(tmp_path / "host.step"), read_tree(tmp_path / "own.step")

    def told(node, frame):
        frame = frame @ np.vstack([node.placement, [0, 0, 0, 1]])
        color = node.color or node.occurrence_color
        volume = 0.0 if node.children else node.volume
        # CadQuery names products, and of occurrences only those of single shapes.
        yield node.name, None if color is None else tuple(np.round(color, 5)), round(volume, 4), np.round(frame, 9)
        for child in node.children:
            yield from told(child, frame)

    ours = [row for row in told(own, np.eye(4)) if row[2]]
    theirs = [row for row in told(host, np.eye(4)) if row[2]]
    assert [row[:3] for row in ours] == [row[:3] for row in theirs]
    for one, other in zip(ours, theirs, strict=True):
        np.testing.assert_allclose(one[3], other[3], atol=1e-8)
    assert "right connector" in loom["parts"].objects


@pytest.mark.parametrize("scene", ["loom", "parts", "cables", "W"])
@pytest.mark.parametrize("part", ["plate", "parts", "cables"])
@pytest.mark.parametrize("wire", ["W", "parts", "cables"])
def test_names_that_the_groups_have_too(scene, part, wire, tmp_path):
    if part == wire:
        return
    ports = (0, 0, 0), (0, 120, 0)
    cables = (cc.Cable(wire, 4.0, *(cc.Port(at, UP) for at in ports), length=350.0),)
    file = SAMPLES / "parts" / "connector.step"
    whole = to_assembly(cc.Scene(scene, cables, (cc.Part(part, file),)))
    solids = [path.rpartition("/")[2] for path in whole.objects if path.count("/") > 0]
    assert {part, wire} <= set(solids)
    whole.export(str(tmp_path / "a.step"))
    assert cq.importers.importStep(str(tmp_path / "a.step")).solids().size() >= 2


def test_colours_of_single_faces_reach_the_assembly(tmp_path):
    """io1-cm-214 has two faces of another colour."""
    data = Path(__file__).parents[1] / "data" / "io1-cm-214.stp"
    scene = cc.Scene("one", parts=(cc.Part("flange", data),))
    to_assembly(scene).export(str(tmp_path / "host.step"))
    (root,) = read_tree(tmp_path / "host.step")
    (wanted,) = (node for own in read_tree(data) for node in own.walk() if node.subshape_colors)
    found = [node for node in root.walk() if node.subshape_colors]
    colors = [color for node in found for color in node.subshape_colors.values()]
    np.testing.assert_allclose(colors, list(wanted.subshape_colors.values()), atol=1e-6)


# --- manners ------------------------------------------------------------------------------------------------------

UNTOUCHED = """
import json, sys
import cadquery
def state():
    return {
        f"{name}.{key}": id(value)
        for name, module in list(sys.modules.items()) if name.split(".")[0] == "cadquery"
        for owner in [module, *(v for v in vars(module).values() if isinstance(v, type))]
        for key, value in vars(owner).items() if not key.startswith("__")
    }
before = state()
modules = set(sys.modules)
import cablecad
light = sorted(name for name in set(sys.modules) - modules if not name.startswith("cablecad"))
import cablecad.adapters.cadquery as adapter
adapter.cable((0, 0, 0), (0, 100, 0), diameter=4, length=120)
after = state()
print(json.dumps([light, sorted(key for key in before if after.get(key) != before[key])]))
"""


def test_nothing_in_the_host_is_touched(tmp_path):
    done = subprocess.run([sys.executable, "-c", UNTOUCHED], capture_output=True, text=True, check=True, cwd=tmp_path)
    light, changed = json.loads(done.stdout)
    assert changed == []
    assert light == []  # `import cablecad` loads nothing that the host had not


def test_the_sample_runs_and_reads_back(tmp_path):
    check_loom(run_sample("cadquery_loom.py", tmp_path))
