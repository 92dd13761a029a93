"""Self-gaps and margins of many equilibria together: the same as of each alone."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cablecad.model import Cable, Clamp, Material, Pin
from cablecad.rod.room import judge_together, measure_gaps
from cablecad.rod.solution import RodSolution
from cablecad.rod.solve import solve_many
from cablecad.rod.stability import stability
from cablecad.self_gap import self_gap

MATERIAL = Material(youngs_modulus=1000.0, poissons_ratio=0.25)


def cables(count: int, seed: int) -> list[Cable]:
    """Clamps and pins, loops and hairs of slack, thin and thick, with and without lead-outs."""
    rng = np.random.default_rng(seed)
    made = []
    for i in range(count):
        ratio = rng.uniform(0.0, 0.999) if i % 5 else 1.0 - 10.0 ** rng.uniform(-6.0, -2.0)
        toward, a, b = rng.uniform(-math.pi, math.pi, 3)
        place = (100.0 * ratio * math.cos(toward), 100.0 * ratio * math.sin(toward), 0.0)
        straight = 3.0 if i % 7 == 3 and ratio < 0.8 else 0.0
        start = Clamp((0.0, 0.0, 0.0), (math.cos(a), math.sin(a), 0.0), straight)
        end = Clamp(place, (math.cos(b), math.sin(b), 0.0)) if i % 3 else Pin(place)
        diameter = float(10.0 ** rng.uniform(-2.0, 1.3))
        made.append(Cable(f"W{i}", diameter, start, end, length=100.0, material=MATERIAL, bulge=(1e-3, 1.0, 0.0)))
    return made


@pytest.fixture(scope="module")
def solved() -> list[RodSolution]:
    return [one for one in solve_many(cables(80, 3), search="wide") if isinstance(one, RodSolution)]


def test_gaps_are_those_of_each_alone(solved: list[RodSolution]) -> None:
    equilibria = [one for solution in solved for one in solution.equilibria]
    measure_gaps(equilibria)
    measured = [one for one in equilibria if "self_gap" in one.__dict__]
    assert len(measured) > 200
    assert any(len(one.centreline.pieces) > 1 for one in measured)
    for one in measured:
        alone = self_gap(one.centreline, one.diameter / 2.0)
        if alone is None:
            assert one.self_gap is None
        else:
            # Families of one distance are left within a thousandth of it.
            assert one.self_gap == pytest.approx(alone, abs=1e-9 * 100.0 + 1e-3 * (alone + one.diameter))
    exact = sum(
        one.self_gap is not None and abs(one.self_gap - self_gap(one.centreline, one.diameter / 2.0)) < 1e-9
        for one in measured
    )
    assert exact > 0.95 * sum(one.self_gap is not None for one in measured)
    assert {one.self_gap is None for one in measured} == {True, False}
    assert any(one.self_gap is not None and one.self_gap < 0.0 for one in measured)


def test_margins_are_those_of_each_alone() -> None:
    first, second = (solve_many(cables(30, 4)) for _ in range(2))
    together = [one for solution in first if isinstance(solution, RodSolution) for one in solution.equilibria]
    judge_together(together)
    alone = [one for solution in second if isinstance(solution, RodSolution) for one in solution.equilibria]
    assert len(together) == len(alone) > 50
    for one, other in zip(together, alone, strict=True):
        assert one.trace is not None
        assert not np.isnan(one.trace.row.margins).any()
        size = 1.0 + one.trace.row.omega[0] ** 2
        assert one.stability.in_plane == pytest.approx(other.stability.in_plane, rel=1e-6, abs=1e-6 * size)
        assert one.stability.out_of_plane == pytest.approx(other.stability.out_of_plane, rel=1e-6, abs=1e-6 * size)
        assert one.stability.stable_in_plane == other.stability.stable_in_plane
        assert one.stability.free_turn == other.stability.free_turn


def test_tangents_are_those_of_the_shapes(solved: list[RodSolution]) -> None:
    """Of one regime, and of all with taut ones among them."""
    s = np.linspace(0.0, 1.0, 41)
    found = solved[0].equilibria[0].trace
    assert found is not None
    assert found.among.taut.any()
    for rows in (found.among, found.among.take(~found.among.taut)):
        theta, kappa, _ = rows.at(s)
        cosine, sine, bent = rows.tangents(s)
        size = (1.0 + rows.omega + rows.kappa_max)[:, None]
        assert np.max(np.abs(cosine - np.cos(theta)) / size) < 1e-13
        assert np.max(np.abs(sine - np.sin(theta)) / size) < 1e-13
        assert np.max(np.abs(bent - kappa) / size**2) < 1e-13


def test_the_least_bend_radius_is_known_without_drawing(solved: list[RodSolution]) -> None:
    for solution in solved:
        for one in solution.equilibria:
            drawn = one.centreline.greatest_curvature()[0]
            assert one.bend_radius_min == pytest.approx(1.0 / drawn, rel=1e-9)


def test_a_single_one_is_measured_in_its_plane() -> None:
    for solution in solve_many(cables(20, 9)):
        assert isinstance(solution, RodSolution)
        one = solution.equilibrium
        assert one.trace is not None
        gap = one.self_gap
        assert ("shape" in one.__dict__) == one.trace.is_taut  # else nothing is drawn for it
        alone = self_gap(one.centreline, one.diameter / 2.0)
        assert gap == (None if alone is None else pytest.approx(alone, abs=1e-9 * 100.0))


def test_a_long_loop_is_judged_on_panels() -> None:
    """Ends drawn far past each other: the pendulum nearly stands, and the loop takes a tenth of the length."""
    loop = Cable("loop", 0.1, Clamp((0, 0, 0), (1, 0, 0)), Clamp((-93.0, 0, 0), (1, 0, 0)), length=100.0)
    straightened = Cable("arc", 0.1, Clamp((0, 0, 0), (1, 0, 0)), Clamp((93.0, 0, 0), (1, 0, 0)), length=100.0)
    for cable in (loop, straightened):
        (solution,) = solve_many([cable], search="wide")
        assert isinstance(solution, RodSolution)
        for one in solution.equilibria:
            row = one.trace.row  # type: ignore[union-attr]
            if row.taut[0]:
                continue
            fine = stability(
                lambda s, row=row: row.at(np.atleast_1d(s))[0][0],
                lambda s, row=row: row.at(np.atleast_1d(s))[1][0],
                row.force[0],
                start_clamped=True,
                end_clamped=True,
            )
            size = 1.0 + max(row.omega[0], row.kappa_max[0] / 2.0) ** 2
            assert one.stability.in_plane == pytest.approx(float(fine.in_plane), abs=3e-6 * size)
            assert one.stability.out_of_plane == pytest.approx(float(fine.out_of_plane), abs=3e-6 * size)
