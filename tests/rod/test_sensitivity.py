"""Derivatives of planar equilibria against central differences of re-solved ones."""

import math

import numpy as np
import pytest

from cablecad.errors import UsageError
from cablecad.rod.follow import follow_planar
from cablecad.rod.planar import solve_planar
from cablecad.rod.sensitivity import INPUTS, sensitivity

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
}


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
    (start, end, place), kind = SCENES[name]
    best = solve_planar([start], [end], [place], **kind).equilibria.take(np.array([0]))
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
        assert np.max(np.abs(difference - flat[:, column])) < 1e-6 * scale


def test_an_angle_at_a_pin_is_no_input():
    (start, end, place), kind = SCENES["clamp and pin"]
    best = solve_planar([start], [end], [place], **kind).equilibria.take(np.array([0]))
    assert not np.any(sensitivity(best, POINTS).points[..., INPUTS.index("end_angle")])


def test_force_is_the_gradient_of_the_energy():
    """Castigliano: dE/d(x, y) = n, dE/d(angle) = -+kappa at the ends; second derivatives are then symmetric."""
    (start, end, place), kind = SCENES["clamps"]
    best = solve_planar([start], [end], [place], **kind).equilibria.take(np.array([0]))
    d = sensitivity(best)
    gradient = np.stack([d.force[0], d.force[1], -d.kappa0, d.kappa1])[:, [0, 1, 3, 4]]
    assert np.max(np.abs(gradient - gradient.T)) < 1e-8 * np.max(np.abs(gradient))


def test_more_than_one_equilibrium_is_refused():
    found = solve_planar([0.0], [0.0], [(0.8, 0.0)]).equilibria
    with pytest.raises(UsageError, match="takes one equilibrium, given 2"):
        sensitivity(found)
