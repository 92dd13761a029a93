"""Scenes that are refused: the exit code, the place, the value and the remedy, and that nothing is left behind."""

from __future__ import annotations

import pytest
from loom import FORMAT, PVC, TOWARD, cable, names, part, scene, write

COMMANDS = {
    "solve": ("solve",),
    "build": ("build", "-o", "out.step"),
    "strict": ("build", "--strict", "-o", "out.step"),
    "check": ("check",),
}

# What is wrong, the text, and what must be said of it.
INVALID = {
    "number in quotes": (cable(diameter='"4 mm"'), ["cables.W1.diameter = '4 mm'", "without quotes or a unit"]),
    "negative diameter": (cable(diameter="-4"), ["cables.W1.diameter = -4", "must be greater than 0"]),
    "zero diameter": (cable(diameter="0"), ["cables.W1.diameter = 0", "must be greater than 0"]),
    "nan": (cable(diameter="nan"), ["cables.W1.diameter = nan", "must be a finite number"]),
    "infinite length": (cable(length="inf"), ["cables.W1.length = inf", "must be a finite number of mm"]),
    "beyond a double": (cable(length="1e999"), ["cables.W1.length = inf", "must be a finite number of mm"]),
    "truth for a length": (cable(length="true"), ["cables.W1.length = True", "must be a finite number of mm"]),
    "no length": (cable(length=None), ["cables.W1.length", "is missing; give length, slack, force"]),
    "negative slack": (cable(length=None, slack="-0.1"), ["cables.W1.slack = -0.1", "must be greater than 0"]),
    "two coordinates": (
        cable(end="{ position = [300, 0] }"),
        ["cables.W1.end.position = [300, 0]", "must be three numbers [x, y, z]"],
    ),
    "nan in a position": (
        cable(end="{ position = [300, nan, 0] }"),
        ["cables.W1.end.position[1] = nan", "must be a finite number"],
    ),
    "angle of 180 degrees": (
        cable(length=None, angle_deg="180"),
        ["cables.W1.angle_deg = 180", "must be less than 180"],
    ),
    "colour by name": (cable(color='"red"'), ["cables.W1.color = 'red'", "must be #rrggbb or #rrggbbaa"]),
    "zero bulge": (cable(bulge="[0, 0, 0]"), ["cables.W1.bulge", "an axis must not be zero"]),
    "bulge along the chord": (cable(bulge="[-2, 0, 0]"), ["cables.W1.bulge", "parallel to the chord", "across it"]),
    "negative rule": (cable(min_bend_radius="-1"), ["cables.W1.min_bend_radius = -1", "greater than 0"]),
    "unknown key": (cable(lenght="350"), ["cables.W1.lenght = 350", "did you mean 'length'?"]),
    "unknown table": (cable() + "[tolerances]\nshape = 1\n", ["tolerances", "did you mean 'tolerance'?"]),
    "unknown material": (cable(material='"pvc"'), ["cables.W1.material = 'pvc'", "write [materials.pvc]"]),
    "force without material": (
        cable(length=None, force="5"),
        ["cables.W1.force = 5", "needs a material with a bending stiffness"],
    ),
    "third datum": (
        cable(rise="50"),
        [
            "cables.W1.rise = 50",
            "contradicts end.position = 300 mm and length = 350 mm, which give 80.369",
            "leave one",
        ],
    ),
    "chord against the positions": (
        cable(chord="301"),
        ["cables.W1.chord = 301", "300 mm apart; write that, or leave it out"],
    ),
    "two dimensionless data": (
        cable(length=None, slack="0.1", angle_deg="20", end=TOWARD),
        ["cables.W1.length", "one of them not slack or angle_deg; given: slack, angle_deg"],
    ),
    "one datum towards": (cable(end=TOWARD), ["cables.W1.length = 350", "needs two data", "given: length"]),
    "shortest without a rule": (cable(length='"shortest"'), ["cables.W1.length = 'shortest'", "needs min_bend_radius"]),
    "outward and direction": (
        cable(end="{ position = [300, 0, 0], outward = [0, 0, 1], direction = [0, 0, -1] }"),
        ["cables.W1.end.direction", "either outward or direction, and not both"],
    ),
    "toward and position": (
        cable(end="{ position = [300, 0, 0], toward = [1, 0, 0] }"),
        ["cables.W1.end.toward", "leave out toward, or leave out position"],
    ),
    "equilibrium that is not there": (cable(equilibrium="99"), ["cables.W1.equilibrium = 99", "were found"]),
    "winding that is not there": (
        cable(equilibrium="{ winding = 7, side = 1 }"),
        ["cables.W1.equilibrium", "no such equilibrium was found; the (winding, side) found are"],
    ),
    "one name twice": (cable() + cable(), ["cables[1].name = 'W1'", "names must be unique"]),
    "line break in a name": (
        cable("W\n1"),
        ["cables[0].name = 'W\\n1'", "must not contain control characters"],
    ),
    "two stiffnesses": (
        cable(material='"pvc"') + "[materials.pvc]\nyoungs_modulus = 1\nbending_stiffness = 1\n",
        ["materials.pvc", "either youngs_modulus or bending_stiffness, and not both"],
    ),
    "part without a file": (
        cable() + "[[parts]]\nname = 'plate'\n",
        ["parts.plate.step", "write the path of the STEP file"],
    ),
    "turn about nothing": (
        part(rotation="{ axis = [0, 0, 0], angle_deg = 90 }"),
        ["parts.plate.rotation.axis", "an axis must not be zero"],
    ),
    "tolerance below the floor": (
        "[tolerance]\nshape = 1e-10\n" + cable(),
        ["tolerance.shape = 1e-10", "below the floor of 1e-09 mm"],
    ),
    "nothing in it": ("name = 'empty'\n", ["cables", "a scene needs at least one cable or part"]),
}

