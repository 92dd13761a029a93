"""Follow an equilibrium while its ends move: Newton's method from the last shape, no search.

Most moves need no more than a few evaluations of the exact flow from mid-span, in floats (`midpoint`). Where that does
not serve (hardly any slack, tension with its boundary layers, long moves) Newton's method on the modes does. A branch
may end (a fold) or lose stability on the way. The first shows as a failure to converge, or as a jump to a shape far
away; both are tried again in halves of the move before the branch is called lost. Stability is judged anew, when asked.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from cablecad.rod.classify import classify
from cablecad.rod.equilibria import SHARP_MODES, Equilibria, absolute, modes_for, sides
from cablecad.rod.midpoint import CONTRACTION, Held, Reach, State, carry, refine
from cablecad.rod.midpoint import wrap as wrap_one
from cablecad.rod.planar import RESIDUAL, solve_planar
from cablecad.rod.polish import EASY_OMEGA, polish
from cablecad.rod.problem import Problem
from cablecad.rod.ritz import SETTLED, newton, ritz
from cablecad.rod.taut import SEED, wrap

_FAR = 1.0
"""A shape that turned further than the ends did plus this is another equilibrium [rad]."""

_HALVINGS = 5

_SMALL_EXCESS = 0.1

_EASY_EXCESS = 1e-3
"""With less slack angles are small and positions from the flow lose what the chord is short of the length."""

_TURN = 2.0 * math.pi


def follow_planar(
    last: Equilibria,
    start_angle: float,
    end_angle: float,
    end: Any,
    *,
    excess: float | None = None,
    torsion_ratio: float | None = None,
) -> Equilibria | None:
    """Follow one equilibrium to moved ends.

    Args:
        last: One equilibrium (of length 1), as `solve_planar` gives it.
        start_angle: New angle at the start; not read at a pin.
        end_angle: New angle at the end; not read at a pin.
        end: New end position, shape (2,).
        excess: New 1 - chord, where it is known better than from `end`.
        torsion_ratio: GJ/EI where both ends hold the spin.

    Returns:
        The same equilibrium there, or None where it ceased to exist. Whether it is still stable, its margins tell.
    """
    x, y = float(end[0]), float(end[1])
    target = _Place(start_angle, end_angle, x, y, 1.0 - math.hypot(x, y) if excess is None else float(excess))
    if not target.excess > 0.0:
        return None
    if not last.taut[0]:
        found = _move(last, target, torsion_ratio)
        if found is not None:
            return found
        found = _halves(last, target, torsion_ratio, _HALVINGS)
        if found is not None:
            return found
    return _nearest(last, target, torsion_ratio)


class _Place(NamedTuple):
    """Where the ends are."""

    start_angle: float
    end_angle: float
    x: float
    y: float
    excess: float

    def frame(self, old: float) -> float:
        """Angle of the chord, in the turn next to `old`, which stays where the ends coincide."""
        return old if self.excess >= 1.0 - 1e-14 else old + wrap_one(math.atan2(self.y, self.x) - old)


def _move(last: Equilibria, target: _Place, torsion_ratio: float | None) -> Equilibria | None:
    return _glide(last, target, torsion_ratio) or _step(last, target, torsion_ratio)


def _glide(last: Equilibria, target: _Place, torsion_ratio: float | None) -> Equilibria | None:
    """The state at mid-span alone, in floats; None where that does not serve."""
    omega, old_excess = last.omega.item(), last.excess.item()
    if omega > EASY_OMEGA or min(target.excess, old_excess) < _EASY_EXCESS or max(target.excess, old_excess) > 1 - 1e-9:
        return None
    start_clamped, end_clamped = last.held[0].tolist()
    old = last.frame.item()
    frame = target.frame(old)
    before = State(last.lean.item(), last.kappa.item(), last.direction.item() - frame, omega, bool(last.tension[0]))
    theta0, theta1 = last.theta0.item(), last.theta1.item()
    turned = [
        wrap_one(target.start_angle - theta0) if start_clamped else 0.0,
        wrap_one(target.end_angle - theta1) if end_clamped else 0.0,
    ]
    theta0, theta1 = theta0 + turned[0], theta1 + turned[1]
    given = Held(start_clamped, end_clamped, theta0 - frame, theta1 - frame, target.excess)
    state, residual = refine(before, given)
    if not residual <= RESIDUAL or state.omega > EASY_OMEGA:
        return None
    ends = carry(state, 0.5)
    theta = last.theta.item()
    theta += wrap_one(state.direction + state.lean + frame - theta)
    quarters = carry(state, 0.25)
    moved = abs(frame - old) + abs(turned[0]) + abs(turned[1]) + _FAR
    far = [
        theta + there.turn - last.theta.item() - here.turn
        for there, here in zip(quarters, carry(before, 0.25), strict=True)
    ]
    here0, here1 = theta + ends[0].turn, theta + ends[1].turn
    far += [here0 - theta0, here1 - theta1]
    if max(map(abs, far)) > moved:
        return None
    return _described(last, target, frame, state, residual, theta, ends, quarters[0], torsion_ratio)


def _described(
    last: Equilibria,
    target: _Place,
    frame: float,
    state: State,
    residual: float,
    theta: float,
    ends: tuple[Reach, Reach],
    quarter: Reach,
    torsion_ratio: float | None,
) -> Equilibria:
    """What `classify` and `absolute` say, from the exact flow."""
    held = last.held[0].tolist()
    begin, finish = ends
    sine, cosine = math.sin(state.compression), math.cos(state.compression)
    lift = -(sine * begin.along + cosine * begin.across)
    bow = sine * (quarter.along - begin.along) + cosine * (quarter.across - begin.across)
    heights = np.array([[lift, bow]])
    p, c = state.half
    c, h = state.omega * c, state.kappa / 2.0
    peak = 2.0 * math.hypot(h, state.omega * p)
    swings = abs(c) >= abs(h)
    crests = _zeros(begin.phase, finish.phase, 0.0)
    theta0, theta1 = theta + begin.turn, theta + finish.turn
    size = state.omega**2 if state.tension else -(state.omega**2)
    direction = state.direction + frame
    values = {
        "theta": theta,
        "kappa": state.kappa,
        "lean": state.lean,
        "direction": direction,
        "omega": state.omega,
        "theta0": theta0,
        "theta1": theta1,
        "kappa0": begin.kappa,
        "kappa1": finish.kappa,
        "energy": 2.0 * (state.omega**2 * (finish.square - begin.square) - (c - h) * (c + h)),
        "kappa_max": peak if crests else max(abs(begin.kappa), abs(finish.kappa)),
        "residual": residual,
        "torsion_ratio": torsion_ratio if torsion_ratio is not None and all(held) else math.nan,
        "frame": frame,
        "excess": target.excess,
        "a": 0.0,
        "b": 0.0,
    }
    return Equilibria(
        scene=last.scene,
        tension=last.tension,
        force=np.array([[size * math.cos(direction), size * math.sin(direction)]]),
        winding=np.array([round((theta1 - target.end_angle) / _TURN) if all(held) else 0]),
        inflections=np.array([_zeros(begin.phase, finish.phase, math.pi / 2.0) if swings else 0]),
        heights=heights,
        side=sides(heights),
        verdict=np.zeros((1, 2), dtype=int),
        margins=np.full((1, 2), np.nan),
        free_turns=np.zeros(1, dtype=bool),
        taut=last.taut,
        z=np.full((1, SHARP_MODES + 2), np.nan),
        held=last.held,
        **{name: np.array([value]) for name, value in values.items()},
    )


def _zeros(low: float, high: float, first: float) -> int:
    """Points first + j pi strictly between two phases, which may come in either order; an end within 1e-9 is on it."""
    low, high = sorted(((low - first) / math.pi, (high - first) / math.pi))
    return max(0, math.ceil(high - 1e-9) - math.floor(low + 1e-9) - 1)


def _step(last: Equilibria, target: _Place, torsion_ratio: float | None) -> Equilibria | None:
    """Newton's method on the modes."""
    held = bool(last.held[0, 0]), bool(last.held[0, 1])
    if not any(held) and target.excess > 1.0 - 1e-9:
        return None  # pins at one point: the turn is free, and only the search handles it
    modes = int(modes_for(last.omega)[0])
    space = ritz(*held, modes)
    old = float(last.frame[0])
    frame = target.frame(old)
    z = last.modes[:, : modes + 2].copy()
    turns = _TURN * np.rint((last.theta0[0] - z[0, 0] - old) / _TURN)
    before = z @ space.functions.T + (old + turns)
    z[0, :2] += old + turns - frame
    moved = abs(frame - old)
    for i, angle in enumerate((target.start_angle, target.end_angle)):
        if held[i]:
            change = wrap_one(angle - frame - z[0, i])
            z[0, i] += change
            moved += abs(change)
    excess = np.array([target.excess])
    force = last.force @ np.array([[np.cos(frame), -np.sin(frame)], [np.sin(frame), np.cos(frame)]])
    z, force, change_left = newton(space, z, force, excess, contraction=CONTRACTION)
    if not change_left[0] < SETTLED or np.max(np.abs(z @ space.functions.T + frame - before)) > moved + _FAR:
        return None
    problem = Problem(*held, z[:, 0], z[:, 1], excess, torsion_ratio)
    targets = np.where(last.held, z[:, :2], 0.0)
    middle, probe, residual = polish(space, z, force, targets, excess)
    if not residual[0] <= RESIDUAL:
        return None
    scene = np.zeros(1, dtype=int)
    found = classify(problem, space, scene, z, middle, probe, residual)
    start, end = np.array([z[0, 0] + frame]), np.array([target.end_angle])
    found = absolute(found, start, end, np.array([frame]))
    return replace(found, scene=last.scene)


