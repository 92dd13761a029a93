"""The report: every key of format 1 and no other, null where nothing is known, and numbers that hold by themselves."""

from __future__ import annotations

import json
import re
from itertools import pairwise

import mpmath as mp
import numpy as np
import pytest
from loom import FORMAT, PVC, TOWARD, cable, names, part, scene, write
from oracle import PinnedOracle

TOP = ["format", "cablecad", "scene", "cables", "parts", "seconds"]
CABLE = [
    *("name", "result", "message", "model", "reason", "branch", "length", "chord", "slack", "out_of_plane_deg"),
    *("residual", "rise", "end_angle_deg", "bend_radius_min", "bend_radius_min_at", "self_gap", "energy_per_EI"),
    *("EI", "GJ", "energy", "weight_ratio", "start", "end", "stable_in_plane", "margin_in_plane"),
    *("stable_out_of_plane", "margin_out_of_plane", "spin", "equilibria", "points", "solid", "violations"),
    *("warnings", "seconds"),
]
END = ["position", "direction", "force", "moment", "force_per_EI", "moment_per_EI"]
EQUILIBRIUM = [
    *("index", "winding", "side", "inflections", "energy_per_EI", "bend_radius_min", "self_gap", "stable_in_plane"),
    *("margin_in_plane", "stable_out_of_plane", "margin_out_of_plane"),
]
SOLID = [
    *("deviation", "tolerance", "volume", "volume_error", "area", "area_error", "bend_radius_min", "valid"),
    *("knot_spans", "faces"),
]
NEEDS_MATERIAL = ["EI", "GJ", "energy", "weight_ratio"]
NOT_NUMBERS = ["name", "result", "message", "equilibria", "points", "violations", "warnings", "seconds", "start", "end"]

CLAMPED = cable(
    start="{ position = [0, 0, 0], outward = [0, 0, 1] }",
    end="{ position = [120, 0, 0], outward = [0, 0, 1] }",
    material='"pvc"',
)


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def read_json(text: str) -> dict:
    """JSON as its standard has it: no NaN, no Infinity, no key twice."""

    def refuse(constant: str) -> None:
        raise AssertionError(f"{constant} is no JSON")

    def whole(pairs: list) -> dict:
        assert len(dict(pairs)) == len(pairs)
        return dict(pairs)

    return json.loads(text, parse_constant=refuse, object_pairs_hook=whole)


@pytest.fixture
def report(cli, here):
    """The report of a scene: as `solve --json` prints it, or as another command gives it."""

    def make(text: str, *arguments: str, command: str = "solve", code: int = 0) -> dict:
        path = write(here / "scene.toml", text)
        if command == "build":
            ended = cli("build", path, "-o", "out.step", "--report", "out.json", *arguments)
            written = (here / "out.json").read_text(encoding="utf-8")
        else:
            ended = cli(command, path, "--json", *arguments)
            written = ended.out
        assert ended.code == code, ended.err
        assert written.endswith("}\n")
        return read_json(written)

    return make


def assert_keys(found: dict) -> None:
    """All keys at every level, in the order of the contract."""
    assert list(found) == TOP
    assert list(found["seconds"]) == ["import", "read", "cables", "write", "total"]
    for part_ in found["parts"]:
        assert list(part_) == ["name", "solids"]
    for one in found["cables"]:
        assert list(one) == CABLE
        assert list(one["start"]) == list(one["end"]) == END
        assert list(one["seconds"]) == ["solve", "tube", "check"]
        for equilibrium in one["equilibria"]:
            assert list(equilibrium) == EQUILIBRIUM
        assert one["solid"] is None or list(one["solid"]) == SOLID


# --- keys and nulls --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("command", ["solve", "build", "check"])
def test_keys_of_solved_cables(report, command):
    tables = (cable("arch"), CLAMPED.replace("W1", "held"), cable("line", length="300"))
    found = report(scene(*tables, head=PVC), command=command)
    assert_keys(found)
    assert (found["format"], found["scene"]) == (1, "scene")
    arch, held, line = found["cables"]
    assert [one["result"] for one in found["cables"]] == ["solved"] * 3
    assert [one["model"] for one in found["cables"]] == ["planar", "planar", "straight"]
    assert all(one["reason"] for one in found["cables"])
    for key in NEEDS_MATERIAL:
        assert arch[key] is None
    for end in ("start", "end"):
        assert (arch[end]["force"], arch[end]["moment"]) == (None, None)
        assert None not in held[end].values()
    assert held["weight_ratio"] is None  # no mass was given
    assert None not in [held[key] for key in NEEDS_MATERIAL[:3]]
    assert (line["bend_radius_min"], line["bend_radius_min_at"], line["rise"], line["branch"]) == (
        None,
        None,
        0,
        "line",
    )
    for one in found["cables"]:
        assert (one["message"], one["violations"], one["warnings"], one["points"]) == ("", [], [], [])
        assert (one["solid"] is None) == (command == "solve")
        assert one["stable_in_plane"] is one["stable_out_of_plane"] is True
    assert found["seconds"]["cables"] <= found["seconds"]["total"]
    assert (found["seconds"]["write"] is None) == (command != "build")


