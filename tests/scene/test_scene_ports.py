"""Ends on parts: read from a file, checked in Python, turned into numbers without the kernel, and written again."""

from __future__ import annotations

import dataclasses
import json
import math
import subprocess
import sys
import tomllib

import numpy as np
import pytest
from scene_text import PORT, ported

from cablecad.errors import SceneError
from cablecad.model import Cable, NamedPort, Part, PartPort, Pin, Port, Rotation, Scene
from cablecad.pipeline import resolve_ends, solve, solve_scene
from cablecad.scene import load_scene, parse_scene, resolved_text

TURN = Rotation((1, 2, -2), 100.0)


def matrix_of(rotation: Rotation) -> np.ndarray:
    """By quaternions: another way than the model's."""
    w = math.cos(math.radians(rotation.angle_deg) / 2)
    x, y, z = math.sin(math.radians(rotation.angle_deg) / 2) * np.array(rotation.axis) / np.linalg.norm(rotation.axis)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def bracket(**keys: object) -> Part:
    ports = (NamedPort("J1", (3, 4, 5), (0, 0.6, 0.8)), NamedPort("loose", (0, 0, 1)))
    return Part("bracket", "bracket.step", ports=ports, **keys)


def hung(start: PartPort, **keys: object) -> Cable:
    return Cable("W1", diameter=2.0, start=start, end=Port((40, 0, 0), (0, 0, 1)), length=150.0, **keys)


def test_a_file_gives_parts_their_ports_and_cables_their_ends():
    loose = 'name = "loose"\nposition = [0, 0, 1]'
    scene = parse_scene(ported(PORT, loose, end='{ part = "plate", near = [1, 2, 3], straight = 4 }'))
    assert scene.parts[0].ports == (NamedPort("J1", (0, 0, 0), (0, 0, 1)), NamedPort("loose", (0, 0, 1)))
    assert scene.cables[0].start == PartPort("plate", port="J1")
    assert scene.cables[0].end == PartPort("plate", near=(1, 2, 3), straight=4.0)


@pytest.mark.parametrize("rotation", [Rotation(), TURN, Rotation((0, 0, 1), 90), Rotation((0, -3, 0), 450)])
def test_a_named_port_moves_with_its_part(rotation):
    part = bracket(position=(10, -20, 30), rotation=rotation)
    run = resolve_ends(Scene(cables=(hung(PartPort("bracket", port="J1", straight=6.0)),), parts=(part,)))
    (cable,) = run.scene.cables
    assert isinstance(cable.start, Port)
    assert cable.start.straight == 6.0
    np.testing.assert_allclose(cable.start.position, matrix_of(rotation) @ (3, 4, 5) + (10, -20, 30), atol=1e-14)
    np.testing.assert_allclose(cable.start.outward, matrix_of(rotation) @ (0, 0.6, 0.8), atol=1e-15)
    assert run.remarks == []


def test_quarter_turns_are_exact():
    part = bracket(rotation=Rotation((0, 0, 1), -90), position=(1, 1, 1))
    assert part.placed((3, 4, 5)) == (5.0, -2.0, 6.0)
    assert Rotation((0, 0, 7), 180).turned((1, 2, 3)) == (-1.0, -2.0, 3.0)


def test_a_scene_with_named_ports_solves_as_its_numbers_do():
    part = bracket(position=(0, 0, 0), rotation=Rotation((1, 0, 0), -math.degrees(math.asin(0.6)) + 90))
    asked = Scene(cables=(hung(PartPort("bracket", port="J1")),), parts=(part,))
    numbers = resolve_ends(asked).scene
    there, here = (solve_scene(scene).report()["cables"][0] for scene in (asked, numbers))
    assert there["message"] == here["message"]
    assert {**there, "seconds": 0} == {**here, "seconds": 0}


def test_a_port_without_an_axis_is_a_pin():
    free = Cable("W1", 2.0, PartPort("bracket", port="loose"), Pin((40, 0, 1)), length=50.0)
    run = solve_scene(Scene(cables=(free,), parts=(bracket(),)))
    assert run.outcomes[0].solution is not None
    assert run.outcomes[0].solution.chord == 40.0


def test_named_ports_need_no_kernel(tmp_path):
    scene = ported(PORT)
    (tmp_path / "loom.toml").write_text(scene)
    for command in ("solve", "resolve"):
        code = (
            f"import sys\nfrom cablecad.cli import main\ntry:\n    main(['{command}', 'loom.toml'])\n"
            "except SystemExit as end:\n    assert not end.code\nassert 'OCP' not in sys.modules"
        )
        subprocess.run([sys.executable, "-c", code], check=True, cwd=tmp_path, capture_output=True)


@pytest.mark.parametrize(
    ("end", "path", "words"),
    [
        (PartPort("braket", port="J1"), "cables.W1.start.part", "did you mean 'bracket'?"),
        (PartPort("bracket", port="lose"), "cables.W1.start.port", "did you mean 'loose'?"),
    ],
)
def test_a_scene_made_in_python_knows_its_parts(end, path, words):
    with pytest.raises(SceneError, match=words.replace("?", r"\?")) as caught:
        Scene(cables=(hung(end),), parts=(bracket(),))
    assert [mistake.path for mistake in caught.value.mistakes] == [path]


