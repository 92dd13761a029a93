"""The figures of the planar solver, by its public functions: what it solves, against what, and in what time.

Every line states its target and whether it holds. Seeds are fixed; times are ratios of medians taken in one run, the
rivals' turns between the solver's own.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from cablecad.bench.rivals import Array, Scenes, boundary_value, rival_energy, search_45
from cablecad.errors import CablecadError, InfeasibleError, SolveError
from cablecad.model import Cable, Clamp, Material, Pin
from cablecad.rod.solution import RodSolution
from cablecad.rod.solve import solve_many, solve_rod

RESIDUAL = 1e-12
"""Target: largest unmet end condition, position over length, direction as an angle."""

SAME = 1e-9
"""Relative difference of energies that is rounding."""

# GJ/EI of 0.8, so that the twist takes part: Poisson's ratio of 1/4. The size of the modulus does not matter.
_MATERIAL = Material(youngs_modulus=1000.0, poissons_ratio=0.25)

Answer = RodSolution | CablecadError


@dataclass(frozen=True)
class Line:
    """One figure: what it is, what came out, and whether it is what was aimed at."""

    name: str
    obtained: str
    target: str
    holds: bool


def random_scenes(count: int, seed: int, *, excess: bool = False) -> Scenes:
    """Chord/length uniform in 0..0.999 (or the excess log-uniform in 1e-10..1e-2), all directions and angles."""
    rng = np.random.default_rng(seed)
    d = 1.0 - 10.0 ** rng.uniform(-10.0, -2.0, count) if excess else rng.uniform(0.0, 0.999, count)
    toward, a, b = (rng.uniform(-np.pi, np.pi, count) for _ in range(3))
    if excess:
        # Every other one with angles of the order its slack allows without boundary layers.
        small = 3.0 * np.sqrt(1.0 - d) / np.pi
        a, b = (toward + angle * np.where(np.arange(count) % 2, small, 1.0) for angle in (a, b))
    return Scenes(a, b, d[:, None] * np.stack([np.cos(toward), np.sin(toward)], axis=-1))


def cables(scenes: Scenes, *, start_clamped: bool = True, end_clamped: bool = True) -> list[Cable]:
    """Scenes as cables of 1 mm."""
    made = []
    for a, b, (x, y) in zip(scenes.a, scenes.b, scenes.end, strict=True):
        begin, finish = (0.0, 0.0, 0.0), (float(x), float(y), 0.0)
        made.append(
            Cable(
                "bench",
                1e-3,
                Clamp(begin, (math.cos(a), math.sin(a), 0.0)) if start_clamped else Pin(begin),
                Clamp(finish, (math.cos(b), math.sin(b), 0.0)) if end_clamped else Pin(finish),
                length=1.0,
                material=_MATERIAL,
                bulge=(1e-3, 1.0, 0.0),
            )
        )
    return made


def figures(share: float = 1.0) -> tuple[str, bool]:
    """The table of figures, and whether every target holds.

    Args:
        share: Of the full counts, in (0, 1]; the targets stay.
    """
    lines = [
        *_random_clamps(share),
        _solved("300 pin-pin: solved", random_scenes(_count(300, share), 2), start_clamped=False, end_clamped=False),
        _solved("300 clamp-pin: solved", random_scenes(_count(300, share), 3), end_clamped=False),
        *_hair_of_slack(share),
        *_times(share),
    ]
    width = [max(len(getattr(line, key)) for line in lines) for key in ("name", "obtained", "target")]
    text = "\n".join(
        f"{line.name:<{width[0]}}  {line.obtained:<{width[1]}}  {line.target:<{width[2]}}  "
        f"{'holds' if line.holds else 'MISSED'}"
        for line in lines
    )
    return text, all(line.holds for line in lines)


def _count(full: int, share: float) -> int:
    return max(2, round(full * share))


def _energies(answers: Sequence[Answer]) -> Array:
    return np.array([a.equilibrium.energy_per_EI * a.length if isinstance(a, RodSolution) else np.inf for a in answers])


def _worst(answers: Sequence[Answer]) -> float:
    return max((a.residual for a in answers if isinstance(a, RodSolution)), default=math.inf)


def _share(answers: Sequence[Answer]) -> tuple[int, str]:
    solved = sum(isinstance(a, RodSolution) for a in answers)
    return solved, f"{solved} of {len(answers)}"


def _random_clamps(share: float) -> list[Line]:
    scenes = random_scenes(_count(2000, share), 1)
    answers = solve_many(cables(scenes))
    solved, text = _share(answers)
    worst, energy = _worst(answers), _energies(answers)
    stable = all(bool(a.stability.stable_in_plane) for a in answers if isinstance(a, RodSolution))
    lines = [
        Line("2000 clamp-clamp: solved", text, "all", solved == len(answers)),
        Line("  worst residual", f"{worst:.1e}", f"<= {RESIDUAL:.0e}", worst <= RESIDUAL),
        Line("  stable in the plane", "all" if stable else "NOT all", "all", stable),
    ]
    best = search_45(scenes)
    known = np.isfinite(best)
    above = np.count_nonzero(known & (energy > best * (1.0 + SAME)))
    missed = np.count_nonzero(known & (energy < best * (1.0 - SAME)))
    said = f"{above} above; rival higher {missed}, rival without an answer {np.count_nonzero(~known)}"
    lines.append(Line("  against the best of 45 starts", said, "none above", above == 0))
    some = _count(100, share)
    rng = np.random.default_rng(11)
    rival, error = np.array([rival_energy(scenes.a[i], scenes.b[i], scenes.end[i], rng, 10) for i in range(some)]).T
    # The error is Richardson's estimate; twice of it leaves room for its own.
    known = np.isfinite(rival) & np.isfinite(error)
    margin = np.where(known, 2.0 * error + 1e-6 * energy[:some], 0.0)
    higher = np.count_nonzero(known & (energy[:some] > rival + margin))
    same = np.count_nonzero(known & (np.abs(energy[:some] - rival) <= margin))
    missed = np.count_nonzero(known & (energy[:some] < rival - margin))
    said = (
        f"{higher} above; same {same}, rival higher {missed}, rival without an answer {some - np.count_nonzero(known)}"
    )
    lines.append(Line("  100 against a discrete rod, 10 starts", said, "none above", higher == 0))
    return lines


def _solved(name: str, scenes: Scenes, *, start_clamped: bool = True, end_clamped: bool = True) -> Line:
    answers = solve_many(cables(scenes, start_clamped=start_clamped, end_clamped=end_clamped))
    solved, text = _share(answers)
    worst = _worst(answers)
    said = f"{text}, worst residual {worst:.1e}"
    return Line(name, said, f"all, <= {RESIDUAL:.0e}", solved == len(answers) and worst <= RESIDUAL)


def _hair_of_slack(share: float) -> list[Line]:
    answers = solve_many(cables(random_scenes(_count(500, share), 4, excess=True)))
    solved, text = _share(answers)
    refused = sum(isinstance(a, InfeasibleError) for a in answers)
    worst = _worst(answers)
    return [
        Line(
            "500 with 1 - d in 1e-10..1e-2",
            f"solved {text}, refused with the reason {refused}",
            "solved or refused",
            solved + refused == len(answers),
        ),
        Line("  worst residual", f"{worst:.1e}", f"<= {RESIDUAL:.0e}", worst <= RESIDUAL),
    ]


def _times(share: float) -> list[Line]:
    """Medians; both margins of stability are asked of every solution, which `solve_bvp` does not know."""
    scenes = random_scenes(_count(120, share), 5)
    many = cables(random_scenes(_count(1000, share), 6))
    ones = cables(scenes)
    moved = Scenes(scenes.a + 0.01, scenes.b - 0.01, scenes.end * 0.99)
    places = cables(moved)
    solve_many(many[:2])  # trial functions are made once in a process
    cold, warm, batch, rival = [], [], [], []
    s = np.linspace(0.0, 1.0, 9)
    for i, (cable, place) in enumerate(zip(ones, places, strict=True)):
        begun = time.perf_counter()
        solution = solve_rod(cable)
        _judge(solution)
        cold.append(time.perf_counter() - begun)
        guess = _guess(solution, scenes.a[i], s)
        begun = time.perf_counter()
        boundary_value(scenes, i, guess)
        rival.append(time.perf_counter() - begun)
        begun = time.perf_counter()
        with suppress(SolveError):  # a branch that ended is an answer too, and took its time
            _judge(solution.moved(start=place.start_support, end=place.end_support))  # type: ignore[arg-type]
        warm.append(time.perf_counter() - begun)
        if i % max(1, len(ones) // 3) == 0:
            begun = time.perf_counter()
            for answer in solve_many(many):
                if isinstance(answer, RodSolution):
                    _judge(answer)
            batch.append((time.perf_counter() - begun) / len(many))
    unit = float(np.median(rival))
    lines = []
    for name, taken, target in (("cold", cold, 1.0), ("solve_many over 1000", batch, 0.3), ("a warm step", warm, 0.1)):
        ratio = float(np.median(taken)) / unit
        said = f"{ratio:.3f} ({np.median(taken) * 1e3:.2f} ms; mean {np.mean(taken) * 1e3:.2f} ms)"
        lines.append(Line(f"time over solve_bvp's: {name}", said, f"<= {target}", ratio <= target))
    lines[0] = Line(
        f"{lines[0].name} (it took {unit * 1e3:.2f} ms)",
        *(getattr(lines[0], k) for k in ("obtained", "target", "holds")),
    )
    return lines


def _judge(solution: RodSolution) -> None:
    verdict = solution.stability
    bool(verdict.stable_in_plane), bool(verdict.stable_out_of_plane)


def _guess(solution: RodSolution, angle: float, s: Array) -> tuple[Array, Array, Array, Array]:
    """Angles without jumps, curvatures about z, places and internal force at `s`."""
    fine = np.linspace(0.0, 1.0, 2001)
    tangent = solution.tangent(fine)
    turned = np.unwrap(np.arctan2(tangent[:, 1], tangent[:, 0]))
    theta = angle + np.interp(s, fine, turned - turned[0])
    kappa = np.interp(s, fine, np.gradient(turned, fine))
    return theta, kappa, solution.position(s)[:, :2], solution.equilibrium.end.force_per_EI[:2]
