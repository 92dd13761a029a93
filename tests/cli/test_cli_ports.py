"""Ends on parts at the command line: named ports and features of real files, and `cablecad resolve`."""

from __future__ import annotations

import json
import math
import shutil
import tomllib
from pathlib import Path

import numpy as np
import pytest
from loom import cable, names, part, scene, write

pytest.importorskip("OCP", reason="solids need the kernel")

from cablecad.brep.step import read_tree

CONNECTOR = Path(__file__).parents[2] / "samples" / "parts" / "connector.step"
DATA = Path(__file__).parents[1] / "data"
PORT = '[[parts.ports]]\nname = "J1"\nposition = [0, 0, 0]\noutward = [1, 0, 0]\n'
TURN = "{ axis = [0, 0, 1], angle_deg = 180 }"

LOOM = scene(
    part("left", "parts/connector.step"),
    part("right", "parts/connector.step", position="[200, 0, 0]", rotation=TURN) + PORT,
    cable(
        length="260.0",
        start='{ part = "left", near = [0.01, 0, 0], straight = 5 }',
        end='{ part = "right", port = "J1" }',
    ),
)


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch):
    (tmp_path / "parts").mkdir()
    shutil.copy(CONNECTOR, tmp_path / "parts" / "connector.step")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_solve_says_what_it_took_from_geometry(cli, here):
    write(here / "loom.toml", LOOM)
    ended = cli("solve", "loom.toml")
    assert ended.code == 0
    assert ended.err == (
        "note: ends of cables are taken from the geometry of left, for which Open Cascade is loaded\n"
        "note: cable W1: start is taken from part left: circular edge of radius 5 mm at [0, 0, 0], outward [1, 0, 0], "
        "0.01 mm away (in its own coordinates)\n"
    )
    assert cli("solve", "loom.toml", "-q").err == ""
    report = json.loads(cli("solve", "loom.toml", "--json").out)
    (one,) = report["cables"]
    for end, place in (("start", 0.0), ("end", 200.0)):
        np.testing.assert_allclose(one[end]["position"], [place, 0, 0], atol=1e-12)
        np.testing.assert_allclose(one[end]["direction"], [1, 0, 0], atol=1e-14)
    assert "; start is taken from part left: circular edge of radius 5 mm" in one["reason"]
    assert report["seconds"]["import"] is not None
    assert report["seconds"]["read"] > 0.0


def test_ends_by_name_alone_load_no_kernel_and_say_nothing(cli, here):
    left = part("left", "parts/connector.step") + PORT
    right = part("right", "parts/connector.step", position="[200, 0, 0]", rotation=TURN) + PORT
    ends = {"start": '{ part = "left", port = "J1" }', "end": '{ part = "right", port = "J1" }'}
    write(here / "loom.toml", scene(left, right, cable(**ends, length="260.0")))
    ended = cli("solve", "loom.toml", "--json")
    assert (ended.code, ended.err) == (0, "")
    assert json.loads(ended.out)["seconds"]["import"] is None


@pytest.mark.parametrize("output", [None, "loom2.toml", "loom2.json", "out/loom2.toml"])
def test_resolved_scenes_build_the_same_bytes(cli, here, output):
    (here / "out").mkdir()
    write(here / "loom.toml", LOOM)
    assert cli("build", "loom.toml", "-o", "a.step").code == 0
    if output is None:
        ended = cli("resolve", "loom.toml")
        output = write(here / "out" / "printed.toml", ended.out)
    else:
        ended = cli("resolve", "loom.toml", "-o", output)
        assert ended.out == f"{output}\n"
    assert ended.code == 0
    built = cli("build", output, "-o", "b.step")
    assert (built.code, built.err) == (0, "")
    assert (here / "a.step").read_bytes() == (here / "b.step").read_bytes()


def test_resolve_prints_json_too(cli, here):
    write(here / "loom.toml", LOOM)
    data = json.loads(cli("resolve", "loom.toml", "--json").out)
    assert data["cables"][0]["start"] == {"position": [0, 0, 0], "outward": [1, 0, 0], "straight": 5}
    assert data["parts"][0]["step"] == str(here / "parts" / "connector.step")
    assert data["parts"][1]["ports"] == [{"name": "J1", "position": [0, 0, 0], "outward": [1, 0, 0]}]
    assert tomllib.loads(cli("resolve", "loom.toml").out) == data


def test_ports_move_with_their_part(cli, here):
    """The same pick on a part that was turned and moved: the end is where the part's mouth is now."""
    turn = "{ axis = [0, 1, 0], angle_deg = -90 }"
    placed = part("left", "parts/connector.step", position="[10, 20, 30]", rotation=turn)
    end = "{ position = [110, 20, 30], outward = [0, 0, 1] }"
    write(here / "loom.toml", scene(placed, cable(start='{ part = "left", near = [0, 0, 0] }', end=end)))
    (one,) = json.loads(cli("solve", "loom.toml", "--json").out)["cables"]
    np.testing.assert_allclose(one["start"]["position"], [10, 20, 30], atol=1e-12)
    np.testing.assert_allclose(one["start"]["direction"], [0, 0, 1], atol=1e-15)
    assert cli("build", "loom.toml").code == 0
    (root,) = read_tree(here / "loom.step")
    (left,) = root.children[0].children
    np.testing.assert_allclose(left.placement[:, :3] @ (1, 0, 0), [0, 0, 1], atol=1e-12)


