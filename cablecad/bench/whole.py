"""Whole cables, from the scene to the file, by stage; and what it takes to start.

Ours is `run_build`, as `cablecad build` calls it. The rival is the same function, the same checks and the same
document, with Open Cascade's sweep in the place of our faces. Open Cascade's own share of writing is taken by the clock
around its `Transfer`, `SendModel` and `Print`, and what is left of `translated` is the freeing of what these made.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from shutil import copytree, ignore_patterns
from statistics import median
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import cablecad
from cablecad.bench.clock import take_turns
from cablecad.bench.stage import Effort, Tell
from cablecad.bench.table import Table, Target, column
from cablecad.model import Cable, Port, Scene
from cablecad.pipeline import run_build

if TYPE_CHECKING:
    from OCP.TopoDS import TopoDS_Shape, TopoDS_Solid

    from cablecad.pipeline.solid import Prepared
    from cablecad.report import CableOutcome

OURS = "cablecad"
SHELL, SHELL_256 = "on MakePipeShell along our fit, 1e-6 mm", "on MakePipeShell along 256 spans, 1e-3 mm"
METHODS = (OURS, SHELL, SHELL_256)
TOLERANCE = 1e-3


@dataclass(frozen=True)
class CableRow:
    """A scene, built; times a cable."""

    method: str = column("method")
    cables: int = column("cables", form="d")
    solve: float = column("solve", "ms", ".2f")
    tube: float = column("tube", "ms", ".2f")
    check: float = column("check", "ms", ".2f")
    document: float = column("document", "ms", ".2f")
    translate: float = column("OCC's own writing", "ms", ".2f")
    free: float = column("OCC's freeing", "ms", ".2f")
    rewrite: float = column("rewriting", "ms", ".2f")
    rest: float = column("rest", "ms", ".2f")
    total: float = column("total", "ms", ".2f")
    share: float = column("share of OCC's", "%", ".0f")
    bytes: int = column("STEP", "bytes", "d")


@dataclass(frozen=True)
class StartRow:
    """A process from its start to its end."""

    command: str = column("command")
    time: float = column("time", "s", ".3f")
    over: float | None = column("over its yardstick", form=".2f")


def loom(count: int) -> Scene:
    """Cables side by side between connectors that point up, their lengths and chords different: U-shaped."""
    cables = []
    for i in range(count):
        start = Port((0.0, 20.0 * i, 0.0), outward=(0.0, 0.0, 1.0))
        end = Port((120.0 + i % 7, 20.0 * i, 0.0), outward=(0.0, 0.0, 1.0))
        cables.append(Cable(f"W{i}", 4.0, start, end, length=300.0 + i % 100))
    return Scene("loom", tuple(cables), tolerance=TOLERANCE)


def run(effort: Effort, tell: Tell) -> list[Table]:
    """The stage."""
    with TemporaryDirectory(prefix="cablecad-bench-") as place:
        tell("one cable")
        alone = _builds(1, Path(place), effort.count(15, 5))
        many, turns = effort.count(100, 40), effort.count(15, 3)
        tell(f"a scene of {many} cables")
        together = _builds(many, Path(place), turns, warm=True)
        tell("starting up")
        starts = _starts(Path(place), effort)
    over = {row.command: row.over for row in starts}
    solve, build = (next(value for key, value in over.items() if key.startswith(f"cablecad {x}")) for x in ("s", "b"))
    return [
        Table(
            "cable",
            f"Whole cables to {TOLERANCE:g} mm, all checks on: milliseconds and bytes a cable, by stage",
            [_middle(found) for builds in (alone, together) for found in builds.values()],
            _targets(together),
            (
                f"builds of median time of {effort.count(15, 5)} of one cable and {turns} of {many}, in turn; the "
                "targets are medians of the turns' own ratios and shares; U-shaped cables, 300 to 400 mm long, 4 mm "
                "thick; Open Cascade already imported",
                "OCC's own writing: its transfer to a STEP model, and that model's text; OCC's freeing: of that model, "
                "which does not count in its share; rewriting: the same bytes in any process, and to the disk",
                "tube: the self-gap of the exact curve and of the fit, the fit with its measured deviation, the faces; "
                "check: BRepCheck, volume, area",
                "along our fit, 1e-6 mm: the product's method = 'pipe_shell'; along 256 spans: the best one can make "
                "of the sweep, by a spine finer than it needs",
            ),
        ),
        Table(
            "start",
            "From nothing to a result: processes",
            starts,
            [
                Target("start: cablecad solve of one cable over importing numpy and pydantic", solve or 0.0, 2.5),
                Target(
                    "start: cablecad build of one cable over importing OCP.gp, numpy and pydantic", build or 0.0, 1.5
                ),
            ],
            (
                f"medians of {effort.count(9, 3)} processes, with Open Cascade of {effort.count(9, 1)}, in turn; "
                "cablecad with its bytecode, as pip installs it",
            ),
        ),
    ]


def _builds(count: int, place: Path, turns: int, *, warm: bool = False) -> dict[str, list[CableRow]]:
    """The builds of each method, in turn; the first of each counts only if all is warm."""
    scene = loom(count)
    builds: dict[str, list[CableRow]] = {name: [] for name in METHODS}
    for turn in range(turns if warm else turns + 1):
        for name, found in builds.items():
            row = _build(name, scene, place / "loom.step")
            if warm or turn:
                found.append(row)
    return builds


def _middle(builds: Sequence[CableRow]) -> CableRow:
    """The build of median time."""
    return sorted(builds, key=lambda row: row.total)[len(builds) // 2]


def _targets(builds: dict[str, list[CableRow]]) -> list[Target]:
    """What the figures of a scene of many are held to.

    Each turn is compared with itself, for the machine is not equally fast in all of them, and the median counts.
    """
    ours, *theirs = (builds[name] for name in METHODS)
    return [
        *[
            Target(
                f"cable: {ours[0].cables} in a scene, time over the same {rival[0].method}",
                median(a.total / b.total for a, b in zip(ours, rival, strict=True)),
                1 / 3,
            )
            for rival in theirs
        ],
        Target(
            "cable: share of Open Cascade's own transfer + write in what is left",
            median(row.share for row in ours) / 100.0,
            0.4,
            ">=",
        ),
    ]


def _build(name: str, scene: Scene, path: Path) -> CableRow:
    """One build, its time by stage."""
    from OCP.STEPCAFControl import STEPCAFControl_Writer
    from OCP.StepData import StepData_StepWriter

    from cablecad.brep import step
    from cablecad.brep.document import Document

    seconds: dict[str, float] = {}
    with (
        _clocked(seconds, "document", Document, "assembled"),
        _clocked(seconds, "free", step, "translated"),
        _clocked(seconds, "translate", STEPCAFControl_Writer, "Transfer"),
        _clocked(seconds, "translate", StepData_StepWriter, "SendModel"),
        _clocked(seconds, "translate", StepData_StepWriter, "Print"),
        _swept(name),
    ):
        begun = time.perf_counter()
        run = run_build(scene, path)
        total = time.perf_counter() - begun
    run.raise_first()
    for outcome in run.outcomes:
        for stage in ("solve", "tube", "check"):
            seconds[stage] = seconds.get(stage, 0.0) + outcome.seconds[stage]
    each = {stage: taken / len(scene.cables) * 1e3 for stage, taken in seconds.items()}
    each["rewrite"] = run.seconds["write"] / len(scene.cables) * 1e3 - each["document"] - each["free"]
    each["free"] -= each["translate"]
    total *= 1e3 / len(scene.cables)
    return CableRow(
        method=name,
        cables=len(scene.cables),
        **each,
        rest=total - sum(each.values()),
        total=total,
        share=100.0 * each["translate"] / total,
        bytes=path.stat().st_size // len(scene.cables),
    )


@contextmanager
def _clocked(seconds: dict[str, float], stage: str, owner: Any, method: str) -> Iterator[None]:
    """Add the time spent in a method of a class to a stage."""
    held = owner.__dict__[method]
    of_class = isinstance(held, classmethod)
    call: Callable[..., Any] = held.__func__ if of_class else getattr(owner, method)

    def clocked(*arguments: Any, **named: Any) -> Any:
        begun = time.perf_counter()
        try:
            return call(*arguments, **named)
        finally:
            seconds[stage] = seconds.get(stage, 0.0) + time.perf_counter() - begun

    setattr(owner, method, classmethod(clocked) if of_class else clocked)
    try:
        yield
    finally:
        setattr(owner, method, held)


@contextmanager
def _swept(name: str) -> Iterator[None]:
    """Let a rival's sweep stand in for the faces of ours, in the pipeline as it is."""
    from cablecad.bench.sweeps import quintic_spine, sweep_pipe_shell
    from cablecad.brep import tube
    from cablecad.pipeline import solid

    make_solid = solid.make_solid

    def along_256_spans(outcome: CableOutcome, prepared: Prepared, _method: object = None) -> TopoDS_Solid:
        def build_tube(_fit: object, radius: float, **_method: object) -> TopoDS_Shape:
            assert outcome.solution is not None
            curve = outcome.solution.centreline
            start = curve.frames([0.0])
            tolerance = prepared.fit.tolerance
            return sweep_pipe_shell(
                quintic_spine(curve, 256), start.position[0], start.tangent[0], radius, tolerance=tolerance
            )

        with _replaced(tube, "build_tube", build_tube):
            return make_solid(outcome, prepared)

    if name == OURS:
        yield
    elif name == SHELL:
        with _replaced(solid, "make_solids", partial(solid.make_solids, method="pipe_shell")):
            yield
    else:
        with _replaced(solid, "make_solid", along_256_spans):
            yield


