"""From a file or a text to model objects: both syntaxes, what they hold, and how reading fails."""

from __future__ import annotations

import json
import logging
import math
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from cablecad.errors import ExchangeError, SceneError, UsageError
from cablecad.model import (
    SHAPE_TOLERANCE,
    Cable,
    Clamp,
    EquilibriumKey,
    Material,
    Part,
    Pin,
    Port,
    Rotation,
    Scene,
    Toward,
)
from cablecad.scene import load_scene, parse_scene
from cablecad.scene.starter import starter_scene

# Every key of format 1.
FULL = """
format = 1
name = "gearbox loom"

[tolerance]
shape = 0.01

[materials.pvc]
youngs_modulus = 3890
poissons_ratio = 0.25
mass_per_length = 0.02

[materials."as measured"]
bending_stiffness = 48883.0
torsional_stiffness = 39106.0

[[parts]]
name = "plate"
step = "parts/plate.step"
position = [1, 2.5, -3]
rotation = { axis = [0, 0, 2], angle_deg = 90 }

[[parts]]
name = "box"
step = "/stock/box.step"

[[cables]]
name = "W1"
diameter = 4
length = 350
material = "pvc"
color = "#2b6cb0"
start = { position = [0, 0, 0], outward = [0, 0, 1] }
end = { position = [0, 120, 0], direction = [0, 0, -1], straight = 15.0 }
min_bend_radius = 20.0
bulge = [1, 0, 0]
equilibrium = 2
allow_contact = true

[[cables]]
name = "W2"
diameter = 1.5
length = "shortest"
min_bend_radius = 30
start = { position = [0, 0, 0] }
end = { position = [9, 0, 0], outward = [1, 0, 0], straight = 0 }
equilibrium = { winding = -1, side = -1 }

[[cables]]
name = "W3"
diameter = 2
slack = 1e-12
start = { position = [0, 0, 0], direction = [0, 3, 4], straight = 1 }
end = { position = [0, 30, 40] }
equilibrium = {}

[[cables]]
name = "W4"
diameter = 4
force = 4.2
rise = 73.9
material = "as measured"
color = "#2b6cb080"
start = { position = [1, 1, 1] }
end = { toward = [0, 0, 1] }

[[cables]]
name = "W5"
diameter = 4
chord = -12
bend_radius = 30
angle_deg = 140
start = { position = [1, 1, 1] }
end = { toward = [0, 0, 1] }
"""

