"""The planar two-point problem: every shape a weightless rod of given length takes between two clamps or pins.

Units: L = EI = 1; the start is the origin. Scenes go through in arrays; one scene and a thousand take the same path.

1. Taut cables (`taut`): nearly straight but misaligned; exact in closed form where omega > 36.
2. Descent (`descend`): an SQP on the energy over a dozen Legendre modes from several windings and asymmetric starts.
   A winding whose least energy, (difference of end angles)^2/2, exceeds the best found cannot win and is left out.
3. Newton's method over 14 or 16 modes, or 24 to 44 where these do not do (`newton`), then on the state at mid-span
   against the exact flow (`polish`).
4. Sorting out: duplicates dropped, energy, inflections, side, residual, and the stability of each.

The search is stated, not proved complete. On 2000 random scenes
none ended above the best of its own wide search (65 starts).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from cablecad.rod.classify import classify, classify_taut, padded
from cablecad.rod.descent import descend, first_force
from cablecad.rod.equilibria import SHARP_MODES, Equilibria, absolute, join, modes_for, ranked, sketch_modes_for
from cablecad.rod.judge import judge_in_plane
from cablecad.rod.polish import polish
from cablecad.rod.problem import Problem
from cablecad.rod.quadrature import gauss_legendre
from cablecad.rod.ritz import SETTLED, gap, newton, ritz
from cablecad.rod.starts import starts
from cablecad.rod.taut import EXACT, Taut, taut, wrap
from cablecad.rod.trial import Array, legendre

COARSE_MODES = 8
ROOM = 0.005
"""Scenes of less excess that have an exactly taut shape are not searched further: others need room to turn. Lower ones
were met from 0.02 on (18 of 619 scenes of 0.02 to 0.05) and none of 3780 below. tests/experiments/planar_search.py."""

ONE_POINT = 1e-12
"""Pins closer than this (over length) are taken to be at one point: rounding turns such a cable as it likes."""

CHUNK = 512
"""Scenes that go through together, an eighth of it in a wide search: 100 MB (wide 400), and no faster with more."""

_FEW = 24
"""Of so few solutions the verdicts that their own modes leave in doubt wait until someone asks."""

_ALIKE = 1e-9
"""Energies that differ by less are one: rounding."""

_FULL = 0.1
"""Share of the excess that a discretised solution may miss."""

_BENT = 1.0
"""Largest angle [rad] above which a sketch may do: of small angles the modes themselves have to give all digits."""

_SKETCHED = 1e-3
"""Last change of the angles up to which a sketch is refined; `polish` does the rest. 1e-2 and 1e-5 take longer."""

RESIDUAL = 1e-12
"""Largest unmet end condition of a solution: position over length, angle in radians."""

SOLVED, STRAIGHT, INFEASIBLE, UNSOLVED = "solved", "straight", "infeasible", "unsolved"

_TURN = 2.0 * np.pi


@dataclass(frozen=True, slots=True)
class Search:
    """What was asked and found.

    Attributes:
        equilibria: All that were found, sorted.
        result: For each scene ``"solved"``, ``"straight"`` (aligned, no excess), ``"infeasible"`` or ``"unsolved"``.
        descents: Starts tried for each scene.
    """

    equilibria: Equilibria
    result: list[str]
    descents: np.ndarray


def solve_planar(
    start_angle: Any,
    end_angle: Any,
    end: Any,
    *,
    excess: Any = None,
    start_clamped: bool = True,
    end_clamped: bool = True,
    torsion_ratio: float | None = None,
    search: Literal["answer", "wide"] = "answer",
) -> Search:
    """Find the equilibria of rods of length 1 from the origin to `end`.

    Args:
        start_angle: Angles of the tangent at the start, shape (n,); not read at a pin.
        end_angle: Angles at the end, shape (n,); not read at a pin.
        end: End positions, shape (n, 2).
        excess: 1 - chord, shape (n,), where it is known better than from `end`; the direction of the chord is always
            taken from `end`.
        start_clamped: Whether the start's direction is held.
        end_clamped: Whether the end's direction is held.
        torsion_ratio: GJ/EI where both ends hold the spin; None: spin is free.
        search: ``"wide"``: windings to -2..2, more starts, and Newton's method for unstable ones.

    Returns:
        The equilibria; no scene raises, `result` tells.
    """
    end = np.atleast_2d(np.asarray(end, dtype=float))
    count = len(end)
    start_angle = np.broadcast_to(np.asarray(start_angle, dtype=float), (count,))
    end_angle = np.broadcast_to(np.asarray(end_angle, dtype=float), (count,))
    chord = np.hypot(end[:, 0], end[:, 1])
    excess = 1.0 - chord if excess is None else np.broadcast_to(np.asarray(excess, dtype=float), (count,))
    # Where the ends coincide the chord has no direction, and any frame serves.
    frame = np.where(excess < 1.0 - 1e-14, np.arctan2(end[:, 1], end[:, 0]), start_angle if start_clamped else 0.0)
    a = wrap(start_angle - frame) if start_clamped else np.zeros(count)
    b = wrap(end_angle - frame) if end_clamped else np.zeros(count)
    finite = np.isfinite(excess) & np.isfinite(a) & np.isfinite(b) & np.isfinite(frame)
    result = np.where(finite & (excess > 0.0), UNSOLVED, INFEASIBLE).astype(object)
    aligned = finite & (excess == 0.0) & (np.abs(a) < 1e-9) & (np.abs(b) < 1e-9)
    result[aligned] = STRAIGHT
    excess = np.where(finite, excess, 1.0)
    descents = np.zeros(count, dtype=int)
    apart = np.full(count, True)
    problems = []
    if not start_clamped and not end_clamped:
        apart = excess < 1.0 - ONE_POINT
        turned = Problem(True, False, a, b, excess, None, one_point=True)
        problems.append((turned, np.flatnonzero((result == UNSOLVED) & ~apart)))
    given = Problem(start_clamped, end_clamped, a, b, excess, torsion_ratio)
    problems.append((given, np.flatnonzero((result == UNSOLVED) & apart)))
    parts = []
    for problem, scenes in problems:
        for some in _chunks(scenes, wide=search == "wide"):
            parts.append(_run(problem, some, descents, wide=search == "wide"))
            missing = some[~_answered(parts[-1], count)[some]]
            if len(missing) and search != "wide":
                parts += [_run(problem, few, descents, wide=True) for few in _chunks(missing, wide=True)]
    found = ranked(absolute(join(*parts), start_angle, end_angle, frame))
    result[found.scene] = SOLVED
    return Search(found, list(result), descents)


def _answered(found: Equilibria, count: int) -> np.ndarray:
    """For which of `count` scenes the equilibrium of least energy is stable in the plane.

    One that is not proves that there is a lower one, down the way it gives in to.
    """
    least, stable = np.full((2, count), np.inf)
    np.minimum.at(least, found.scene, found.energy)
    own = found.stable_in_plane
    np.minimum.at(stable, found.scene[own], found.energy[own])
    answered: np.ndarray = np.isfinite(stable) & (stable <= least * (1.0 + _ALIKE))
    return answered


def _chunks(scenes: np.ndarray, *, wide: bool) -> list[np.ndarray]:
    size = CHUNK // 8 if wide else CHUNK
    return [scenes[low : low + size] for low in range(0, len(scenes), size)]


def _run(problem: Problem, scenes: np.ndarray, descents: np.ndarray, *, wide: bool) -> Equilibria:
    """Search `scenes` (indices); `descents` counts the starts."""
    best = np.full(len(problem.excess), np.inf)
    parts, seeds, scenes = _taut_tier(problem, scenes)
    for part in parts:
        np.minimum.at(best, part.scene, part.energy)
    coarse = ritz(*problem.kind, COARSE_MODES)
    if all(problem.kind):
        rounds: list[tuple[int, ...]] = [(-2, -1, 0, 1, 2)] if wide else [(-1, 0, 1), (-1, 1)]
    else:
        rounds = [(0,)]
    for i, windings in enumerate(rounds):
        if not len(scenes):
            break
        begin = starts(
            problem.a[scenes], problem.b[scenes], *problem.kind, problem.excess[scenes], windings=windings, wide=wide
        )
        scene, data = scenes[begin.scene], begin.data
        if all(problem.kind) and not wide:
            # Differences below a full turn first; the others only where their bound is below the best found.
            bound = (data[:, 1] - data[:, 0]) ** 2 / 2.0
            first = bound <= _TURN**2 / 2.0
            keep = first if i == 0 else (bound < best[scene]) & ~first
            scene, data = scene[keep], data[keep]
        if not len(scene):
            continue
        np.add.at(descents, scene, 1)
        z = np.zeros((len(scene), COARSE_MODES + 2))
        z[:, :4] = data
        starting = z
        z, force, reached = descend(coarse, z, problem.excess[scene])
        energy = ((z[:, 1] - z[:, 0]) ** 2 + np.sum(z[:, 2:] ** 2, axis=1)) / 2.0
        np.minimum.at(best, scene[reached], energy[reached])
        kept = np.flatnonzero(reached)
        # What is still on its way may yet be the least of all.
        late = np.flatnonzero(~reached & (energy < best[scene]))
        kept = np.concatenate([some[_distinct(scene[some], z[some])] for some in (kept, late)])
        if wide:
            # From the starts themselves Newton's method goes to whatever is near, unstable equilibria too.
            seeds.append((scene, padded(starting, SHARP_MODES), _first_force(problem, starting)))
        seeds.append((scene[kept], padded(z[kept], SHARP_MODES), force[kept]))
    if not any(problem.kind) and len(scenes):
        seeds.append(_pinned_modes(scenes, problem.excess[scenes]))
    if seeds:
        scene, z, force = (np.concatenate(part) for part in zip(*seeds, strict=True))
        parts += _finish(problem, scene, z, force)
    return join(*parts)


def _taut_tier(
    problem: Problem, scenes: np.ndarray
) -> tuple[list[Equilibria], list[tuple[np.ndarray, Array, Array]], np.ndarray]:
    """Taut cables in closed form, seeds from those not quite taut, and the scenes still to be searched."""
    if not len(scenes) or not any(problem.kind):
        return [], [], scenes
    pulled = taut(problem.a[scenes], problem.b[scenes], *problem.kind, problem.excess[scenes]).among(scenes)
    exact = pulled.take(np.flatnonzero(pulled.omega >= EXACT))
    closed = np.zeros(len(problem.excess), dtype=bool)
    closed[exact.scene] = True
    scenes = scenes[~(closed[scenes] & (problem.excess[scenes] < ROOM))]
    near = pulled.take(np.flatnonzero((pulled.omega < EXACT) & np.isin(pulled.scene, scenes)))
    seeds = [(near.scene, *_modes_of(near, SHARP_MODES))] if len(near.scene) else []
    return [classify_taut(exact, problem)] if len(exact.scene) else [], seeds, scenes


def _first_force(problem: Problem, z: Array) -> Array:
    """Least-squares multipliers at starts."""
    return first_force(ritz(*problem.kind, COARSE_MODES), z)


def _finish(problem: Problem, scene: np.ndarray, z: Array, force: Array) -> list[Equilibria]:
    """From near solutions to equilibria: by a sketch where that may do, and what does not end there by all modes."""
    # By scene, so that what is found of one does not depend on the others.
    hardest = np.zeros(len(problem.excess))
    np.maximum.at(hardest, scene, np.sqrt(np.hypot(force[:, 0], force[:, 1])))
    enough = modes_for(hardest[scene])
    functions = ritz(*problem.kind, COARSE_MODES).functions
    bent = np.max(np.abs(z[:, : COARSE_MODES + 2] @ functions.T), axis=1) > _BENT
    modes = np.where(bent, sketch_modes_for(hardest[scene]), enough)
    done: list[Equilibria] = []
    left = np.arange(len(scene))
    while len(left):
        again = []
        for count in np.unique(modes[left]).tolist():
            rows = left[modes[left] == count]
            sketched = bool(count < enough[rows[0]])
            found, ended = _finish_with(
                problem, count, scene[rows], z[rows, : count + 2], force[rows], sketched=sketched
            )
            done.append(found)
            again.append(rows[~ended & sketched])
        left, modes = np.concatenate(again), enough
    return done


def _finish_with(
    problem: Problem, modes: int, scene: np.ndarray, z: Array, force: Array, *, sketched: bool
) -> tuple[Equilibria, np.ndarray]:
    """The equilibria that near solutions lead to over so many modes, and which of them did lead to one, shape (n,)."""
    space, settled = ritz(*problem.kind, modes), _SKETCHED if sketched else SETTLED
    z, force, change = newton(space, z, force, problem.excess[scene], settled=settled)
    # A line is no answer, though a hair of excess is less than the residual allows.
    short = np.abs(gap(space, z, problem.excess[scene])[2][:, 0])
    ended = (change < settled) & (short <= _FULL * problem.excess[scene])
    if sketched:  # what went to small angles is not for a sketch either
        ended &= np.max(np.abs(z @ space.functions.T), axis=1) > _BENT / 2.0
    good = np.flatnonzero(ended)
    kept = good[_distinct(scene[good], z[good], 1e-6)]
    scene, z, force = scene[kept], z[kept], force[kept]
    middle, probe, residual = polish(space, z, force, problem.targets[scene], problem.excess[scene], sketched=sketched)
    ended[kept] = residual <= RESIDUAL
    left = np.flatnonzero(residual <= RESIDUAL)
    found = classify(problem, space, scene[left], z[left], middle.take(left), probe.take(left), residual[left])
    if sketched:
        # Near a fold the sketch of a minimum may lead to the saddle beside it.
        sure = found.verdict[:, 0] != 0
        ended[kept[left[~sure]]] = False
        found = found.take(np.flatnonzero(sure))
    elif len(found) > _FEW:
        judge_in_plane(found)
    return found, ended


def _distinct(scene: np.ndarray, z: Array, tolerance: float = 1e-2) -> np.ndarray:
    """Indices of rows that differ from each other within their scene.

    Rows are compared by energy, end angle and a fixed generic combination of their coefficients, relative to the size
    of their angles: twins agree in the first two only. A row kept twice does no harm.
    """
    if not len(scene):
        return np.zeros(0, dtype=int)
    mix = 1.0 / (1.0 + 0.37 * np.arange(z.shape[1])) * np.where(np.arange(z.shape[1]) % 3 == 1, -0.83, 1.0)
    signature = z @ mix / np.minimum(1.0, np.max(np.abs(z), axis=1) + 1e-300)
    energy = (z[:, 1] - z[:, 0]) ** 2 + np.sum(z[:, 2:] ** 2, axis=1)
    order = np.lexsort((signature, scene))
    scene, signature, energy, end = scene[order], signature[order], energy[order], z[order, 1]
    fresh = np.ones(len(order), dtype=bool)
    fresh[1:] = (
        (np.diff(scene) != 0)
        | (np.abs(np.diff(signature)) > tolerance)
        | (np.abs(np.diff(energy)) > tolerance * (energy[1:] + energy[:-1]))
        | (np.abs(np.diff(end)) > tolerance)
    )
    kept: np.ndarray = np.sort(order[fresh])
    return kept


def _modes_of(pulled: Taut, modes: int) -> tuple[Array, Array]:
    """Coefficients and force of taut cables: c_j = int theta' p_j ds by quadrature fine enough for their layers."""
    s, w = gauss_legendre(4 * modes)
    polynomial, _ = legendre(s, modes)
    z = np.empty((len(pulled.scene), modes + 2))
    z[:, 0], z[:, 1] = pulled.direction + pulled.a, pulled.direction + pulled.b
    z[:, 2:] = pulled.curvature(s) @ (w[:, None] * polynomial)
    size = pulled.omega**2
    return z, np.stack([size * np.cos(pulled.direction), size * np.sin(pulled.direction)], axis=-1)


