"""The loom: clamped cables between connectors that are parts of the scene, as they are seen in the gallery."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("OCP", reason="solids need the kernel")

from cablecad import solve
from cablecad.brep.step import read_tree
from cablecad.scene import load_scene

LOOM = Path(__file__).parents[2] / "samples" / "loom.toml"
LENGTHS = {"W1": 200.0, "W2": 190.0, "W3": 210.0}


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    from cablecad.cli.group import cablecad
    from cablecad.cli.session import run_command

    folder = tmp_path_factory.mktemp("loom")
    arguments = ["build", str(LOOM), "-o", str(folder / "a.step"), "--report", str(folder / "a.json"), "--strict", "-q"]
    assert run_command(cablecad, arguments) == 0
    return json.loads((folder / "a.json").read_text(encoding="utf-8")), read_tree(folder / "a.step")


def test_every_cable_is_stable_as_long_as_it_was_cut_and_within_its_rule(built):
    report, _ = built
    assert {one["name"]: one["length"] for one in report["cables"]} == LENGTHS
    for one in report["cables"]:
        assert (one["stable_in_plane"], one["stable_out_of_plane"]) == (True, True)
        assert one["residual"] < 1e-12
        assert one["bend_radius_min"] > 20.0
        assert (one["warnings"], one["violations"]) == ([], [])
        assert abs(one["solid"]["volume_error"]) < 1e-3


def test_ends_are_the_mouths_of_connectors(built):
    """A connector's mouth is at its origin and faces its +X: there every cable begins or ends, along it."""
    _, (root,) = built
    parts = {node.occurrence: node.placement for node in root.children[0].children}
    for cable in load_scene(LOOM).cables:
        solution = solve(cable)
        for end, state, sign in (("start", solution.equilibrium.start, 1.0), ("end", solution.equilibrium.end, -1.0)):
            placement = parts[f"{cable.name} {end}"]
            np.testing.assert_allclose(state.position, placement[:, 3], atol=1e-9)
            np.testing.assert_allclose(sign * state.direction, placement[:, 0], atol=1e-12)


def test_an_s_a_hook_and_a_u_turn():
    turns = {}
    for cable in load_scene(LOOM).cables:
        start, end = solve(cable).tangent([0.0, LENGTHS[cable.name]])
        turns[cable.name] = round(float(np.degrees(np.arccos(np.clip(start @ end, -1.0, 1.0)))))
    assert turns == {"W1": 0, "W2": 90, "W3": 180}
