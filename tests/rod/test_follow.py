"""Following an equilibrium: in steps of any size, there and back, past a loss of stability, and up to a fold."""

import math

import numpy as np
import pytest

from cablecad.rod.equilibria import SHARP_MODES
from cablecad.rod.follow import follow_planar
from cablecad.rod.planar import solve_planar
from cablecad.rod.ritz import ritz

FIRST = np.array([0])


def clamps(degrees):
    return math.radians(degrees), -math.radians(degrees), (0.9, 0.0)


@pytest.mark.parametrize("step", [0.25, 1.0, 2.0, 5.0, 8.0])
def test_an_arch_is_followed_to_its_fold_and_not_beyond(step):
    """Clamps turned down: the arch loses its stability sideways at -36.5 degrees and ends in a fold at -36.85.

    Beyond, the same clamps hold another shape, of a ninth of the energy, into which a real arch snaps.
    """
    shape, degrees = solve_planar(*([v] for v in clamps(40.0))).equilibria.take(FIRST), 40.0
    while (moved := follow_planar(shape, *clamps(degrees - step))) is not None:
        assert moved.side[0] == 1
        assert bool(moved.stable_in_plane[0]) is (degrees - step > -36.55)
        shape, degrees = moved, degrees - step
    assert -36.9 < degrees < -36.4 + step
    beyond = solve_planar(*([v] for v in clamps(-37.0))).equilibria
    assert beyond.energy[0] < 0.2 * shape.energy[0]


@pytest.mark.parametrize("kind", [{}, {"end_clamped": False}, {"start_clamped": False}])
def test_there_and_back(kind):
    rng = np.random.default_rng(6)
    for _ in range(12):
        a, b, d, toward = rng.uniform(-math.pi, math.pi), rng.uniform(-math.pi, math.pi), rng.uniform(0.1, 0.9), 0.3
        place = np.array([d * math.cos(toward), d * math.sin(toward)])
        first = solve_planar([a], [b], [place], **kind).equilibria.take(FIRST)
        there = follow_planar(first, a + 0.02, b - 0.03, place * 0.98)
        if there is None:
            continue
        back = follow_planar(there, a, b, place)
        assert math.isclose(back.energy[0], first.energy[0], rel_tol=1e-11)
        for name in ("theta0", "theta1", "kappa0", "kappa1", "kappa_max", "winding", "inflections", "side"):
            assert math.isclose(getattr(back, name)[0], getattr(first, name)[0], rel_tol=1e-9, abs_tol=1e-9), name
        assert np.allclose(back.force, first.force, rtol=1e-9, atol=1e-9)
        assert math.isclose(back.margin_in_plane[0], first.margin_in_plane[0], rel_tol=1e-7)
        assert math.isclose(back.margin_out_of_plane[0], first.margin_out_of_plane[0], rel_tol=1e-7, abs_tol=1e-7)
        # Full turns of a whole shape are no difference; 24 modes hold 3e-7 of an angle.
        change = (back.modes - first.modes) @ ritz(True, True, SHARP_MODES).functions.T
        assert np.max(np.abs(change - 2 * math.pi * np.rint(change[0, 0] / (2 * math.pi)))) < 3e-7


def test_description_is_that_of_a_new_search():
    """Side, inflections, winding and greatest curvature from phases agree with those counted along the shape."""
    rng = np.random.default_rng(17)
    compared = 0
    for _ in range(40):
        a, b, d = rng.uniform(-math.pi, math.pi), rng.uniform(-math.pi, math.pi), rng.uniform(0.1, 0.95)
        first = solve_planar([a], [b], [(d, 0.0)], torsion_ratio=0.8).equilibria.take(FIRST)
        moved = follow_planar(first, a + 0.01, b + 0.01, (0.995 * d, 0.002), torsion_ratio=0.8)
        found = solve_planar([a + 0.01], [b + 0.01], [(0.995 * d, 0.002)], torsion_ratio=0.8).equilibria
        if moved is None:
            continue
        (same,) = np.flatnonzero(
            (np.abs(found.energy / moved.energy - 1) < 1e-9) & (np.abs(found.kappa0 - moved.kappa0) < 1e-6)
        )
        for name in ("winding", "inflections", "side", "free_turn"):
            assert getattr(found, name)[same] == getattr(moved, name)[0], name
        for name in ("kappa_max", "margin_in_plane", "margin_out_of_plane", "kappa1"):
            assert math.isclose(getattr(found, name)[same], getattr(moved, name)[0], rel_tol=1e-7, abs_tol=1e-6), name
        compared += 1
    assert compared > 35
