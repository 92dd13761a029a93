"""Twins are found, nothing else is taken for one, and what is found once for both is what each would give alone."""

from __future__ import annotations

import numpy as np
import pytest

from cablecad.model import Cable, Clamp, Material, Pin
from cablecad.rod.room import judge_together, measure_gaps
from cablecad.rod.solution import Equilibrium, RodSolution
from cablecad.rod.solve import solve_many
from cablecad.rod.trace import gathered
from cablecad.rod.twins import first_twins
from cablecad.self_gap import self_gap

MATERIAL = Material(youngs_modulus=1000.0, poissons_ratio=0.25)


def side_by_side(length: float, lead_out: float = 15.0, lead_in: float = 15.0) -> Cable:
    """Connectors facing one way: a loop thrown over the start is the one over the end, run through backwards.

    The free ends stand level whatever the straights are.
    """
    start = Clamp((15.0 - lead_out, 0.0, 0.0), (1.0, 0.0, 0.0), lead_out)
    end = Clamp((15.0 - lead_in, 120.0, 0.0), (-1.0, 0.0, 0.0), lead_in)
    return Cable("W", 4.0, start, end, length=length + lead_out + lead_in, material=MATERIAL)


def in_a_row(lead_in: float, *, pinned: bool = False) -> Cable:
    """Connectors facing each other: the cable bulges to either side, a mirror image."""
    end = Pin((80.0 + lead_in, 0.0, 0.0)) if pinned else Clamp((80.0 + lead_in, 0.0, 0.0), (1.0, 0.0, 0.0), lead_in)
    return Cable("W", 1.0, Clamp((0.0, 0.0, 0.0), (1.0, 0.0, 0.0)), end, length=100.0 + lead_in, material=MATERIAL)


def equilibria(*cables: Cable) -> list[Equilibrium]:
    solved = [one for one in solve_many(cables, search="wide") if isinstance(one, RodSolution)]
    assert len(solved) == len(cables)
    return [one for solution in solved for one in solution.equilibria]


def first(some: list[Equilibrium]) -> list[int]:
    traces = [one.trace for one in some if one.trace is not None]
    assert len(traces) == len(some)
    return first_twins(traces, gathered(traces)).tolist()


def twins(some: list[Equilibrium]) -> list[tuple[Equilibrium, Equilibrium]]:
    return [(some[i], some[j]) for i, j in enumerate(first(some)) if i != j]


def assert_one_by_one(some: list[Equilibrium], others: list[Equilibrium]) -> None:
    """What was found together of some is what each of the same others gives alone."""
    measure_gaps(some)
    judge_together(some)
    for one, other in zip(some, others, strict=True):
        gap = self_gap(other.centreline, other.diameter / 2.0)
        assert one.self_gap == pytest.approx(gap, abs=1e-10 * other.centreline.length)
        assert one.stability.in_plane == pytest.approx(other.stability.in_plane, rel=1e-9)
        assert one.stability.out_of_plane == pytest.approx(other.stability.out_of_plane, rel=1e-9)
        assert one.stability.stable_in_plane == other.stability.stable_in_plane
        assert one.stability.free_turn == other.stability.free_turn


def test_a_loop_over_either_end() -> None:
    cables = [side_by_side(length) for length in (280.0, 320.0, 365.0)]
    some = equilibria(*cables)
    found = twins(some)
    assert len(found) >= 3
    for one, other in found:
        assert one is not other
        assert one.energy_per_EI == pytest.approx(other.energy_per_EI, rel=1e-12)
    assert_one_by_one(some, equilibria(*cables))


def test_turned_around_they_are_none_between_straights_of_two_lengths() -> None:
    """The loop passes one straight or the other, and its room goes with which of them is the longer."""
    cable = side_by_side(320.0, lead_out=60.0, lead_in=1.0)
    assert twins(equilibria(side_by_side(320.0)))
    assert not twins(equilibria(cable))
    assert_one_by_one(equilibria(cable), equilibria(cable))


@pytest.mark.parametrize("pinned", [False, True])
@pytest.mark.parametrize("lead_in", [0.0, 20.0])
def test_a_bulge_to_either_side(lead_in: float, pinned: bool) -> None:
    """Mirror images do not swap their ends, so that these need not be alike."""
    cable = in_a_row(lead_in, pinned=pinned)
    assert twins(equilibria(cable))
    assert_one_by_one(equilibria(cable), equilibria(cable))


def test_nothing_else_is_a_twin() -> None:
    """The states of random scenes differ by far more than those of twins: by more than 1e-6."""
    rng = np.random.default_rng(11)
    cables = []
    for i in range(150):
        a, b = rng.uniform(-np.pi, np.pi, 2)
        place = (float(rng.uniform(-90.0, 90.0)), 0.0, 0.0)
        start = Clamp((0.0, 0.0, 0.0), (np.cos(a), np.sin(a), 0.0))
        end = Clamp(place, (np.cos(b), np.sin(b), 0.0)) if i % 3 else Pin(place)
        cables.append(Cable(f"W{i}", 0.1, start, end, length=100.0))
    some = equilibria(*cables)
    assert len(some) > 500
    assert first(some) == list(range(len(some)))
    states = gathered([one.trace for one in some if one.trace is not None])
    off = np.abs(np.diff(np.abs(states.lean))) + np.abs(np.diff(np.abs(states.kappa)))
    assert np.min(off[np.diff(states.scene) == 0]) > 1e-6


def test_the_same_scene_twice_is_no_twin() -> None:
    cable = side_by_side(320.0)
    once, again = equilibria(cable), equilibria(cable)
    alone = first(once)
    assert first(once + again) == alone + [i + len(once) for i in alone]