def test_stages_that_were_not_run_have_no_time(report):
    found = report(scene(cable()))
    assert [found["seconds"][stage] for stage in ("import", "read", "write")] == [None] * 3
    seconds = found["cables"][0]["seconds"]
    assert (seconds["tube"], seconds["check"]) == (None, None)
    assert seconds["solve"] > 0


@pytest.mark.parametrize(("command", "code"), [("solve", 3), ("build", 3), ("check", 3)])
def test_cable_that_has_no_shape_is_all_null(report, command, code):
    found = report(scene(cable("bad", length="200"), cable("good")), command=command, code=code)
    assert_keys(found)
    bad, good = found["cables"]
    assert (bad["result"], good["result"]) == ("infeasible", "solved")
    assert "make the cable longer" in bad["message"]
    for key in CABLE:
        if key not in NOT_NUMBERS:
            assert bad[key] is None
    for end in ("start", "end"):
        assert list(bad[end].values()) == [None] * 6
    assert (bad["equilibria"], bad["points"], bad["violations"], bad["warnings"]) == ([], [], [], [])
    assert good["chord"] == 300


@pytest.mark.parametrize("command", ["build", "check"])
def test_tube_that_would_cut_into_itself(report, command):
    found = report(scene(cable("loop", angle_deg="150", end=TOWARD), cable("good")), command=command, code=4)
    assert_keys(found)
    loop, good = found["cables"]
    assert (loop["result"], loop["solid"], loop["chord"]) == ("invalid_tube", None, None)
    assert "self_gap" in loop["message"]
    (violation,) = loop["violations"]
    assert violation in loop["message"]
    assert (good["result"], good["solid"]["valid"]) == ("solved", True)


def test_solve_reports_it_as_a_violation(report):
    (loop,) = report(scene(cable("loop", angle_deg="150", end=TOWARD)))["cables"]
    assert loop["result"] == "solved"
    assert loop["self_gap"] == pytest.approx(-4.0)
    assert [violation.partition(":")[0] for violation in loop["violations"]] == ["self_gap"]
    assert (loop["stable_in_plane"], loop["stable_out_of_plane"]) == (False, False)
    assert len(loop["warnings"]) == 2
    assert "the ends have crossed" in loop["warnings"][0]
    assert "unstable" in loop["warnings"][1]


def test_allowed_contact_is_a_warning(report):
    text = scene(cable("loop", angle_deg="150", end=TOWARD, allow_contact="true"))
    (loop,) = report(text, command="build")["cables"]
    assert (loop["result"], loop["violations"]) == ("solved", [])
    assert any("allow_contact" in warning for warning in loop["warnings"])
    assert loop["solid"]["valid"] is True


@pytest.mark.parametrize(("arguments", "code"), [([], 0), (["--strict"], 4)])
def test_broken_rule_is_a_violation_of_a_solved_cable(report, here, arguments, code):
    text = scene(cable(min_bend_radius="150"))
    (one,) = report(text, *arguments, command="build", code=code)["cables"]
    assert one["result"] == "solved"
    assert [violation.partition(":")[0] for violation in one["violations"]] == ["min_bend_radius"]
    assert one["solid"]["valid"] is True
    assert ("out.step" in names(here)) == (code == 0)


def test_scene_in_which_some_cannot_be_solved(cli, here):
    path = write(here / "scene.toml", scene(cable("A", length="200"), cable("B"), cable("C", length="100"), cable("D")))
    solved = cli("solve", path)
    assert solved.code == 3
    assert [line.partition(",")[0] for line in solved.out.splitlines()] == [
        *("A: infeasible", "B: solved", "C: infeasible", "D: solved"),
    ]
    built = cli("build", path, "-o", "out.step", "--report", "out.json")
    assert (built.code, built.out) == (3, "out.json\n")
    assert names(here) == ["out.json", "scene.toml"]
    assert [line[:15] for line in built.err.splitlines()] == ["error: cable A:", "error: cable C:"]
    results = [one["result"] for one in read_json((here / "out.json").read_text())["cables"]]
    assert results == ["infeasible", "solved", "infeasible", "solved"]


