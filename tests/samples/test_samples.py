"""Every sample: it solves, builds and checks, its numbers are those of closed forms, and its file reads back."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from oracle import PinnedOracle

pytest.importorskip("OCP", reason="solids need the kernel")

from cablecad.brep.step import read_tree
from cablecad.scene import load_scene

SAMPLES = Path(__file__).parents[2] / "samples"

ANGLES = {
    "paper": {"cable": 20.0},
    "connectors": {"W1": 20.0},
    "figure6": {f"{angle} degrees": float(angle) for angle in (20, 40, 60, 80, 100, 125)},
    "crossed": {"crossed": 150.0},
}
"""The end angle of every cable of the samples; all are 350 mm long."""

CLAMPED = {"clamped": ["W1"]}
"""The cables of the samples that are clamped."""

FACES = {"clamped": 5}
"""Side and caps; a side in three pieces, where straight parts go before and after the free one."""

WARNINGS = {"crossed": ["the ends have crossed", "unstable in its plane", "which allow_contact lets through"]}


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """Each sample built once by the command line: its report and the roots of its STEP file."""
    from cablecad.cli.group import cablecad
    from cablecad.cli.session import run_command

    folder = tmp_path_factory.mktemp("built")
    found = {}
    for name in [*ANGLES, *CLAMPED]:
        step, report = folder / f"{name}.step", folder / f"{name}.json"
        arguments = ["build", str(SAMPLES / f"{name}.toml"), "-o", str(step), "--report", str(report), "--strict", "-q"]
        assert run_command(cablecad, arguments) == 0
        found[name] = json.loads(report.read_text(encoding="utf-8")), read_tree(step)
    return found


def test_every_sample_is_tested_here():
    # The loom is in a file of its own.
    assert {path.stem for path in SAMPLES.glob("*.toml")} == {*ANGLES, *CLAMPED, "loom"}


@pytest.mark.parametrize("name", ANGLES)
def test_numbers(cli, built, name):
    ended = cli("solve", SAMPLES / f"{name}.toml", "--json")
    assert ended.code == 0
    report = json.loads(ended.out)
    cables = {one["name"]: one for one in report["cables"]}
    assert list(cables) == list(ANGLES[name])
    for cable, angle in ANGLES[name].items():
        one, truth = cables[cable], PinnedOracle(350.0, angle_deg=angle).data
        # The connectors are placed to ten digits, which the others repeat in the chord's error.
        digits = 1e-11 if name == "connectors" else 1e-13
        assert one["length"] == 350.0
        assert one["end_angle_deg"] == pytest.approx(angle, rel=10 * digits)
        assert one["chord"] == pytest.approx(float(truth["chord"]), rel=digits)
        assert one["rise"] == pytest.approx(float(truth["rise"]), rel=10 * digits)
        assert one["bend_radius_min"] == pytest.approx(float(truth["bend_radius"]), rel=10 * digits)
        np.testing.assert_allclose(
            one["start"]["force_per_EI"], [float(truth["force"]), 0.0, 0.0], rtol=digits, atol=1e-20
        )
        assert one["residual"] < 1e-14
        stable = angle < 130.7
        assert (one["stable_in_plane"], one["stable_out_of_plane"]) == (stable, stable)
        assert len(one["warnings"]) == len(WARNINGS.get(name, []))
        for words, warning in zip(WARNINGS.get(name, []), one["warnings"], strict=True):
            assert words in warning
        assert one["violations"] == []
    built_cables = built[name][0]["cables"]
    for one, solved in zip(built_cables, report["cables"], strict=True):
        same = {key: value for key, value in one.items() if key not in ("solid", "seconds")}
        assert same == {key: solved[key] for key in same}


def test_the_clamped_cable_meets_its_connectors(cli, built):
    """Where its ends are and point is given; the curve is a mirror image of itself, and as long as it says."""
    report, _ = built["clamped"]
    (cable,) = report["cables"]
    assert (cable["result"], cable["violations"], cable["warnings"]) == ("solved", [], [])
    assert (cable["stable_in_plane"], cable["stable_out_of_plane"]) == (True, True)
    assert cable["residual"] < 1e-14
    for end, place, direction in (("start", [0, 0, 0], [1, 0, 0]), ("end", [0, 120, 0], [-1, 0, 0])):
        np.testing.assert_allclose(cable[end]["position"], place, atol=1e-11)
        np.testing.assert_allclose(cable[end]["direction"], direction, atol=1e-13)
    np.testing.assert_allclose(cable["start"]["force"], np.negative(cable["end"]["force"]), rtol=1e-12, atol=1e-12)
    points = np.array(
        json.loads(cli("solve", SAMPLES / "clamped.toml", "--json", "--points", 2001).out)["cables"][0]["points"]
    )
    np.testing.assert_allclose(points[::-1] * [1, -1, 1] + [0, 120, 0], points, atol=1e-10)
    # Chords are shorter than arcs, by kappa^2 h^2 / 24 of themselves.
    total = np.linalg.norm(np.diff(points, axis=0), axis=1).sum()
    assert 0.0 < 350.0 - total < 350.0 * (0.175 / cable["bend_radius_min"]) ** 2 / 24.0
    solid = cable["solid"]
    assert solid["deviation"] <= 1e-3
    assert solid["volume"] == pytest.approx(math.pi * 4.0 * 350.0, rel=1e-5)


def test_variants_of_the_clamped_cable_solve(cli, tmp_path):
    out = tmp_path / "out"
    ended = cli("batch", SAMPLES / "clamped.csv", "--scene", SAMPLES / "clamped.toml", "-o", out, "--output", "none")
    assert ended.code == 0
    assert "6 rows: 6 done" in ended.err


@pytest.mark.parametrize(("name", "force", "chord", "rise"), [("paper", "3.999069", "339.40582", "38.39728")])
def test_figures_the_readme_prints(built, name, force, chord, rise):
    (one,) = built[name][0]["cables"]
    found = (f"{one['start']['force'][0]:.6f}", f"{one['chord']:.5f}", f"{one['rise']:.5f}")
    assert found == (force, chord, rise)
    readme = (SAMPLES.parent / "README.md").read_text(encoding="utf-8")
    assert f"{force} N, chord {chord} mm, rise {rise} mm" in readme


@pytest.mark.parametrize("name", [*ANGLES, *CLAMPED])
def test_solids(built, name):
    report, (root,) = built[name]
    scene = load_scene(SAMPLES / f"{name}.toml")
    assert root.name == scene.name == report["scene"]
    groups = {group.name: group for group in root.children}
    assert list(groups) == (["parts", "cables"] if scene.parts else ["cables"])
    solids = groups["cables"].children
    assert [(node.name, node.occurrence) for node in solids] == [(cable.name, cable.name) for cable in scene.cables]
    for cable, node, one in zip(scene.cables, solids, report["cables"], strict=True):
        certificate = one["solid"]
        assert certificate["deviation"] <= certificate["tolerance"] == 1e-3
        assert (certificate["valid"], certificate["faces"]) == (True, FACES.get(name, 3))
        # Pappus: pi r^2 L, off by 2 deviation / r at most; read back it is the same solid.
        exact, r = math.pi * 4.0 * 350.0, cable.diameter / 2.0
        assert certificate["volume"] == pytest.approx(exact, rel=2.0 * certificate["deviation"] / r)
        assert certificate["volume_error"] == pytest.approx(certificate["volume"] / exact - 1.0, abs=1e-12)
        # The certificate's comes from the splines, this from Open Cascade's integration of what was read, to 1e-6.
        assert node.volume == pytest.approx(certificate["volume"], rel=1e-6)
        # Side and two caps.
        area = 2.0 * math.pi * r * 350.0 + 2.0 * math.pi * r**2
        assert certificate["area"] == pytest.approx(area, rel=2.0 * certificate["deviation"] / r)
        assert certificate["bend_radius_min"] == pytest.approx(one["bend_radius_min"], rel=1e-2)
        color = bytes.fromhex(f"{cable.color[1:]:f<8}")
        np.testing.assert_allclose(node.color or node.occurrence_color, np.array(list(color)) / 255.0, atol=1e-6)


def test_connectors_are_one_geometry_at_two_places(built):
    report, (root,) = built["connectors"]
    left, right = root.children[0].children
    assert (left.occurrence, right.occurrence) == ("left connector", "right connector")
    assert left.shape.IsSame(right.shape)
    assert [part["solids"] for part in report["parts"]] == [2, 2]
    np.testing.assert_allclose(left.placement, np.eye(3, 4), atol=1e-12)
    (cable,) = load_scene(SAMPLES / "connectors.toml").cables
    half_turn = [[-1, 0, 0, cable.end.position[0]], [0, -1, 0, 0], [0, 0, 1, 0]]
    np.testing.assert_allclose(right.placement, half_turn, atol=1e-12)


def test_crossed_loop_is_refused_unless_contact_is_allowed(cli, tmp_path):
    text = (SAMPLES / "crossed.toml").read_text(encoding="utf-8")
    assert "\nallow_contact = true\n" in text
    path = tmp_path / "crossed.toml"
    path.write_text(text.replace("\nallow_contact = true\n", "\n"), encoding="utf-8")
    assert cli("solve", path).code == 0
    for command in (("build", "-o", str(tmp_path / "out.step")), ("check",)):
        ended = cli(*command, path)
        assert ended.code == 4
        assert "error: cable crossed: self_gap: parts of the cable overlap by" in ended.err
    assert [path.name for path in tmp_path.iterdir()] == ["crossed.toml"]
