"""Spline and tube: ours to a tolerance, beside the sweeps of Open Cascade and of its hosts.

A wave of the elastica, 1000 mm long, at three moduli: gentle, strongly bent, looped. The time is that of the solid,
from the exact centreline: for ours to the fit, our measurement of its deviation, and the faces, for the others to the
spine and the sweep. The deviation of every solid's side from the exact tube is measured by the same means
(`deviation`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from cablecad.bench.clock import take_turns
from cablecad.bench.deviation import measure_side
from cablecad.bench.sandbox import SandboxError, in_sandbox
from cablecad.bench.stage import Effort, Tell
from cablecad.bench.sweeps import (
    fitted_spine,
    installed_hosts,
    interpolated_spine,
    quintic_spine,
    sweep_by_host,
    sweep_pipe,
    sweep_pipe_shell,
)
from cablecad.bench.table import Plot, Table, Target, column
from cablecad.bench.truth import ArchTruth, arch_truths
from cablecad.brep.check import check_solid
from cablecad.brep.document import CableSolid
from cablecad.brep.fit import fit_centreline
from cablecad.brep.step import step_text
from cablecad.brep.tube import build_tube
from cablecad.centreline import Centreline, Placement
from cablecad.errors import GeometryError
from cablecad.rod.elastica import Inflexional
from cablecad.rod.elliptic import complete_k

if TYPE_CHECKING:
    from OCP.TopoDS import TopoDS_Shape, TopoDS_Wire

LENGTH = 1000.0
RADII = {0.342: 5.0, 0.8: 4.0, 0.999: 4.0}
"""Radius of the tube [mm] by modulus."""

OURS = "cablecad"
SHELL, SHELL_256 = "MakePipeShell along our fit", "MakePipeShell along 256 spans"
TARGET_TOLERANCE = 1e-6

PLOTTED = 0.8
"""The modulus of the plot: a strongly bent curve."""


@dataclass(frozen=True)
class TubeRow:
    """A solid."""

    k: float = column("k", form="g")
    method: str = column("method")
    asked: str = column("asked")
    time: float | None = column("time", "ms", ".3g", default=None)
    deviation: float | None = column("deviation", "mm", ".1e", default=None)
    poles: int | None = column("poles", form="d", default=None)
    bytes: int | None = column("STEP", "bytes", "d", default=None)
    valid: bool | None = column("valid", default=None)
    volume: float | None = column("volume error", form=".1e", default=None)
    remark: str = column("remark", default="")


def wave(k: float, waves: int = 1, length: float = LENGTH) -> Centreline:
    """Waves of the elastica from an inflection, in the plane of x and y, each `length` [mm]."""
    m = k * k
    quarter = complete_k(m, 1.0 - m)
    place = Placement(np.zeros(3), np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]))
    return Centreline([Inflexional(place, length * waves, 4.0 * quarter / length, m, 1.0 - m, -quarter)])


def run(effort: Effort, tell: Tell) -> list[Table]:
    """The stage."""
    tolerances = (1e-3, 1e-6) if effort.quick else tuple(10.0**-n for n in range(2, 10))
    counts = (64, 256) if effort.quick else (16, 64, 256, 1024)
    rows: list[TubeRow] = []
    for truth in arch_truths(LENGTH):
        tries: list[_Try] = []
        for tolerance in tolerances:
            tell(f"tube along k = {truth.k:g} to {tolerance:g} mm")
            for name, make in _to_tolerance(truth, tolerance).items():
                tries.append(_try(truth, name, f"{tolerance:.0e} mm", make, 10.0 * tolerance))
        for count in counts:
            tell(f"tube along {count} points of k = {truth.k:g}")
            for name, make in _through_points(truth, count).items():
                tries.append(_try(truth, name, f"{count} points", make, 0.5 * RADII[truth.k]))
        rows += _timed(tries, effort.count(5, 3))
    return [
        Table(
            "tube",
            f"Tubes along a wave of the elastica, {LENGTH:g} mm: time, deviation, size",
            rows,
            _targets(rows),
            (
                f"medians of {effort.count(5, 3)} in turn; radius " + ", ".join(f"{r:g} mm" for r in RADII.values()),
                "deviation: greatest of 13 x 601 samples of the solid's side from the exact tube (mpmath), measured "
                "alike on every solid",
                "MakePipeShell: corrected Frenet; along our own fit to the same tolerance, or along a C4 quintic of "
                "256 equal spans, whose own error at k = 0.999 is 1e-7 mm",
                "MakePipe and the hosts: along interpolated points",
                f"hosts installed: {', '.join(installed_hosts()) or 'none'}",
            ),
            Plot(
                "time",
                "deviation",
                lambda row: row.method if row.k == PLOTTED else None,
                f"Tubes along a wave of the elastica, k = {PLOTTED:g}, {LENGTH:g} mm",
            ),
        )
    ]


def _to_tolerance(truth: ArchTruth, tolerance: float) -> dict[str, Callable[[], TopoDS_Shape]]:
    centreline, radius = wave(truth.k), RADII[truth.k]

    def ours() -> TopoDS_Shape:
        return build_tube(fit_centreline(centreline, radius, tolerance=tolerance), radius)

    def swept(spine: TopoDS_Wire) -> TopoDS_Shape:
        start = centreline.frames([0.0])
        return sweep_pipe_shell(spine, start.position[0], start.tangent[0], radius, tolerance=tolerance)

    def shell() -> TopoDS_Shape:
        return swept(fitted_spine(fit_centreline(centreline, radius, tolerance=tolerance)))

    return {OURS: ours, SHELL: shell, SHELL_256: lambda: swept(quintic_spine(centreline, 256))}


def _through_points(truth: ArchTruth, count: int) -> dict[str, Callable[[], TopoDS_Shape]]:
    centreline, radius = wave(truth.k), RADII[truth.k]

    def pipe() -> TopoDS_Shape:
        at = centreline.frames(np.linspace(0.0, LENGTH, count))
        return sweep_pipe(interpolated_spine(at.position), at.position[0], at.tangent[0], radius)

    def host(name: str) -> TopoDS_Shape:
        at = centreline.frames(np.linspace(0.0, LENGTH, count))
        return sweep_by_host(name, at.position, at.tangent, radius)

    hosts: dict[str, Callable[[], TopoDS_Shape]] = {f"{name}, sweep": partial(host, name) for name in installed_hosts()}
    return {"GeomAPI_Interpolate, MakePipe": pipe, **hosts}


@dataclass(frozen=True)
class _Try:
    """A way to make a solid, and what there is to say of the solid; without a time yet, or for ever if it failed."""

    make: Callable[[], TopoDS_Shape]
    row: TubeRow


def _try(truth: ArchTruth, name: str, asked: str, make: Callable[[], TopoDS_Shape], bound: float) -> _Try:
    """Make a solid and measure it; a rival's first in a process it may kill. Off by over `bound` [mm] is remarkable."""
    row, radius = TubeRow(truth.k, name, asked), RADII[truth.k]
    if name != OURS:
        try:
            in_sandbox(lambda: make() and None)
        except SandboxError as error:
            return _Try(make, replace(row, remark=str(error)))
    solid = make()
    side = measure_side(solid, truth, radius)
    row = replace(row, deviation=side.deviation, poles=side.poles)
    try:
        check = check_solid(solid, radius=radius, length=LENGTH)
        size = len(step_text("tube", [], [CableSolid("tube", solid)]))
    except GeometryError as error:
        return _Try(make, replace(row, remark=str(error)))
    remark = "off by far more than asked, called valid" if side.deviation > bound and check.valid else ""
    return _Try(make, replace(row, bytes=size, valid=check.valid, volume=check.volume_error, remark=remark))


