"""Two-point problems: our solver cold, warm and batched beside collocation, a discrete rod and a 45-start search.

Errors are taken on reference scenes that were solved to 26 digits without elliptic functions; shares and times on
random scenes. The least energy known of a random scene is the lower of ours and of the 45-start search, which share
no code. All times are medians over scenes of one run in which the methods take turns. Of ours both margins of
stability are asked, which no rival knows.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from statistics import median

import numpy as np

from cablecad.bench.clock import once
from cablecad.bench.collocation import Found, Guess, boundary_value, naive_guess
from cablecad.bench.discrete_rod import rod_energy, search_rod
from cablecad.bench.scenes import Array, Scenes, random_scenes, scene_cables
from cablecad.bench.search import search_45
from cablecad.bench.stage import Effort, Tell
from cablecad.bench.table import Plot, Table, Target, column
from cablecad.bench.truth import planar_truths
from cablecad.errors import CablecadError, InfeasibleError, SolveError
from cablecad.model import Cable
from cablecad.rod.solution import RodSolution
from cablecad.rod.solve import solve_many, solve_rod

RESIDUAL = 1e-12
"""Target: largest unmet end condition, position over length, direction as an angle."""

SAME = 1e-9
"""Relative difference of energies that is rounding."""

ALIKE = 0.01
"""Relative difference of energies that may be a rival's discretisation rather than another equilibrium."""

COLD, BATCHED, WARM = "cablecad, cold", "cablecad, batched", "cablecad, warm (moved)"
UNIT = "solve_bvp 1e-06, good start"
STARTS = 3

PYELASTICA_MS, PYELASTICA_ERROR = 8100.0, 9.0e-5
"""Of PyElastica 1.0.0 on the scene random04, 32 segments: where its error had settled (`pyelastica`)."""

Answer = RodSolution | CablecadError


@dataclass(frozen=True)
class SolveRow:
    """A method."""

    method: str = column("method")
    scenes: int = column("scenes", form="d")
    time: float | None = column("time", "ms/scene", ".3g")
    over_bvp: float | None = column("time over solve_bvp's", form=".2f")
    solved: float | None = column("solved", "%", ".1f")
    least: float | None = column("at the least energy", "%", ".1f")
    energy_error: float | None = column("energy error", form=".1e")
    point_error: float | None = column("point error over length", form=".1e")


@dataclass(frozen=True)
class KindRow:
    """Scenes of one kind, solved together by ours alone."""

    kind: str = column("kind of scene")
    scenes: int = column("scenes", form="d")
    solved: int = column("solved", form="d")
    refused: int = column("refused with the reason", form="d")
    residual: float = column("worst residual", form=".1e")
    unstable: int = column("unstable in the plane", form="d")
    above: int | None = column("above the 45 starts", form="d")
    below: int | None = column("below the 45 starts", form="d")


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


def run(effort: Effort, tell: Tell) -> list[Table]:
    """The stage."""
    scenes = random_scenes(effort.count(2000, 60), 1)
    tell(f"{len(scenes.a)} scenes by a search from 45 starts")
    searched = np.empty(0)

    def search() -> None:
        nonlocal searched
        searched = search_45(scenes)

    search_time = once(search) / len(scenes.a)
    kinds, ours = _kinds(effort, tell, scenes, searched)
    best = np.fmin(ours, searched)
    count = effort.count(40, 4)
    tell(f"{count} scenes by every method in turn")
    batch_times: list[float] = []
    together = scene_cables(scenes.take(slice(0, effort.count(1000, 60))))

    def batch() -> None:
        batch_times.append(once(lambda: _judge_all(solve_many(together))) / len(together))

    found, times = _turns(_cases(scenes.take(slice(0, count))), _methods(), between=batch)
    tell("reference scenes")
    truths = planar_truths()[:: effort.count(1, 10)]
    references = Scenes(*(np.array([getattr(t, key) for t in truths]) for key in ("a", "b", "end")))
    checked, _ = _turns(_cases(references), _methods())
    exact = np.array([t.energy for t in truths])
    places = np.array([t.points for t in truths])
    unit = median(times[UNIT])
    rows = []
    for name in _methods():
        energy = np.array([one.energy for one in found[name]])
        rows.append(
            SolveRow(
                name,
                count,
                median(times[name]) * 1e3,
                median(times[name]) / unit,
                *_shares(energy, best[:count]),
                *_errors(checked[name], exact, places),
            )
        )
    at_once = [_found(answer) for answer in solve_many(scene_cables(references))]
    batched = median(batch_times)
    rows.insert(
        1,
        SolveRow(
            BATCHED,
            len(scenes.a),
            batched * 1e3,
            batched / unit,
            *_shares(ours, best),
            *_errors(at_once, exact, places),
        ),
    )
    from_starts = [Found(float(e), NOTHING.points) for e in search_45(references)]
    errors = _errors(from_starts, exact, places)[0], None
    rows.append(
        SolveRow(
            "search from 45 starts",
            len(scenes.a),
            search_time * 1e3,
            search_time / unit,
            *_shares(searched, best),
            *errors,
        )
    )
    rows.append(SolveRow("PyElastica 1.0, recorded", 1, PYELASTICA_MS, None, None, None, None, PYELASTICA_ERROR))
    return [_table(rows, effort, len(truths)), kinds]


