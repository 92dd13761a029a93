"""Grids: every combination, both ends met, and what is no axis."""

from __future__ import annotations

import pytest
from variants import CLAMPED, write

from cablecad.batch import grid_rows
from cablecad.errors import SceneError


@pytest.fixture
def scene(tmp_path):
    return write(tmp_path / "scene.toml", CLAMPED)


def test_full_factorial_last_axis_fastest(scene):
    rows = grid_rows(scene, ["cables.W1.length=300:400:3", "cables.W1.end.position[1]=100,120"])
    assert len(rows) == 6
    assert [row.id for row in rows] == ["1", "2", "3", "4", "5", "6"]
    cables = [row.resolve().cables[0] for row in rows]
    assert [(cable.length, cable.end.position[1]) for cable in cables] == [
        (300.0, 100.0),
        (300.0, 120.0),
        (350.0, 100.0),
        (350.0, 120.0),
        (400.0, 100.0),
        (400.0, 120.0),
    ]


def test_both_ends_of_a_range_are_met(scene):
    lengths = [row.overrides["cables.W1.length"] for row in grid_rows(scene, ["cables.W1.length=0.1:0.7:7"])]
    assert lengths == [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7]


@pytest.mark.parametrize(
    ("axis", "values"),
    [
        ("cables.W1.color=#2b6cb0,#ffffff", ["#2b6cb0", "#ffffff"]),
        ("name=a:b:3,c", ["a:b:3", "c"]),
        ("cables.W1.bulge=[1,0,0], [-1,0,0]", [[1, 0, 0], [-1, 0, 0]]),
        ("cables.W1.length=300", [300]),
        ("cables.W1.length=300:300:1", [300.0]),
        ("cables.W1.end.position[1]=-0e99999999:0.0:1", [0.0]),
        (f"cables.W1.length=0.{'3' * 5000}:1:2", [1 / 3, 1.0]),
        ("cables.W1.allow_contact=true,false", [True, False]),
        ("cables.W1.equilibrium=0:2:3", [0, 1, 2]),
        ("cables.W1.equilibrium=1.0,2", [1, 2]),
        (
            'cables.W1.equilibrium={"winding": 0, "side": 1}, {"winding":1,"side":-1}',
            [{"winding": 0, "side": 1}, {"winding": 1, "side": -1}],
        ),
    ],
)
def test_lists(scene, axis, values):
    name = axis.partition("=")[0]
    assert [row.overrides[name] for row in grid_rows(scene, [axis])] == values


@pytest.mark.parametrize(
    ("axes", "words"),
    [
        (["cables.W1.length"], "write it as NAME=START:STOP:COUNT"),
        (["cables.W1.length="], "has no values"),
        (["cables.W1.equilibrium=0:1:3"], "= 0.5: must be an index such as 0"),
        (["cables.W1.length=300:400:0"], "must be a whole number from 1 to 10000000"),
        (["cables.W1.length=300:400:2.5"], "must be a whole number from 1 to 10000000"),
        (["cables.W1.length=300:400:99999999"], "must be a whole number from 1 to 10000000"),
        (["cables.W1.length=300:400:1"], "a range of one value must begin where it ends"),
        (["cables.W1.length=300:4oo:3"], "'4oo' is no number"),
        (["cables.W1.length=1e-99999999:1:3"], "'1e-99999999' is too small to be told from 0; write 0"),
        (["cables.W1.length=1e99999999:1:3"], "'1e99999999' is no number"),
        (["cables.W1.length=300:400"], "must be a finite number of mm"),
        (["cables.W1.lenght=1,2"], "did you mean 'length'?"),
        (["cables.W1.length=1,2", "cables[0].length=1,2"], "names what cables.W1.length names too"),
        (["cables.W1.length=1:2:5000", "cables.W1.end.position[1]=1:2:5000"], "the grid has 25000000 rows"),
        (["cables.W1.bulge=[1,0,0],[1"], "is no list of [x, y, z]"),
    ],
)
def test_what_is_no_axis(scene, axes, words):
    with pytest.raises(SceneError) as caught:
        grid_rows(scene, axes)
    assert words in str(caught.value)


def test_all_mistakes_at_once(scene):
    with pytest.raises(SceneError) as caught:
        grid_rows(scene, ["cables.W1.lenght=1,2", "cables.W9.length=1,2", "cables.W1.diameter=a,b", "x"])
    assert len(caught.value.mistakes) == 5
