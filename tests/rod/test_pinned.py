"""The pinned cable in space: plane, twins, modes, wrenches, stability, refusals."""

from __future__ import annotations

import math

import numpy as np
import pytest
from oracle import PinnedOracle

from cablecad.errors import InfeasibleError, SceneError
from cablecad.model import Cable, Clamp, EquilibriumKey, Material, Pin, Toward
from cablecad.rod.solve import solve_rod


def pinned(**data) -> Cable:
    given = {"start": Pin((0, 0, 0)), "end": Pin((300, 0, 0)), "length": 350.0} | data
    return Cable("W1", 4.0, **given)


def test_points_against_mpmath() -> None:
    solution = solve_rod(pinned(end=Toward((1, 0, 0)), angle_deg=110.0))
    s = np.linspace(0, 350, 23)
    exact = PinnedOracle(350.0, angle_deg=110.0).points(s)
    found = solution.position(s)
    np.testing.assert_allclose(found[:, [0, 2]], exact, atol=350 * 1e-15)
    np.testing.assert_array_equal(found[:, 1], 0.0)
    np.testing.assert_allclose(solution.points(23), found, atol=0)


def test_default_bulge_is_up_and_x_for_a_vertical_chord() -> None:
    assert solve_rod(pinned()).position(175.0)[0, 2] > 50
    upright = solve_rod(pinned(end=Pin((0, 0, 300))))
    assert upright.position(175.0)[0, 0] > 50
    nearly = solve_rod(pinned(end=Pin((0.2, 0, 300))))  # within 1e-3 rad of Z
    assert nearly.position(175.0)[0, 0] > 50


@pytest.mark.parametrize("bulge", [(0, 1, 0), (1e6, 1, 0), (-5, 1e-3, 1e-3)])
def test_bulge_is_made_perpendicular(bulge) -> None:
    solution = solve_rod(pinned(bulge=bulge))
    side = np.array([0, bulge[1], bulge[2]], dtype=float)
    side /= np.linalg.norm(side)
    middle = solution.position(175.0)[0] - [150, 0, 0]
    np.testing.assert_allclose(middle, solution.rise * side, atol=1e-9)


def test_bulge_along_the_chord_is_refused() -> None:
    with pytest.raises(SceneError, match=r"bulge = \(-2.0, 0.0, 0.0\): is parallel to the chord"):
        solve_rod(pinned(bulge=(-2, 0, 0)))


def test_equilibria_are_modes_with_twins() -> None:
    solution = solve_rod(pinned())
    base = solution.equilibria[0]
    assert [(e.side, e.inflections) for e in solution.equilibria] == [(1, 0), (-1, 0), (1, 1), (-1, 1), (1, 2), (-1, 2)]
    for i, equilibrium in enumerate(solution.equilibria):
        mode = i // 2 + 1
        assert equilibrium.energy_per_EI == pytest.approx(mode**2 * base.energy_per_EI, rel=1e-14)
        assert equilibrium.bend_radius_min == pytest.approx(base.bend_radius_min / mode, rel=1e-14)
        assert bool(equilibrium.stability.stable_in_plane) is (mode == 1)
        # Every mode ends at the pin and its curvature changes sign as often as it says.
        np.testing.assert_allclose(equilibrium.centreline.position(350.0)[0], [300, 0, 0], atol=1e-12)
        inner = equilibrium.centreline.curvature(np.linspace(0, 350, 1000)[1:-1])
        assert np.count_nonzero(np.diff(np.sign(inner))) == equilibrium.inflections
        # Towards the bulge lies the middle, or where that is on the chord, the quarter point.
        lies = equilibrium.centreline.position([87.5 if mode == 2 else 175.0])[0, 2]
        assert np.sign(lies) == equilibrium.side
    for first in (0, 2, 4):
        up, down = (e.centreline.points(50) for e in solution.equilibria[first : first + 2])
        np.testing.assert_allclose(up * [1, 1, -1], down, atol=1e-12)


