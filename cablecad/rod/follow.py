"""Follow an equilibrium while its ends move: Newton's method from the last shape, no search.

A branch may end (a fold) or lose stability on the way. The first shows as a failure to converge, or as a jump to a
shape far away; both are tried again in halves of the move before the branch is called lost. Stability is judged anew.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from cablecad.rod.classify import classify
from cablecad.rod.equilibria import SHARP_MODES, Equilibria, absolute
from cablecad.rod.planar import RESIDUAL, SMOOTH_MODES, SMOOTH_OMEGA, solve_planar
from cablecad.rod.polish import polish
from cablecad.rod.problem import Problem
from cablecad.rod.ritz import newton, ritz
from cablecad.rod.taut import wrap
from cablecad.rod.trial import Array

_FAR = 1.0
"""A shape that turned further than the ends did plus this is another equilibrium [rad]."""

_HALVINGS = 4


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
    point = np.asarray(end, dtype=float)
    chord = float(np.hypot(point[0], point[1]))
    target = _Place(start_angle, end_angle, point, 1.0 - chord if excess is None else float(excess))
    if not target.excess > 0.0:
        return None
    if not last.taut[0]:
        found = _step(last, target, torsion_ratio)
        if found is not None:
            return found
        found = _halves(last, target, torsion_ratio, _HALVINGS)
        if found is not None:
            return found
    return _nearest(last, target, torsion_ratio)


class _Place:
    """Where the ends are."""

    __slots__ = ("end", "end_angle", "excess", "start_angle")

    def __init__(self, start_angle: float, end_angle: float, end: Array, excess: float) -> None:
        self.start_angle, self.end_angle, self.end, self.excess = start_angle, end_angle, end, excess


def _step(last: Equilibria, target: _Place, torsion_ratio: float | None) -> Equilibria | None:
    held = bool(last.held[0, 0]), bool(last.held[0, 1])
    if not any(held) and target.excess > 1.0 - 1e-9:
        return None  # pins at one point: the turn is free, and only the search handles it
    modes = SMOOTH_MODES if last.omega[0] < SMOOTH_OMEGA else SHARP_MODES
    space = ritz(*held, modes)
    old = float(last.frame[0])
    frame = old if target.excess >= 1.0 - 1e-14 else old + float(wrap(np.arctan2(target.end[1], target.end[0]) - old))
    turns = 2.0 * np.pi * np.rint((last.theta0[0] - last.z[0, 0] - old) / (2.0 * np.pi))
    z = last.z[:, : modes + 2].copy()
    before = z @ space.functions.T + (old + turns)
    z[0, :2] += old + turns - frame
    moved = abs(frame - old)
    for i, angle in enumerate((target.start_angle, target.end_angle)):
        if held[i]:
            change = float(wrap(np.array(angle - frame - z[0, i])))
            z[0, i] += change
            moved += abs(change)
    excess = np.array([target.excess])
    force = last.force @ np.array([[np.cos(frame), -np.sin(frame)], [np.sin(frame), np.cos(frame)]])
    z, force, change_left = newton(space, z, force, excess)
    if not change_left[0] < 1e-5 or np.max(np.abs(z @ space.functions.T + frame - before)) > moved + _FAR:
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
        float(here[0, i] + wrap(np.array(goal - here[0, i])) / 2.0) if held[i] else goal
        for i, goal in enumerate((target.start_angle, target.end_angle))
    ]
    point = (position[0, 1] + target.end) / 2.0
    # Halves of a small excess, not of the chords: those would lose it.
    halfway = float(last.excess[0] + target.excess) / 2.0
    bowed = 1.0 - float(np.hypot(point[0], point[1]))
    middle = _Place(angles[0], angles[1], point, halfway if abs(bowed - halfway) < 1e-6 else bowed)
    first = _step(last, middle, torsion_ratio) or _halves(last, middle, torsion_ratio, depth - 1)
    if first is None:
        return None
    return _step(first, target, torsion_ratio) or _halves(first, target, torsion_ratio, depth - 1)


def _nearest(last: Equilibria, target: _Place, torsion_ratio: float | None) -> Equilibria | None:
    """Taut cables, and what became taut: the one of a new search that turned least."""
    found = solve_planar(
        [target.start_angle],
        [target.end_angle],
        [target.end],
        excess=[target.excess],
        start_clamped=bool(last.held[0, 0]),
        end_clamped=bool(last.held[0, 1]),
        torsion_ratio=torsion_ratio,
    ).equilibria
    if not len(found):
        return None
    s = np.linspace(0.0, 1.0, 33)
    before, after = last.at(s)[0], found.at(s)[0]
    far = np.max(np.abs(after - before - 2.0 * np.pi * np.rint((after[:, :1] - before[:, :1]) / (2.0 * np.pi))), axis=1)
    best = int(np.argmin(far))
    ends = np.abs(wrap(after[best, [0, -1]] - before[0, [0, -1]]))
    if far[best] > float(np.sum(ends)) + _FAR:
        return None
    return replace(found.take(np.array([best])), scene=last.scene)
