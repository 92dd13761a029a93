"""Cables in build123d: part objects of the host, in algebra and builder mode, with joints and its own exporter."""

from __future__ import annotations

import copy
import json
import math
import pickle
import subprocess
import sys

import numpy as np
import pytest
from read_back import check_loom, run_sample

pytest.importorskip("build123d")

import build123d as b3d
from build123d import Align, Axis, GeomType, Location, Mode, Plane, Pos, Rot, Vector

import cablecad as cc
from cablecad.adapters.build123d import Cable, port
from cablecad.brep.step import read_tree
from cablecad.errors import GeometryError, InfeasibleError, UsageError

UP = (0.0, 0.0, 1.0)
VOLUME = math.pi * 4.0 * 350.0


def plate_at(y: float = 0.0):
    """A plate of 40 x 40 x 8 with a hole of radius 3 through it."""
    return Pos(0, y, 0) * (b3d.Box(40, 40, 8) - b3d.Cylinder(3, 8))


def rims(part):
    return part.edges().filter_by(GeomType.CIRCLE).sort_by(Axis.Z)


@pytest.fixture(scope="module")
def wire():
    ends = rims(plate_at())[-1], rims(plate_at(120.0))[-1]
    return Cable(*ends, diameter=4, length=350, name="W1", color="#2b6cb080", tolerance=1e-6)


def joint():
    return b3d.RigidJoint("J1", b3d.Box(2, 2, 2).locate(Location((1, 2, 3))), Location((1, 2, 3), (0, 90, 0)))


# --- ends ---------------------------------------------------------------------------------------------------------

ENDS = {
    "location": (lambda: Location((1, 2, 3), (0, 90, 0)), (1, 2, 3), (1, 0, 0)),
    "plane": (lambda: Plane((1, 2, 3), z_dir=(0, -2, 0)), (1, 2, 3), (0, -1, 0)),
    "joint": (joint, (1, 2, 3), (1, 0, 0)),
    "top rim": (lambda: rims(plate_at())[-1], (0, 0, 4), UP),
    "bottom rim": (lambda: rims(plate_at())[0], (0, 0, -4), (0, 0, -1)),
    "rim of a placed part": (lambda: rims(Rot(0, 90, 0) * plate_at(50.0)).sort_by(Axis.X)[-1], (4, 50, 0), (1, 0, 0)),
    "rim picked off a face": (
        lambda: plate_at().faces().sort_by(Axis.Z)[-1].edges().filter_by(GeomType.CIRCLE)[0],
        (0, 0, 4),
        UP,
    ),
    "list of one": (lambda: rims(plate_at())[-1:], (0, 0, 4), UP),
    "face": (lambda: plate_at().faces().sort_by(Axis.X)[-1], (20, 0, 0), (1, 0, 0)),
    "blind hole's wall": (
        lambda: (b3d.Box(20, 20, 20) - Pos(0, 0, 5) * b3d.Cylinder(2, 10)).faces().filter_by(GeomType.CYLINDER)[0],
        (0, 0, 5),
        UP,
    ),
    "circle by itself": (lambda: b3d.Edge.make_circle(3, Plane((1, 2, 3), z_dir=(0, 1, 0))), (1, 2, 3), (0, 1, 0)),
    "circle of a sketch": (lambda: b3d.Circle(3).edges(), (0, 0, 0), UP),
    "vertex": (lambda: b3d.Vertex(1, 2, 3), (1, 2, 3), None),
    "vector": (lambda: Vector(1, 2, 3), (1, 2, 3), None),
    "numbers": (lambda: (1, 2, 3), (1, 2, 3), None),
    "position and outward": (lambda: ((1, 2, 3), (0, 0, 1)), (1, 2, 3), UP),
    "port": (lambda: cc.Port((1, 2, 3), UP), (1, 2, 3), UP),
}


@pytest.mark.parametrize("name", ENDS)
def test_what_an_end_may_be(name):
    make, position, outward = ENDS[name]
    end = port(make())
    np.testing.assert_allclose(end.position, position, atol=1e-12)
    if outward is None:
        assert getattr(end, "outward", None) is None
    else:
        np.testing.assert_allclose(end.outward, outward, atol=1e-12)


NO_ENDS = {
    "straight edge": (lambda: b3d.Box(1, 1, 1).edges()[0], GeometryError, "is no circle"),
    "through hole's wall": (lambda: plate_at().faces().filter_by(GeomType.CYLINDER)[0], GeometryError, "open on both"),
    "two edges": (lambda: rims(plate_at()), UsageError, "a list of 2 shapes"),
    "part": (plate_at, UsageError, "select one of its faces"),
    "text": (lambda: "top", UsageError, "which is no end of a cable"),
    "part of a scene": (lambda: cc.PartPort("plate", port="J1"), UsageError, "needs a scene"),
}


