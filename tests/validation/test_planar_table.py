"""43 planar scenes solved to 26 digits without elliptic functions (Taylor series and Newton at 40 digits).

`tests/data/planar_reference.json` is that table: random scenes, U-turns, rings, quarter circle, coincident ends, hairs
of slack, pins, tiny and large units. Where two minima have equal energies either twin will do: `bulge` is not part of
the table.
"""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

from cablecad.model import Cable, Clamp, Material, Pin
from cablecad.rod.solve import solve_rod

TABLE = json.loads((Path(__file__).parents[1] / "data" / "planar_reference.json").read_text())["planar"]


def numbers(values) -> np.ndarray:
    return np.array(values, dtype=float)


def support(position, angle) -> Clamp | Pin:
    place = (*numbers(position), 0.0)
    return Pin(place) if angle is None else Clamp(place, (math.cos(float(angle)), math.sin(float(angle)), 0.0))


@pytest.mark.parametrize("row", TABLE, ids=lambda row: row["name"])
def test_scene(row) -> None:
    length, EI = float(row["L"]), float(row["EI"])
    start, end = numbers(row["start"]), numbers(row["end"])
    cable = Cable(
        "c",
        length * 1e-4,
        support(row["start"], row["start_angle"]),
        support(row["end"], row["end_angle"]),
        length=length,
        material=Material(bending_stiffness=EI),
        bulge=(0.0, 0.0, 1.0) if np.allclose(start, end) and row["start_angle"] is None else (1e-3, 1.0, 0.0),
    )
    solution = solve_rod(cable)
    # Data rounded to doubles cost a nearly straight cable eps/sqrt(1 - d) in its points, and eps/(1 - d) in energy.
    excess = max(1.0 - float(np.linalg.norm(end - start)) / length, 1e-300)
    eps = np.finfo(float).eps * (1.0 + float(np.abs([start, end]).max()) / length)
    assert solution.energy == pytest.approx(float(row["energy"]), rel=1e-10 + 4 * eps / excess)
    exact = np.column_stack([np.array(row["points"], dtype=float), np.zeros(9)])
    room = length * (1e-9 + 10 * eps / math.sqrt(excess))
    shapes = [
        e for e in solution.equilibria if e.energy_per_EI == pytest.approx(solution.equilibrium.energy_per_EI, rel=1e-8)
    ]
    off = min(float(np.abs(shape.centreline.points(9) - exact).max()) for shape in shapes)
    assert off <= room
    assert solution.residual <= 1e-12
    force = [EI * shape.end.force_per_EI[:2] for shape in shapes]
    scale = 1e-9 * (np.linalg.norm(numbers(row["force"])) + EI / length**2) * (1.0 + eps / excess * 1e9)
    assert min(float(np.abs(f - numbers(row["force"])).max()) for f in force) <= scale


# The S offset's greatest curvature was published as 7.72585748, a sample beside the crest; the first integral
# kappa^2/2 + n.t with the published kappa(0) and n gives 7.72585920.
CLAMPED = {
    "hook": (2.0, (1.0, 0.0), 90.0, 45.0, 9.045443190, 4.44879867, (True, False)),
    "hairpin": (1.0, (0.3, 0.0), 90.0, -90.0, 9.136720278, 7.04728814, (True, True)),
    "S offset": (1.0, (0.6, 0.3), 0.0, 0.0, 14.219524301, 7.72585920, (True, False)),
    "coaxial": (1.0, (0.8, 0.0), 0.0, 0.0, 8.322939530, 5.84957645, (True, None)),
    "right angle": (1.0, (0.5, 0.5), 0.0, 90.0, 4.115276784, 4.68151162, (True, True)),
}


@pytest.mark.parametrize("name", CLAMPED)
def test_clamped_cases_and_their_stability(name: str) -> None:
    """Out of the plane with both frames held at GJ/EI = 0.8; the coaxial S is neutral: it turns about its axis."""
    length, end, a, b, energy, kappa, (inside, outside) = CLAMPED[name]
    cable = Cable(
        name,
        1e-3,
        support((0, 0), math.radians(a)),
        support(end, math.radians(b)),
        length=length,
        material=Material(bending_stiffness=1.0, torsional_stiffness=0.8),
        bulge=(1e-3, 1.0, 0.0),
    )
    solution = solve_rod(cable)
    assert solution.energy == pytest.approx(energy, rel=2e-10)
    assert 1.0 / solution.bend_radius_min == pytest.approx(kappa, rel=2e-9)
    assert solution.stability.spin == "clamped"
    assert bool(solution.stability.stable_in_plane) is inside
    if outside is None:
        assert solution.stability.free_turn
    else:
        assert bool(solution.stability.stable_out_of_plane) is outside
