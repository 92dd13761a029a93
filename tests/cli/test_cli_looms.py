"""What a harness engineer does to a program: other folders, odd names, odd editors, many cables, none, and parts."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from loom import FORMAT, PVC, cable, names, part, scene, write

from cablecad.brep.step import read_tree

CONNECTOR = (Path(__file__).parents[2] / "samples" / "parts" / "connector.step").read_bytes()


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def children(node):
    return {child.occurrence: child for child in node.children}


# --- folders and names -----------------------------------------------------------------------------------------------


def test_paths_of_parts_begin_at_the_scene_those_of_outputs_where_one_stands(cli, here, monkeypatch):
    for folder in ("project/scenes", "project/parts", "elsewhere"):
        (here / folder).mkdir(parents=True)
    write(here / "project" / "parts" / "connector.step", CONNECTOR)
    write(here / "project" / "scenes" / "loom.toml", scene(part("a", "../parts/connector.step"), cable()))
    monkeypatch.chdir(here / "elsewhere")
    scene_path = Path("..") / "project" / "scenes" / "loom.toml"
    assert cli("build", scene_path, "-o", "out.step").out == "out.step\n"
    assert names(here / "elsewhere") == ["out.step"]
    assert cli("build", scene_path).out == f"{scene_path.with_suffix('.step')}\n"
    assert names(here / "project" / "scenes") == ["loom.step", "loom.toml"]


def test_absolute_paths_of_parts(cli, here):
    (here / "far").mkdir()
    write(here / "far" / "connector.step", CONNECTOR)
    path = write(here / "loom.toml", scene(part("a", str(here / "far" / "connector.step"))))
    assert cli("build", path).code == 0


@pytest.mark.parametrize(
    "folder", ["with spaces and (brackets)", "Kabelbäume 電纜", "-o", "~", "a'b\"c", "#1 %20 $HOME"]
)
def test_paths_of_any_letters(cli, here, folder):
    place = here / folder
    place.mkdir()
    write(place / "Stecker groß.step", CONNECTOR)
    path = write(place / "loom 1 ✓.toml", scene(part("Stecker", "Stecker groß.step"), cable()))
    ended = cli("build", path, "-o", place / "aus gabe Ü.step", "--report", place / "r 1.json")
    assert (ended.code, ended.err) == (0, "")
    assert ended.out == f"{place / 'aus gabe Ü.step'}\n{place / 'r 1.json'}\n"
    (root,) = read_tree(place / "aus gabe Ü.step")
    assert list(children(root)) == ["parts", "cables"]


ODD_NAMES = [
    "Käbel Größe 5",
    "电缆-1",
    "кабель",
    "🧵 loom",
    "it's",
    'a "b"',
    "a;b,(c)=#1$*",
    "\\X2\\00E4\\X0\\",
    "a/b\\c",
]


def test_names_of_any_letters_come_back(cli, here):
    places = [
        {end: f"{{ position = [{x}, {50 * i}, 0] }}" for end, x in (("start", 0), ("end", 300))}
        for i in range(len(ODD_NAMES))
    ]
    tables = [cable(name, **place) for name, place in zip(ODD_NAMES, places, strict=True)]
    path = write(here / "loom.toml", scene('name = "Baum ☃"\n', *tables))
    ended = cli("build", path, "--report", "out.json")
    assert (ended.code, ended.err) == (0, "")
    (root,) = read_tree(here / "loom.step")
    assert root.name == "Baum ☃"
    assert [node.name for node in root.children[0].children] == ODD_NAMES
    assert [node.occurrence for node in root.children[0].children] == ODD_NAMES
    assert (here / "loom.step").read_bytes().isascii()
    report = json.loads((here / "out.json").read_text(encoding="utf-8"))
    assert [one["name"] for one in report["cables"]] == ODD_NAMES


def test_very_long_names(cli, here):
    long, longer = "L" * 300, "電" * 3000
    path = write(here / "loom.toml", scene(f"name = '{long}'\n", cable(longer)))
    assert cli("build", path).code == 0
    (root,) = read_tree(here / "loom.step")
    assert (root.name, root.children[0].children[0].name) == (long, longer)
    broken = write(here / "loom.toml", scene(cable(longer, diameter="-1")))
    assert len(cli("solve", broken).err) < 1000  # a message is to be read


# --- editors ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("change", ["lines end with CR LF", "byte order mark", "no line break at the end"])
def test_what_editors_do(cli, here, change):
    text = scene(cable(), part(step="p.step"), head='name = "x"\n')
    data = {
        "lines end with CR LF": text.replace("\n", "\r\n").encode(),
        "byte order mark": b"\xef\xbb\xbf" + text.encode(),
        "no line break at the end": text.rstrip().encode(),
    }[change]
    write(here / "p.step", CONNECTOR)
    plain = write(here / "plain.toml", text)
    edited = write(here / "edited.toml", data)
    assert cli("build", plain).code == cli("build", edited).code == 0
    assert (here / "plain.step").read_bytes() == (here / "edited.step").read_bytes()


def test_json_scene_gives_what_the_same_toml_gives(cli, here):
    one = {
        "name": "W1",
        "diameter": 4,
        "length": 350,
        "start": {"position": [0, 0, 0]},
        "end": {"position": [300, 0, 0]},
    }
    write(here / "loom.json", json.dumps({"format": 1, "cables": [one]}, ensure_ascii=True))
    write(here / "loom.toml", scene(cable()))
    assert cli("build", "loom.json", "-o", "a.step").code == cli("build", "loom.toml", "-o", "b.step").code == 0
    assert (here / "a.step").read_bytes() == (here / "b.step").read_bytes()


# --- few and many ----------------------------------------------------------------------------------------------------


def test_scene_of_parts_alone(cli, here):
    write(here / "p.step", CONNECTOR)
    path = write(here / "loom.toml", scene(part("a", "p.step"), part("b", "p.step", position="[100, 0, 0]")))
    assert cli("solve", path).out == cli("check", path).out == ""
    ended = cli("build", path, "--report", "out.json")
    assert (ended.code, ended.out) == (0, f"{here / 'loom.step'}\nout.json\n")
    report = json.loads((here / "out.json").read_text())
    assert (report["cables"], report["parts"]) == ([], [{"name": "a", "solids": 2}, {"name": "b", "solids": 2}])
    (root,) = read_tree(here / "loom.step")
    assert list(children(root)) == ["parts"]


def test_parts_of_one_file_share_its_geometry_and_stand_where_they_were_put(cli, here):
    write(here / "p.step", CONNECTOR)
    turned = part("b", "p.step", position="[10, 20, 30]", rotation="{ axis = [0, 0, 2], angle_deg = 90 }")
    path = write(here / "loom.toml", scene(part("a", "p.step"), turned))
    assert cli("build", path).code == 0
    one, other = read_tree(here / "loom.step")[0].children[0].children
    assert one.shape.IsSame(other.shape)
    np.testing.assert_allclose(one.placement, np.eye(3, 4), atol=1e-15)
    np.testing.assert_allclose(other.placement, [[0, -1, 0, 10], [1, 0, 0, 20], [0, 0, 1, 30]], atol=1e-15)


def test_fifty_cables(cli, here):
    tables = [
        cable(
            f"W{i}",
            start=f"{{ position = [0, {20 * i}, 0] }}",
            end=f"{{ position = [300, {20 * i}, 0] }}",
            length=str(301 + i),
            color=f'"#{5 * i:02x}0000"',
        )
        for i in range(50)
    ]
    path = write(here / "loom.toml", scene(*tables))
    ended = cli("build", path, "--report", "out.json")
    assert (ended.code, ended.err) == (0, "")
    built = read_tree(here / "loom.step")[0].children[0].children
    assert [node.name for node in built] == [f"W{i}" for i in range(50)]
    for i, node in enumerate(built):
        assert node.volume == pytest.approx(math.pi * 4 * (301 + i), rel=1e-5)
        np.testing.assert_allclose(node.color, (5 * i / 255, 0, 0, 1), atol=1e-6)
    assert all(one["solid"]["valid"] for one in json.loads((here / "out.json").read_text())["cables"])


def test_one_bad_cable_of_fifty_is_named(cli, here):
    tables = [cable(f"W{i}", length="299" if i == 37 else "310") for i in range(50)]
    ended = cli("solve", write(here / "loom.toml", scene(*tables)))
    assert ended.code == 3
    assert [line for line in ended.out.splitlines() if ": solved, " not in line] == ["W37: infeasible"]
    assert ended.err.startswith("error: cable W37: length 299 mm is 1 mm less than")
    assert ended.err.count("\n") == 1


# --- ways to say it --------------------------------------------------------------------------------------------------


def test_any_two_data_give_the_same_cable(cli, here):
    """Each pair of data of the cable with 40 degrees, taken from its own report, gives it again."""
    first = write(
        here / "loom.toml", scene(cable(angle_deg="40", material='"pvc"', end="{ toward = [1, 0, 0] }"), head=PVC)
    )
    (one,) = json.loads(cli("solve", first, "--json").out)["cables"]
    data = {
        "length": one["length"],
        "chord": one["chord"],
        "rise": one["rise"],
        "bend_radius": one["bend_radius_min"],
        "force": one["start"]["force"][0],
        "angle_deg": one["end_angle_deg"],
        "slack": one["slack"],
    }
    pairs = [(a, b) for i, a in enumerate(data) for b in list(data)[i + 1 :] if {a, b} != {"angle_deg", "slack"}]
    tables = []
    for a, b in pairs:
        keys = {"length": None, a: repr(data[a]), b: repr(data[b])}
        tables.append(cable(f"{a} and {b}", material='"pvc"', end="{ toward = [1, 0, 0] }", **keys))
    ended = cli("solve", write(here / "loom.toml", scene(*tables, head=PVC)), "--json")
    assert ended.code == 0
    for (a, b), found in zip(pairs, json.loads(ended.out)["cables"], strict=True):
        assert found["length"] == pytest.approx(350.0, rel=1e-10), (a, b)
        assert found["end_angle_deg"] == pytest.approx(40.0, rel=1e-9), (a, b)
    assert len(pairs) == 20


def test_redundant_data_that_agree_are_fine(cli, here):
    path = write(here / "loom.toml", scene(cable(rise="80.3694497")))
    ended = cli("solve", path)
    assert ended.code == 0
    assert ended.out == cli("solve", write(here / "loom.toml", scene(cable()))).out


@pytest.mark.parametrize(
    ("bulge", "axis", "sign"), [(None, 2, 1), ("[0, 0, -3]", 2, -1), ("[0, 1, 0]", 1, 1), ("[5, -1e-3, 0]", 1, -1)]
)
def test_bulge_is_the_side_it_bends_to(cli, here, bulge, axis, sign):
    path = write(here / "loom.toml", FORMAT + cable(**({} if bulge is None else {"bulge": bulge})))
    (one,) = json.loads(cli("solve", path, "--json", "--points", "3").out)["cables"]
    expected = [150.0, 0.0, 0.0]
    expected[axis] = sign * one["rise"]
    np.testing.assert_allclose(one["points"][1], expected, atol=1e-10)
