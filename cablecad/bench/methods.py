"""Ways to solve a two-point problem between clamps: ours, collocation, a discrete rod; and their turns."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial

import numpy as np

from cablecad.bench.collocation import Found, Guess, boundary_value, naive_guess
from cablecad.bench.discrete_rod import search_rod
from cablecad.bench.scenes import Array, Scenes, scene_cables
from cablecad.errors import CablecadError, SolveError
from cablecad.model import Cable
from cablecad.rod.solution import RodSolution
from cablecad.rod.solve import solve_many, solve_rod

COLD, WARM = "cablecad, cold", "cablecad, warm (moved)"
UNIT = "solve_bvp 1e-06, good start"
RODS = {f"discrete rod, {n} segments": n for n in (50, 100, 200)}
"""Methods that may take seconds a scene, and their segments."""

STARTS = 3
"""Of a discrete rod, at random."""

Answer = RodSolution | CablecadError


@dataclass(frozen=True)
class Case:
    """A scene, and what some methods are given beside it.

    Attributes:
        a: Angle at the start.
        b: Angle at the end.
        end: Place of the end.
        cable: The scene as a cable.
        neighbour: Solution of a scene 1 % away, for the warm step; an error where it has none.
        guess: Of the solution, nine points for collocation; None where there is none.
    """

    a: float
    b: float
    end: Array
    cable: Cable
    neighbour: Answer
    guess: Guess | None


Method = Callable[[Case], Callable[[], Found]]
"""Solves a case; what it found is read off later, and that takes no part in its time."""

NOTHING = Found(np.inf, np.full((9, 2), np.nan))


def all_methods() -> dict[str, Method]:
    """Every method, by the name of its row."""
    bvp = {
        f"solve_bvp {tolerance:.0e}, good start": partial(_by_collocation, tolerance=tolerance)
        for tolerance in (1e-3, 1e-6, 1e-9)
    }
    rods = {name: partial(_by_rod, segments=n) for name, n in RODS.items()}
    return {COLD: cold, WARM: warm, **bvp, "solve_bvp 1e-06, naive start": _by_naive_collocation, **rods}


def cold(case: Case) -> Callable[[], Found]:
    """Ours, from nothing but the scene."""
    try:
        solution = solve_rod(case.cable)
    except CablecadError:
        return lambda: NOTHING
    judge(solution)
    return partial(read_off, solution)


def warm(case: Case) -> Callable[[], Found]:
    """Ours, from the neighbour's solution."""
    if isinstance(case.neighbour, RodSolution):
        with suppress(SolveError):  # a branch that ended is an answer too, and took its time
            moved = case.neighbour.moved(start=case.cable.start_support, end=case.cable.end_support)  # type: ignore[arg-type]
            judge(moved)
            return partial(read_off, moved)
    return lambda: NOTHING


def _by_collocation(case: Case, *, tolerance: float) -> Callable[[], Found]:
    if case.guess is None:
        return lambda: NOTHING
    return boundary_value(case.a, case.end, case.guess, tolerance=tolerance)


def _by_naive_collocation(case: Case) -> Callable[[], Found]:
    return boundary_value(case.a, case.end, naive_guess(case.a, case.b, case.end))


def _by_rod(case: Case, *, segments: int) -> Callable[[], Found]:
    rng = np.random.default_rng(round(1e9 * abs(case.a)))  # of the scene: the same starts for any number of segments
    found = search_rod(case.a, case.b, case.end, segments=segments, starts=STARTS, rng=rng)
    return lambda: found


def judge(solution: RodSolution) -> None:
    """Ask for what is only worked out when it is asked for."""
    verdict = solution.stability
    bool(verdict.stable_in_plane), bool(verdict.stable_out_of_plane)


def judge_all(answers: Sequence[Answer]) -> None:
    """`judge` all that were solved."""
    for answer in answers:
        if isinstance(answer, RodSolution):
            judge(answer)


def read_off(answer: Answer) -> Found:
    """Energy and points of an answer, to compare it by."""
    if isinstance(answer, CablecadError):
        return NOTHING
    return Found(answer.equilibrium.energy_per_EI * answer.length, answer.points(9)[:, :2])


def cases_of(scenes: Scenes) -> list[Case]:
    """Scenes with what warm steps and good guesses begin from."""
    cables = scene_cables(scenes)
    solved = solve_many(cables)
    neighbours = solve_many(scene_cables(Scenes(scenes.a + 0.01, scenes.b - 0.01, scenes.end * 0.99)))
    return [
        Case(
            float(scenes.a[i]), float(scenes.b[i]), scenes.end[i], cable, neighbours[i], _guess(solved[i], scenes.a[i])
        )
        for i, cable in enumerate(cables)
    ]


def _guess(answer: Answer, angle: float) -> Guess | None:
    """Nine points of a solution: angles without jumps, curvatures about z, places; and the internal force."""
    if isinstance(answer, CablecadError):
        return None
    s, fine = np.linspace(0.0, 1.0, 9), np.linspace(0.0, 1.0, 2001)
    tangent = answer.tangent(fine)
    turned = np.unwrap(np.arctan2(tangent[:, 1], tangent[:, 0]))
    theta = angle + np.interp(s, fine, turned - turned[0])
    kappa = np.interp(s, fine, np.gradient(turned, fine))
    return Guess(theta, kappa, answer.position(s)[:, :2], answer.equilibrium.end.force_per_EI[:2])


def in_turn(
    cases: Sequence[Case], methods: dict[str, Method], *, few: int | None = None, between: Callable[[], object] = bool
) -> tuple[dict[str, list[Found]], dict[str, list[float]]]:
    """What each method finds of each case, and its times [s], the methods taking turns.

    The first call of each does not count, for it loads what is loaded late: with few cases it would tell.

    Args:
        cases: What to solve.
        methods: By name.
        few: How many of the cases discrete rods get, which take seconds; None for all.
        between: Takes three turns beside them.
    """
    found: dict[str, list[Found]] = {name: [] for name in methods}
    times: dict[str, list[float]] = {name: [] for name in methods}
    for name, method in methods.items():
        if name not in RODS:
            method(cases[0])
    for i, case in enumerate(cases):
        if i % max(1, len(cases) // 3) == 0:
            between()
        for name, method in methods.items():
            if name in RODS and few is not None and i >= few:
                continue
            begun = time.perf_counter()
            read = method(case)
            times[name].append(time.perf_counter() - begun)
            found[name].append(read())
    return found, times