@pytest.mark.parametrize("name", NO_ENDS)
def test_what_no_end_may_be(name):
    make, error, words = NO_ENDS[name]
    with pytest.raises(error, match=words):
        port(make())


def test_frames_are_ports_to_the_api_itself():
    """Their z axis is outward, without any adapter."""
    plane = Plane((1, 2, 3), z_dir=(0, 1, 0))
    for frame in (plane, plane.location):
        plain = cc.Cable("W", 4.0, frame, Location((0, 120, 4)), length=350.0)
        assert plain.start.position == pytest.approx((1, 2, 3))
        assert plain.start.outward == pytest.approx((0, 1, 0), abs=1e-15)
        assert plain.end == cc.Port((0, 120, 4), (0, 0, 1))


class Placed(Location):
    """A user's own kind of location."""


@pytest.mark.parametrize("frame", [Pos(0, 0, 0), Rot(0, 0, 0), Placed((0, 0, 0)), Pos(0, 0, 0) * Rot(0, 0, 30)])
def test_kinds_of_locations_are_ports_too(frame):
    plain = cc.Cable("W", 4.0, frame, Pos(0, 120, 0), length=350.0)
    assert plain.start == cc.Port((0, 0, 0), (0, 0, 1))
    assert cc.solve(plain).moved(end=Pos(0, 125, 0)).chord == pytest.approx(125.0)


def test_errors_with_values_of_the_host_can_be_pickled():
    with pytest.raises(cc.SceneError) as caught:
        cc.Cable("W", 4.0, Vector(1, 2, 3), Plane.XY, length=300.0)
    assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)


def test_ports_of_parts_that_are_placed_elsewhere():
    end = port(rims(plate_at())[-1], Location((1, 2, 3), (0, 90, 0)))
    np.testing.assert_allclose(end.position, (5, 2, 3), atol=1e-12)
    np.testing.assert_allclose(end.outward, (1, 0, 0), atol=1e-12)


def test_data_reach_the_cable():
    made = Cable(
        (0, 0, 0), (0, 100, 0), 4, length=120, bulge=Vector(1, 0, 0), material=cc.Material(youngs_modulus=10.0)
    )
    assert made.cable.bulge == (1.0, 0.0, 0.0)
    assert made.report["start"]["force"] is not None
    with pytest.raises(UsageError, match="a cable has no lenght; besides"):
        Cable((0, 0, 0), (0, 100, 0), diameter=4, lenght=120)
    with pytest.raises(UsageError, match="needs its diameter"):
        Cable((0, 0, 0), (0, 100, 0), length=120)
    with pytest.raises(InfeasibleError):
        Cable((0, 0, 0), (0, 100, 0), diameter=4, length=90)


# --- a part object like any other ---------------------------------------------------------------------------------


def test_it_is_a_part_of_the_host(wire):
    assert isinstance(wire, b3d.BasePartObject)
    assert wire.is_valid
    assert wire.label == "W1"
    assert tuple(wire.color) == pytest.approx((0x2B / 255, 0x6C / 255, 0xB0 / 255, 0x80 / 255), abs=1e-6)
    assert wire.volume == pytest.approx(VOLUME, rel=1e-6)
    assert len(wire.solids()) == 1
    assert len(wire.faces()) == 3


def test_the_hosts_operations(wire):
    highest = wire.solution.points(2001)[:, 2].max()
    assert pytest.approx(highest + 2.0, abs=1e-2) == wire.bounding_box().max.Z
    half = wire - Pos(0, -140, 0) * b3d.Box(400, 400, 800)  # all on this side of y = 60
    assert not isinstance(half, Cable)
    assert half.volume == pytest.approx(VOLUME / 2, rel=1e-6)
    ball = Pos(*wire.solution.position([175.0])[0]) * b3d.Sphere(5)
    both, common = wire + ball, wire & ball
    assert both.volume == pytest.approx(VOLUME + ball.volume - common.volume, rel=1e-5)
    for wall in (-0.5, 0.5):  # a hollow cable, and a sleeve around it
        hollow = b3d.offset(wire, amount=wall, openings=wire.faces().filter_by(GeomType.PLANE))
        assert hollow.is_valid
        assert hollow.volume == pytest.approx(VOLUME * abs((2.0 + wall) ** 2 - 4.0) / 4.0, rel=1e-5)
    assert wire.distance_to(plate_at()) == pytest.approx(1.0, abs=1e-6)  # radius 2 in a hole of radius 3
    vertices, triangles = wire.tessellate(0.1)
    assert min(len(vertices), len(triangles)) > 100
    assert "Solid" in wire.show_topology()


