"""Moved cables and exact derivatives, against solving anew and against differences."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from cablecad.errors import InfeasibleError, NotPlanarError, SolveError, UsageError
from cablecad.model import Cable, Clamp, Pin, Port, Toward
from cablecad.rod.solve import solve_rod

TURN = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
PLACE = np.array([30.0, -20.0, 50.0])


def support(x: float, y: float, angle: float | None, straight: float = 0.0):
    """An end in a plane of general position; `angle` None is a pin."""
    position = tuple(TURN @ [x, y, 0.0] + PLACE)
    if angle is None:
        return Pin(position)
    return Clamp(position, tuple(TURN @ [math.cos(angle), math.sin(angle), 0.0]), straight)


CASES = {
    "hook": (100.0, (0.0, 0.0, 1.2, 0.0), (45.0, 20.0, -0.7, 0.0)),
    "lead-outs": (100.0, (0.0, 0.0, 1.2, 7.0), (45.0, 20.0, -0.7, 11.0)),
    "clamp-pin": (100.0, (0.0, 0.0, 0.4, 5.0), (70.0, 10.0, None, 0.0)),
    "pin-clamp": (100.0, (0.0, 0.0, None, 0.0), (70.0, 10.0, -0.5, 5.0)),
    "pin-pin": (100.0, (0.0, 0.0, None, 0.0), (70.0, 10.0, None, 0.0)),
    "U-turn": (100.0, (0.0, 0.0, 0.0, 0.0), (0.0, 30.0, math.pi, 0.0)),
    "taut": (100.0, (0.0, 0.0, 0.3, 0.0), (99.9, 0.5, -0.2, 0.0)),
}


def cable(length, start, end) -> Cable:
    return Cable("c", 0.1, support(*start), support(*end), length=length, bulge=tuple(TURN @ [0.1, 1.0, 0.0]))


def values(solution, s) -> dict[str, np.ndarray]:
    state = solution.equilibrium
    return {
        "start_force_per_EI": state.start.force_per_EI,
        "end_force_per_EI": state.end.force_per_EI,
        "start_moment_per_EI": state.start.moment_per_EI,
        "end_moment_per_EI": state.end.moment_per_EI,
        "bend_radius_min": np.array(solution.bend_radius_min),
        "points": solution.position(s),
    }


@pytest.mark.parametrize("name", CASES)
def test_derivatives_against_differences(name: str) -> None:
    """Fourth-order differences of solutions found anew; inputs in the plane's own axes."""
    length, start, end = CASES[name]
    base = solve_rod(cable(length, start, end))
    free = length - start[3] - end[3]
    shares = np.array([0.13, 0.5, 0.8])
    s = np.concatenate([start[3] + free * shares, [0.4 * start[3], length - 0.3 * end[3]]])
    found = base.sensitivity(s)
    axes = TURN.T @ np.stack([found.e1, found.e2], axis=1)  # columns: e1 and e2 in the plane's coordinates
    flip = np.sign(np.linalg.det(axes[:2, :2]))  # e1 to e2 may turn against the drawing's sense

    def moved(column: str, step: float):
        at_start, at_end, long = list(start), list(end), length
        target = at_start if column.startswith("start") else at_end
        if column == "length":
            long += step
        elif column.endswith("angle"):
            target[2] += flip * step
        else:
            direction = axes[:2, 0 if column.endswith("x") else 1]
            target[0] += direction[0] * step
            target[1] += direction[1] * step
        arcs = np.concatenate([start[3] + (long - start[3] - end[3]) * shares, [0.4 * start[3], long - 0.3 * end[3]]])
        return values(solve_rod(cable(long, at_start, at_end)), arcs)

    for i, column in enumerate(found.inputs):
        if (column, None) in (("start_angle", start[2]), ("end_angle", end[2])):
            continue  # a pin has no angle
        h = 2e-3 * (0.01 if column.endswith("angle") else 1.0) * (0.2 if name == "taut" else 1.0)
        samples = [moved(column, k * h) for k in (-2, -1, 1, 2)]
        for key in values(base, s):
            a, b, c, d = (sample[key] for sample in samples)
            difference = (a - 8 * b + 8 * c - d) / (12 * h)
            derivative = getattr(found, key)[..., i]
            scale = np.abs(getattr(found, key)).max() + np.abs(difference).max()
            np.testing.assert_allclose(derivative, difference, atol=3e-6 * scale, err_msg=f"{name} {column} {key}")


@pytest.mark.parametrize("name", CASES)
def test_moved_equals_solved_anew(name: str) -> None:
    length, start, end = CASES[name]
    solution = solve_rod(cable(length, start, end))
    for i in range(1, 6):
        there = (end[0] - 1.5 * i, end[1] + 0.7 * i, None if end[2] is None else end[2] + 0.03 * i, end[3])
        solution = solution.moved(end=support(*there), length=length + 0.4 * i)
        anew = solve_rod(cable(length + 0.4 * i, start, there))
        near = min(np.abs(e.centreline.points(31) - solution.points(31)).max() for e in anew.equilibria)
        assert near < 1e-8 * length
        assert solution.residual < 1e-12
        assert solution.length == pytest.approx(length + 0.4 * i)