def _pinned_modes(scenes: np.ndarray, excess: Array) -> tuple[np.ndarray, Array, Array]:
    """Seeds near the pinned modes 2 and 3, unstable ones: theta = A cos(j pi s), mean of cos(theta) = J0(A) = d."""
    # J0(A) = 1 - A^2/4 + A^4/64 to the amplitudes that matter; Newton mends the rest.
    amplitude = np.sqrt(8.0 * (1.0 - np.sqrt(np.maximum(1.0 - excess, 0.0) * 0.96 + 0.04)))
    s, w = gauss_legendre(60)
    polynomial, _ = legendre(s, SHARP_MODES)
    scene, z, force = [], [], []
    for mode in (2, 3):
        for sign in (1.0, -1.0):
            rows = np.zeros((len(scenes), SHARP_MODES + 2))
            rows[:, 0], rows[:, 1] = sign * amplitude, sign * amplitude * (-1.0) ** mode
            slope = -sign * mode * np.pi * np.sin(mode * np.pi * s) * w
            rows[:, 2:] = amplitude[:, None] * (slope @ polynomial)
            scene.append(scenes)
            z.append(rows)
            load = -((mode * np.pi) ** 2) * (1.0 + excess)
            force.append(np.stack([load, 0.0 * load], axis=-1))
    return np.concatenate(scene), np.concatenate(z), np.concatenate(force)