def _timed(tries: Sequence[_Try], repeats: int) -> list[TubeRow]:
    """Rows with the times of those that made a solid: all methods and tolerances of a curve take turns."""
    made = {i: one.make for i, one in enumerate(tries) if one.row.deviation is not None}
    times = take_turns(made, repeats)
    return [replace(one.row, time=times[i] * 1e3) if i in times else one.row for i, one in enumerate(tries)]


def _targets(rows: Sequence[TubeRow]) -> list[Target]:
    asked = f"{TARGET_TOLERANCE:.0e} mm"
    of = {name: [row for row in rows if row.method == name and row.asked == asked] for name in (OURS, SHELL, SHELL_256)}
    targets = []
    for name in (SHELL, SHELL_256):
        pairs = list(zip(of[OURS], of[name], strict=True))
        deviation, size = ([_ratio(a, b, key) for a, b in pairs] for key in ("deviation", "bytes"))
        rival = f"over that of {name}"
        time, total = (_ratio_of_sums(pairs, key) for key in ("time", "bytes"))
        targets += [
            Target(f"tube at 1e-6 mm: time {rival}, the three curves together", time, 0.25),
            Target(f"tube at 1e-6 mm: deviation {rival}, the greatest of three", max(deviation), 1.0),
            Target(f"tube at 1e-6 mm: STEP bytes {rival}, the three curves together", total, 0.5),
            Target(f"tube at 1e-6 mm: STEP bytes {rival}, the greatest of three", max(size), 0.5),
        ]
    return targets


def _ratio_of_sums(pairs: Sequence[tuple[TubeRow, TubeRow]], key: str) -> float:
    """Ours in all over theirs in all; not a number where one is missing."""
    ours, theirs = (math.fsum(getattr(row, key) or math.nan for row in rows) for rows in zip(*pairs, strict=True))
    return ours / theirs


def _ratio(ours: TubeRow, theirs: TubeRow, key: str) -> float:
    """Ours over theirs; infinite for what ours has not, nothing where the rival has not."""
    a, b = getattr(ours, key), getattr(theirs, key)
    return math.inf if a is None else 0.0 if b is None else a / b