def test_equilibrium_is_chosen_by_index_and_by_key() -> None:
    for choice in (1, EquilibriumKey(0, -1)):
        solution = solve_rod(pinned(equilibrium=choice))
        assert solution.index == 1
        assert solution.position(175.0)[0, 2] < -50
    second = solve_rod(pinned(equilibrium=2))
    assert second.bend_radius_min == pytest.approx(solve_rod(pinned()).bend_radius_min / 2)
    assert any("unstable in its plane" in warning for warning in second.warnings)
    with pytest.raises(SceneError, match="only 6 equilibria"):
        solve_rod(pinned(equilibrium=6))
    with pytest.raises(SceneError, match="no such equilibrium"):
        solve_rod(pinned(equilibrium=EquilibriumKey(1, 1)))


@pytest.mark.parametrize("choice", range(6))
def test_wrench_balance_and_conserved_moment(choice: int) -> None:
    """Forces and moments balance, and the moment along the cable is the force's about the chord: M = F y."""
    solution = solve_rod(pinned(equilibrium=choice, bulge=(0, 1, 2), end=Pin((200, 100, -50))))
    start, end = solution.equilibrium.start, solution.equilibrium.end
    np.testing.assert_allclose(start.force_per_EI + end.force_per_EI, 0, atol=1e-20)
    torque = np.cross(end.position - start.position, end.force_per_EI)
    np.testing.assert_allclose(start.moment_per_EI + end.moment_per_EI + torque, 0, atol=1e-16)
    s = np.linspace(0, 350, 31)
    frames = solution.centreline.frames(s)
    bending = solution.curvature(s)[:, None] * frames.binormal  # internal moment per EI at the section
    # The part from s to the end is held by the section's moment -M(s), the end's force, and no end moment.
    lever = np.cross(end.position - frames.position, end.force_per_EI)
    np.testing.assert_allclose(bending, lever, atol=1e-14)


@pytest.mark.parametrize("angle", [10.0, 90.0, 130.0, 132.0, 160.0])
def test_first_integral(angle: float) -> None:
    """kappa^2 / 2 + n.t is constant along the delivered centreline."""
    solution = solve_rod(pinned(end=Toward((1, 0, 0)), angle_deg=angle))
    s = np.linspace(0, 350, 101)
    energy = solution.curvature(s) ** 2 / 2 + solution.tangent(s) @ solution.equilibrium.end.force_per_EI
    assert np.ptp(energy) <= 1e-14 * np.linalg.norm(solution.equilibrium.end.force_per_EI)


def test_crossed_ends_warn_and_are_unstable() -> None:
    solution = solve_rod(pinned(end=Toward((1, 0, 0)), angle_deg=150.0))
    assert solution.chord < 0
    assert solution.slack is None
    assert not solution.stability.stable_in_plane
    assert not solution.stability.stable_out_of_plane
    assert any("ends have crossed" in warning for warning in solution.warnings)
    assert [violation.rule for violation in solution.violations] == ["self_gap"]
    np.testing.assert_allclose(solution.position(350.0)[0], [solution.chord, 0, 0], atol=1e-12)


@pytest.mark.parametrize(("angle", "margin"), [(130.0, 0.18), (132.0, -0.30), (160.0, -1.12)])
def test_published_margins(angle: float, margin: float) -> None:
    solution = solve_rod(pinned(end=Toward((1, 0, 0)), angle_deg=angle))
    assert solution.stability.in_plane == pytest.approx(margin, abs=5e-3)


