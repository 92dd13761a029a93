"""How cost grows: with the number of cables, the tolerance, and the length in waves.

Exponents are fitted over the upper half of the sizes; p says: twice as many cost 2^p as much. Of the tolerance it is
the order q: an error ten times smaller costs 10^(1/q) times as many spans; ten is what a spline of degree nine can do.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory

import numpy as np

from cablecad.bench.clock import once
from cablecad.bench.sandbox import SandboxError, in_sandbox
from cablecad.bench.stage import Effort, Tell
from cablecad.bench.sweeps import interpolated_spine, sweep_pipe
from cablecad.bench.table import Plot, Table, Target, column
from cablecad.bench.tubes import LENGTH, wave
from cablecad.bench.whole import loom
from cablecad.brep.document import CableSolid
from cablecad.brep.fit import fit_centreline
from cablecad.brep.step import step_text
from cablecad.brep.tube import build_tube
from cablecad.centreline import Centreline
from cablecad.pipeline import run_build, solve_many

RADIUS = 4.0
POINTS_A_WAVE = 16
"""Of the rival's spine."""

CABLES, TOLERANCES, WAVES = "cables in a scene, built", "tolerance of a tube", "waves of a tube, to 1e-6 mm"
SOLVED, RIVAL = "cables solved together", f"waves of a tube, MakePipe through {POINTS_A_WAVE} points each"


@dataclass(frozen=True)
class GrowthRow:
    """One size."""

    what: str = column("what grows")
    size: float = column("size", form="g")
    time: float | None = column("time", "ms", ".3g")
    spans: int | None = column("knot spans", form="d")
    bytes: int | None = column("STEP", "bytes", "d")
    remark: str = column("remark")


@dataclass(frozen=True)
class ExponentRow:
    """A law."""

    what: str = column("what grows")
    of: str = column("what it costs")
    exponent: float = column("exponent", form=".2f")
    sizes: str = column("over sizes")


def run(effort: Effort, tell: Tell) -> list[Table]:
    """The stage."""
    rows: list[GrowthRow] = []
    counts = (1, 10, 30) if effort.quick else (1, 3, 10, 30, 100, 300, 1000)
    tell("number of cables")
    solve_many(loom(1).cables)
    for count in counts:
        cables = loom(count).cables
        taken = _median(lambda cables=cables: solve_many(cables), 3 if count <= 100 else 1)  # type: ignore[misc]
        rows.append(GrowthRow(SOLVED, count, taken, None, None, ""))
    with TemporaryDirectory(prefix="cablecad-bench-") as place:
        for count in counts:
            tell(f"{count} cables")
            rows.append(_built(count, Path(place)))
    tell("tolerance")
    curve = wave(0.8)
    for digit in range(1, 10, effort.count(1, 2)):
        rows.append(_tube(TOLERANCES, 10.0**-digit, curve, 10.0**-digit, effort.count(7, 3)))
    for waves in (1, 3, 10) if effort.quick else (1, 3, 10, 30, 100):
        tell(f"{waves} waves")
        rows.append(_tube(WAVES, waves, wave(0.8, waves), 1e-6, effort.count(5, 2)))
        rows.append(_pipe(waves, effort.count(3, 1)))
    laws = [
        _law(rows, SOLVED, "time"),
        _law(rows, CABLES, "time"),
        _law(rows, CABLES, "bytes"),
        _law(rows, TOLERANCES, "spans", order=True),
        _law(rows, TOLERANCES, "time"),
        _law(rows, WAVES, "time"),
        _law(rows, WAVES, "spans"),
        _law(rows, RIVAL, "time"),
    ]
    exponents = {(row.what, row.of): row.exponent for row in laws}
    return [
        Table(
            "growth",
            "Cost against size",
            rows,
            (),
            (
                f"a wave: k = 0.8, {LENGTH:g} mm long, radius {RADIUS:g} mm; cables: those of the stage 'cable'",
                "with a tolerance below 1e-9 times the length rounding comes into sight",
            ),
            Plot("size", "time", lambda row: row.what if row.what != TOLERANCES else None),
        ),
        Table(
            "exponents",
            "Exponents of growth, fitted over the upper half of the sizes",
            laws,
            [
                Target("growth: exponent of time by number of cables", exponents[CABLES, "time"], 1.15),
                Target("growth: exponent of a tube's time by its waves", exponents[WAVES, "time"], 1.15),
                Target(
                    "growth: order of the fit, error by number of spans",
                    exponents[TOLERANCES, "order of the fit"],
                    9.0,
                    ">=",
                ),
            ],
        ),
    ]


def _built(count: int, place: Path) -> GrowthRow:
    scene, path = loom(count), place / "loom.step"
    taken = _median(lambda: run_build(scene, path).raise_first(), 3 if count <= 10 else 1)
    return GrowthRow(CABLES, count, taken, None, path.stat().st_size, "")


def _tube(what: str, size: float, curve: Centreline, tolerance: float, repeats: int) -> GrowthRow:
    fit = fit_centreline(curve, RADIUS, tolerance=tolerance)
    solid = build_tube(fit, RADIUS)
    taken = _median(lambda: build_tube(fit_centreline(curve, RADIUS, tolerance=tolerance), RADIUS), repeats)
    size_of_file = len(step_text("tube", [], [CableSolid("tube", solid)]))
    return GrowthRow(what, size, taken, fit.spans, size_of_file, "")


def _pipe(waves: int, repeats: int) -> GrowthRow:
    at = wave(0.8, waves).frames(np.linspace(0.0, LENGTH * waves, POINTS_A_WAVE * waves + 1))

    def sweep() -> None:
        sweep_pipe(interpolated_spine(at.position), at.position[0], at.tangent[0], RADIUS)

    try:
        in_sandbox(sweep)
    except SandboxError as error:
        return GrowthRow(RIVAL, waves, None, None, None, str(error))
    return GrowthRow(RIVAL, waves, _median(sweep, repeats), None, None, "")


def _median(work: Callable[[], object], repeats: int) -> float:
    """Median time [ms]."""
    return median(once(work) for _ in range(repeats)) * 1e3


def _law(rows: Sequence[GrowthRow], what: str, key: str, *, order: bool = False) -> ExponentRow:
    """The slope of log(cost) by log(size), or for a tolerance of log(1/tolerance) by log(cost)."""
    some = [row for row in rows if row.what == what and getattr(row, key) is not None]
    some = some[len(some) // 2 :] if len(some) > 3 else some[-2:]
    if len(some) < 2:
        return ExponentRow(what, key, math.nan, "-")
    sizes, costs = (np.log([getattr(row, name) for row in some]) for name in ("size", key))
    slope = float(np.polyfit(costs, -sizes, 1)[0] if order else np.polyfit(sizes, costs, 1)[0])
    return ExponentRow(what, "order of the fit" if order else key, slope, f"{some[0].size:g} to {some[-1].size:g}")