def _table(rows: Sequence[SolveRow], effort: Effort, references: int) -> Table:
    taken = {row.method: row.over_bvp or math.inf for row in rows}
    return Table(
        "solve",
        "Two-point problems between clamps: time, reliability and error",
        rows,
        [
            Target("solve: time over solve_bvp's at 1e-6 from a good start: cold", taken[COLD], 1.0),
            Target("solve: time over solve_bvp's likewise: solved together", taken[BATCHED], 0.3),
            Target("solve: time over solve_bvp's likewise: a warm step", taken[WARM], 0.1),
        ],
        (
            f"solve_many takes {effort.count(1000, 60)} scenes together; at the least energy: within 1 % of the lower "
            "of ours and of the 45 starts",
            f"errors: medians over those of {references} reference scenes (26 digits) where the method is at the least "
            "energy; of energy relative, of nine points the largest component",
            "solve_bvp, good start: nine points of our own solution, 1 % off, the right winding; naive start: the "
            "angle turning evenly, the place along the chord, no force. It finds one equilibrium and cannot tell "
            "whether it is stable or the least",
            f"discrete rod: scipy's L-BFGS from {STARTS} random starts",
            "PyElastica: recorded figures of one scene and 32 segments, on two busy cores; it takes no turns here: "
            "python -m cablecad.bench.pyelastica takes them anew",
        ),
        Plot("time", "point_error", _series),
    )


def _series(row: SolveRow) -> str:
    """Our three ways each on its own, what differs in its tolerance or its segments joined."""
    if row.method.startswith("solve_bvp"):
        return "solve_bvp, " + row.method.partition(", ")[2]
    return row.method if row.method.startswith("cablecad") else row.method.partition(",")[0]


def _methods() -> dict[str, Method]:
    bvp = {
        f"solve_bvp {tolerance:.0e}, good start": partial(_by_collocation, tolerance=tolerance)
        for tolerance in (1e-3, 1e-6, 1e-9)
    }
    rods = {f"discrete rod, {n} segments": partial(_by_rod, segments=n) for n in (50, 100, 200)}
    return {COLD: _cold, WARM: _warm, **bvp, "solve_bvp 1e-06, naive start": _by_naive_collocation, **rods}


def _cold(case: Case) -> Callable[[], Found]:
    try:
        solution = solve_rod(case.cable)
    except CablecadError:
        return lambda: NOTHING
    _judge(solution)
    return partial(_found, solution)


def _warm(case: Case) -> Callable[[], Found]:
    if isinstance(case.neighbour, RodSolution):
        with suppress(SolveError):  # a branch that ended is an answer too, and took its time
            moved = case.neighbour.moved(start=case.cable.start_support, end=case.cable.end_support)  # type: ignore[arg-type]
            _judge(moved)
            return partial(_found, moved)
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


def _judge(solution: RodSolution) -> None:
    verdict = solution.stability
    bool(verdict.stable_in_plane), bool(verdict.stable_out_of_plane)


def _judge_all(answers: Sequence[Answer]) -> None:
    for answer in answers:
        if isinstance(answer, RodSolution):
            _judge(answer)


def _found(answer: Answer) -> Found:
    if isinstance(answer, CablecadError):
        return NOTHING
    return Found(answer.equilibrium.energy_per_EI * answer.length, answer.points(9)[:, :2])


def _cases(scenes: Scenes) -> list[Case]:
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