def _halves(last: Equilibria, target: _Place, torsion_ratio: float | None, depth: int) -> Equilibria | None:
    """The move in two halves, each halved again where need be."""
    if not depth:
        return None
    held = last.held[0]
    here, _, position = last.at(np.array([0.0, 1.0]))
    angles = [
        float(here[0, i]) + wrap_one(goal - float(here[0, i])) / 2.0 if held[i] else goal
        for i, goal in enumerate((target.start_angle, target.end_angle))
    ]
    x, y = (float(position[0, 1, 0]) + target.x) / 2.0, (float(position[0, 1, 1]) + target.y) / 2.0
    chord = math.hypot(x, y)
    excess = 1.0 - chord
    if max(last.excess[0], target.excess) < _SMALL_EXCESS:
        # Shapes go with the logarithm of a small excess (omega with its inverse), and a chord would lose its digits.
        excess = math.sqrt(float(last.excess[0]) * target.excess)
        x, y = x / chord * (1.0 - excess), y / chord * (1.0 - excess)
    middle = _Place(angles[0], angles[1], x, y, excess)
    first = _move(last, middle, torsion_ratio) or _halves(last, middle, torsion_ratio, depth - 1)
    if first is None:
        return None
    return _move(first, target, torsion_ratio) or _halves(first, target, torsion_ratio, depth - 1)


def _nearest(last: Equilibria, target: _Place, torsion_ratio: float | None) -> Equilibria | None:
    """Taut cables, and what became taut: the one of a new search that turned least."""
    if last.omega[0] < SEED or not last.tension[0]:
        return None  # such a branch ended in a fold: what a search would find lies beyond a snap
    found = solve_planar(
        [target.start_angle],
        [target.end_angle],
        [(target.x, target.y)],
        excess=[target.excess],
        start_clamped=bool(last.held[0, 0]),
        end_clamped=bool(last.held[0, 1]),
        torsion_ratio=torsion_ratio,
    ).equilibria
    if not len(found):
        return None
    s = np.linspace(0.0, 1.0, 33)
    before, after = last.at(s)[0], found.at(s)[0]
    far = np.max(np.abs(after - before - _TURN * np.rint((after[:, :1] - before[:, :1]) / _TURN)), axis=1)
    far[found.omega < SEED / 2.0] = np.inf
    best = int(np.argmin(far))
    ends = np.abs(wrap(after[best, [0, -1]] - before[0, [0, -1]]))
    if far[best] > float(np.sum(ends)) + _FAR:
        return None
    return replace(found.take(np.array([best])), scene=last.scene)