PVC = Material(youngs_modulus=3890.0, poissons_ratio=0.25, mass_per_length=0.02)
MEASURED = Material(bending_stiffness=48883.0, torsional_stiffness=39106.0)
EXPECTED = Scene(
    name="gearbox loom",
    tolerance=0.01,
    parts=(
        Part("plate", "parts/plate.step", (1.0, 2.5, -3.0), Rotation((0.0, 0.0, 2.0), 90.0)),
        Part("box", "/stock/box.step"),
    ),
    cables=(
        Cable(
            "W1",
            4.0,
            Port((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
            Clamp((0.0, 120.0, 0.0), (0.0, 0.0, -1.0), 15.0),
            length=350.0,
            material=PVC,
            color="#2b6cb0",
            min_bend_radius=20.0,
            bulge=(1.0, 0.0, 0.0),
            equilibrium=2,
            allow_contact=True,
        ),
        Cable(
            "W2",
            1.5,
            Pin((0.0, 0.0, 0.0)),
            Port((9.0, 0.0, 0.0), (1.0, 0.0, 0.0)),
            length="shortest",
            min_bend_radius=30.0,
            equilibrium=EquilibriumKey(-1, -1),
        ),
        Cable(
            "W3",
            2.0,
            Clamp((0.0, 0.0, 0.0), (0.0, 3.0, 4.0), 1.0),
            Pin((0.0, 30.0, 40.0)),
            slack=1e-12,
            equilibrium=EquilibriumKey(0, 1),
        ),
        Cable(
            "W4",
            4.0,
            Pin((1.0, 1.0, 1.0)),
            Toward((0.0, 0.0, 1.0)),
            force=4.2,
            rise=73.9,
            material=MEASURED,
            color="#2b6cb080",
        ),
        Cable("W5", 4.0, Pin((1.0, 1.0, 1.0)), Toward((0.0, 0.0, 1.0)), chord=-12.0, bend_radius=30.0, angle_deg=140.0),
    ),
)

LEAST = "format = 1\n[[parts]]\nname = 'plate'\nstep = 'plate.step'\n"


def text_of(error: pytest.ExceptionInfo[SceneError]) -> str:
    (mistake,) = error.value.mistakes
    assert mistake.path == ""
    return mistake.problem


def test_toml_gives_the_objects_a_python_user_would_make():
    assert parse_scene(FULL) == EXPECTED


@pytest.mark.parametrize("text", [FULL, starter_scene(), LEAST])
def test_json_with_the_same_keys_gives_the_same_scene(text):
    assert parse_scene(json.dumps(tomllib.loads(text))) == parse_scene(text)


def test_numbers_are_floats_whatever_way_they_were_written():
    cable = parse_scene(FULL).cables[0]
    numbers = [cable.diameter, cable.length, *cable.start.position, *cable.bulge]
    assert {type(number) for number in numbers} == {float}


def test_defaults():
    scene = parse_scene(LEAST)
    assert (scene.name, scene.tolerance, scene.cables) == ("scene", SHAPE_TOLERANCE, ())
    assert scene.parts == (Part("plate", "plate.step", (0.0, 0.0, 0.0), Rotation((0.0, 0.0, 1.0), 0.0)),)


@pytest.mark.parametrize("suffix", ["toml", "TOML", "json", "scene", ""])
def test_file_is_read_and_its_parts_begin_in_its_folder(tmp_path, suffix):
    path = tmp_path / f"loom.{suffix}"
    path.write_text(json.dumps(tomllib.loads(FULL)) if suffix == "json" else FULL, encoding="utf-8")
    scene = load_scene(path)
    assert scene.source == path
    assert [part.step for part in scene.parts] == [tmp_path / "parts/plate.step", Path("/stock/box.step")]
    assert scene.inputs == (path, *(part.step for part in scene.parts))
    assert load_scene(str(path)) == scene


def test_suffix_wins_over_the_looks(tmp_path):
    path = tmp_path / "loom.toml"
    path.write_text(json.dumps(tomllib.loads(LEAST)), encoding="utf-8")
    with pytest.raises(SceneError, match=re.escape(f"{path}: 1 mistake")) as caught:
        load_scene(path)
    assert text_of(caught).startswith("is not valid TOML at line 1, column 1: Invalid statement")
    assert "read as" not in text_of(caught)


def test_syntax_given_wins_over_the_suffix():
    assert parse_scene(LEAST, syntax="toml", source="loom.json").source == Path("loom.json")


def test_syntax_found_by_looks_is_told(caplog):
    with caplog.at_level(logging.INFO, logger="cablecad"):
        parse_scene(LEAST, source="loom.txt")
        parse_scene(f"\n {json.dumps(tomllib.loads(LEAST))}")
        parse_scene(LEAST, source="loom.toml")
    assert [record.getMessage().partition(",")[0] for record in caplog.records] == [
        "loom.txt; read as TOML",
        "scene; read as JSON",
    ]


def test_a_third_syntax_is_a_usage_error():
    with pytest.raises(UsageError, match="'toml' or 'json', not 'yaml'"):
        parse_scene(LEAST, syntax="yaml")


def test_byte_order_mark_and_line_ends_of_other_systems():
    scene = parse_scene(LEAST)
    assert parse_scene(b"\xef\xbb\xbf" + LEAST.replace("\n", "\r\n").encode()) == scene
    assert parse_scene("\ufeff" + json.dumps(tomllib.loads(LEAST))) == scene


def test_text_of_any_language():
    text = 'format = 1\n[[parts]]\nname = "Gehäuse 箱 🔌"\nstep = "gehäuse.step"\n'
    assert parse_scene(text.encode()).parts[0].name == "Gehäuse 箱 🔌"
    assert parse_scene(json.dumps(tomllib.loads(text))).parts[0].name == "Gehäuse 箱 🔌"  # as \u escapes


@pytest.mark.parametrize(
    ("text", "syntax", "words"),
    [
        ("", None, "is empty; `cablecad new FILE` writes a scene to begin with"),
        (" \n\t\n", "json", "is empty"),
        (b"\xff\xfef\x00o\x00", None, "is not UTF-8 text: byte 0xff in line 1; save the file"),
        (b'format = 1\nname = "caf\xe9"\n', None, "byte 0xe9 in line 2"),
        ("format = 1\nname = loom\n", "toml", "is not valid TOML at line 2, column 8: Invalid value, in 'name = loom'"),
        ("format = 1\ndiameter = 4 mm\n", "toml", "TOML at line 2, column 14: Expected newline"),
        ("format = 1\nformat = 1\n", "toml", "TOML at line 2, column 11: Cannot overwrite a value"),
        ("format = 1\nname = [1,", "toml", "is not valid TOML at line 2, column 11: "),
        (f"format = {'9' * 5000}", "toml", "is not valid TOML: Exceeds the limit (4300 digits)"),
        ('{"format": 1,}', "json", "is not valid JSON at line 1, column 1"),
        ('{"format": 1,\n "name": loom}', "json", "is not valid JSON at line 2, column 10: Expecting value"),
        ('{"format": 1} 2', "json", "is not valid JSON at line 1, column 15: Extra data"),
        ('{"format": 1', None, "; read as JSON, as it begins with a brace: the suffix .toml or .json would tell"),
        ("format: 1", None, "; read as TOML, as it does not begin with a brace: the suffix"),
        ("[1, 2]", "json", "must be a table of keys at the top"),
        ("null", "json", "must be a table of keys at the top"),
        ("[" * 100_000, "json", "is nested too deep to be read"),
        ('{"a":' * 100_000, "json", "is nested too deep to be read"),
        ("format = " + "[" * 100_000, "toml", "is nested too deep to be read"),
    ],
)
def test_what_is_no_table_is_one_clear_mistake(text, syntax, words):
    with pytest.raises(SceneError) as caught:
        parse_scene(text, syntax=syntax)
    assert words in text_of(caught)
    assert len(str(caught.value)) < 400


@pytest.mark.parametrize(("open_", "close"), [('{"a":', "}"), ("[", "]")])
def test_what_nests_as_deep_as_the_parser_reads_is_still_a_mistake(open_, close):
    text = f'{{"format": 1, "name": {open_ * 200}1{close * 200}}}'
    with pytest.raises(SceneError) as caught:
        parse_scene(text)
    assert [mistake.path for mistake in caught.value.mistakes] == ["name", "cables"]
    with pytest.raises(SceneError):
        parse_scene(f"format = 1\n{'.'.join('a' * 2000)} = 1")  # a table in a table, 2000 times, without recursion


def test_json_may_not_repeat_a_key_and_says_where():
    text = '{"format": 1, "cables": [{"name": "W1", "diameter": 4, "diameter": "5", "length": 9, "length": 9}]}'
    with pytest.raises(SceneError) as caught:
        parse_scene(text)
    found = {mistake.path: mistake for mistake in caught.value.mistakes if "more than once" in mistake.problem}
    assert set(found) == {"cables.W1.diameter", "cables.W1.length"}
    assert found["cables.W1.length"].value == 9


@pytest.mark.parametrize("number", ["NaN", "Infinity", "-Infinity", "1e400", f"-{'1' * 400}", "9" * 5000])
def test_json_numbers_that_are_not_finite_are_refused(number):
    scene = f'{{"format": 1, "tolerance": {{"shape": {number}}}, "parts": [{{"name": "a", "step": "a.step"}}]}}'
    with pytest.raises(SceneError) as caught:
        parse_scene(scene)
    (mistake,) = caught.value.mistakes
    assert mistake.path == "tolerance.shape"
    assert mistake.problem.startswith("must be a finite number")
    assert not math.isfinite(mistake.value)


def test_json_null_is_no_value():
    text = json.dumps(tomllib.loads(LEAST) | {"name": None, "tolerance": None})
    with pytest.raises(SceneError) as caught:
        parse_scene(text)
    assert [(mistake.path, mistake.value) for mistake in caught.value.mistakes] == [("name", None), ("tolerance", None)]


def test_half_a_character_is_refused_and_can_be_printed():
    text = '{"format": 1, "\\udcff": 1, "parts": [{"name": "a\\ud83d", "step": "a.step"}]}'
    with pytest.raises(SceneError) as caught:
        parse_scene(text)
    assert [mistake.path for mistake in caught.value.mistakes] == ['"\ufffd"', 'parts."a\ufffd".name']
    assert "half a character" in caught.value.mistakes[1].problem
    assert str(caught.value).encode()


def test_files_that_cannot_be_read(tmp_path, monkeypatch):
    missing = tmp_path / "missing.toml"
    with pytest.raises(ExchangeError, match=r"missing\.toml': No such file") as caught:
        load_scene(missing)
    assert caught.value.exit_code == 5
    with pytest.raises(ExchangeError, match=f"cannot read the scene file '{re.escape(str(tmp_path))}'"):
        load_scene(tmp_path)
    with pytest.raises(ExchangeError, match="null"):
        load_scene("loom\0.toml")

    def refuse(path):
        raise PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr(Path, "read_bytes", refuse)
    with pytest.raises(ExchangeError, match="Permission denied"):
        load_scene(missing)


def test_mistakes_of_a_file_name_it(tmp_path):
    path = tmp_path / "loom.toml"
    path.write_text("format = 2\n", encoding="utf-8")
    with pytest.raises(SceneError) as caught:
        load_scene(path)
    assert caught.value.source == str(path)
    assert str(caught.value).startswith(f"{path}: 2 mistakes\n  format = 2: ")


def test_reading_a_scene_loads_no_numerics_and_no_kernel():
    code = (
        "import sys; from cablecad.scene import parse_scene; from cablecad.scene.starter import starter_scene;"
        "parse_scene(starter_scene()); print({'numpy', 'scipy', 'OCP', 'rich', 'click'} & set(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"
