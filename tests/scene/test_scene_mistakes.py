"""Bad scenes: each row gives every mistake that must be reported, by path and words, and so which must not."""

from __future__ import annotations

import json

import pytest
from bad_ports import PORTS
from scene_text import PVC, cable, material, part, pinned, ported

from cablecad.errors import SceneError
from cablecad.scene import parse_scene


def mistakes_of(text: str) -> dict[str, list[str]]:
    """The mistakes as they are printed, by path."""
    with pytest.raises(SceneError) as caught:
        parse_scene(text, syntax="toml")
    found: dict[str, list[str]] = {}
    for mistake in caught.value.mistakes:
        found.setdefault(mistake.path, []).append(str(mistake))
    return found


TYPES = {
    "text for a number": (cable(diameter='"4"'), {"cables.W1.diameter": "= '4': must be a number without quotes"}),
    "text with a unit": (cable(diameter='"4mm"'), {"cables.W1.diameter": "a unit, such as 4.0"}),
    "truth for a number": (cable(diameter="true"), {"cables.W1.diameter": "= True: must be a number"}),
    "a date for a number": (cable(diameter="2020-01-01"), {"cables.W1.diameter": "must be a number"}),
    "nan": (cable(diameter="nan"), {"cables.W1.diameter": "= nan: must be a finite number"}),
    "infinity": (cable(min_bend_radius="inf"), {"cables.W1.min_bend_radius": "must be a finite number"}),
    "beyond a double": (cable(diameter="1e400"), {"cables.W1.diameter": "must be a finite number"}),
    "a whole number beyond a double": (
        cable(diameter="1" + "0" * 400, bulge=f"[0, -{'9' * 330}, 1]"),
        {"cables.W1.diameter": "= inf: must be a finite number", "cables.W1.bulge[1]": "= -inf: must be a finite"},
    ),
    "a whole number no decimal can show": (
        cable(diameter="0x" + "f" * 6000),
        {"cables.W1.diameter": "must be a finite number"},
    ),
    "length in words": (cable(length='"long"'), {"cables.W1.length": 'a finite number of mm, or "shortest"'}),
    "length infinite": (cable(length="inf"), {"cables.W1.length": 'a finite number of mm, or "shortest"'}),
    "length true": (cable(length="true"), {"cables.W1.length": 'a finite number of mm, or "shortest"'}),
    "a number for a text": (cable(color="255"), {"cables.W1.color": "must be a text in quotes, such as"}),
    "a number for truth": (cable(allow_contact="1"), {"cables.W1.allow_contact": "must be true or false"}),
    "text for truth": (cable(allow_contact='"true"'), {"cables.W1.allow_contact": "must be true or false"}),
    "two numbers for three": (
        cable(start="{ position = [0, 0], outward = [0, 0, 1] }"),
        {"cables.W1.start.position": "= [0, 0]: must be three numbers [x, y, z], such as [0, 0, 0]"},
    ),
    "four numbers for three": (cable(bulge="[1, 2, 3, 4]"), {"cables.W1.bulge": "must be three numbers"}),
    "a number for three": (cable(bulge="1"), {"cables.W1.bulge": "must be three numbers"}),
    "a table for three": (cable(bulge="{ x = 1, y = 0, z = 0 }"), {"cables.W1.bulge": "must be three numbers"}),
    "text among three": (
        cable(end='{ position = [0, "120", nan], outward = [0, 0, 1] }'),
        {
            "cables.W1.end.position[1]": "= '120': must be a number",
            "cables.W1.end.position[2]": "must be a finite number",
        },
    ),
    "an array for an end": (
        cable(end="[0, 120, 0]"),
        {"cables.W1.end": "must be a table, such as { position = [0, 120, 0], outward = [0, 0, 1] }"},
    ),
    "half an equilibrium": (cable(equilibrium="0.5"), {"cables.W1.equilibrium": "an index such as 0, or a table {"}),
    "equilibrium 1.0": (cable(equilibrium="1.0"), {"cables.W1.equilibrium": "an index such as 0, or a table {"}),
    "winding and side": (
        cable(equilibrium="{ winding = 0.5, side = 2 }"),
        {"cables.W1.equilibrium.winding": "must be a whole number", "cables.W1.equilibrium.side": "must be 1 or -1"},
    ),
    "tolerance is no table": (
        cable(head="tolerance = 0.001"),
        {"tolerance": "= 0.001: must be a table, such as { shape = 0.001 }"},
    ),
    "materials in an array": (
        cable(head='[[materials]]\nname = "pvc"', material='"pvc"'),
        {"materials": "must be a table, such as { pvc = { youngs_modulus = 3890.0"},
    ),
    "a material without a name": (
        cable(head="[materials]\nyoungs_modulus = 3890.0", material='"pvc"'),
        {
            "materials.youngs_modulus": "must be a table, such as { youngs_modulus = 3890.0",
            "cables.W1.material": "no such material",
        },
    ),
    "one cable in an array": (
        "format = 1\ncables = [5]",
        {"cables[0]": "= 5: must be an array of tables: in TOML each begins with [[cables]]"},
    ),
    "[cables], and its own mistakes": (
        cable(diameter='"4"').replace("[[cables]]", "[cables]"),
        {"cables": "in TOML each begins with [[cables]], in JSON", "cables.W1.diameter": "must be a number"},
    ),
    "[cables.W1]": (
        "format = 1\n[cables.W1]\ndiameter = 4.0",
        {"cables": "in TOML each begins with [[cables]]"},
    ),
    "[parts]": (
        'format = 1\n[parts]\nname = "plate"\nstep = "plate.step"',
        {"parts": "in TOML each begins with [[parts]], in JSON"},
    ),
}