def test_report_of_a_scene_whose_part_cannot_be_read(report, here):
    found = report(scene(part(), cable()), command="build", code=5)
    assert_keys(found)
    assert found["parts"] == [{"name": "plate", "solids": None}]
    assert found["cables"][0]["solid"]["valid"] is True
    assert names(here) == ["out.json", "scene.toml"]


def test_no_report_of_an_invalid_scene(cli, here):
    path = write(here / "scene.toml", scene(cable(rise="50"), cable("short", length="100")))
    assert cli("build", path, "-o", "out.step", "--report", "out.json").code == 2
    assert names(here) == ["scene.toml"]


# --- numbers ---------------------------------------------------------------------------------------------------------


def test_numbers_of_the_paper(report):
    """350 mm of 4 mm PVC, pinned, 20 degrees: against closed forms in 50 digits."""
    text = scene(cable(angle_deg="20", end=TOWARD, material='"pvc"'), head=PVC)
    (one,) = report(text, command="build")["cables"]
    truth = PinnedOracle(350.0, angle_deg=20.0)
    EI = 3890 * mp.pi * 4**4 / 64
    exact = truth.data | {"EI": EI, "GJ": EI / mp.mpf("1.25"), "end_angle_deg": mp.mpf(20), "rise": truth.data["rise"]}
    exact |= {"bend_radius_min": truth.data["bend_radius"], "bend_radius_min_at": mp.mpf(175)}
    # Energy: EI/2 times the integral of kappa^2, with kappa = 2 k omega cn.
    energy = 2 * truth.m * truth.omega * mp.quad(lambda u: mp.ellipfun("cn", u, m=truth.m) ** 2, [-truth.K, 0, truth.K])
    exact |= {"energy_per_EI": energy, "energy": EI * energy}
    for key in ("length", "chord", "slack", "rise", "end_angle_deg", "bend_radius_min", "EI", "GJ", "energy"):
        assert one[key] == pytest.approx(float(exact[key]), rel=1e-13)
    assert one["energy_per_EI"] == pytest.approx(float(energy), rel=1e-13)
    assert one["bend_radius_min_at"] == pytest.approx(175.0, abs=1e-5)  # a maximum is flat
    force = float(EI * truth.data["force"])
    np.testing.assert_allclose(one["start"]["force"], [force, 0, 0], rtol=1e-13, atol=1e-13)
    assert (round(force, 6), round(one["chord"], 5), round(one["rise"], 5)) == (3.999069, 339.40582, 38.39728)
    assert one["residual"] <= 1e-14
    assert one["solid"]["deviation"] <= one["solid"]["tolerance"] == 1e-3
    assert one["solid"]["volume"] == pytest.approx(float(mp.pi) * 4 * 350, rel=1e-6)
    assert one["solid"]["faces"] == 3


@pytest.mark.parametrize(
    "text", [cable(material='"pvc"'), CLAMPED, cable(angle_deg="150", end=TOWARD, material='"pvc"')]
)
def test_what_the_supports_apply_is_in_balance(report, text):
    """F0 + F1 = 0 and M0 + M1 + (r1 - r0) x F1 = 0, per unit EI and in newtons."""
    (one,) = report(scene(text, head=PVC))["cables"]
    for force, moment, scale in (("force_per_EI", "moment_per_EI", 1.0), ("force", "moment", one["EI"])):
        (F0, M0, r0), (F1, M1, r1) = (
            [np.array(one[end][key]) for key in (force, moment, "position")] for end in ("start", "end")
        )
        assert np.linalg.norm(F0) * one["length"] ** 2 / scale > 1.0  # there is something to balance
        np.testing.assert_allclose(F0 + F1, 0.0, atol=1e-13 * np.linalg.norm(F0))
        np.testing.assert_allclose(M0 + M1 + np.cross(r1 - r0, F1), 0.0, atol=1e-11 * scale / one["length"])
        np.testing.assert_allclose(F0, scale * np.array(one["start"]["force_per_EI"]), rtol=1e-15)