def _turns(
    cases: Sequence[Case], methods: dict[str, Method], *, between: Callable[[], object] = bool
) -> tuple[dict[str, list[Found]], dict[str, list[float]]]:
    """What each method finds of each case, and its times [s], the methods taking turns; `between` three times too."""
    found: dict[str, list[Found]] = {name: [] for name in methods}
    times: dict[str, list[float]] = {name: [] for name in methods}
    for i, case in enumerate(cases):
        if i % max(1, len(cases) // 3) == 0:
            between()
        for name, method in methods.items():
            begun = time.perf_counter()
            read = method(case)
            times[name].append(time.perf_counter() - begun)
            found[name].append(read())
    return found, times


def _shares(energy: Array, best: Array) -> tuple[float, float]:
    """Percentage solved, and at the least energy."""
    solved = np.isfinite(energy)
    return 100.0 * float(solved.mean()), 100.0 * float((energy <= best * (1.0 + ALIKE)).mean())


def _errors(found: Sequence[Found], exact: Array, places: Array) -> tuple[float | None, float | None]:
    """Median relative error of the energy and of points, where the least energy was found."""
    off = np.abs(np.array([one.energy for one in found]) / exact - 1.0)
    right = off <= ALIKE
    if not right.any():
        return None, None
    points = np.abs(np.array([one.points for one in found]) - places).max(axis=(1, 2))
    return float(np.median(off[right])), float(np.median(points[right]))


# --- kinds of scenes ----------------------------------------------------------------------------------------------


def _kinds(effort: Effort, tell: Tell, scenes: Scenes, searched: Array) -> tuple[Table, Array]:
    """The table of kinds; energies of the clamped scenes, infinite where unsolved."""
    tell(f"{len(scenes.a)} scenes solved together")
    solve_many(scene_cables(scenes.take(slice(0, 2))))  # trial functions are made once in a process
    answers = solve_many(scene_cables(scenes))
    tell("pins, and hairs of slack")
    pins = random_scenes(effort.count(300, 30), 2)
    mixed = random_scenes(effort.count(300, 30), 3)
    slack = random_scenes(effort.count(500, 50), 4, excess=True)
    rows = [
        _kind("clamp-clamp", answers, searched),
        _kind("pin-pin", solve_many(scene_cables(pins, start_clamped=False, end_clamped=False))),
        _kind("clamp-pin", solve_many(scene_cables(mixed, end_clamped=False))),
        _kind("clamp-clamp, 1 - chord/length of 1e-10 to 1e-2", solve_many(scene_cables(slack))),
    ]
    unanswered = sum(row.scenes - row.solved - row.refused for row in rows)
    targets = [
        Target("solve: scenes neither solved nor refused with the reason", unanswered, 0),
        Target("solve: refused although the excess is not a hair", sum(row.refused for row in rows[:3]), 0),
        Target("solve: worst residual", max(row.residual for row in rows), RESIDUAL),
        Target("solve: answers unstable in the plane", sum(row.unstable for row in rows), 0),
        Target("solve: energies above the search from 45 starts", rows[0].above or 0, 0),
        _against_rods(effort, tell, scenes, _energies(answers)),
    ]
    table = Table(
        "solve-kinds",
        "What the planar solver solves: random scenes of fixed seeds, all angles and directions",
        rows,
        targets,
        (
            "above, below: energies that differ by more than 1e-9 of themselves, where the 45 starts have an answer",
            "discrete rods: the first scenes, 200 segments from 10 random starts each; above: by more than twice the "
            "rod's own discretisation error, a third of the difference to 100 segments",
        ),
    )
    return table, _energies(answers)


def _against_rods(effort: Effort, tell: Tell, scenes: Scenes, energy: Array) -> Target:
    """How many of the first scenes are above a discrete elastic rod by more than its discretisation error."""
    count, starts = effort.count(100, 4), effort.count(10, 3)
    tell(f"{count} discrete rods of 200 segments")
    rng = np.random.default_rng(11)
    above = 0
    for i in range(count):
        rival, error = rod_energy(scenes.a[i], scenes.b[i], scenes.end[i], starts=starts, rng=rng)
        if np.isfinite(rival) and np.isfinite(error):
            above += bool(energy[i] > rival + 2.0 * error + 1e-6 * energy[i])
    return Target(f"solve: energies above {count} discrete rods by more than their error", above, 0)


def _kind(name: str, answers: Sequence[Answer], searched: Array | None = None) -> KindRow:
    solved = [answer for answer in answers if isinstance(answer, RodSolution)]
    above = below = None
    if searched is not None:
        energy, known = _energies(answers), np.isfinite(searched)
        above = int(np.count_nonzero(known & (energy > searched * (1.0 + SAME))))
        below = int(np.count_nonzero(known & (energy < searched * (1.0 - SAME))))
    return KindRow(
        name,
        len(answers),
        len(solved),
        sum(isinstance(answer, InfeasibleError) for answer in answers),
        max((answer.residual for answer in solved), default=math.inf),
        sum(not answer.stability.stable_in_plane for answer in solved),
        above,
        below,
    )


def _energies(answers: Sequence[Answer]) -> Array:
    return np.array([a.equilibrium.energy_per_EI * a.length if isinstance(a, RodSolution) else np.inf for a in answers])