# The same of whole texts, in which not even the format can be read.
TEXTS = {
    "no format": ("scene.toml", cable(), ["format", "write format = 1"]),
    "format of the future": ("scene.toml", "format = 2\n" + cable(), ["format = 2", "use a cablecad that reads this"]),
    "empty file": ("scene.toml", "", ["is empty; `cablecad new FILE` writes a scene to begin with"]),
    "broken TOML": ("scene.toml", FORMAT + "[[cables]\n", ["is not valid TOML at line 2", "'[[cables]'"]),
    "broken JSON": ("scene.json", '{"format": 1,', ["is not valid JSON at line 1"]),
    "TOML called JSON": ("scene.json", scene(cable()), ["is not valid JSON at line 1"]),
    "a key twice in JSON": ("scene.json", '{"format": 1, "format": 1, "parts": []}', ["format", "more than once"]),
    "Latin-1": ("scene.toml", scene(cable("K\xe4bel")).encode("latin-1"), ["is not UTF-8 text: byte 0xe4", "UTF-8"]),
    "UTF-16": ("scene.toml", scene(cable()).encode("utf-16"), ["is not UTF-8 text: byte 0xff", "save the file"]),
    "a picture": ("scene.toml", b"\x89PNG\r\n\x1a\n\0\0", ["is not UTF-8 text: byte 0x89"]),
    "a STEP file": ("scene.step", "ISO-10303-21;\nHEADER;\n", ["is not valid TOML at line 1"]),
}

TEXTS |= {name: ("scene.toml", scene(text), said) for name, (text, said) in INVALID.items()}


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def assert_refused(ended, code, said):
    assert ended.code == code, ended.err
    assert ended.err.startswith("error: ")
    assert ended.err.endswith("\n")
    assert "Traceback" not in ended.err
    for words in said:
        assert words in ended.err


@pytest.mark.parametrize("command", ["solve", "build", "check"])
@pytest.mark.parametrize(("file", "text", "said"), TEXTS.values(), ids=TEXTS)
def test_invalid_scene(cli, here, file, text, said, command):
    path = write(here / file, text)
    ended = cli(*COMMANDS[command], path, *(["--report", "out.json"] if command == "build" else []))
    assert_refused(ended, 2, [str(path), *said])
    assert ended.out == ""
    assert names(here) == [file]


def test_all_mistakes_of_all_cables_at_once(cli, here):
    texts = cable("A", rise="50"), cable("B"), cable("C", bulge="[1, 0, 0]"), cable("D", length="200")
    ended = cli("solve", write(here / "scene.toml", scene(*texts)))
    assert_refused(ended, 2, ["scene.toml: 2 mistakes\n  cables.A.rise", "\n  cables.C.bulge"])


def clamped(start, end):
    keys = ("position", "outward")
    texts = [
        "{ " + ", ".join(f"{k} = {v}" for k, v in zip(keys, values, strict=True)) + " }" for values in (start, end)
    ]
    return dict(zip(("start", "end"), texts, strict=True))


