"""One value of a scene over a range: how it is written, and where it goes."""

from __future__ import annotations

import copy

import pytest

from cablecad.errors import SceneError, UsageError
from cablecad.scene import load_data, load_scene, parse_sweep, resolve_scene, with_value

DATA = {
    "format": 1,
    "cables": [
        {
            "name": name,
            "diameter": 4.0,
            "length": 350.0,
            "start": {"position": [0, y, 0]},
            "end": {"position": [300, y, 0]},
        }
        for name, y in (("W1", 0), ("W1.2", 9))
    ],
}


@pytest.mark.parametrize(
    ("text", "place", "values"),
    [
        ("cables.W1.length=300:400:11", "cables.W1.length", tuple(range(300, 401, 10))),
        ("a.b=0:1:3", "a.b", (0, 0.5, 1)),
        ("a.b=1:0:2", "a.b", (1, 0)),
        ("a.b=5:5:1", "a.b", (5,)),
        ("a.b= 1, 2.5,-3 ", "a.b", (1, 2.5, -3)),
        ("cables.x=y.length=1:2:2", "cables.x=y.length", (1, 2)),
        ("a=1e-3:3e-3:3", "a", (1e-3, pytest.approx(2e-3, rel=1e-15), 3e-3)),
    ],
)
def test_what_a_range_says(text, place, values):
    sweep = parse_sweep(text)
    assert (sweep.place, sweep.values) == (place, values)


def test_whole_numbers_stay_whole():
    """An index of an equilibrium is one."""
    assert [type(value) for value in parse_sweep("a=0:4:3").values] == [int, int, int]
    assert [type(value) for value in parse_sweep("a=0.0:4.0:3").values] == [float, float, float]


@pytest.mark.parametrize(
    "text", ["", "a", "a=", "=1:2:3", "a=1:2", "a=1:2:3:4", "a=1:2:0", "a=1:2:1", "a=1:2:x", "a=1:2:2.5", "a=1,,2",
             "a=one", "a=nan:1:3", "a=0:inf:3", "a=0:1:1000001"],
)  # fmt: skip
def test_what_says_nothing(text):
    with pytest.raises(UsageError, match=r"cables\.W1\.length=300:400:11|how many values there are"):
        parse_sweep(text)


@pytest.mark.parametrize(
    ("place", "found"),
    [
        ("cables.W1.length", lambda data: data["cables"][0]["length"]),
        ('cables."W1.2".length', lambda data: data["cables"][1]["length"]),
        ("cables[1].length", lambda data: data["cables"][1]["length"]),
        ("cables.W1.end.position[2]", lambda data: data["cables"][0]["end"]["position"][2]),
        ("cables.W1.min_bend_radius", lambda data: data["cables"][0]["min_bend_radius"]),
        ("format", lambda data: data["format"]),
    ],
)
def test_where_a_value_goes(place, found):
    before = copy.deepcopy(DATA)
    changed = with_value(DATA, place, 77.5)
    assert before == DATA  # as it was
    assert found(changed) == 77.5
    assert {key: value for key, value in changed.items() if key != place.split(".")[0].split("[")[0]} == {
        key: value for key, value in DATA.items() if key != place.split(".")[0].split("[")[0]
    }


@pytest.mark.parametrize(
    ("place", "said"),
    [
        ("cables.W9.length", "there is no 'W9' in the scene; there is W1, W1.2"),
        ("cables.W1.end.position[3]", "there is no 3 in the scene; there is 0, 1, 2"),
        ("cables.W1.end[0]", "there is no 0 in the scene; there is position"),
        ("cables[2].length", "there is no 2 in the scene; there is W1, W1.2"),
        ("cables..length", "is no place such as"),
        ("cables.W1]", "is no place such as"),
        ("cables.W1.length.mm", "nothing called 'mm' in a single value"),
        ("wires.W1.length", "there is no 'wires' in the scene; there is format, cables"),
        ("cables.W1.finish.position", "there is no 'finish' in the scene; there is name, diameter"),
    ],
)
def test_places_that_are_not(place, said):
    with pytest.raises(UsageError, match=said):
        with_value(DATA, place, 1.0)


def test_data_of_a_file_make_the_scene_of_the_file(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(
        'format = 1\n[[cables]]\nname = "W1"\ndiameter = 4.0\nlength = 350\nstart = { position = [0, 0, 0] }\n'
        "end = { position = [300, 0, 0] }\n"
    )
    data = load_data(path)
    assert resolve_scene(data, source=path) == load_scene(path)
    (longer,) = resolve_scene(with_value(data, "cables.W1.length", 400), source=path).cables
    assert longer.length == 400.0
    with pytest.raises(SceneError, match=r"cables\.W1\.length"):
        resolve_scene(with_value(data, "cables.W1.length", -1), source=path)


def test_data_that_no_scene_may_hold_are_refused_as_by_load_scene(tmp_path):
    path = tmp_path / "scene.json"
    path.write_text('{"format": 1, "format": 1, "cables": []}')
    errors = []
    for load in (load_data, load_scene):
        with pytest.raises(SceneError) as caught:
            load(path)
        errors.append(str(caught.value))
    assert errors[0] == errors[1]
    assert "stands more than once" in errors[0]