KEYS = {
    "a slip": (cable(length=None, lenght="350"), {"cables.W1.lenght": "unknown key 'lenght'; did you mean 'length'?"}),
    "another spelling": (
        cable(color=None, colour='"#ff0000"'),
        {"cables.W1.colour": "unknown key 'colour'; did you mean 'color'?"},
    ),
    "another case": (
        cable(**{"min-Bend-Radius": "20"}),
        {"cables.W1.min-Bend-Radius": "did you mean 'min_bend_radius'?"},
    ),
    "nothing near": (
        cable(xyz="1"),
        {"cables.W1.xyz": "unknown key 'xyz'; known: name, diameter, length, slack, chord"},
    ),
    "near at its place only": (
        cable(start="{ position = [0, 0, 0], outwards = [0, 0, 1] }"),
        {"cables.W1.start.outwards": "unknown key 'outwards'; did you mean 'outward'?"},
    ),
    "toward at the start": (
        cable(start="{ position = [0, 0, 0], toward = [0, 0, 1] }"),
        {"cables.W1.start.toward": "unknown key 'toward'; did you mean 'outward'? (toward is a key of end)"},
    ),
    "of the cable, in its end": (
        cable(length=None, end="{ position = [0, 120, 0], outward = [0, 0, 1], length = 350 }"),
        {"cables.W1.end.length": "(length is a key of [[cables]])"},
    ),
    "format below a header": (
        cable(head="[tolerance]").replace("format = 1\n", "").replace("[tolerance]", "[tolerance]\nformat = 1"),
        {"tolerance.format": "(format is a key of the top of the file)"},
    ),
    "[[cable]]": (
        cable().replace("[[cables]]", "[[cable]]"),
        {"cable": "unknown key 'cable'; did you mean 'cables'?"},
    ),
    "of a later version": (
        part('name = "plate"\nstep = "plate.step"\ndensity = 1.2'),
        {"parts.plate.density": "unknown key 'density'; known: name, step, position, rotation, ports"},
    ),
    "of a port": (
        ported('name = "J1"\nposition = [0, 0, 0]\ndirection = [0, 0, 1]'),
        {"parts.plate.ports[0].direction": "unknown key 'direction'; known: name, position, outward (direction is a"},
    ),
    "of a material": (
        material("youngs_modulus = 3890\ndensity = 1.3"),
        {"materials.pvc.density": "unknown key 'density'; known: youngs_modulus, poissons_ratio"},
    ),
    "of a rotation": (
        part('name = "plate"\nstep = "plate.step"\nrotation = { axis = [0, 0, 1], angle = 90 }'),
        {"parts.plate.rotation.angle": "did you mean 'angle_deg'?"},
    ),
    "odd characters in keys": (
        cable(**{'"a b"': "1", '"\\u0007"': "2"}),
        {'cables.W1."a b"': "unknown key 'a b'", 'cables.W1."\\u0007"': "unknown key '\\x07'"},
    ),
}