INFEASIBLE = {
    "shorter than the chord": (
        cable(length="200"),
        "infeasible",
        ["length 200 mm is 100 mm less than the distance of the ends, 300 mm", "make the cable longer"],
    ),
    "a hair shorter": (cable(length="299.9999999999"), "infeasible", ["make the cable longer"]),
    "below the Euler load": (
        PVC + cable(material='"pvc"', force="3.938", end=TOWARD),
        "infeasible",
        ["force = 3.938 N", "the Euler load 3.93843 N of this length", "give a greater force"],
    ),
    "above the Euler load of the chord": (
        PVC + cable(material='"pvc"', length=None, force="6"),
        "infeasible",
        ["force = 6 N", "the Euler load of that distance", "give a smaller force or a shorter chord"],
    ),
    "crossed kind between two positions": (
        cable(length=None, angle_deg="150"),
        "infeasible",
        ["an end angle of 150 degrees with a chord of 300 mm", "above 130.7099 degrees", "`toward` with the length"],
    ),
    "higher than any": (
        cable(rise="150", end=TOWARD),
        "infeasible",
        ["rise = 150 mm", "at most 0.4031402 of its length, here at most 141.09"],
    ),
    "tighter than the chord allows": (
        cable(length=None, bend_radius="100"),
        "infeasible",
        ["bend_radius = 100 mm"],
    ),
    "a loop beyond numbers": (
        cable(chord="-349.9", end=TOWARD),
        "infeasible",
        ["chord -349.9 mm is below -0.994 of the length 350 mm", "choose a chord nearer to zero"],
    ),
    "exactly as long, askew": (
        cable(length="300", **clamped(([0, 0, 0], [1, 0, 0.1]), ([300, 0, 0], [-1, 0, 0]))),
        "infeasible",
        ["the axis of its start is 5.71059 degrees off the line", "give it some slack or align the axis"],
    ),
    "exactly as long, with a rise": (
        cable(length="300", rise="3"),
        "infeasible",
        ["it is straight and has no rise; leave that out, or leave out the length"],
    ),
    "clamps in two planes": (
        cable(**clamped(([0, 0, 0], [0, 0, 1]), ([300, 0, 0], [0, 1, 0]))),
        "not_planar",
        ["the ends do not lie in one plane", "degrees", "turn a connector"],
    ),
}


@pytest.mark.parametrize(("text", "result", "said"), INFEASIBLE.values(), ids=INFEASIBLE)
def test_no_such_shape(cli, here, text, result, said):
    path = write(here / "scene.toml", scene(text))
    said = ["cable W1: ", *said]
    for command in ("solve", "check"):
        ended = cli(*COMMANDS[command], path)
        assert_refused(ended, 3, said)
        assert ended.out == f"W1: {result}\n"
    for command in ("build", "strict"):
        ended = cli(*COMMANDS[command], path)
        assert_refused(ended, 3, said)
        assert ended.out == ""
    assert names(here) == ["scene.toml"]


# The ends of a hairpin meet: its tube overlaps itself by its whole diameter where the ends lie upon each other.
SPOILT = {
    "thicker than it bends": (
        cable(diameter="290"),
        ["the least bend radius 143.302 mm at s = 175 mm is not more than the cable's own radius 145 mm", "thinner"],
    ),
    "thicker than it bends, contact allowed": (
        cable(diameter="290", allow_contact="true"),
        ["is not more than the cable's own radius 145 mm"],
    ),
    "crossed loop": (
        cable(angle_deg="150", end=TOWARD),
        ["self_gap: parts of the cable overlap by", "none of the equilibria found", "allow_contact = true"],
    ),
    "ends at one point": (cable(end="{ position = [0, 0, 0] }"), ["parts of the cable overlap by 4 mm"]),
}


@pytest.mark.parametrize(("text", "said"), SPOILT.values(), ids=SPOILT)
def test_tube_that_would_cut_into_itself(cli, here, text, said):
    path = write(here / "scene.toml", scene(text))
    solved = cli("solve", path)
    assert solved.code == 0
    assert solved.out.startswith("W1: solved, planar")
    assert said[0] in solved.err
    for command in ("build", "strict", "check"):
        ended = cli(*COMMANDS[command], path)
        assert ended.code == 4
        (told,) = [line for line in ended.err.splitlines() if line.startswith("error: ")]
        assert told.startswith("error: cable W1: ")
        for words in said:
            assert words in told
        assert said[0] not in ended.err.replace(told, "")  # said once
        assert ended.out == ("W1: invalid_tube\n" if command == "check" else "")
    assert names(here) == ["scene.toml"]


