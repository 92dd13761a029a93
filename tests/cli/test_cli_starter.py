"""`cablecad new` and `cablecad schema`: what a user begins with."""

from __future__ import annotations

import json
import re
import tomllib
from pathlib import Path

import jsonschema
import pytest
from loom import FORMAT, cable, names, write

SAMPLES = sorted((Path(__file__).parents[2] / "samples").glob("*.toml"))


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_new_scene_solves_builds_and_checks(cli, here):
    ended = cli("new", "loom.toml")
    assert (ended.code, ended.out, ended.err) == (0, "loom.toml\n", "")
    assert cli("solve", "loom.toml").out.startswith("W1: solved, planar (inflexional), length 350 mm, chord 308.42 mm")
    assert (cli("build", "loom.toml").out, cli("check", "loom.toml").code) == ("loom.step\n", 0)
    assert names(here) == ["loom.step", "loom.toml"]


def test_what_the_new_scene_says_of_itself_holds(cli, here):
    """The numbers it offers in its comments, to the digits they have."""
    cli("new", "loom.toml")
    text = (here / "loom.toml").read_text()
    (one,) = json.loads(cli("solve", "loom.toml", "--json").out)["cables"]
    found = {
        **one,
        "angle_deg": one["end_angle_deg"],
        "force": one["start"]["force"][0],
        "bend_radius": one["bend_radius_min"],
    }
    for key in ("slack", "force", "angle_deg", "rise", "bend_radius"):
        (offered,) = re.findall(rf"^#{key} = (\S+)", text, re.MULTILINE)
        assert f"{found[key]:.{len(offered.partition('.')[2])}f}" == offered


def test_new_scene_never_replaces_a_file_unasked(cli, here):
    write(here / "loom.toml", "mine")
    ended = cli("new", "loom.toml")
    assert (ended.code, ended.out) == (2, "")
    assert ended.err == "error: loom.toml exists; choose another name, or --force to replace it\n"
    assert (here / "loom.toml").read_text() == "mine"
    assert cli("new", "loom.toml", "--force").code == 0
    assert tomllib.loads((here / "loom.toml").read_text())["format"] == 1
    assert names(here) == ["loom.toml"]


@pytest.mark.parametrize(
    ("path", "code", "said"),
    [
        ("loom", 2, "give a name that ends in .toml"),
        ("loom.json", 2, "the starter scene is TOML; give a name that ends in .toml"),
        ("", 2, "give a name that ends in .toml"),
        ("no/loom.toml", 5, "its folder does not exist; create it"),
        ("folder.toml", 5, "it is a folder; give the name of a file"),
        ("n" * 300 + ".toml", 5, "its name is too long"),
    ],
)
def test_new_scene_that_cannot_be_written(cli, here, path, code, said):
    (here / "folder.toml").mkdir()
    ended = cli("new", path, *(["--force"] if path == "folder.toml" else []))
    assert (ended.code, ended.out) == (code, "")
    assert said in ended.err
    assert names(here) == ["folder.toml"]


def test_schema_is_one_and_accepts_what_the_commands_accept(cli):
    ended = cli("schema")
    assert (ended.code, ended.err) == (0, "")
    schema = json.loads(ended.out)
    jsonschema.Draft202012Validator.check_schema(schema)
    validator = jsonschema.Draft202012Validator(schema)
    cli("new", "loom.toml")
    for path in [*SAMPLES, Path("loom.toml")]:
        validator.validate(tomllib.loads(path.read_text(encoding="utf-8")))
    assert len(SAMPLES) >= 4


@pytest.mark.parametrize(
    "wrong",
    [cable(lenght="3"), cable(diameter="-4"), cable(color='"red"'), cable(end="{ position = [1] }"), "cables = []\n"],
)
def test_schema_refuses_what_the_commands_refuse(cli, here, wrong):
    schema = json.loads(cli("schema").out)
    text = FORMAT + wrong
    assert not jsonschema.Draft202012Validator(schema).is_valid(tomllib.loads(text))
    assert cli("solve", write(here / "loom.toml", text)).code == 2