MISSING = {
    "format": (cable().replace("format = 1\n", ""), {"format": "is missing; write format = 1 at the top"}),
    "format in quotes": (cable().replace("= 1\n", '= "1"\n', 1), {"format": "must be a whole number, such as 1"}),
    "format of the future": (
        cable().replace("= 1\n", "= 2\n", 1),
        {"format": "= 2: is not known here: write format = 1"},
    ),
    "format 1.0": (cable().replace("= 1\n", "= 1.0\n", 1), {"format": "must be a whole number, such as 1"}),
    "any cable or part": ("format = 1\n", {"cables": "at least one cable or part"}),
    "all of a cable": (
        "format = 1\n[[cables]]\n",
        {f"cables[0].{key}": "is missing" for key in ("name", "diameter", "start", "end", "length")},
    ),
    "all of a part": (part(""), {"parts[0].name": "is missing", "parts[0].step": "is missing; write the path"}),
    "length": (cable(length=None), {"cables.W1.length": 'is missing; give length, slack or length = "shortest"'}),
    "length, pinned": (
        pinned(length=None, chord="100"),
        {"cables.W1.length": "is missing; give length, slack, force, angle_deg, rise or bend_radius"},
    ),
    "length, one end unknown": (
        cable(length=None, start=None, end="{ position = [0, 0, 9] }"),
        {"cables.W1.start": "is missing", "cables.W1.length": "is missing; give length or slack"},
    ),
    "the second datum": (
        pinned(end="{ toward = [0, 0, 1] }", length="350"),
        {"cables.W1.length": "needs two data of length (or slack), chord, force"},
    ),
    "a datum with a scale": (
        pinned(end="{ toward = [0, 0, 1] }", length=None, slack="0.1", angle_deg="40"),
        {"cables.W1.length": "one of them not slack or angle_deg; given: slack, angle_deg"},
    ),
    "position of the start": (
        cable(start="{ outward = [0, 0, 1] }"),
        {"cables.W1.start.position": "is missing; write position = [x, y, z]"},
    ),
    "position of the end": (cable(end="{}"), {"cables.W1.end.position": "or toward = [x, y, z]"}),
    "material for a force": (pinned(force="4.2"), {"cables.W1.force": "= 4.2: needs a material"}),
    "rule for shortest": (cable(length='"shortest"'), {"cables.W1.length": "needs min_bend_radius"}),
    "half a rotation": (
        part('name = "plate"\nstep = "plate.step"\nrotation = { axis = [0, 0, 1] }'),
        {"parts.plate.rotation.angle_deg": "is missing; write the angle"},
    ),
    "modulus": (material("mass_per_length = 0.02"), {"materials.pvc": "needs youngs_modulus [MPa], or bending_stiff"}),
}