def test_refusal_names_the_first_equilibrium_that_does_not_touch_itself(cli, here):
    """The third mode of this cable is bent too tightly for its diameter, the first is not."""
    path = write(here / "scene.toml", scene(cable(diameter="110", equilibrium="4")))
    ended = cli(*COMMANDS["build"], path)
    assert ended.code == 4
    assert "warning: cable W1: the chosen equilibrium is unstable in its plane" in ended.err
    assert "is not more than the cable's own radius 55 mm" in ended.err
    assert "(equilibrium = 0 does not touch itself)" in ended.err
    again = write(here / "scene.toml", scene(cable(diameter="110", equilibrium="0")))
    assert cli(*COMMANDS["check"], again).code == 0


RULE = (
    "min_bend_radius: the least bend radius 143.302 mm at s = 175 mm is below the rule of 150 mm; make the cable longer"
)


@pytest.mark.parametrize(
    ("command", "code", "kind", "out", "left"),
    [
        ("solve", 0, "warning", "W1: solved", []),
        ("build", 0, "warning", "out.step\n", ["out.step"]),
        ("strict", 4, "error", "", []),
        ("check", 4, "error", "W1: broken rules, deviation", []),
    ],
)
def test_broken_rule(cli, here, command, code, kind, out, left):
    path = write(here / "scene.toml", scene(cable(min_bend_radius="150")))
    ended = cli(*COMMANDS[command], path)
    assert ended.code == code
    assert ended.err.startswith(f"{kind}: cable W1: {RULE}")
    assert ended.err.count("\n") == 1
    assert ended.out.startswith(out)
    assert names(here) == [*left, "scene.toml"]


def test_rule_that_is_kept_is_not_mentioned(cli, here):
    path = write(here / "scene.toml", scene(cable(min_bend_radius="143")))
    for command, code in (("build", 0), ("strict", 0), ("check", 0)):
        ended = cli(*COMMANDS[command], path)
        assert (ended.code, ended.err) == (code, "")


# --- tolerances ------------------------------------------------------------------------------------------------------


FAR = cable(start="{ position = [1e9, 0, 0] }", end="{ position = [1000000300.0, 0, 0] }")
"""At 1e9 mm the doubles are 1.2e-7 mm apart, and no tolerance below 2e-14 of it can be kept: 2e-5 mm."""


@pytest.mark.parametrize("command", ["build", "check"])
def test_tolerance_that_cannot_be_kept_so_far_out(cli, here, command):
    path = write(here / "scene.toml", scene(FAR, cable("near"), head="[tolerance]\nshape = 1e-6\n"))
    assert cli("solve", path).code == 0
    ended = cli(*COMMANDS[command], path, *(["--report", "out.json"] if command == "build" else []))
    assert_refused(ended, 2, [f"{path}: 1 mistake\n  tolerance.shape = 1e-06: is below 2e-05 mm", "for cable W1"])
    assert names(here) == ["scene.toml"]


def test_tolerance_that_can_be_kept_so_far_out(cli, here):
    path = write(here / "scene.toml", scene(FAR, head="[tolerance]\nshape = 1e-4\n"))
    assert cli(*COMMANDS["check"], path).code == 0


@pytest.mark.parametrize(
    ("value", "said"),
    [
        ("0", "must be greater than 0"),
        ("-1", "must be greater than 0"),
        ("1e-10", "below the floor of 1e-09 mm"),
        ("nan", "must be a finite number"),
        ("inf", "must be a finite number"),
    ],
)
def test_tolerance_on_the_command_line(cli, here, value, said):
    path = write(here / "scene.toml", scene(cable()))
    assert_refused(cli(*COMMANDS["build"], path, "--tolerance", value), 2, ["tolerance", value.lstrip("-"), said])
    assert names(here) == ["scene.toml"]


def test_tolerance_above_what_a_tube_can_bear_is_lowered(cli, here):
    path = write(here / "scene.toml", scene(cable(), head="[tolerance]\nshape = 0.5\n"))
    ended = cli(*COMMANDS["build"], path)
    assert (ended.code, ended.out) == (0, "out.step\n")
    assert "warning: cable W1: tolerance 0.5 mm was lowered to 0.1 mm, a twentieth of the cable's radius" in ended.err