def test_what_is_not_clear_is_one_scene_error(cli, here):
    text = scene(
        part("left", "parts/connector.step"),
        cable(start='{ part = "left", near = [-3, 0, 0] }', end='{ part = "left", near = [500, 0, 0] }'),
    )
    write(here / "loom.toml", text)
    for command in (("solve",), ("build", "-o", "out.step"), ("check",), ("resolve",), ("resolve", "-o", "b.toml")):
        ended = cli(*command, "loom.toml")
        assert (ended.code, ended.out) == (2, "")
        lines = ended.err.splitlines()
        assert lines[0] == "error: loom.toml: 2 mistakes"
        assert lines[1].startswith(
            "  cables.W1.start.near = [-3.0, 0.0, 0.0]: 2 ports are as near, in the part's own coordinates: circular"
        )
        assert "outward [1, 0, 0], 0 mm away; circular edge" in lines[1]
        assert lines[2].startswith("  cables.W1.end.near = [500.0, 0.0, 0.0]: is 500 mm away from every feature")
    assert names(here) == ["loom.toml", "parts"]


def test_a_part_that_cannot_be_read_keeps_only_its_cables_from_their_ends(cli, here):
    text = scene(
        part("left", "parts/none.step"),
        part("right", "parts/connector.step"),
        cable("W1", start='{ part = "left", near = [0, 0, 0] }'),
        cable("W2"),
    )
    write(here / "loom.toml", text)
    ended = cli("solve", "loom.toml")
    assert ended.code == 5
    assert ended.out.startswith("W1: unsolved\nW2: solved")
    assert "error: part left: parts/none.step does not exist" in ended.err
    assert "error: cable W1: its start is on part left, which could not be read" in ended.err
    ended = cli("resolve", "loom.toml")
    assert (ended.code, ended.out) == (5, "")
    report = json.loads(cli("solve", "loom.toml", "--json").out)
    assert [one["result"] for one in report["cables"]] == ["unsolved", "solved"]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("-o", "loom.toml"), "is also an input of the scene"),
        (("-o", "parts/connector.step"), "its name must end in .toml or .json"),
        (("-o", "new.toml", "--json"), "its name must end in .json"),
    ],
)
def test_resolve_refuses_outputs_that_cannot_be_meant(cli, here, arguments, said):
    write(here / "loom.toml", LOOM)
    before = (here / "loom.toml").read_bytes()
    ended = cli("resolve", "loom.toml", *arguments)
    assert (ended.code, ended.out) == (2, "")
    assert said in ended.err
    assert (here / "loom.toml").read_bytes() == before
    assert names(here) == ["loom.toml", "parts"]


def test_bolt_holes_of_a_file_from_another_package(cli, here):
    """io1-cm-214: a flange of six holes of radius 3.5 on a circle of 37.5, 6 thick along x; in its own placement."""
    ends = {"start": '{ part = "flange", near = [0, 0.2, 37.4] }', "end": '{ part = "flange", near = [0, 0, -37.5] }'}
    write(here / "loom.toml", scene(part("flange", str(DATA / "io1-cm-214.stp")), cable(**ends, length="200.0")))
    (one,) = json.loads(cli("solve", "loom.toml", "--json").out)["cables"]
    np.testing.assert_allclose(one["start"]["position"], [0, 0, 37.5], atol=1e-9)
    np.testing.assert_allclose(one["end"]["position"], [0, 0, -37.5], atol=1e-9)
    for end, way in (("start", -1), ("end", 1)):
        assert math.dist(one[end]["direction"], (way, 0, 0)) < 1e-9


def test_holes_of_an_assembly_that_knows_no_circles(cli, here):
    """as1-oc-214: nested assemblies, and every circle two splines, one exact and one off by 5e-6 of the radius.

    The bolt heads stand on the plate's brackets; the rod's ends stick out at x = -10 and 190, its axis at y 75, z 60.
    """
    ends = {"start": '{ part = "as1", near = [-10, 75.3, 60] }', "end": '{ part = "as1", near = [190, 75, 60.1] }'}
    write(here / "loom.toml", scene(part("as1", str(DATA / "as1-oc-214.stp")), cable(**ends, length="330.0")))
    (one,) = json.loads(cli("solve", "loom.toml", "--json").out)["cables"]
    for end, x in (("start", -10), ("end", 190)):
        np.testing.assert_allclose(one[end]["position"], [x, 75, 60], atol=1e-9)
        np.testing.assert_allclose(one[end]["direction"], [-1, 0, 0], atol=1e-9)
