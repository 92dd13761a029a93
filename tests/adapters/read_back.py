"""What a host's exporter wrote of the two samples, measured: both make the same loom."""

from __future__ import annotations

import math
import subprocess
import sys
from pathlib import Path

import numpy as np

SAMPLES = Path(__file__).parents[2] / "samples"

LENGTH, RADIUS = 260.0, 2.5
SLOPE = math.radians(20.0)
# Where the holes are, by hand: the panel's top, and the side of the housing, which is tilted and moved.
HOLES = {
    "panel": ((0.0, 0.0, 4.0), (0.0, 0.0, 1.0)),
    "housing": (
        (160.0 - 20.0 * math.cos(SLOPE), 0.0, 70.0 - 20.0 * math.sin(SLOPE)),
        (-math.cos(SLOPE), 0.0, -math.sin(SLOPE)),
    ),
}
COLORS = {"panel": (0.8, 0.8, 0.75), "housing": (0.2, 0.22, 0.25), "W1": (0x2B / 255, 0x6C / 255, 0xB0 / 255)}


def run_sample(name: str, folder: Path) -> Path:
    """Run a sample as README says, in a folder of its own."""
    done = subprocess.run(
        [sys.executable, str(SAMPLES / name), "loom.step"], cwd=folder, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[0] == "loom.step"
    return folder / "loom.step"


def check_loom(path: Path) -> None:
    """Names, colours, the cable's ends at the holes of the parts in the file, and its volume."""
    from OCP.TopAbs import TopAbs_ShapeEnum

    from cablecad.brep.kernel import subshapes
    from cablecad.brep.rounds import circle_of
    from cablecad.brep.step import read_tree

    (root,) = read_tree(path)
    nodes = {node.name: node for node in root.walk()}
    assert [node.name for node in root.children] == ["panel", "housing", "W1"]
    circles = {}
    for name, color in COLORS.items():
        node = nodes[name]
        np.testing.assert_allclose(node.color or node.occurrence_color, (*color, 1.0), atol=1e-6)
        turn, move = node.placement[:, :3], node.placement[:, 3]
        found = [circle_of(edge) for edge in subshapes(node.shape, TopAbs_ShapeEnum.TopAbs_EDGE)]
        circles[name] = [(turn @ one.centre + move, turn @ one.axis) for one in found if one is not None]
    for name, (centre, axis) in HOLES.items():
        for owner in (name, "W1"):
            apart, tilt = min(
                (float(np.linalg.norm(place - centre)), float(np.linalg.norm(np.cross(way, axis))))
                for place, way in circles[owner]
            )
            assert apart < 1e-9, (name, owner)
            assert tilt < 1e-9, (name, owner)
    assert abs(nodes["W1"].volume / (math.pi * RADIUS**2 * LENGTH) - 1.0) < 1e-7
