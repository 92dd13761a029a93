"""Two-point problems: our solver cold, warm and batched beside collocation, a discrete rod and a 45-start search.

Errors are taken on reference scenes that were solved to 26 digits without elliptic functions; shares and times on
random scenes. The least energy known of a random scene is the lower of ours and of the 45-start search, which share
no code. All times are medians over scenes of one run in which the methods take turns. Of ours both margins of
stability are asked, which no rival knows.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import median

import numpy as np

from cablecad.bench.clock import once
from cablecad.bench.collocation import Found
from cablecad.bench.discrete_rod import rod_energy
from cablecad.bench.methods import (
    COLD,
    NOTHING,
    STARTS,
    UNIT,
    WARM,
    Answer,
    all_methods,
    cases_of,
    in_turn,
    judge_all,
    read_off,
)
from cablecad.bench.scenes import Array, Scenes, random_scenes, scene_cables
from cablecad.bench.search import search_45
from cablecad.bench.stage import Effort, Tell
from cablecad.bench.table import Plot, Table, Target, column
from cablecad.bench.truth import planar_truths
from cablecad.errors import InfeasibleError
from cablecad.rod.solution import RodSolution
from cablecad.rod.solve import solve_many

RESIDUAL = 1e-12
"""Target: largest unmet end condition, position over length, direction as an angle."""

SAME = 1e-9
"""Relative difference of energies that is rounding."""

ALIKE = 0.01
"""Relative difference of energies that may be a rival's discretisation rather than another equilibrium."""

BATCHED = "cablecad, batched"

PYELASTICA_MS, PYELASTICA_ERROR = 8100.0, 9.0e-5
"""Of PyElastica 1.0.0 on the scene random04, 32 segments: where its error had settled (`pyelastica`)."""


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


def run(effort: Effort, tell: Tell) -> list[Table]:
    """The stage."""
    scenes = random_scenes(effort.count(2000, 60), 1)
    by_search = effort.count(2000, 20)
    tell(f"{by_search} scenes by a search from 45 starts")
    searched = np.full(len(scenes.a), np.nan)

    def search() -> None:
        searched[:by_search] = search_45(scenes.take(slice(0, by_search)))

    search_time = once(search) / by_search
    kinds, ours = _kinds(effort, tell, scenes, searched)
    best = np.fmin(ours, searched)
    count, few = effort.count(40, 16), effort.count(40, 1)
    tell(f"{count} scenes by every method in turn")
    batch_times: list[float] = []
    together = scene_cables(scenes.take(slice(0, effort.count(1000, 60))))

    def batch() -> None:
        batch_times.append(once(lambda: judge_all(solve_many(together))) / len(together))

    found, times = in_turn(cases_of(scenes.take(slice(0, count))), all_methods(), few=few, between=batch)
    tell("reference scenes")
    truths = planar_truths()[:: effort.count(1, 10)]
    references = Scenes(*(np.array([getattr(t, key) for t in truths]) for key in ("a", "b", "end")))
    checked, _ = in_turn(cases_of(references), all_methods(), few=effort.count(len(truths), 1))
    exact = np.array([t.energy for t in truths])
    places = np.array([t.points for t in truths])
    unit = median(times[UNIT])
    rows = []
    for name in all_methods():
        energy = np.array([one.energy for one in found[name]])
        rows.append(
            SolveRow(
                name,
                len(energy),
                median(times[name]) * 1e3,
                median(times[name]) / unit,
                *_shares(energy, best[: len(energy)]),
                *_errors(checked[name], exact, places),
            )
        )
    at_once = [read_off(answer) for answer in solve_many(scene_cables(references))]
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
            by_search,
            search_time * 1e3,
            search_time / unit,
            *_shares(searched[:by_search], best[:by_search]),
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


def _shares(energy: Array, best: Array) -> tuple[float, float]:
    """Percentage solved, and at the least energy."""
    solved = np.isfinite(energy)
    return 100.0 * float(solved.mean()), 100.0 * float((energy <= best * (1.0 + ALIKE)).mean())


def _errors(found: Sequence[Found], exact: Array, places: Array) -> tuple[float | None, float | None]:
    """Median relative error of the energy and of points, where the least energy was found; of the first scenes."""
    exact, places = exact[: len(found)], places[: len(found)]
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
            f"discrete rods: the first scenes, 200 segments from {effort.count(10, 2)} random starts each; above: by "
            "more than twice the rod's own discretisation error, a third of the difference to 100 segments",
        ),
    )
    return table, _energies(answers)


def _against_rods(effort: Effort, tell: Tell, scenes: Scenes, energy: Array) -> Target:
    """How many of the first scenes are above a discrete elastic rod by more than its discretisation error."""
    count, starts = effort.count(100, 2), effort.count(10, 2)
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
