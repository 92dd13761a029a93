"""Table 1 of the paper done right: E = 3.89e9 N/m^2, Poisson's ratio 0.25, diameter 4 mm, length 350 mm.

The table's forces, 4.75e-3 N and 9.5e-3 N, are far below the Euler load of this cable, 3.93843 N: under them it stays
straight. What the end angle asks for is computed here once more with mpmath and compared with the figures worked out
beforehand.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from oracle import PinnedOracle

from cablecad.errors import InfeasibleError
from cablecad.model import Cable, Material, Pin, Section, Toward
from cablecad.rod.solve import solve_rod

PVC = Material(youngs_modulus=3890.0, poissons_ratio=0.25)


def table_1(**data):
    return Cable("table 1", 4.0, Pin((0, 0, 0)), Toward((1, 0, 0)), length=350.0, material=PVC, **data)


def test_stiffness_and_euler_load() -> None:
    bending = PVC.EI(Section(4.0))
    assert bending == pytest.approx(48883.18, abs=5e-3)
    assert PVC.GJ(Section(4.0)) == pytest.approx(39106.5, abs=0.05)
    assert bending * (math.pi / 350.0) ** 2 == pytest.approx(3.93843, abs=5e-6)


@pytest.mark.parametrize(
    ("angle", "force", "chord", "rise", "bend_radius"),
    [(20.0, 3.999069, 339.40582, 38.39728, 318.34647), (40.0, 4.189163, 308.42123, 73.89206, 157.91901)],
)
def test_end_angle(angle: float, force: float, chord: float, rise: float, bend_radius: float) -> None:
    solution = solve_rod(table_1(angle_deg=angle))
    oracle = PinnedOracle(350.0, angle_deg=angle).data
    start, end = solution.equilibrium.start, solution.equilibrium.end
    found = solution.EI * start.force_per_EI
    # The figures as published, to their digits, and mpmath to rounding.
    assert found[0] == pytest.approx(force, abs=6e-7)
    assert solution.chord == pytest.approx(chord, abs=6e-6)
    assert solution.rise == pytest.approx(rise, abs=6e-6)
    assert solution.bend_radius_min == pytest.approx(bend_radius, abs=6e-6)
    assert found[0] == pytest.approx(float(oracle["force"]) * solution.EI, rel=1e-14)
    assert solution.chord == pytest.approx(float(oracle["chord"]), rel=1e-14)
    assert solution.rise == pytest.approx(float(oracle["rise"]), rel=1e-14)
    # The supports push towards each other, balance, and hold no moment: M0 + M1 + (r1 - r0) x F1 = 0.
    np.testing.assert_array_equal(start.force_per_EI + end.force_per_EI, 0.0)
    np.testing.assert_array_equal(np.cross(end.position - start.position, end.force_per_EI), 0.0)
    np.testing.assert_array_equal([start.moment_per_EI, end.moment_per_EI], 0.0)
    assert solution.stability.stable_in_plane
    assert solution.stability.stable_out_of_plane


@pytest.mark.parametrize("force", [4.75e-3, 9.5e-3])
def test_printed_forces_do_not_bend_it(force: float) -> None:
    with pytest.raises(InfeasibleError, match=r"Euler load 3\.93843"):
        solve_rod(table_1(force=force))