@pytest.mark.parametrize("text", [CLAMPED, cable(angle_deg="150", end=TOWARD)])
def test_end_states_agree_with_the_points(report, text):
    """Directions and moments by differences of the points: M0 = -EI kappa(0) b, M1 = +EI kappa(L) b."""
    count = 35_001
    (one,) = report(scene(text, head=PVC), "--points", str(count))["cables"]
    points, step = np.array(one["points"]), one["length"] / (count - 1)
    assert points.shape == (count, 3)
    assert points[0].tolist() == one["start"]["position"]
    assert points[-1].tolist() == one["end"]["position"]
    # Chords of equal arcs are short of them by kappa^2 step^3 / 24 each.
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    np.testing.assert_allclose(lengths, step, rtol=step**2 / (24 * one["bend_radius_min"] ** 2) + 1e-10)
    tangents = np.diff(points, axis=0) / step
    for at, end in ((0, "start"), (-1, "end")):
        np.testing.assert_allclose(tangents[at], one[end]["direction"], atol=step / one["bend_radius_min"])
    turn = np.cross(tangents[:-1], tangents[1:]) / step  # kappa b one step from the ends, and further in
    for first, second, end, sign in ((0, 1, "start", -1.0), (-1, -2, "end", 1.0)):
        at_end = 2.0 * turn[first] - turn[second]
        np.testing.assert_allclose(sign * at_end, one[end]["moment_per_EI"], atol=2e-8)


@pytest.mark.parametrize("count", [2, 7])
def test_points_are_listed_if_asked_for(report, count):
    tables = cable(), cable("line", length="300"), cable("bad", length="100")
    arch, line, bad = report(scene(*tables), "--points", str(count), code=3)["cables"]
    assert [len(one["points"]) for one in (arch, line, bad)] == [count, count, 0]
    np.testing.assert_allclose(line["points"], np.linspace([0, 0, 0], [300, 0, 0], count), atol=1e-13)


def test_equilibria_come_by_energy_and_the_unstable_last(report):
    (one,) = report(scene(CLAMPED, head=PVC), "--equilibria")["cables"]
    found = one["equilibria"]
    assert [equilibrium["index"] for equilibrium in found] == list(range(len(found)))
    assert len(found) > 2
    stable = [equilibrium["stable_in_plane"] for equilibrium in found]
    assert stable == sorted(stable, reverse=True)
    energies = [equilibrium["energy_per_EI"] for equilibrium in found[: sum(stable)]]
    for less, more in pairwise(energies):
        assert less <= more * (1.0 + 1e-12)  # twins differ by rounding
    for key in EQUILIBRIUM[4:]:
        assert found[0][key] == one[key]


def test_mass_only_judges_gravity(report):
    """w L^3 / EI, with w = 0.02 kg/m x 9.80665 m/s^2 and the stiffness as measured."""
    stranded = "[materials.stranded]\nbending_stiffness = 2500.0\nmass_per_length = 0.02\n"
    (one,) = report(scene(cable(material='"stranded"'), head=stranded))["cables"]
    assert one["weight_ratio"] == pytest.approx(0.02 * 9.80665e-3 * 350**3 / 2500, rel=1e-14)
    assert (one["EI"], one["GJ"]) == (2500.0, None)
    assert [warning.partition(",")[0] for warning in one["warnings"]] == ["gravity is not modelled"]


# --- as text ---------------------------------------------------------------------------------------------------------


def test_vectors_stand_on_one_line_and_names_as_they_are(cli, here):
    path = write(here / "scene.toml", FORMAT + "name = 'Käbel [1,\\n 2]'\n" + cable("[\\n1, 2\\n]"))
    text = cli("solve", path, "--json", "--points", "2").out
    assert '"scene": "Käbel [1,\\\\n 2]"' in text
    assert re.search(r'"position": \[[-+\d.e, ]+\],\n', text)
    assert read_json(text)["cables"][0]["name"] == "[\\n1, 2\\n]"
    assert not re.search(r"^[-+\d.e, ]+$", text, re.MULTILINE)  # a line of numbers alone


def test_report_file_is_what_check_prints_but_for_the_times(report):
    text = scene(cable(), CLAMPED.replace("W1", "held"), head=PVC)

    def untimed(found: dict) -> dict:
        cables = [{**one, "seconds": None} for one in found["cables"]]
        return {**found, "cables": cables, "seconds": None}

    assert untimed(report(text, command="build")) == untimed(report(text, command="check"))
    solved = untimed(report(text))
    built = untimed(report(text, command="build"))
    for one in built["cables"]:
        one["solid"] = None
    assert solved == built