VALUES = {
    "diameter 0": (cable(diameter="0"), {"cables.W1.diameter": "must be greater than 0"}),
    "length below 0": (cable(length="-350"), {"cables.W1.length": "= -350.0: must be greater than 0"}),
    "slack 0": (cable(length=None, slack="0"), {"cables.W1.slack": "must be greater than 0"}),
    "angle 180": (pinned(length=None, angle_deg="180"), {"cables.W1.angle_deg": "must be less than 180"}),
    "straight below 0": (
        cable(end="{ position = [0, 120, 0], outward = [0, 0, 1], straight = -1 }"),
        {"cables.W1.end.straight": "must be 0 or more"},
    ),
    "straight without an axis": (
        pinned(end="{ position = [0, 120, 0], straight = 5 }"),
        {"cables.W1.end.straight": "needs an axis to run along: give outward or direction"},
    ),
    "a zero axis": (
        cable(start="{ position = [0, 0, 0], direction = [0, 0, 0] }"),
        {"cables.W1.start.direction": "an axis must not be zero"},
    ),
    "a zero bulge": (cable(bulge="[0, 0, 0]"), {"cables.W1.bulge": "an axis must not be zero"}),
    "a colour's name": (cable(color='"red"'), {"cables.W1.color": "= 'red': must be #rrggbb or #rrggbbaa"}),
    "equilibrium -1": (cable(equilibrium="-1"), {"cables.W1.equilibrium": "an index of 0 or more"}),
    "a blank name": (cable(name='" "'), {"cables[0].name": "must be a text that is not empty"}),
    "two lines of a name": (cable(name='"a\\nb"'), {"cables[0].name": "control characters"}),
    "poissons_ratio 0.6": (
        material("youngs_modulus = 3890\npoissons_ratio = 0.6"),
        {"materials.pvc.poissons_ratio": "= 0.6: must be 0.5 or less"},
    ),
    "youngs_modulus 0": (material("youngs_modulus = 0"), {"materials.pvc.youngs_modulus": "greater than 0"}),
    "tolerance below the floor": (
        cable(head="[tolerance]\nshape = 1e-10"),
        {"tolerance.shape": "= 1e-10: is below the floor of 1e-09 mm"},
    ),
    "tolerance 0": (cable(head="[tolerance]\nshape = 0"), {"tolerance.shape": "must be greater than 0"}),
    "an empty step": (part('name = "plate"\nstep = ""'), {"parts.plate.step": "must be the path of a STEP file"}),
    "a null in step": (part('name = "p"\nstep = "a\\u0000"'), {"parts.p.step": "must be the path of a STEP file"}),
}

TOGETHER = {
    "outward and direction": (
        cable(end="{ position = [0, 120, 0], outward = [0, 0, 1], direction = [0, 0, -1] }"),
        {"cables.W1.end.direction": "= [0.0, 0.0, -1.0]: give either outward or direction, and not both"},
    ),
    "position and toward": (
        pinned(end="{ position = [0, 120, 0], toward = [0, 1, 0] }"),
        {"cables.W1.end.toward": "goes with no other key: leave out toward, or leave out position"},
    ),
    "toward with an axis": (
        pinned(end="{ toward = [0, 1, 0], outward = [0, 0, 1], straight = 5 }"),
        {"cables.W1.end.toward": "leave out toward, or leave out outward and straight"},
    ),
    "toward from a clamp": (
        cable(end="{ toward = [0, 0, 1] }"),
        {"cables.W1.end.toward": "needs a start that is pinned"},
    ),
    "shortest toward": (
        pinned(end="{ toward = [0, 0, 1] }", length='"shortest"', min_bend_radius="20"),
        {"cables.W1.length": '"shortest" needs an end with a position'},
    ),
    "length and slack": (cable(slack="0.1"), {"cables.W1.slack": "give either length or slack, and not both"}),
    "shortest and slack": (
        cable(length='"shortest"', min_bend_radius="20", slack="0.1"),
        {"cables.W1.slack": 'goes against length = "shortest"'},
    ),
    "data of a pinned cable on a clamped one": (
        cable(head=PVC, material='"pvc"', rise="30", force="3", chord="120"),
        {f"cables.W1.{key}": "is for a cable pinned at both ends" for key in ("rise", "force", "chord")},
    ),
    "unknown material": (
        cable(head=PVC, material='"pcv"'),
        {"cables.W1.material": "= 'pcv': no such material; did you mean 'pvc'?"},
    ),
    "unknown material, nothing near": (
        cable(head=PVC, material='"steel"'),
        {"cables.W1.material": "no such material; the file has pvc"},
    ),
    "no materials": (
        cable(material='"pvc"'),
        {"cables.W1.material": "the file has none: write [materials.pvc]"},
    ),
    "two moduli": (
        material("youngs_modulus = 3890\nbending_stiffness = 48883"),
        {"materials.pvc": "give either youngs_modulus or bending_stiffness, and not both"},
    ),
    "ratio and torsional stiffness": (
        material("youngs_modulus = 3890\npoissons_ratio = 0.2\ntorsional_stiffness = 39106"),
        {"materials.pvc.poissons_ratio": "either poissons_ratio or torsional_stiffness"},
    ),
    "ratio without modulus": (
        material("bending_stiffness = 48883\npoissons_ratio = 0.2"),
        {"materials.pvc.poissons_ratio": "needs youngs_modulus; or give torsional_stiffness"},
    ),
    "one name twice": (
        cable() + cable().partition("\n")[2],
        {"cables[1].name": "= 'W1': is also the name of cables[0]; names must be unique"},
    ),
    "a part's name on a cable": (
        cable(head='[[parts]]\nname = "W1"\nstep = "a.step"'),
        {"cables[0].name": "is also the name of parts[0]"},
    ),
}