@contextmanager
def _replaced(module: Any, name: str, value: Any) -> Iterator[None]:
    """Give a module's name another value for a while."""
    held = getattr(module, name)
    setattr(module, name, value)
    try:
        yield
    finally:
        setattr(module, name, held)


SCENE = """format = 1
[[cables]]
name = "W1"
diameter = 4.0
length = 350.0
start = { position = [0, 0, 0],   outward = [0, 0, 1] }
end   = { position = [0, 120, 0], outward = [0, 0, 1] }
"""

COMMAND_LINE = "from cablecad.cli import main; main()"


def _starts(place: Path, effort: Effort) -> list[StartRow]:
    scene, out = place / "one.toml", place / "one.step"
    scene.write_text(SCENE, encoding="utf-8")
    light, heavy = "import numpy, pydantic", "import OCP.gp, numpy, pydantic"
    quick: dict[str, Sequence[str]] = {
        f"python -c '{light}'": (light,),
        "cablecad solve, one cable": (COMMAND_LINE, "solve", str(scene)),
    }
    slow: dict[str, Sequence[str]] = {
        f"python -c '{heavy}'": (heavy,),
        "cablecad build, one cable": (COMMAND_LINE, "build", str(scene), "-o", str(out)),
    }
    if not effort.quick:
        quick |= {"python -c 'import cablecad'": ("import cablecad",), "cablecad --help": (COMMAND_LINE, "--help")}
        slow |= {"python -c 'import cablecad.brep.step'": ("import cablecad.brep.step",)}

    # What pip installs has its bytecode on the disk, as the yardsticks do; a checkout may not. A copy gets it in the
    # turn that does not count.
    copytree(Path(cablecad.__path__[0]), place / "cablecad", ignore=ignore_patterns("__pycache__"))
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}

    def start(arguments: Sequence[str]) -> None:
        # With -c the working folder comes first of all that modules are looked for in.
        command = [sys.executable, "-c", *arguments]
        subprocess.run(command, check=True, capture_output=True, cwd=place, env=environment)

    times = {
        name: taken
        for commands, repeats in ((quick, effort.count(9, 3)), (slow, effort.count(9, 1)))
        for name, taken in take_turns(
            {name: partial(start, words) for name, words in commands.items()}, repeats
        ).items()
    }
    yardsticks = {"cablecad solve, one cable": light, "cablecad build, one cable": heavy}
    return [
        StartRow(name, taken, taken / times[f"python -c '{yardsticks[name]}'"] if name in yardsticks else None)
        for name, taken in times.items()
    ]
