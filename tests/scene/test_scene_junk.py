"""Nonsense as a scene: whatever stands in it, the answer is a scene or one of cablecad's own errors, never a crash."""

from __future__ import annotations

import copy
import json
import tomllib
from typing import Literal

import hypothesis.strategies as st
import jsonschema
from hypothesis import given, settings
from test_scene_load import FULL

from cablecad.errors import CablecadError, SceneError
from cablecad.model import Scene
from cablecad.scene import parse_scene, scene_schema

KEYS = sorted({key for table in [scene_schema(), *scene_schema()["$defs"].values()] for key in table["properties"]})
VALIDATOR = jsonschema.Draft202012Validator(scene_schema())

scalars = (
    st.none()
    | st.booleans()
    | st.integers(-3, 3)
    | st.integers()
    | st.sampled_from([10**400, -(10**400), 2**1024 - 1])
    | st.floats()
    | st.text(st.characters(), max_size=5)  # surrogates too
    | st.sampled_from(["shortest", "pvc", "W1", "plate", "#123456"])
)
keys = st.sampled_from(KEYS) | st.text(max_size=4)
junk = st.recursive(
    scalars | st.lists(st.integers(-2, 2), min_size=3, max_size=3),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(keys, inner, max_size=6),
    max_leaves=20,
)


def parsed(text: str | bytes, syntax: Literal["toml", "json"] | None = None) -> Scene | CablecadError:
    try:
        return parse_scene(text, syntax=syntax)
    except CablecadError as error:
        return error


def tables_of(value: object) -> list[dict | list]:
    """Every table and array in raw data, itself first."""
    parts = value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
    inner = [table for part in parts for table in tables_of(part)]
    return [value, *inner] if isinstance(value, dict | list) else inner


@given(junk)
@settings(max_examples=300, deadline=None, derandomize=True)
def test_any_json_is_a_scene_or_an_error_that_can_be_printed(value):
    answer = parsed(json.dumps(value))
    if isinstance(answer, CablecadError):
        assert str(answer).encode()
        assert isinstance(answer, SceneError)
        assert answer.mistakes
        assert all("Input should" not in mistake.problem for mistake in answer.mistakes)  # pydantic's words


@given(st.data())
@settings(max_examples=300, deadline=None, derandomize=True)
def test_a_good_scene_with_something_put_in_is_refused_or_fits_the_schema(data):
    scene = copy.deepcopy(tomllib.loads(FULL))
    for _ in range(data.draw(st.integers(1, 3))):
        table = data.draw(st.sampled_from(tables_of(scene)))
        value = data.draw(junk)
        if isinstance(table, dict):
            table[data.draw(keys)] = value
        elif table:
            table[data.draw(st.integers(0, len(table) - 1))] = value
    answer = parsed(json.dumps(scene))
    if isinstance(answer, Scene):
        VALIDATOR.validate(scene)
    else:
        assert str(answer).encode()


@given(st.data())
@settings(max_examples=200, deadline=None, derandomize=True)
def test_a_key_taken_out_is_no_crash(data):
    scene = copy.deepcopy(tomllib.loads(FULL))
    table = data.draw(st.sampled_from([table for table in tables_of(scene) if isinstance(table, dict) and table]))
    del table[data.draw(st.sampled_from(sorted(table)))]
    answer = parsed(json.dumps(scene))
    if isinstance(answer, Scene):
        VALIDATOR.validate(scene)


@given(st.text(max_size=40) | st.binary(max_size=40), st.sampled_from([None, "toml", "json"]))
@settings(max_examples=300, deadline=None, derandomize=True)
def test_any_text_is_a_scene_or_an_error_that_can_be_printed(text, syntax):
    assert str(parsed(text, syntax)).encode()