@pytest.mark.parametrize(
    ("diameter", "far", "said"),
    [
        ("1.9e-6", "0", "cables.W1.diameter = 1.9e-06: is too small for a solid"),
        ("0.002", "1e10", "cables.W1.diameter = 0.002: is too small at its place: a solid may be off by 5e-05 mm"),
    ],
)
def test_a_cable_too_thin_for_a_solid(cli, here, diameter, far, said):
    ends = {end: f"{{ position = [{far}, {y}, 0], outward = [0, 0, 1] }}" for end, y in (("start", 0), ("end", 120))}
    path = write(here / "scene.toml", scene(cable(diameter=diameter, **ends)))
    assert cli("solve", path).code == 0
    assert_refused(cli(*COMMANDS["build"], path), 2, [said])
    assert names(here) == ["scene.toml"]


@pytest.mark.parametrize("end", ["start", "end"])
@pytest.mark.parametrize(("straight", "good"), [("5e-8", False), ("1e-9", False), ("1e-6", True), ("0", True)])
def test_a_straight_too_short_for_a_solid(cli, here, end, straight, good):
    y = {"start": 0, "end": 120}[end]
    port = f"{{ position = [0, {y}, 0], outward = [0, 0, 1], straight = {straight} }}"
    path = write(here / "scene.toml", scene(cable(**{end: port})))
    assert cli("solve", path).code == 0
    if good:
        assert cli(*COMMANDS["build"], path).code == 0
        return
    said = f"cables.W1.{end}.straight = {float(straight)!r}: is too short for a solid"
    assert_refused(cli(*COMMANDS["build"], path), 2, [said, "leave it out"])


# --- several failures at once ----------------------------------------------------------------------------------------

CONTRADICTING = cable("odd", rise="50")
NO_FILE = part(step="missing.step")
SHORT = cable("short", length="200")
LOOP = cable("loop", angle_deg="150", end=TOWARD)
TIGHT = cable("tight", min_bend_radius="150")


@pytest.mark.parametrize(
    ("tables", "solve", "build", "said"),
    [
        ((CONTRADICTING, NO_FILE, SHORT, LOOP), 2, 2, ["cables.odd.rise"]),
        ((NO_FILE, SHORT, LOOP, TIGHT), 3, 5, ["part plate: ", "missing.step", "cable short: ", "cable loop: "]),
        ((SHORT, LOOP, TIGHT), 3, 3, ["cable short: ", "cable loop: "]),
        ((LOOP, NO_FILE), 0, 5, ["part plate: ", "cable loop: "]),
        ((LOOP, TIGHT), 0, 4, ["cable loop: "]),
    ],
    ids=["2 before all", "5 before 3", "3 before 4", "5 before 4", "4"],
)
def test_several_failures_at_once_are_all_told_and_the_first_claim_is_the_code(cli, here, tables, solve, build, said):
    path = write(here / "scene.toml", scene(*tables))
    assert cli("solve", path).code == solve
    for command in ("build", "strict", "check"):
        ended = cli(*COMMANDS[command], path)
        assert ended.code == build
        for words in said:
            assert words in ended.err
    assert names(here) == ["scene.toml"]


def test_a_late_mistake_does_not_hide_what_else_is_wrong(cli, here):
    """Found only when its cable is solved, or built."""
    for late in (cable("B", equilibrium=77), cable("B", diameter="1e-7")):
        path = write(here / "scene.toml", scene(cable("A", length="200"), late))
        ended = cli("build", path, "-o", "out.step")
        assert ended.code == 2
        assert "cables.B" in ended.err
        assert "cable A: length 200 mm is 100 mm less than the distance" in ended.err


@pytest.mark.parametrize(
    ("keys", "place"),
    [
        ({"diameter": "1e-99", "material": '"pvc"'}, "diameter"),
        ({"diameter": "1e99", "material": '"pvc"'}, "diameter"),
    ],
)
def test_stiffness_beyond_numbers(cli, here, keys, place):
    ended = cli("solve", write(here / "scene.toml", scene(PVC, cable(**keys))), "--json")
    assert ended.code == 2
    assert f"cables.W1.{place}" in ended.err
    assert "bending stiffness" in ended.err


@pytest.mark.parametrize("value", ["youngs_modulus = 1e308", "youngs_modulus = 10.0\nmass_per_length = 1e308"])
def test_material_beyond_numbers(cli, here, value):
    text = scene(f"[materials.pvc]\n{value}\n", cable(material='"pvc"'))
    ended = cli("solve", write(here / "scene.toml", text), "--json")
    assert ended.code == 2
    assert "which can be computed with" in ended.err
