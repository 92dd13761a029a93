"""Derivatives of planar equilibria against central differences of re-solved ones."""

import math

import numpy as np
import pytest

from cablecad.errors import UsageError
from cablecad.rod.follow import follow_planar
from cablecad.rod.planar import solve_planar
from cablecad.rod.sensitivity import INPUTS, sensitivity
from cablecad.rod.variation import vary

POINTS = np.array([0.1, 0.37, 0.5, 0.83])

SCENES = {
    "clamps": ((0.5, -1.2, (0.4, 0.3)), {}),
    "clamps, reversed chord": ((0.5, 2.2, (-0.4, -0.1)), {}),
    "U-turn": ((0.0, math.pi, (0.0, 0.2)), {}),
    "clamp and pin": ((0.4, 0.0, (0.6, -0.2)), {"end_clamped": False}),
    "pin and clamp": ((0.0, 0.9, (0.3, 0.5)), {"start_clamped": False}),
    "pins": ((0.0, 0.0, (0.5, 0.2)), {"start_clamped": False, "end_clamped": False}),
    "tension": ((0.4, -0.3, (0.985, 0.02)), {}),
    "taut": ((1.4, 0.6, (0.97, 0.05)), {}),
    "taut, one pin": ((2.4, 0.0, (0.98, 0.05)), {"end_clamped": False}),
    # Loops that slide along the rod almost freely, held by the tails of layers at the ends.
    "loop": ((0.0, 0.0, (0.7, 0.0)), {"search": "wide", "index": 2}),
    "two loops": ((0.0, 0.0, (0.6, 0.0)), {"search": "wide", "index": 4}),
    "loop beside a clamp": ((math.pi / 2.0, 0.0, (0.9, 0.0)), {"search": "wide", "index": 1}),
    "sharp": ((-2.9366, 0.2256, (0.94687, 0.0)), {}),
}
"""Angles at the ends and the place of the end, and how to solve; `index`: of the equilibrium."""


def equilibrium(name):
    (start, end, place), kind = SCENES[name]
    how = {key: value for key, value in kind.items() if key != "index"}
    found = solve_planar([start], [end], [place], **how).equilibria
    return start, end, place, found.take(np.array([kind.get("index", 0)]))


def measured(shape, length):
    """Force, end curvatures, points and least bend radius at full size, EI = 1."""
    _, _, points = shape.at(POINTS)
    return np.concatenate(
        [
            shape.force[0] / length**2,
            shape.kappa0 / length,
            shape.kappa1 / length,
            (points[0] * length).ravel(),
            [length / shape.kappa_max[0]],
        ]
    )


@pytest.mark.parametrize("name", SCENES)
def test_derivatives_against_differences(name):
    start, end, place, best = equilibrium(name)
    exact = sensitivity(best, POINTS)
    flat = np.concatenate(
        [exact.force, exact.kappa0[None], exact.kappa1[None], exact.points.reshape(-1, 5), exact.bend_radius[None]]
    )
    step = 1e-5
    for column, key in enumerate(INPUTS):
        ends = []
        for sign in (1.0, -1.0, 2.0, -2.0):
            given = {"x": place[0], "y": place[1], "length": 1.0, "start_angle": start, "end_angle": end}
            given[key] += sign * step
            moved = follow_planar(
                best,
                given["start_angle"],
                given["end_angle"],
                (given["x"] / given["length"], given["y"] / given["length"]),
            )
            ends.append(measured(moved, given["length"]))
        # Fourth order; rounding of 1e-15 over the step leaves 1e-10 of the size.
        difference = (8.0 * (ends[0] - ends[1]) - (ends[2] - ends[3])) / (12.0 * step)
        scale = np.max(np.abs(flat[:, column])) + 1.0
        assert np.max(np.abs(difference - flat[:, column])) < 1e-7 * scale


def test_an_angle_at_a_pin_is_no_input():
    *_, best = equilibrium("clamp and pin")
    assert not np.any(sensitivity(best, POINTS).points[..., INPUTS.index("end_angle")])


@pytest.mark.parametrize("name", ["clamps", "loop", "two loops", "sharp", "tension"])
def test_force_is_the_gradient_of_the_energy(name):
    """Castigliano: dE/d(x, y) = n, dE/d(angle) = -+kappa at the ends; second derivatives are then symmetric."""
    *_, best = equilibrium(name)
    d = sensitivity(best)
    gradient = np.stack([d.force[0], d.force[1], -d.kappa0, d.kappa1])[:, [0, 1, 3, 4]]
    assert np.max(np.abs(gradient - gradient.T)) < 1e-9 * np.max(np.abs(gradient))


@pytest.mark.parametrize("excess", [1e-4, 1e-8, 1e-12, 1e-20])
def test_a_hair_of_slack(excess):
    """theta = a sin(2 pi s) with a^2 = 4 excess: it answers the length like 1 / sqrt(excess), and the force does not.

    That of the force hangs on digits of the force that are rounding from an excess of 1e-16 on.
    """
    best = solve_planar([0.0], [0.0], [(1.0 - excess, 0.0)], excess=[excess]).equilibria.take(np.array([0]))
    d = sensitivity(best, [0.5])
    assert abs(d.points[0, 1, 2]) == pytest.approx(1.0 / (np.pi * np.sqrt(excess)), rel=2.0 * excess + 1e-9)
    # n = -4 pi^2 (1 + excess / 2) and a force goes with the length to the -2.
    if excess > 1e-16:
        off = 1e-8 * np.abs(d.force).max()
        assert d.force[0, 0] == pytest.approx(2.0 * np.pi**2, rel=5.0 * excess + 1e-9, abs=off)


def test_what_is_too_sharp_is_refused():
    with pytest.raises(UsageError, match="too sharp for derivatives"):
        vary(np.sin, np.cos, np.array([1e8, 0.0]), start_clamped=True, end_clamped=True)


def test_a_straight_rod_has_no_derivatives():
    with pytest.raises(UsageError, match="straight"):
        vary(np.zeros_like, np.zeros_like, np.array([100.0, 0.0]), start_clamped=True, end_clamped=True)


@pytest.mark.parametrize("clamped", [True, False])
def test_a_rod_under_tension(clamped):
    """d'' = w^2 d - f: a beam under tension, next to straight, its end moved across by one."""
    w, bend = 20.0, 1e-8
    curve = lambda s: bend * np.cos(np.pi * s), lambda s: -bend * np.pi * np.sin(np.pi * s)
    found = vary(*curve, np.array([w**2, 0.0]), start_clamped=clamped, end_clamped=clamped)
    # Between clamps d = f / w^2 (1 - cosh(w (s - 1/2)) / cosh(w / 2)), of integral one; between pins d = 1.
    force = w**2 / (1.0 - np.tanh(w / 2.0) / (w / 2.0)) if clamped else w**2
    assert found.force[1, 1] == pytest.approx(force, rel=1e-10)
    assert found.kappa0[1] == pytest.approx(force / w * np.tanh(w / 2.0) if clamped else 0.0, rel=1e-10)
    assert found.kappa1[1] == pytest.approx(-found.kappa0[1], rel=1e-10)
    assert found.moved(np.array([0.0, 0.5, 1.0]))[:, 1, 1] == pytest.approx([0.0, 0.5, 1.0], abs=1e-10)


def test_more_than_one_equilibrium_is_refused():
    found = solve_planar([0.0], [0.0], [(0.8, 0.0)]).equilibria
    with pytest.raises(UsageError, match="takes one equilibrium, given 2"):
        sensitivity(found)
