"""Dotted names of values of a scene: the place each names, what is not there, and what changes."""

from __future__ import annotations

import copy

import pytest

from cablecad.errors import SceneError
from cablecad.scene import find_target, load_raw_scene, overlaps

SCENE = """\
format = 1
[materials.pvc]
youngs_modulus = 3890.0
[[parts]]
name = "plate"
step = "plate.step"
[[parts.ports]]
name = "J1"
position = [12, 0, 3]
outward = [0, 0, 1]
[[parts]]
name = "left connector"
step = "left.step"
position = [1, 2, 3]
[[cables]]
name = "W1"
diameter = 4.0
length = 350.0
start = { position = [0, 0, 0], outward = [0, 0, 1] }
end = { position = [0, 120, 0], outward = [0, 0, 1] }
[[cables]]
name = "W1.a"
diameter = 4.0
length = 350.0
start = { position = [0, 0, 0] }
end = { position = [0, 120, 0] }
"""


@pytest.fixture
def raw(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(SCENE)
    return load_raw_scene(path)


@pytest.mark.parametrize(
    ("name", "place"),
    [
        ("name", ("name",)),
        ("tolerance.shape", ("tolerance", "shape")),
        ("materials.pvc.youngs_modulus", ("materials", "pvc", "youngs_modulus")),
        ("materials.pvc.poissons_ratio", ("materials", "pvc", "poissons_ratio")),
        ("cables.W1.length", ("cables", 0, "length")),
        ("cables[1].length", ("cables", 1, "length")),
        ('cables."W1.a".length', ("cables", 1, "length")),
        ("cables.W1.slack", ("cables", 0, "slack")),
        ("cables.W1.end.position[1]", ("cables", 0, "end", "position", 1)),
        ("cables.W1.end", ("cables", 0, "end")),
        ("cables.W1.equilibrium.winding", ("cables", 0, "equilibrium", "winding")),
        ("parts.left connector.position[2]", ("parts", 1, "position", 2)),
        ("parts.plate.position[2]", ("parts", 0, "position", 2)),
        ("parts.plate.ports.J1.position[0]", ("parts", 0, "ports", 0, "position", 0)),
        ("parts[0].ports[0].outward", ("parts", 0, "ports", 0, "outward")),
        ("parts.plate.rotation.angle_deg", ("parts", 0, "rotation", "angle_deg")),
    ],
)
def test_place(raw, name, place):
    assert find_target(name, raw.data).place == place


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("cables.W2.length", "no cable 'W2'; the scene has W1, W1.a"),
        ("parts.left conector.step", "no part 'left conector'; did you mean 'left connector'?"),
        ("materials.pcv.youngs_modulus", "no material 'pcv'; did you mean 'pvc'?"),
        ("cables.W1.lenght", "unknown key 'lenght' of cables[0]; did you mean 'length'?"),
        ("tolerance.form", "unknown key 'form' of tolerance; known: shape"),
        ("kables.W1.length", "unknown key 'kables'; did you mean 'cables'?"),
        ("cables[2].length", "the scene has 2 cables, counted from 0"),
        ("cables.W1.end.position[3]", "[3] is beyond the three numbers of cables[0].end.position"),
        ("cables.W1.end.position[0][1]", "is no list of numbers: leave out [1]"),
        ("cables.W1.length[0]", "cables[0].length is no list of numbers: leave out [0]"),
        ("cables.W1.length.mm", "cables[0].length holds no keys: leave out .mm"),
        ("cables.W1.bulge[0]", "the scene has no cables[0].bulge to change one number of"),
        ("cables.W1", "names no single value"),
        ("cables", "names no single value"),
        ("materials.pvc", "names no single value"),
        ("parts.plate.ports", "names no single value"),
        ("parts.plate.ports.J1", "names no single value"),
        ("parts.plate.ports.J2.position", "no port 'J2'; the scene has J1"),
        ("cables..W1", "is no dotted name such as cables.W1.end.position[1]: see '..W1'"),
        ("cables.W1.", "is no dotted name"),
        ("[0]", "is no list of numbers"),
        ("", "is empty"),
    ],
)
def test_what_is_not_there(raw, name, words):
    with pytest.raises(SceneError) as caught:
        find_target(name, raw.data)
    assert words in str(caught.value)


def test_two_cables_of_one_name_go_by_number(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(SCENE.replace("W1.a", "W1"))
    data = load_raw_scene(path).data
    with pytest.raises(SceneError, match=r"2 cables are called 'W1': write cables\[0\] and so on"):
        find_target("cables.W1.length", data)
    assert find_target("cables[1].length", data).place == ("cables", 1, "length")


def test_overriding_changes_a_copy(raw):
    before = copy.deepcopy(raw.data)
    names = ["cables.W1.length", "cables.W1.end.position[1]", "parts.plate.position[2]", "tolerance.shape"]
    changed = raw.overridden([(find_target(name, raw.data), 7.0 + i) for i, name in enumerate(names)])
    assert raw.data == before
    cable, plate = changed.data["cables"][0], changed.data["parts"][0]
    assert (cable["length"], cable["end"]) == (7.0, {"position": [0, 8.0, 0], "outward": [0, 0, 1]})
    assert (plate["position"], changed.data["tolerance"]) == ([0.0, 0.0, 9.0], {"shape": 10.0})
    assert changed.data["cables"][1] is raw.data["cables"][1]
    scene = changed.resolve()
    assert (scene.cables[0].length, scene.cables[0].end.position, scene.tolerance) == (7.0, (0.0, 8.0, 0.0), 10.0)


def test_none_takes_a_key_out(raw):
    length, slack = (find_target(f"cables.W1.{key}", raw.data) for key in ("length", "slack"))
    cable = raw.overridden([(length, None), (slack, 0.5)]).resolve().cables[0]
    assert (cable.length, cable.slack) == (None, 0.5)


def test_a_table_takes_the_place_of_an_index(raw):
    target = find_target("cables.W1.equilibrium.winding", raw.data)
    index = find_target("cables.W1.equilibrium", raw.data)
    cable = raw.overridden([(index, 0), (target, 1)]).resolve().cables[0]
    assert (cable.equilibrium.winding, cable.equilibrium.side) == (1, 1)


@pytest.mark.parametrize(
    ("one", "other", "do"),
    [
        ("cables.W1.length", "cables[0].length", True),
        ("cables.W1.end", "cables.W1.end.position[0]", True),
        ("cables.W1.end.position[0]", "cables.W1.end.position[1]", False),
        ("cables.W1.length", "cables[1].length", False),
    ],
)
def test_overlaps(raw, one, other, do):
    assert overlaps(*(find_target(name, raw.data) for name in (one, other))) is do


def test_wrong_types_and_unknown_keys_of_a_scene_are_told_before_anything_is_overridden(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(SCENE.replace("diameter = 4.0", 'diameter = "4"', 1).replace("length = 350.0", "lenght = 350.0"))
    with pytest.raises(SceneError) as caught:
        load_raw_scene(path)
    assert [mistake.path for mistake in caught.value.mistakes] == [
        "cables.W1.diameter",
        "cables.W1.lenght",
        'cables."W1.a".lenght',
    ]


def test_what_a_scene_lacks_may_come_with_the_override(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(SCENE.replace("length = 350.0\n", "", 1))
    raw = load_raw_scene(path)
    assert raw.overridden([(find_target("cables.W1.length", raw.data), 400)]).resolve().cables[0].length == 400
