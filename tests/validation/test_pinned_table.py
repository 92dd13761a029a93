"""The pinned table of 26-digit solutions found without elliptic functions (Taylor series and Newton at 40 digits).

`tests/data/pinned_reference.json` is that table: end angle, k, F/Pcr, chord, rise and energy for a rod of length and
stiffness one, and hard cases. "slack" there means 1 - chord / length.
"""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

from cablecad.model import Cable, Pin, Toward
from cablecad.rod.arch import FIGURE_EIGHT, HIGHEST
from cablecad.rod.pinned_data import solve_pinned
from cablecad.rod.solve import solve_rod

TABLE = json.loads((Path(__file__).parents[1] / "data" / "pinned_reference.json").read_text())
ROWS = {row["end_angle_deg"]: {key: float(value) for key, value in row.items()} for row in TABLE["rows"]}
SPECIAL = TABLE["special"]
PCR = math.pi**2


@pytest.mark.parametrize("angle", ROWS)
def test_row(angle: str) -> None:
    row = ROWS[angle]
    solution = solve_rod(
        Cable("row", 1e-3, Pin((0, 0, 0)), Toward((1, 0, 0)), length=1.0, angle_deg=row["end_angle_deg"])
    )
    equilibrium = solution.equilibrium
    assert solution.chord == pytest.approx(row["chord_over_L"], rel=1e-13, abs=1e-15)
    assert solution.rise == pytest.approx(row["mid_height_over_L"], rel=1e-14)
    assert equilibrium.energy_per_EI == pytest.approx(row["energy_L_over_EI"], rel=1e-14)
    assert equilibrium.start.force_per_EI[0] / PCR == pytest.approx(row["P_over_Pcr"], rel=1e-14)
    middle = solution.position(0.5)[0]
    assert middle[2] == pytest.approx(row["mid_height_over_L"], rel=1e-14)
    assert middle[0] == pytest.approx(row["chord_over_L"] / 2, abs=1e-15)
    assert solution.residual < 1e-15
    crossed = row["end_angle_deg"] > 130.7099107
    assert bool(solution.stability.stable_in_plane) is not crossed


@pytest.mark.parametrize("exponent", [2, 4, 6, 8, 10, 12, 14, 16])
def test_hair_of_slack(exponent: int) -> None:
    """The excess given exactly, as a slack: (L - d)/d = e/(1 - e) for e = 1 - d/L."""
    exact = SPECIAL[f"pinned slack 1e-{exponent}"]
    excess = 10.0**-exponent
    solved = solve_pinned({"slack": excess / (1.0 - excess), "length": 1.0})
    assert solved.arch.m == pytest.approx(float(exact["m"]), rel=4e-14)
    assert solved.datum("rise") == pytest.approx(float(exact["mid_height_over_L"]), rel=2e-14)
    assert solved.omega**2 / PCR == pytest.approx(float(exact["P_over_Pcr"]), rel=1e-15)
    assert solved.arch.angle == pytest.approx(float(exact["end_angle_rad"]), rel=2e-14)


@pytest.mark.parametrize("ratio", ["-0.5", "-0.9", "-0.99"])
def test_long_loops(ratio: str) -> None:
    exact = SPECIAL[f"pinned d/L={ratio}"]
    solved = solve_pinned({"length": 1.0, "chord": float(ratio)})
    assert solved.omega**2 / PCR == pytest.approx(float(exact["P_over_Pcr"]), rel=1e-13)


def test_figure_eight_and_highest_arch() -> None:
    assert pytest.approx(float(SPECIAL["figure-eight m (2E=K)"]), rel=4e-16) == FIGURE_EIGHT.m
    assert math.degrees(FIGURE_EIGHT.angle) == pytest.approx(float(SPECIAL["figure-eight beta0 deg"]), rel=1e-15)
    closed = solve_pinned({"length": 1.0, "chord": 0.0})
    assert closed.omega**2 / PCR == pytest.approx(float(SPECIAL["figure-eight P/Pcr (pinned,d=0)"]), rel=1e-14)
    assert closed.arch.energy_ratio == pytest.approx(float(SPECIAL["pinned d=0 energy*L/EI"]), rel=1e-14)
    assert pytest.approx(float(SPECIAL["max mid height m"]), rel=4e-16) == HIGHEST.m
    assert HIGHEST.size("rise") / HIGHEST.size("length") == pytest.approx(float(SPECIAL["max mid height/L"]), rel=1e-15)