def test_dragging_turns_past_the_bulge_without_a_jump() -> None:
    """Both ends turn once around: the plane's side must not flip where the chord passes the bulge."""
    solution = solve_rod(Cable("c", 1.0, Clamp((0, 0, 0), (0, 1, 0)), Clamp((60, 0, 0), (0, -1, 0)), length=150.0))
    first = solution.points(21)
    for angle in np.linspace(0, 2 * math.pi, 41)[1:]:
        c, s = math.cos(angle), math.sin(angle)
        solution = solution.moved(start=Clamp((0, 0, 0), (-s, c, 0)), end=Clamp((60 * c, 60 * s, 0), (s, -c, 0)))
        turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
        np.testing.assert_allclose(solution.points(21), first @ turn.T, atol=1e-8)


def test_move_refuses_what_it_cannot_follow() -> None:
    solution = solve_rod(Cable("c", 1.0, Clamp((0, 0, 0), (1, 0, 0)), Clamp((60, 10, 0), (1, 0, 0)), length=80.0))
    with pytest.raises(InfeasibleError, match="less than the distance"):
        solution.moved(end=Clamp((100, 0, 0), (1, 0, 0)))
    with pytest.raises(NotPlanarError):
        solution.moved(end=Clamp((60, 10, 0), (1, 0, 1)))
    with pytest.raises(UsageError, match="a clamp or a pin"):
        solution.moved(end=Pin((60, 10, 0)))
    toward = solve_rod(Cable("c", 1.0, Pin((0, 0, 0)), Toward((1, 0, 0)), length=80.0, angle_deg=30.0))
    with pytest.raises(UsageError, match="toward"):
        toward.moved(length=90.0)


def test_a_lost_branch_is_said() -> None:
    """An arch whose clamps are turned down snaps through: its branch ends or turns unstable, and the move says so."""

    def clamps(degrees: float):
        c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
        return {"start": Clamp((0, 0, 0), (c, s, 0)), "end": Clamp((90, 0, 0), (c, -s, 0))}

    solution = solve_rod(Cable("c", 1.0, **clamps(40.0), length=100.0))
    assert solution.stability.stable_in_plane
    said = ""
    for degrees in np.arange(38.0, -80.0, -2.0):
        try:
            solution = solution.moved(**clamps(float(degrees)))
        except SolveError as error:
            said = str(error)
            break
        said = " ".join(solution.warnings)
        if "lost its stability in its plane" in said:
            assert not solution.stability.stable_in_plane
            break
    assert "ceased to exist" in said or "lost its stability in its plane" in said
    assert degrees < 0.0


def test_moved_length_of_a_slack_cable_is_kept() -> None:
    slack = replace(cable(1.0, (0, 0, 0.3, 0), (50, 0, -0.3, 0)), length=None, slack=0.2)
    solution = solve_rod(slack)
    assert solution.length == pytest.approx(60.0)
    assert solution.moved(end=support(48, 0, -0.3)).length == pytest.approx(60.0)


def test_sensitivity_of_a_straight_cable_is_refused() -> None:
    with pytest.raises(UsageError, match="straight"):
        solve_rod(Cable("c", 1.0, Port((0, 0, 0)), Port((5, 0, 0)), length=5.0)).sensitivity()


def pins(apart: float, **data) -> Cable:
    return Cable("c", 0.01, Pin((0, 0, 0)), Pin((apart, 0, 0)), length=1.0, bulge=(0.0, 1.0, 0.0), **data)


@pytest.mark.parametrize("apart", [0.3, 1e-4, 1e-6, 1e-8])
def test_pins_next_to_each_other(apart: float) -> None:
    """A move of the end across the chord turns the whole; the nearer the pins, the more."""
    solution = solve_rod(pins(apart))
    found = solution.sensitivity([0.1, 0.7])
    x, y, _ = solution.position([0.1, 0.7]).T
    across = found.points[:, :2, found.inputs.index("end_y")] * found.e2[1]
    exact = np.stack([-y, x], axis=1) / apart
    np.testing.assert_allclose(across, exact, atol=1e-7 * np.abs(exact).max())
    assert solution.slack == pytest.approx((1.0 - apart) / apart, rel=1e-12)


@pytest.mark.parametrize("apart", [0.0, 1e-13])
def test_pins_at_one_point_have_no_derivatives(apart: float) -> None:
    with pytest.raises(UsageError, match="its ends coincide"):
        solve_rod(pins(apart)).sensitivity()


@pytest.mark.parametrize("index", range(6))
def test_derivatives_of_pinned_modes_are_those_of_their_own_twin(index: int) -> None:
    solution, h = solve_rod(pins(0.6, equilibrium=index)), 1e-5
    there, back = (solution.moved(length=1.0 + step).position([0.4 * (1.0 + step)])[0] for step in (h, -h))
    found = solution.sensitivity([0.4]).points[0, :, 0]
    np.testing.assert_allclose(found, (there - back) / (2.0 * h), atol=1e-7)