# A mistake hides no other one of the same cable, and draws no other one after it.
SEVERAL = {
    "five in one cable": (
        cable(
            diameter='"4mm"',
            length=None,
            material='"pvd"',
            color='"red"',
            end="{ position = [0, 120, 0], outward = [0, 0, 1], direction = [0, 0, 1] }",
            head=PVC,
        ),
        {
            "cables.W1.diameter": "must be a number",
            "cables.W1.length": "is missing",
            "cables.W1.material": "did you mean 'pvc'?",
            "cables.W1.color": "#rrggbb",
            "cables.W1.end.direction": "not both",
        },
    ),
    "five in five places": (
        "format = 3\n[tolerance]\nshape = -1\n[materials.pvc]\nyoungs_modulus = true\n"
        '[[parts]]\nname = "plate"\n[[cables]]\nname = "plate"\ncolour = "red"\ndiameter = 4\nslack = 0.1\n'
        'material = "pvc"\nstart = { position = [0, 0] }\nend = { position = [0, 0, 1], outward = [1, 0, 0] }',
        {
            "format": "write format = 1",
            "tolerance.shape": "greater than 0",
            "materials.pvc.youngs_modulus": "must be a number",
            "parts.plate.step": "is missing",
            "cables.plate.start.position": "three numbers",
            "cables.plate.colour": "did you mean 'color'?",
            "cables[0].name": "is also the name of parts[0]",
        },
    ),
    "an unreadable start is not missing, and still has an axis": (
        cable(start='{ position = "here", outward = [0, 0, 1] }', length=None, rise="3"),
        {
            "cables.W1.start.position": "three numbers",
            "cables.W1.rise": "is for a cable pinned at both ends",
            "cables.W1.length": "is missing",
        },
    ),
    "an unreadable axis is an axis": (
        cable(start='{ position = [0, 0, 0], direction = "up", straight = 5 }', length=None),
        {"cables.W1.start.direction": "three numbers", "cables.W1.length": 'slack or length = "shortest"'},
    ),
    "two axes, one of them unreadable": (
        cable(end="{ position = [0, 120, 0], outward = [0, 0, 1], direction = true }"),
        {"cables.W1.end.direction": ("must be three numbers", "either outward or direction, and not both")},
    ),
    "an unreadable toward is one": (
        pinned(end="{ toward = [0, 1] }", length="350"),
        {"cables.W1.end.toward": "three numbers", "cables.W1.length": "needs two data"},
    ),
    "an unreadable length is a length": (
        cable(length='"35O"', slack="0.1"),
        {"cables.W1.length": "a finite number of mm", "cables.W1.slack": "either length or slack"},
    ),
    "an unreadable datum is a datum": (
        pinned(end="{ toward = [0, 0, 1] }", rise='"73"'),
        {"cables.W1.rise": "must be a number"},
    ),
    "an unreadable rule is a rule": (
        cable(length='"shortest"', min_bend_radius='"20 mm"'),
        {"cables.W1.min_bend_radius": "must be a number"},
    ),
    "a mistaken material is a material": (
        pinned(head="[materials.pvc]\nyoungs_modulus = -1\n", material='"pvc"', force="3"),
        {"materials.pvc.youngs_modulus": "greater than 0"},
    ),
    "an unreadable modulus is a modulus": (
        material('youngs_modulus = "3.89 GPa"\npoissons_ratio = 0.9'),
        {"materials.pvc.youngs_modulus": "must be a number", "materials.pvc.poissons_ratio": "0.5 or less"},
    ),
    "a cable that is none keeps the others' places": (
        'format = 1\ncables = [5, { name = "W1" }, { diameter = 0 }]',
        {
            "cables[0]": "array of tables",
            **{f"cables.W1.{key}": "is missing" for key in ("diameter", "start", "end", "length")},
            "cables[2].diameter": "greater than 0",
            **{f"cables[2].{key}": "is missing" for key in ("name", "start", "end", "length")},
        },
    ),
    "names that cannot be read are not the same": (
        "format = 1\nparts = [{ name = 1, step = 'a.step' }, { name = 1, step = 'b.step' }]",
        {"parts[0].name": "text in quotes", "parts[1].name": "text in quotes"},
    ),
    "cables with one name go by their index": (
        cable(diameter='"4"') + cable(length="0").partition("\n")[2],
        {
            "cables[0].diameter": "must be a number",
            "cables[1].length": "greater than 0",
            "cables[1].name": "is also the name of cables[0]",
        },
    ),
}