def test_joints_are_the_ends_with_their_axes_outward(wire):
    for label, y in (("start", 0), ("end", 120)):
        frame = wire.joints[label].location
        assert isinstance(wire.joints[label], b3d.RigidJoint)
        assert tuple(frame.position) == pytest.approx((0, y, 4), abs=1e-9)
        assert tuple(Plane(frame).z_dir) == pytest.approx(UP, abs=1e-12)
        assert wire.joints[label].symbol.is_valid


def test_a_joint_given_as_an_end_is_the_cables_joint_too():
    given = joint()
    made = Cable(given, Location((1, 60, 3), (0, 90, 0)), diameter=2, length=150)
    for axis in ("x_dir", "z_dir"):
        assert tuple(getattr(Plane(made.joints["start"].location), axis)) == pytest.approx(
            tuple(getattr(Plane(given.location), axis)), abs=1e-9
        )


def test_a_connector_plugs_into_a_joint_of_the_cable(wire):
    plug = b3d.Cylinder(3, 10)
    b3d.RigidJoint("mouth", plug, Location((0, 0, 5)))
    wire.joints["end"].connect_to(plug.joints["mouth"])
    assert tuple(plug.center()) == pytest.approx((0, 120, -1), abs=1e-9)


def test_pinned_ends_have_joints_along_the_cable():
    made = Cable((0, 0, 0), (0, 100, 0), diameter=2, length=120)
    for label, way in (("start", 1), ("end", -1)):
        tangent = way * np.array(made.report[label]["direction"])
        assert tuple(Plane(made.joints[label].location).z_dir) == pytest.approx(tuple(tangent), abs=1e-12)


def test_rotation_and_align_come_last_and_take_the_joints_along():
    """Aligned first, then turned, as build123d does: (x, y) goes to (-y, x)."""
    ends = (0, 0, 0), (0, 100, 0)
    align = (Align.MIN, Align.CENTER, Align.MAX)
    plain = Cable(*ends, diameter=4, length=120)
    turned = Cable(*ends, diameter=4, length=120, rotation=(0, 0, 90), align=align)
    box = turned.bounding_box()
    assert pytest.approx((0.0, 0.0, 0.0), abs=5e-2) == (box.min.Y, box.center().X, box.max.Z)
    assert pytest.approx((plain.bounding_box().size.X, plain.bounding_box().size.Y), abs=5e-2) == (
        box.size.Y,
        box.size.X,
    )
    for label in ("start", "end"):
        frame = turned.joints[label].location
        assert b3d.Vertex(*frame.position).distance_to(turned) < 1e-6
        way = np.array(plain.report[label]["direction"]) * (1 if label == "start" else -1)
        assert tuple(Plane(frame).z_dir) == pytest.approx((-way[1], way[0], way[2]), abs=1e-12)
    assert turned.report["start"]["position"] == plain.report["start"]["position"]


def test_in_a_builder_it_adds_to_the_part_once():
    with b3d.BuildPart() as loom:
        b3d.Box(40, 40, 8)
        b3d.Hole(1.5)
        block = loom.part.volume
        start = rims(loom.part)[-1]
        made = Cable(start, Location((0, 120, 4)), diameter=4, length=350)
        assert loom.part.volume == pytest.approx(block + VOLUME, rel=1e-6)
        before = loom.part.volume
        again = made.moved(end=Location((0, 125, 4)))
        assert loom.part.volume == before
        Cable(start, Location((0, 120, 4)), diameter=4, length=350, mode=Mode.PRIVATE)
        assert loom.part.volume == before
        Cable(start, Location((0, 120, 4)), diameter=4, length=350, mode=Mode.SUBTRACT)
        assert loom.part.volume == pytest.approx(block, rel=1e-3)
    assert again.solution.chord == pytest.approx(125.0, abs=1e-12)
    assert made.report["length"] == 350.0


def test_at_several_places_in_a_builder():
    with b3d.BuildPart() as loom, b3d.Locations((0, 0, 0), (50, 0, 0)):
        made = Cable((0, 0, 0), (0, 100, 0), diameter=4, length=120)
    assert loom.part.volume == pytest.approx(2 * math.pi * 4 * 120, rel=1e-6)
    assert made.volume == pytest.approx(2 * math.pi * 4 * 120, rel=1e-6)
    with pytest.raises(UsageError, match="holds 2 solids"):
        made.built  # noqa: B018 - the access is the test


MOVES = {
    "moved": lambda one: one.moved(Location((1, 2, 3), (10, 20, 30))),
    "algebra": lambda one: Pos(1, 2, 3) * Rot(0, 30, 0) * one,
    "located": lambda one: one.located(Location((1, 2, 3))),
    "copy.copy": copy.copy,
    "copy.deepcopy of a moved one": lambda one: copy.deepcopy(one.moved(Location((1, 2, 3)))),
    "translate": lambda one: one.translate((1, 2, 3)),
    "rotate": lambda one: one.rotate(Axis.Y, 30),
    "move in place": lambda one: copy.copy(one).move(Location((1, 2, 3), (10, 20, 30))),
}