@pytest.mark.parametrize(
    ("make", "path"),
    [
        (lambda: PartPort("bracket"), "part"),
        (lambda: PartPort("bracket", port="J1", near=(0, 0, 0)), "near"),
        (lambda: PartPort("bracket", near=(0, 0)), "near"),
        (lambda: PartPort(" ", port="J1"), "part"),
        (lambda: PartPort("bracket", port="J1", straight=-1), "straight"),
        (lambda: NamedPort("J1", (0, 0, 0), (0, 0, 0)), "outward"),
        (lambda: Part("a", "a.step", ports=[NamedPort("J1", (0, 0, 0))] * 2), "ports[1].name"),
        (lambda: solve(hung(PartPort("bracket", port="J1"))), "start"),
    ],
)
def test_objects_refuse_mistakes(make, path):
    with pytest.raises(SceneError) as caught:
        make()
    assert [mistake.path for mistake in caught.value.mistakes] == [path]


def test_data_that_do_not_fit_what_the_port_turns_out_to_be():
    """In Python the cable is made before the scene knows whether its port has an axis."""
    free = Cable("W1", 2.0, PartPort("bracket", port="J1"), Pin((40, 0, 1)), length=50.0, rise=10.0)
    stiff = Cable("W2", 2.0, PartPort("bracket", port="loose", straight=5.0), Pin((40, 0, 1)), length=50.0)
    with pytest.raises(SceneError) as caught:
        solve_scene(Scene(cables=(free, stiff), parts=(bracket(),)))
    assert [mistake.path for mistake in caught.value.mistakes] == ["cables.W1.rise", "cables.W2.start.straight"]


FULL = """
# A comment that is lost.
format = 1
name = 'say "so" \\ ∅'
tolerance.shape = 1e-7
materials.pvc.youngs_modulus = 3890
materials."as measured" = { bending_stiffness = 4.5e4 }

[[parts]]
name = "bracket"
step = "parts/bracket.step"
rotation = { axis = [0, 0, 1], angle_deg = 30 }
[[parts.ports]]
name = "J1"
position = [0.1, 0.2, 0.3]
outward = [0, 0, 1]
[[parts.ports]]
name = "J2"
position = [1, 2, 3]

[[parts]]
name = "box"
step = "/stock/box.step"
ports = []

[[cables]]
name = "W1"
diameter = 4
length = 350
material = "as measured"
start = { part = "bracket", port = "J1", straight = 1.5 }
end = { position = [0, 120, 0], direction = [0, 0, -1] }
equilibrium = { winding = 0, side = -1 }

[[cables]]
name = "W2"
diameter = 4
angle_deg = 20
length = 350
start = { part = "bracket", port = "J2" }
end = { toward = [0, 0, 1] }
allow_contact = true
"""


@pytest.mark.parametrize("syntax", ["toml", "json"])
def test_a_resolved_scene_loads_as_what_it_was_made_from(syntax, tmp_path):
    path = tmp_path / "loom.toml"
    path.write_text(FULL, encoding="utf-8")
    resolved = resolve_ends(load_scene(path)).scene
    text = resolved_text(path, resolved, syntax=syntax)
    again = parse_scene(text, syntax=syntax, source=path)
    placed = [dataclasses.replace(cable) for cable in resolved.cables]
    pin = resolved.cables[1].start
    placed[1] = dataclasses.replace(placed[1], start=Pin(pin.position))  # a port without an axis is written as a pin
    assert again.cables == tuple(placed)
    assert again.parts == (
        dataclasses.replace(resolved.parts[0], step=tmp_path / "parts/bracket.step"),
        resolved.parts[1],
    )
    assert (again.name, again.tolerance) == (resolved.name, resolved.tolerance)
    assert resolved_text(path, resolved, syntax=syntax) == text
    data = tomllib.loads(text) if syntax == "toml" else json.loads(text)
    assert data["cables"][1]["end"] == {"toward": [0, 0, 1]}
    assert "part" not in json.dumps(data["cables"])


@pytest.mark.parametrize(
    ("folder", "step"),
    [
        (None, "{here}/parts/bracket.step"),
        ("{here}", "parts/bracket.step"),
        ("{here}/out/deep", "../../parts/bracket.step"),
    ],
)
def test_paths_of_parts_lead_to_the_same_files(folder, step, tmp_path):
    path = tmp_path / "loom.toml"
    path.write_text(FULL, encoding="utf-8")
    scene = resolve_ends(load_scene(path)).scene
    text = resolved_text(path, scene, folder=None if folder is None else folder.format(here=tmp_path))
    assert [part["step"] for part in tomllib.loads(text)["parts"]] == [step.format(here=tmp_path), "/stock/box.step"]