BAD = {
    f"{group}: {name}": row
    for group, rows in {
        "type": TYPES,
        "key": KEYS,
        "port": PORTS,
        "missing": MISSING,
        "value": VALUES,
        "together": TOGETHER,
        "several": SEVERAL,
    }.items()
    for name, row in rows.items()
}


@pytest.mark.parametrize(("text", "expected"), BAD.values(), ids=BAD)
def test_bad_scene_reports_all_its_mistakes_and_no_others(text, expected):
    found = mistakes_of(text)
    assert set(found) == set(expected)
    for path, words in expected.items():
        lines = (words,) if isinstance(words, str) else words
        assert len(found[path]) == len(lines)
        for printed, line in zip(found[path], lines, strict=True):
            assert printed.startswith(path)
            assert line in printed


@pytest.mark.parametrize("text", [cable(), pinned(), pinned(end="{ toward = [0, 0, 1] }", rise="73")])
def test_the_rows_differ_from_good_scenes(text):
    assert parse_scene(text).cables[0].name == "W1"


def test_one_error_tells_the_file_and_all_mistakes():
    with pytest.raises(SceneError, match=r"^loom\.toml: 2 mistakes\n  cables\.W1\.dia.*\n  cables\.W1\.len") as caught:
        parse_scene(cable(diameter='"4"', length="0"), source="loom.toml")
    assert caught.value.exit_code == 2


def test_mistake_carries_the_value_as_written():
    with pytest.raises(SceneError) as caught:
        parse_scene(cable(diameter='"4mm"'))
    (mistake,) = caught.value.mistakes
    assert mistake.value == "4mm"


def test_mistakes_come_in_the_order_scene_materials_parts_cables():
    text = SEVERAL["five in five places"][0]
    heads = [path.partition(".")[0].partition("[")[0] for path in mistakes_of(text)]
    rest = [head for head in heads if head in ("materials", "parts")]
    assert heads[0] == "format"
    assert rest == ["materials", "parts"]
    assert heads[-1] == "cables"


@pytest.mark.parametrize(
    ("name", "shown"),
    [
        ("W1", "W1"),
        ("main loom", '"main loom"'),
        ("a.b", '"a.b"'),
        ("Käbel", '"Käbel"'),
        ('say "so"', '"say \\"so\\""'),
        ("x" * 200, f'"{"x" * 61}..."'),
        ("no\u00a0break", "[0]"),  # looks like another name than it is: told by its index
    ],
)
def test_odd_names_are_quoted_in_paths(name, shown):
    found = mistakes_of(cable(name=json.dumps(name), diameter="0"))
    head = "cables" if shown.startswith("[") else "cables."
    assert set(found) == {f"{head}{shown}.diameter"}
