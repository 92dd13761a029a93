"""Cables between clamps and pins: planes, lead-outs, twins, lists, certificates, refusals."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

from cablecad.errors import InfeasibleError, NotPlanarError, SceneError, UsageError
from cablecad.model import Cable, Clamp, EquilibriumKey, Material, Pin, Port
from cablecad.rod.quadrature import integrate_tangent
from cablecad.rod.solve import solve_many, solve_rod

UP = (0, 0, 1)


def ports(**more) -> Cable:
    """The cable of the scene format: two connectors facing up, 120 mm apart."""
    given = {"start": Port((0, 0, 0), UP), "end": Port((0, 120, 0), UP), "length": 350.0} | more
    return Cable("W1", 4.0, **given)


SHAPES = {
    "ports": ports(),
    "lead-outs": ports(start=Port((0, 0, 0), UP, straight=20.0), end=Port((0, 120, 0), UP, straight=35.0)),
    "S": Cable("S", 1.0, Clamp((0, 0, 0), (1, 0, 0)), Clamp((60, 30, 0), (1, 0, 0)), length=100.0),
    "clamp-pin": Cable("cp", 1.0, Clamp((5, 5, 5), (1, 2, 3)), Pin((40, 0, 20)), length=70.0),
    "pin-clamp": Cable("pc", 1.0, Pin((40, 0, 20)), Clamp((5, 5, 5), (1, 2, 3)), length=70.0),
    "ring": Cable("ring", 1.0, Clamp((1, 2, 3), (1, 0, 0)), Clamp((1, 2, 3), (1, 0, 0)), length=100.0),
    "circle": Cable("half", 1.0, Clamp((0, 0, 0), (1, 0, 0)), Clamp((0, 200 / math.pi, 0), (-1, 0, 0)), length=100.0),
    "taut": Cable("taut", 1e-3, Clamp((0, 0, 0), (1, 0.4, 0)), Clamp((100, 0, 0), (1, 0.2, 0)), length=100.01),
    "coincident": Cable("co", 1.0, Clamp((0, 0, 0), (1, 0, 0)), Clamp((0, 0, 0), (-1, 0, 0)), length=100.0),
}


@pytest.mark.parametrize("name", SHAPES)
def test_certificates(name: str) -> None:
    """Of the delivered centreline of every equilibrium, by means the solver does not share."""
    cable = SHAPES[name]
    solution = solve_rod(cable)
    assert solution.residual <= 1e-12
    length = solution.length
    ends = [np.array(cable.start_support.position), np.array(cable.end_support.position)]
    for equilibrium in solution.equilibria:
        centreline, start, end = equilibrium.centreline, equilibrium.start, equilibrium.end
        assert centreline.length == pytest.approx(length, rel=1e-15)
        # Positions and tangents at the supports.
        found = centreline.position([0.0, centreline.length])
        np.testing.assert_allclose(found, ends, atol=1e-12 * (length + np.abs(ends).max()))
        for support, tangent in ((cable.start_support, start.direction), (cable.end_support, end.direction)):
            if isinstance(support, Clamp):
                wanted = np.array(support.direction) / np.linalg.norm(support.direction)
                np.testing.assert_allclose(tangent, wanted, atol=2e-12)
        # Supports balance, each moment about its own end.
        size = np.linalg.norm(start.force_per_EI) + 1.0 / length**2
        np.testing.assert_allclose(start.force_per_EI + end.force_per_EI, 0.0, atol=1e-14 * size)
        torque = np.cross(end.position - start.position, end.force_per_EI)
        total = start.moment_per_EI + end.moment_per_EI + torque
        np.testing.assert_allclose(total, 0.0, atol=1e-11 * size * length)
        # kappa^2/2 + n.t is constant along the free part.
        lead = [getattr(s, "straight", 0.0) for s in (cable.start_support, cable.end_support)]
        s = np.linspace(lead[0], length - lead[1], 203)[1:-1]
        integral = centreline.curvature(s) ** 2 / 2 + centreline.tangent(s) @ end.force_per_EI
        np.testing.assert_allclose(integral, integral[0], atol=1e-11 * (size + np.abs(integral).max()))
        # Positions are the integral of the tangent, by Gauss's rule in the plane's own axes.
        e1 = centreline.tangent(lead[0])[0]
        e2 = centreline.normal(lead[0])[0]

        def angle(at, centreline=centreline, e1=e1, e2=e2):
            tangent = centreline.tangent(np.ravel(at))
            return np.reshape(np.arctan2(tangent @ e2, tangent @ e1), np.shape(at))

        # Neighbouring arclengths: a layer of a taut cable lies within the first of them.
        stops = np.unique(
            np.concatenate(
                [
                    np.linspace(lead[0], length - lead[1], 41),
                    lead[0] + length * np.geomspace(1e-9, 0.02, 40),
                    length - lead[1] - length * np.geomspace(1e-9, 0.02, 40),
                ]
            )
        )
        steps = np.array([integrate_tangent(angle, np.array([a, b]))[1] for a, b in pairwise(stops)])
        path = centreline.position(stops)
        integrated = path[0] + np.concatenate([[[0, 0]], np.cumsum(steps, axis=0)]) @ np.stack([e1, e2])
        np.testing.assert_allclose(integrated, path, atol=1e-11 * length)


def test_moment_is_minus_curvature_at_the_start() -> None:
    """start.moment = -EI kappa(0) b and end.moment = +EI kappa(L) b, with force -n and +n."""
    solution = solve_rod(SHAPES["S"])
    s = np.array([0.0, solution.length])
    kappa, b = solution.curvature(s), solution.centreline.binormal(s)
    state = solution.equilibrium
    np.testing.assert_allclose(state.start.moment_per_EI, -kappa[0] * b[0], atol=1e-15)
    np.testing.assert_allclose(state.end.moment_per_EI, kappa[1] * b[1], atol=1e-15)
    # kappa' = -n x t about b: the sign of the force.
    slope = solution.curvature(0.0, derivative=1)[0]
    n, t = state.end.force_per_EI, state.start.direction
    assert slope == pytest.approx(float(n @ np.cross(t, b[0])), rel=1e-9)


def test_bulge_chooses_between_twins() -> None:
    """Aligned clamps leave the plane and the side open; offset ones only the order of an S."""
    start = Clamp((0, 0, 0), (1, 0, 0))
    for bulge in ((0, 1, 0), (0, 0, -1), (0, -3, 4)):
        cable = Cable("c", 1.0, start, Clamp((80, 0, 0), (1, 0, 0)), length=100.0, bulge=bulge)
        solution = solve_rod(cable)
        middle = solution.position(50.0)[0] - [40, 0, 0]
        np.testing.assert_allclose(middle / np.linalg.norm(middle), np.array(bulge) / np.linalg.norm(bulge), atol=1e-9)
        assert "bulge decided" in solution.reason
    for sign in (1, -1):
        cable = Cable("S", 1.0, start, Clamp((60, 30, 0), (1, 0, 0)), length=100.0, bulge=(0, sign, 0))
        solution = solve_rod(cable)
        across = np.array([-30, 60, 0]) / math.hypot(30, 60)
        middle = (solution.position(50.0)[0] - [30, 15, 0]) @ across
        quarter = (solution.position(25.0)[0] - [30, 15, 0]) @ across
        assert (middle if abs(middle) > 1e-9 else quarter) * sign > 0
        first, second = solution.equilibria[:2]
        assert first.energy_per_EI == pytest.approx(second.energy_per_EI, rel=1e-12)


def test_bulge_along_the_chord_is_a_scene_error() -> None:
    with pytest.raises(SceneError, match="parallel to the chord"):
        solve_rod(ports(bulge=(0, 5, 0)))


def test_equilibria_are_listed_stable_first_by_energy() -> None:
    solution = solve_rod(ports(), search="wide")
    stable = [bool(e.stability.stable_in_plane) for e in solution.equilibria]
    assert stable == sorted(stable, reverse=True)
    energies = [e.energy_per_EI for e, s in zip(solution.equilibria, stable, strict=True) if s]
    assert all(after >= before * (1 - 1e-12) for before, after in pairwise(energies))  # twins differ by rounding
    assert len(energies) >= 5
    assert {e.winding for e in solution.equilibria} >= {-1, 0, 1}
    narrow = solve_rod(ports())
    assert narrow.equilibrium.energy_per_EI == pytest.approx(solution.equilibrium.energy_per_EI, rel=1e-13)


def test_equilibrium_by_index_and_by_key() -> None:
    wide = solve_rod(ports(), search="wide")
    second = solve_rod(ports(equilibrium=1))
    assert second.equilibrium.energy_per_EI == pytest.approx(wide.equilibria[1].energy_per_EI, rel=1e-12)
    key = EquilibriumKey(second.equilibrium.winding, second.equilibrium.side)
    assert solve_rod(ports(equilibrium=key)).equilibrium.energy_per_EI == pytest.approx(
        second.equilibrium.energy_per_EI, rel=1e-12
    )
    with pytest.raises(SceneError, match="no such equilibrium"):
        solve_rod(ports(equilibrium=EquilibriumKey(7, 1)))
    with pytest.raises(SceneError, match="counted from 0"):
        solve_rod(ports(equilibrium=99))


def test_out_of_plane_instability_is_a_warning_with_its_cause() -> None:
    """The hook is stable in its plane and leaves it, at GJ/EI = 0.8."""
    hook = Cable(
        "hook",
        1e-2,
        Clamp((0, 0, 0), (0, 1, 0)),
        Clamp((1, 0, 0), (1, 1, 0)),
        length=2.0,
        material=Material(bending_stiffness=1.0, torsional_stiffness=0.8),
    )
    solution = solve_rod(hook)
    assert solution.stability.stable_in_plane
    assert not solution.stability.stable_out_of_plane
    assert any("leaving the plane" in warning and "held by both ends" in warning for warning in solution.warnings)


@pytest.mark.parametrize("straight", [0.0, 12.0])
def test_slightly_out_of_plane_is_projected_and_reported(straight: float) -> None:
    off = 4e-7
    cable = ports(start=Port((0, 0, 0), (off, 0, 1), straight=straight), end=Port((0, 120, 0), UP, straight=straight))
    solution = solve_rod(cable)
    assert solution.out_of_plane_deg == pytest.approx(math.degrees(off), rel=0.6)
    assert solution.residual <= 1e-12
    with pytest.raises(NotPlanarError, match="do not lie in one plane"):
        solve_rod(ports(start=Port((0, 0, 0), (1e-5, 0, 1))))


def test_lead_outs_count_in_the_length_and_are_straight() -> None:
    solution = solve_rod(SHAPES["lead-outs"])
    np.testing.assert_allclose(solution.centreline.breaks, [0, 20, 315, 350])
    np.testing.assert_allclose(solution.position([0, 10, 20]), [[0, 0, 0], [0, 0, 10], [0, 0, 20]], atol=1e-12)
    np.testing.assert_array_equal(solution.curvature([5.0, 340.0]), 0.0)
    free = solve_rod(Cable("f", 4.0, Port((0, 0, 20), UP), Port((0, 120, 35), UP), length=295.0))
    np.testing.assert_allclose(solution.position(np.linspace(20, 315, 9)), free.points(9), atol=1e-9)


def test_lead_outs_that_leave_nothing_are_infeasible() -> None:
    with pytest.raises(InfeasibleError, match="leave nothing"):
        solve_rod(ports(start=Port((0, 0, 0), UP, straight=200.0), end=Port((0, 120, 0), UP, straight=150.0)))
    with pytest.raises(InfeasibleError, match="less than the distance it has to span"):
        solve_rod(ports(start=Port((0, 0, 0), (0, -1, 0), straight=150.0), length=380.0))


def test_slack_is_the_primary_datum() -> None:
    """A hair of slack given as such reaches shapes that positions and length cannot tell."""
    start, end = Clamp((1e3, 0, 0), (1, 0, 0)), Clamp((1.1e3, 0, 0), (1, 0, 0))
    for slack in (1e-6, 1e-9, 1e-12):
        solution = solve_rod(Cable("c", 1e-3, start, end, slack=slack))
        assert solution.slack == slack
        # Clamped buckling: rise = (2/pi) L sqrt(slack) to first order.
        assert solution.rise == pytest.approx(100.0 * 2 / math.pi * math.sqrt(slack), rel=3e-3)


def test_many_solves_all_kinds_together_and_carries_errors() -> None:
    cables = [*SHAPES.values(), ports(length=100.0), ports(start=Pin((0, 0, 0)), end=Pin((0, 120, 0)))]
    results = solve_many(cables)
    assert isinstance(results[-2], InfeasibleError)
    for cable, result in zip(cables, results, strict=True):
        if not isinstance(result, InfeasibleError):
            assert result.equilibrium.energy_per_EI == pytest.approx(
                solve_rod(cable).equilibrium.energy_per_EI, rel=1e-9, abs=1e-16
            )


def aligned(**more) -> Cable:
    given = {"start": Clamp((0, 0, 0), (1, 0, 0)), "end": Clamp((100, 0, 0), (1, 0, 0)), "length": 100.0} | more
    return Cable("c", 1.0, **given)


@pytest.mark.parametrize(("straights", "good"), [((60.0, 60.0), False), ((150.0, 0.0), False), ((60.0, 40.0), True)])
def test_straight_lengths_beyond_a_straight_cable(straights, good) -> None:
    cable = aligned(
        start=Clamp((0, 0, 0), (1, 0, 0), straight=straights[0]),
        end=Clamp((100, 0, 0), (1, 0, 0), straight=straights[1]),
    )
    if good:
        assert solve_rod(cable).model == "straight"
    else:
        with pytest.raises(InfeasibleError, match="held by the connectors"):
            solve_rod(cable)


@pytest.mark.parametrize("wanted", [1, 5, EquilibriumKey(1, -1), EquilibriumKey(0, 1)])
def test_a_straight_cable_has_one_equilibrium(wanted) -> None:
    with pytest.raises(SceneError, match="equilibrium"):
        solve_rod(aligned(equilibrium=wanted))
    assert solve_rod(aligned(equilibrium=0)).index == 0


def test_axes_of_any_length_along_a_line() -> None:
    solution = solve_rod(aligned(start=Clamp((0, 0, 0), (1e-170, 0, 0)), end=Clamp((100, 0, 0), (1e-170, 1e-180, 0))))
    assert solution.residual == pytest.approx(1e-10, rel=1e-3)


@pytest.mark.parametrize("slack", [1e-8, 1e-10, 1e-13, 1e-16])
@pytest.mark.parametrize("tilt", [1e-8, 3e-7, 9e-7])
def test_what_a_hair_of_slack_leaves_of_the_plane(slack, tilt) -> None:
    """Clamps tilted within a plane by next to nothing: where that shows in the shape, they decide, not the bulge."""
    start, end = Clamp((0, 0, 0), (1, tilt, 0)), Clamp((100, 0, 0), (1, -tilt, 0))
    free, given = (
        solve_rod(Cable("c", 1.0, start, end, slack=slack, bulge=bulge)).equilibrium.energy_per_EI
        for bulge in (None, (0, 1, 0))
    )
    assert free == pytest.approx(given, rel=4e-3)


def test_bulge_along_the_tangent_of_coincident_ends() -> None:
    place = (5.0, 5.0, 5.0)
    cable = Cable("c", 1.0, Clamp(place, (0, 1, 0)), Clamp(place, (0, 1, 0)), length=100.0, bulge=(0, 1, 0))
    with pytest.raises(SceneError, match="parallel to the tangent of the ends, which coincide"):
        solve_rod(cable)


@pytest.mark.parametrize("turn", np.linspace(0.0, 6.0, 12))
def test_a_semicircle_is_a_circle_however_it_lies(turn) -> None:
    cosine, sine, size = math.cos(turn), math.sin(turn), 17.3 * (1.0 + turn)
    end = (2.0 * size / math.pi * cosine, 2.0 * size / math.pi * sine, 0.0)
    clamps = Clamp((0, 0, 0), (-sine, cosine, 0)), Clamp(end, (sine, -cosine, 0))
    assert solve_rod(Cable("c", 0.1, *clamps, length=size)).equilibrium.branch == "circle"


@pytest.mark.parametrize("slack", [1e-20, 1e-59, 1e-61, 1e-99])
@pytest.mark.parametrize("held", [True, False])
def test_a_hair_of_slack_is_as_stable_as_a_straight_cable(slack, held) -> None:
    """The buckled beam: its margins tend to (k pi)^2 - (j pi)^2 of the modes k above its own, j."""
    ends = [Clamp((0, y, 0), (0, 1, 0)) if held else Pin((0, y, 0)) for y in (0, 120)]
    solution = solve_rod(Cable("c", 4.0, *ends, slack=slack))
    # Between clamps the antisymmetric mode, tan(x) = x, is next; between pins the second.
    margin = 4.0 * (4.493409457909064**2 - math.pi**2) if held else 3.0 * math.pi**2
    assert solution.stability.in_plane == pytest.approx(margin, rel=1e-6)
    assert solution.stability.stable_out_of_plane


def test_slack_beyond_what_can_be_computed_with_is_refused() -> None:
    ends = Pin((0, 0, 0)), Pin((0, 1e60, 0))
    for slack in (1e-150, 1e154, 1e200):
        with pytest.raises(SceneError, match=r"slack = .*must be 0 or between"):
            Cable("c", 4.0, *ends, slack=slack)
    with pytest.raises(SceneError, match=r"slack = .*longer than the 1e"):
        solve_rod(Cable("c", 4.0, *ends, slack=1e60))


def test_an_unknown_search_is_refused() -> None:
    with pytest.raises(UsageError, match="no search 'Wide'; take one of answer, wide"):
        solve_rod(Cable("c", 4.0, Pin((0, 0, 0)), Pin((0, 90, 0)), length=100.0), search="Wide")  # type: ignore[arg-type]


def test_a_clamp_turned_backwards_may_turn_about_the_pull() -> None:
    """Of a taut cable such a layer costs the same in any plane: no margin, however the cable is turned round."""
    gap, first, last = 100.0 * 0.999999999951528, 1.570796411283643, 3.141592653576694
    one, other = ((math.cos(angle), math.sin(angle), 0.0) for angle in (first, last))
    back_one, back_other = ((-x, -y, 0.0) for x, y, _ in (one, other))
    there = Clamp((0, 0, 0), one), Clamp((gap, 0, 0), other)
    back = Clamp((gap, 0, 0), back_other), Clamp((0, 0, 0), back_one)
    for ends in (there, back):
        found = solve_rod(Cable("c", 0.4, *ends, length=100.0, bulge=(0.3, 1, 0))).stability
        assert found.out_of_plane == 0.0
        assert not found.stable_out_of_plane
        assert found.stable_in_plane


def test_a_length_below_rounding_is_refused() -> None:
    place = Pin((1000, 0, 0))
    with pytest.raises(InfeasibleError, match="less than numbers tell apart"):
        solve_rod(Cable("c", 1e-3, place, place, length=6e-15))
