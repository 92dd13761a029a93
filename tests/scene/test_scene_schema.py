"""The JSON Schema: it says every key with its unit, takes what `load_scene` takes, and refuses typical mistakes."""

from __future__ import annotations

import json
import tomllib

import jsonschema
import pytest
from scene_text import PORT, cable, part, pinned, ported
from test_scene_load import FULL, LEAST
from test_scene_mistakes import BAD

from cablecad.errors import SceneError
from cablecad.model import RANGES, Cable, Material, NamedPort, Part, Rotation
from cablecad.scene import parse_scene, scene_schema
from cablecad.scene.starter import starter_scene

SCHEMA = scene_schema()
TABLES = {"Scene": SCHEMA, **SCHEMA["$defs"]}
KEYS = [(table, key) for table, schema in TABLES.items() for key in schema["properties"]]

# What no schema can say: what ties one place of a file to another, and the numbers it does not tell apart.
BEYOND = {
    "port: a part that is not there",
    "port: a part without ports",
    "port: a port that is not there",
    "port: data of a pinned cable on a feature",
    "port: data of a pinned cable on a port with an axis",
    "port: length and slack on a port with an axis",
    "port: no parts at all",
    "port: one name for two ports",
    "port: straight at a port without an axis",
    "together: unknown material",
    "together: unknown material, nothing near",
    "together: no materials",
    "together: one name twice",
    "together: a part's name on a cable",
    "together: toward from a clamp",
    "together: shortest toward",
    "together: length and slack",
    "together: data of a pinned cable on a clamped one",
    "missing: the second datum",
    "missing: a datum with a scale",
    "missing: format 1.0",
    "type: equilibrium 1.0",
    "value: a null in step",
    "type: nan",
}


@pytest.fixture(scope="module")
def validator():
    jsonschema.Draft202012Validator.check_schema(SCHEMA)
    return jsonschema.Draft202012Validator(SCHEMA)


def test_it_is_json_of_its_own():
    first = scene_schema()
    assert json.loads(json.dumps(first)) == first
    first["properties"].clear()
    assert scene_schema()["properties"]


def test_every_table_is_closed_and_described():
    for schema in TABLES.values():
        assert schema["additionalProperties"] is False
        assert schema["title"]
        assert schema["description"]


@pytest.mark.parametrize(("table", "key"), KEYS)
def test_every_key_is_described_with_its_unit_and_an_example(table, key, validator):
    schema = TABLES[table]["properties"][key]
    (example,) = schema["examples"]
    resolved = {"$defs": SCHEMA["$defs"], **schema}
    jsonschema.Draft202012Validator(resolved).validate(example)
    if schema.get("type") in ("number", "array") and "$ref" not in schema.get("items", {}):
        units = ("[mm]", "[MPa]", "[N mm^2]", "[kg/m]", "[N]", "[degrees]", "(dimensionless)")
        assert sum(unit in schema["description"] for unit in units) == 1
    assert schema["description"].endswith((".", "."))
    assert "default" not in schema or schema["default"] is not None


def test_keys_are_those_of_the_model():
    fields = {name: set(kind.__slots__) for name, kind in (("Cable", Cable), ("Part", Part), ("Material", Material))}
    fields["Rotation"], fields["Port"] = set(Rotation.__slots__), set(NamedPort.__slots__)
    for name, keys in fields.items():
        assert set(TABLES[f"{name}Table"]["properties"]) == keys


@pytest.mark.parametrize(
    "text", [FULL, LEAST, starter_scene(), cable(), pinned(), ported(PORT), part("name='a'\nstep='b'")]
)
def test_it_accepts_valid_scenes(text, validator):
    parse_scene(text)
    validator.validate(tomllib.loads(text))


UNPRINTABLE = {"type: a whole number no decimal can show"}
"""The validator refuses it and then fails at saying so."""


@pytest.mark.parametrize("name", sorted(set(BAD) - BEYOND - UNPRINTABLE))
def test_it_rejects_bad_scenes(name, validator):
    assert not validator.is_valid(tomllib.loads(BAD[name][0]))


@pytest.mark.parametrize("name", sorted(BEYOND))
def test_it_lets_through_only_what_no_schema_can_say(name, validator):
    assert validator.is_valid(tomllib.loads(BAD[name][0]))


END = {"position": [0, 120, 0]}


@pytest.mark.parametrize(
    ("end", "fits"),
    [
        (END, True),
        (END | {"straight": 0}, True),
        (END | {"straight": 5}, False),
        (END | {"outward": [0, 0, 1], "straight": 5}, True),
        (END | {"direction": [0, 0, -1], "straight": 5}, True),
        (END | {"outward": [0, 0, 1], "direction": [0, 0, -1]}, False),
        (END | {"outward": [0, 0, 0]}, False),
        (END | {"toward": [0, 1, 0]}, False),
        ({"toward": [0, 1, 0]}, True),
        ({"toward": [0, 1, 0], "straight": 0}, False),
        ({"outward": [0, 1, 0]}, False),
        ({}, False),
    ],
)
def test_ends_agree_with_the_loader(end, fits, validator):
    scene = tomllib.loads(pinned(rise="30"))
    del scene["cables"][0]["rise"]
    scene["cables"][0]["end"] = end
    if "toward" in end:
        scene["cables"][0]["rise"] = 30
    if fits:
        parse_scene(json.dumps(scene))
    else:
        with pytest.raises(SceneError):
            parse_scene(json.dumps(scene))
    assert validator.is_valid(scene) == fits