@pytest.mark.parametrize("name", MOVES)
def test_results_travel_with_a_cable_that_moves_as_a_whole(wire, name):
    moved, plain = MOVES[name](wire), MOVES[name](b3d.Part(wire.wrapped))
    assert isinstance(moved, Cable)
    assert moved.report is wire.report
    center = b3d.CenterOf.MASS
    assert tuple(moved.center(center)) == pytest.approx(tuple(plain.center(center)), abs=1e-9)
    frame = Location(moved.built.solid.wrapped.Location())
    start = (frame * Pos(*wire.solution.position([0.0])[0])).position
    assert tuple(moved.joints["start"].location.position) == pytest.approx(tuple(start), abs=1e-9)
    assert b3d.Vertex(*start).distance_to(plain) < 1e-6


def test_an_end_that_moves_is_solved_again(wire):
    again = wire.moved(end=Location((0, 125, 4)))
    assert isinstance(again, Cable)
    assert again.solution.chord == pytest.approx(125.0, abs=1e-12)
    assert again.volume == pytest.approx(VOLUME, rel=1e-6)
    assert tuple(again.joints["end"].location.position) == pytest.approx((0, 125, 4), abs=1e-9)
    assert tuple(again.joints["start"].location.position) == pytest.approx((0, 0, 4), abs=1e-9)
    assert (again.label, tuple(again.color)) == (wire.label, tuple(wire.color))
    assert wire.solution.chord == pytest.approx(120.0, abs=1e-12)
    frame = Location((10, 20, 30), (10, 20, 30))
    there = wire.moved(frame).moved(end=frame * Location((0, 125, 4)))
    assert there.solution.chord == pytest.approx(125.0, abs=1e-9)
    assert tuple(there.joints["end"].location.position) == pytest.approx(
        tuple((frame * Location((0, 125, 4))).position), abs=1e-9
    )
    with pytest.raises(UsageError, match="call it twice"):
        wire.moved(Location((0, 0, 1)), end=Location((0, 125, 4)))


@pytest.mark.parametrize(
    "change",
    [
        lambda one: one.scale(2.0),
        lambda one: one.mirror(Plane.XY),
        lambda one: one.rotate(Axis.Y, 30, transform=True),
        lambda one: one.translate((1, 2, 3), transform=True),
        lambda one: b3d.fillet(one.edges()[:1], 0.2),
    ],
)
def test_what_is_no_longer_the_cable_says_so(wire, change):
    changed = change(wire)
    assert changed.wrapped is not None
    if isinstance(changed, Cable):
        for ask in (lambda: changed.report, lambda: changed.built, lambda: changed.moved(end=Location((0, 125, 4)))):
            with pytest.raises(UsageError, match="no longer the cable"):
                ask()


def test_its_own_step_file(wire, tmp_path):
    (Pos(0, 0, 50) * wire).write_step(tmp_path / "w.step")
    (root,) = read_tree(tmp_path / "w.step")
    (node,) = root.children[0].children
    assert node.name == "W1"
    assert node.placement[2, 3] == pytest.approx(50.0)
    assert node.volume == pytest.approx(VOLUME, rel=1e-6)
    assert Cable(cc.build(wire.cable)).report["name"] == "W1"


# --- manners ------------------------------------------------------------------------------------------------------

UNTOUCHED = """
import json, sys
import build123d
def state():
    return {
        f"{name}.{key}": id(value)
        for name, module in list(sys.modules.items()) if name.split(".")[0] == "build123d"
        for owner in [module, *(v for v in vars(module).values() if isinstance(v, type))]
        for key, value in vars(owner).items() if not key.startswith(("__", "_abc_"))
    }
before = state()
modules = set(sys.modules)
import cablecad
light = sorted(name for name in set(sys.modules) - modules if not name.startswith("cablecad"))
import cablecad.adapters.build123d as adapter
adapter.Cable((0, 0, 0), (0, 100, 0), diameter=4, length=120)
after = state()
print(json.dumps([light, sorted(key for key in before if after.get(key) != before[key])]))
"""


def test_nothing_in_the_host_is_touched(tmp_path):
    done = subprocess.run([sys.executable, "-c", UNTOUCHED], capture_output=True, text=True, check=True, cwd=tmp_path)
    light, changed = json.loads(done.stdout)
    assert changed == []
    assert light == []  # `import cablecad` loads nothing that the host had not


def test_the_sample_runs_and_reads_back(tmp_path):
    check_loom(run_sample("build123d_loom.py", tmp_path))
