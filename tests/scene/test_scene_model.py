"""The checks behind the scene reader, asked for by a Python user who makes the objects himself."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cablecad.errors import SceneError
from cablecad.model import (
    Cable,
    EquilibriumKey,
    Material,
    Part,
    Pin,
    Port,
    Section,
    Toward,
    cable_mistakes,
    checked_tolerance,
    material_mistakes,
)

ENDS = {"start": Port((0, 0, 0), (0, 0, 1)), "end": Port((0, 120, 0), (0, 0, 1))}
PINS = {"start": Pin((0, 0, 0)), "end": Pin((0, 120, 0))}


def paths(make) -> list[str]:
    with pytest.raises(SceneError) as caught:
        make()
    return [mistake.path for mistake in caught.value.mistakes]


@pytest.mark.parametrize("position", ["123", ["1", "2", "3"], (True, 0, 0), (10**400, 0, 0), (0, 0), 5, None, b"abc"])
def test_what_float_would_take_for_three_numbers_is_refused(position):
    assert paths(lambda: Pin(position))[0].startswith("position")


@pytest.mark.parametrize("position", [[1, 2, 3], np.array([1.0, 2.0, 3.0]), np.arange(1, 4, dtype=np.float32)])
def test_any_three_numbers_are_a_position(position):
    assert Pin(position).position == (1.0, 2.0, 3.0)


def test_whole_numbers_beyond_a_double_are_not_finite():
    with pytest.raises(SceneError, match="must be a finite number"):
        Section(10**400)


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ({"youngs_modulus": 1.0, "poissons_ratio": True}, ["poissons_ratio"]),
        ({"youngs_modulus": 1.0, "poissons_ratio": float("inf")}, ["poissons_ratio"]),
        ({"bending_stiffness": 1.0, "poissons_ratio": 0.2, "torsional_stiffness": 1.0}, ["poissons_ratio"]),
        ({"youngs_modulus": 0.0, "bending_stiffness": 1.0}, ["youngs_modulus", ""]),
    ],
)
def test_material_tells_each_mistake_once(values, expected):
    assert paths(lambda: Material(**values)) == expected


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ({"length": 350.0, "material": "pvc"}, ["material"]),
        ({"length": "shortest", "slack": 0.1, "min_bend_radius": 9.0}, ["slack"]),
        ({"force": 3.0, "length": 350.0}, ["force"]),
        ({"length": 350.0, "start": (0, 0, 0), "end": 5}, ["start", "end"]),
        ({"length": 350.0, "equilibrium": True}, ["equilibrium"]),
    ],
)
def test_cable_tells_each_mistake_once(values, expected):
    assert paths(lambda: Cable(**{"name": "W1", "diameter": 4.0, **ENDS, **values})) == expected


@pytest.mark.parametrize("side", [True, 1.0, 0, "1"])
def test_side_is_one_of_two_whole_numbers(side):
    assert paths(lambda: EquilibriumKey(0, side)) == ["side"]


@pytest.mark.parametrize("step", ["", "."])
def test_step_is_a_path(step):
    assert paths(lambda: Part("plate", step)) == ["step"]


@pytest.mark.parametrize(
    ("given", "unreadable", "expected"),
    [
        ({**ENDS}, {"length"}, []),
        ({**ENDS, "slack": 0.1}, {"length"}, ["slack"]),
        ({**ENDS, "length": "shortest"}, {"min_bend_radius"}, []),
        ({**PINS, "length": 1.0, "force": 3.0}, {"material"}, []),
        ({"start": PINS["start"], "end": Toward((0, 0, 1)), "length": 1.0}, {"chord"}, []),
        ({"start": PINS["start"], "end": Toward((0, 0, 1)), "slack": 1.0}, {"angle_deg"}, ["length"]),
        ({"start": ENDS["start"], "rise": 3.0}, {"end"}, ["rise", "length"]),
        ({"start": PINS["start"], "rise": 3.0}, {"end"}, []),
        ({"start": PINS["start"]}, {"end"}, ["length"]),
    ],
)
def test_what_could_not_be_read_counts_as_given(given, unreadable, expected):
    values = {"name": "W1", "diameter": 4.0, **given}
    assert [mistake.path for mistake in cable_mistakes(values, unreadable)] == expected


def test_a_modulus_that_could_not_be_read_counts_as_given():
    assert not list(material_mistakes({"poissons_ratio": 0.2}, {"youngs_modulus"}))
    assert [mistake.path for mistake in material_mistakes({}, {"poissons_ratio"})] == [""]


def test_scalars_of_numpy_are_numbers() -> None:
    cable = Cable("a", np.float32(4.0), Pin((0, 0, 0)), Pin(np.array([1, 0, 0])), length=np.int64(3))
    assert (type(cable.diameter), cable.diameter) == (float, 4.0)
    assert (type(cable.length), cable.length) == (int, 3)


@pytest.mark.parametrize(
    "position", [{1, 2, 3}, {1: 0, 2: 0, 3: 0}, b"abc", np.array(5.0), np.eye(3), np.ones((3, 1)), (10**400, 0, 0)]
)
def test_what_has_no_order_or_no_three_numbers_is_no_position(position):
    with pytest.raises(SceneError, match="position"):
        Pin(position)


@pytest.mark.parametrize("tolerance", [None, "x", True, math.nan, math.inf, -1.0, 0.0, 10**400, np.array(5.0), 1e-12])
def test_a_tolerance_given_by_itself_is_checked(tolerance):
    with pytest.raises(SceneError, match=r"tolerance\.shape"):
        checked_tolerance(tolerance)
    assert checked_tolerance(np.float64(0.5)) == 0.5


@pytest.mark.parametrize("key", ["equilibrium", "allow_contact"])
def test_what_always_has_a_value_is_not_none(key):
    with pytest.raises(SceneError, match=key):
        Cable("W1", 4.0, Pin((0, 0, 0)), Pin((0, 90, 0)), length=100.0, **{key: None})