def assert_agreed(scene, fits, validator, said):
    """The loader takes a scene, or refuses it and says what; and the schema does the same."""
    if fits:
        parse_scene(json.dumps(scene))
    else:
        with pytest.raises(SceneError, match=said):
            parse_scene(json.dumps(scene))
    assert validator.is_valid(scene) == fits


def numbers_around(key: str) -> list[tuple[float, bool]]:
    above, least, below, most = RANGES[key]
    tries = []
    for bound, belongs, step in ((above, False, 1), (least, True, 1), (below, False, -1), (most, True, -1)):
        if bound is not None:
            tries += [(bound, belongs), (bound + 0.01 * step, True), (bound - 0.01 * step, False)]
    return tries


@pytest.mark.parametrize(("key", "value", "fits"), [(key, *row) for key in RANGES for row in numbers_around(key)])
def test_ranges_of_schema_and_loader_are_one(key, value, fits, validator):
    scene = tomllib.loads(pinned(head="[materials.pvc]\n", material='"pvc"'))
    (wire,), pvc = scene["cables"], scene["materials"]["pvc"]
    pvc["bending_stiffness" if key in ("bending_stiffness", "torsional_stiffness") else "youngs_modulus"] = 5.0
    if key == "straight":
        wire["end"] |= {"outward": [0, 0, 1], "straight": value}
    elif key in TABLES["MaterialTable"]["properties"]:
        pvc[key] = value
    else:
        if key == "slack":
            del wire["length"]
        wire[key] = value
    assert_agreed(scene, fits, validator, rf"{key} = ")


@pytest.mark.parametrize("key", ["diameter", "slack", "rise", "force", "min_bend_radius", "length"])
@pytest.mark.parametrize(("value", "fits"), [(1e-101, False), (1e-99, True), (1e99, True), (1e101, False)])
def test_numbers_that_cannot_be_computed_with(key, value, fits, validator):
    scene = tomllib.loads(pinned(head="[materials.pvc]\nbending_stiffness = 5\n", material='"pvc"'))
    (wire,) = scene["cables"]
    if key == "slack":
        del wire["length"]
    wire[key] = value
    assert_agreed(scene, fits, validator, rf"{key} = ")


@pytest.mark.parametrize(
    ("name", "fits"),
    [("W", True), ("W 1", True), ("Ä", True), (" W", False), ("W ", False), ("", False), ("a\nb", False)],
)
def test_names_of_schema_and_loader_are_one(name, fits, validator):
    scene = tomllib.loads(cable())
    scene["cables"][0]["name"] = name
    assert_agreed(scene, fits, validator, "name")


@pytest.mark.parametrize(("shape", "fits"), [(1e-9, True), (0.9e-9, False), (0, False), (5, True)])
def test_tolerance_floor_is_in_both(shape, fits, validator):
    text = LEAST + f"[tolerance]\nshape = {shape}\n"
    if fits:
        parse_scene(text)
    else:
        with pytest.raises(SceneError, match=r"tolerance\.shape"):
            parse_scene(text)
    assert validator.is_valid(tomllib.loads(text)) == fits


ON_PLATE = {"part": "plate"}


@pytest.mark.parametrize(
    ("end", "fits"),
    [
        (ON_PLATE | {"port": "J1"}, True),
        (ON_PLATE | {"port": "J1", "straight": 5}, True),
        (ON_PLATE | {"near": [0, 0, 0]}, True),
        (ON_PLATE | {"near": [0, 0, 0], "straight": 5}, True),
        (ON_PLATE | {"near": [0, 0, 0], "port": "J1"}, False),
        (ON_PLATE, False),
        ({"port": "J1"}, False),
        ({"near": [0, 0, 0]}, False),
        (ON_PLATE | {"port": "J1", "position": [0, 0, 0]}, False),
        (ON_PLATE | {"near": [0, 0, 0], "outward": [0, 0, 1]}, False),
        (ON_PLATE | {"port": "J1", "direction": [0, 0, 1]}, False),
        (ON_PLATE | {"port": "J1", "toward": [0, 0, 1]}, False),
        (END | {"part": "plate"}, False),
        (END | {"near": [0, 0, 0]}, False),
    ],
)
@pytest.mark.parametrize("place", ["start", "end"])
def test_ends_on_parts_agree_with_the_loader(place, end, fits, validator):
    scene = tomllib.loads(ported(PORT, start="{ position = [0, 0, 0] }"))
    scene["cables"][0][place] = end
    if fits:
        parse_scene(json.dumps(scene))
    else:
        with pytest.raises(SceneError):
            parse_scene(json.dumps(scene))
    assert validator.is_valid(scene) == fits
