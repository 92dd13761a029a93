"""The starter scene: it reads as it stands, names every key there is, and what it offers in comments is right."""

from __future__ import annotations

import re
import tomllib

import pytest

from cablecad.errors import SceneError
from cablecad.model import Material, Pin
from cablecad.scene import parse_scene, scene_schema
from cablecad.scene.starter import starter_scene

OFFERS = [line[1:] for line in starter_scene().splitlines() if re.match(r"#[a-z\[]", line)]
OF_A_CABLE = OFFERS[OFFERS.index(next(line for line in OFFERS if line.startswith("bulge"))) :]


def test_it_is_a_cable_that_needs_no_file():
    scene = parse_scene(starter_scene(), syntax="toml")
    (cable,) = scene.cables
    assert scene.parts == ()
    assert cable.start == Pin((0.0, 0.0, 0.0))
    assert isinstance(cable.end, Pin)
    assert cable.length > cable.end.position[0]
    assert cable.material == Material(youngs_modulus=3890.0, poissons_ratio=0.25)


def test_it_names_every_key():
    keys = {key for table in [scene_schema(), *scene_schema()["$defs"].values()] for key in table["properties"]}
    words = set(re.findall(r"\w+", starter_scene()))
    assert keys <= words


def test_what_it_offers_above_the_cable_reads():
    lines = starter_scene().splitlines()
    header = lines.index("[[cables]]")
    offered = [line[1:] if re.match(r"#[a-z\[]", line) else line for line in lines[:header]]
    scene = parse_scene("\n".join(offered + lines[header:]))
    assert [part.name for part in scene.parts] == ["plate"]
    assert parse_scene(starter_scene()).cables[0].material != scene.cables[0].material


@pytest.mark.parametrize("offer", OF_A_CABLE)
def test_what_it_offers_for_the_cable_reads(offer):
    """Each line in place of the one it is an alternative to; toward is two data short of a cable, chord is for it."""
    key = offer.partition(" ")[0]
    instead = {"slack": "length", "force": "length", "angle_deg": "length", "rise": "length", "bend_radius": "length"}
    gone, more = {key, instead.get(key, key)}, []
    if "toward" in offer:
        more = ["rise = 73.89"]
        gone |= {"end"}
    if key == "chord":
        more = ["end = { toward = [1, 0, 0] }"]
        gone |= {"end"}
    lines = [line for line in starter_scene().splitlines() if line.partition(" ")[0] not in gone]
    (cable,) = parse_scene("\n".join([*lines, offer, *more])).cables
    assert getattr(cable, key) != getattr(parse_scene(starter_scene()).cables[0], key)


def test_toward_of_a_file_needs_its_data():
    lines = [line for line in starter_scene().splitlines() if not line.startswith("end")]
    with pytest.raises(SceneError, match="needs two data"):
        parse_scene("\n".join([*lines, "end = { toward = [1, 0, 0] }"]))


def test_it_is_plain_toml_of_a_readable_width():
    assert starter_scene().isascii()
    assert max(map(len, starter_scene().splitlines())) <= 120
    assert tomllib.loads(starter_scene())["format"] == 1