def test_material_gives_forces_and_gravity_warning() -> None:
    plain = solve_rod(pinned())
    assert (plain.EI, plain.GJ, plain.energy, plain.weight_ratio) == (None,) * 4
    heavy = solve_rod(pinned(material=Material(bending_stiffness=1000.0, mass_per_length=0.05)))
    weight = 0.05 * 9.80665 / 1000
    assert heavy.weight_ratio == pytest.approx(weight * 350**3 / 1000)
    assert any("gravity is not modelled" in warning for warning in heavy.warnings)
    assert heavy.energy == pytest.approx(1000 * plain.equilibrium.energy_per_EI)


def test_ends_at_one_point() -> None:
    solution = solve_rod(pinned(end=Pin((0, 0, 0)), allow_contact=True))
    assert solution.end_angle_deg == pytest.approx(130.70991070789999)
    assert solution.residual < 1e-15
    assert solution.slack is None


@pytest.mark.parametrize("offset", [0.0, 1.0, 1e5])
def test_straight(offset: float) -> None:
    solution = solve_rod(pinned(start=Pin((offset, 0, 0)), end=Pin((offset + 350.0, 0, 0))))
    assert solution.model == "straight"
    assert solution.bend_radius_min is None
    assert solution.bend_radius_min_at is None
    np.testing.assert_allclose(solution.points(3)[1], [offset + 175, 0, 0])
    clamped = pinned(start=Clamp((0, 0, 0), (1, 0, 0)), end=Clamp((350, 0, 0), (2, 0, 0)))
    assert solve_rod(clamped).model == "straight"


def test_straight_but_not_aligned_is_infeasible() -> None:
    with pytest.raises(InfeasibleError, match="its end is 90 degrees off"):
        solve_rod(pinned(start=Clamp((0, 0, 0), (1, 0, 0)), end=Clamp((350, 0, 0), (0, 1, 0))))
    with pytest.raises(InfeasibleError, match="has no rise"):
        solve_rod(pinned(end=Pin((350, 0, 0)), rise=10.0))


def test_too_short() -> None:
    with pytest.raises(InfeasibleError, match="50 mm less than the distance of the ends, 400 mm"):
        solve_rod(pinned(end=Pin((400, 0, 0))))


def test_chord_against_positions() -> None:
    with pytest.raises(SceneError, match="300 mm apart"):
        solve_rod(pinned(chord=301.0))
    assert solve_rod(pinned(chord=300.0)).residual < 1e-15


@pytest.mark.parametrize("angle", [1e-6, 1e-3, 1.0, 90.0, 179.0, 179.9])
def test_end_angles_of_the_whole_range(angle: float) -> None:
    solution = solve_rod(pinned(end=Toward((0, 1, 0)), angle_deg=angle))
    tangent = solution.tangent(0.0)[0]
    assert math.degrees(math.atan2(tangent[2], tangent[1])) == pytest.approx(angle, rel=1e-9)
    assert solution.residual < 1e-15
    oracle = PinnedOracle(350.0, angle_deg=angle).data
    assert solution.rise == pytest.approx(float(oracle["rise"]), rel=1e-14)
    assert solution.position(175.0)[0, 2] == pytest.approx(float(oracle["rise"]), rel=1e-9, abs=1e-13)


@pytest.mark.parametrize("chord", [1e-2, 1e-6, 1e-10, 1e-12, 1e-14])
def test_slack_of_a_cable_much_longer_than_its_chord(chord: float) -> None:
    ends = {"start": Pin((0, 0, 0)), "end": Pin((chord, 0, 0))}
    by_slack = solve_rod(Cable("c", 1.0, slack=100.0 / chord, **ends))
    by_length = solve_rod(Cable("c", 1.0, length=chord + 100.0, **ends))
    assert by_slack.residual < 1e-12
    assert by_slack.slack == 100.0 / chord
    assert by_slack.length == pytest.approx(by_length.length, rel=1e-14)
    assert by_slack.bend_radius_min == pytest.approx(by_length.bend_radius_min, rel=1e-9)
    middle = np.linspace(0.0, 100.0, 9)
    assert np.abs(by_slack.position(middle) - by_length.position(middle)).max() < 1e-9
