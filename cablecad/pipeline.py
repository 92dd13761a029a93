"""The whole story on one page: scene, model choice, solve, centreline, tube, check, document, report."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from os import PathLike, fspath
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from cablecad.errors import (
    CablecadError,
    ExchangeError,
    GeometryError,
    InvalidTubeError,
    Mistake,
    RuleError,
    SceneError,
    UsageError,
)
from cablecad.files import same_file
from cablecad.model import SHAPE_TOLERANCE, Cable, Part, Scene, Toward, tolerance_floor
from cablecad.report import CableOutcome, cable_report, scene_report

if TYPE_CHECKING:
    from OCP.TopoDS import TopoDS_Solid

    from cablecad.brep.document import CableSolid, Document
    from cablecad.rod.solution import RodSolution

EXIT_ORDER = (1, 2, 5, 3, 4)
"""Which exit code speaks for several failures at once."""

WORST_DEVIATION = 1.0 / 20.0
"""A shape tolerance above this share of the radius is lowered to it: beyond it the tube is no tube."""

Search = Literal["answer", "wide"]
"""How far to look for equilibria: for the answer alone, or for more of them."""

Progress = Callable[[str], None]
"""Called with the name of each cable or part as its turn comes."""


@dataclass(frozen=True)
class Solid:
    """A solid of the kernel, `wrapped` as CadQuery and build123d wrap theirs."""

    wrapped: TopoDS_Solid


@dataclass(frozen=True)
class Built:
    """A cable with its solid.

    Attributes:
        cable: What was asked.
        solution: The solved rod.
        solid: `solid.wrapped` is the `TopoDS_Solid`.
        report: As `cablecad build --report` writes it for a cable.
    """

    cable: Cable
    solution: RodSolution
    solid: Solid
    report: dict[str, Any]

    @property
    def name(self) -> str:
        """The cable's name."""
        return self.cable.name


# --- one cable ----------------------------------------------------------------------------------------------------


def solve(cable: Cable, *, search: Search = "answer") -> RodSolution:
    """Solve a cable as an elastic rod; see `cablecad.rod.solve.solve_rod`."""
    from cablecad.rod.solve import solve_rod

    return solve_rod(cable, search=search)


def solve_many(cables: Sequence[Cable], *, search: Search = "answer") -> list[RodSolution | CablecadError]:
    """Solve cables together, never raising for one of them; see `cablecad.rod.solve.solve_many`."""
    from cablecad.rod.solve import solve_many as solve_rods

    return solve_rods(cables, search=search)


def build(
    cable: Cable, *, tolerance: float = SHAPE_TOLERANCE, method: Literal["direct", "pipe_shell"] = "direct"
) -> Built:
    """Solve a cable and make its solid.

    Args:
        cable: What holds it and how long it is.
        tolerance: Bound on the distance between the solid's side and the exact tube [mm].
        method: "direct", or "pipe_shell" for Open Cascade's own sweep (slower, to 1e-6 mm).

    Raises:
        InfeasibleError: Physics forbids the shape.
        SolveError: No solution was found.
        InvalidTubeError: The tube would cut into itself.
        GeometryError: The solid failed its check.
        SceneError: Contradicting data, or a tolerance below what numbers can keep.
    """
    outcome = CableOutcome(cable)
    with _timed(outcome.seconds, "solve"):
        outcome.solution = solve(cable)
    solid = _make_solid(outcome, outcome.solution, tolerance, method)
    return Built(cable, outcome.solution, Solid(solid), cable_report(outcome))


def _make_solid(
    outcome: CableOutcome, solution: RodSolution, tolerance: float, method: Literal["direct", "pipe_shell"] = "direct"
) -> TopoDS_Solid:
    """Centreline, tube, check; fills in the outcome as it goes."""
    cable, radius = outcome.cable, outcome.cable.section.radius
    with _timed(outcome.seconds, "tube"):
        tolerance = _usable_tolerance(outcome, solution, tolerance)
        _refuse_spoilt_tube(solution)
        from cablecad.brep.spline import fit_centreline

        fit = fit_centreline(solution.centreline, radius, tolerance=tolerance)
        _refuse_spoilt_fit(cable, fit)
        from cablecad.brep.tube import build_tube

        solid = build_tube(fit, radius, method=method)
    with _timed(outcome.seconds, "check"):
        from cablecad.brep.check import check_solid

        check = check_solid(solid, radius=radius, length=solution.centreline.length)
    outcome.fit, outcome.check = fit, check
    # Pappus: the volume of a tube with a side off by e differs by 2 e / r at most, 4 e / r with room for its ends.
    allowed = 4.0 * max(fit.deviation, 1e-7) / radius + 1e-6
    if not check.valid or abs(check.volume_error) > allowed:
        raise GeometryError(
            f"the solid failed its check (BRepCheck {'valid' if check.valid else 'not valid'}, "
            f"volume off by {check.volume_error:.3g} of pi r^2 L, {allowed:.3g} allowed); try another tolerance"
        )
    return solid


def _usable_tolerance(outcome: CableOutcome, solution: RodSolution, tolerance: float) -> float:
    """The tolerance within what numbers can keep and what a tube can bear."""
    cable = outcome.cable
    supports = (cable.start_support, cable.end_support)
    reach = max(abs(x) for support in supports if not isinstance(support, Toward) for x in support.position)
    floor = tolerance_floor(reach + solution.length)
    if tolerance < floor:
        problem = f"is below {floor:.3g} mm, the least that numbers can keep for cable {cable.name} at its place"
        raise SceneError([Mistake("tolerance.shape", problem, tolerance)])
    most = WORST_DEVIATION * cable.section.radius
    if tolerance > most:
        outcome.notes.append(
            f"tolerance {tolerance:g} mm was lowered to {most:g} mm, a twentieth of the cable's radius"
        )
    return min(tolerance, most)


def _refuse_spoilt_tube(solution: RodSolution) -> None:
    """Refuse a tube that would cut into itself, naming the first equilibrium that would not."""
    spoilt = [violation.message for violation in solution.violations if violation.spoils_tube]
    if not spoilt:
        return
    radius = solution.cable.section.radius
    # An index counts in the wide list, which is what the cable gets when it asks for one.
    for i, other in enumerate(solve(solution.cable, search="wide").equilibria):
        gap, bend = other.self_gap, other.bend_radius_min
        if (gap is None or gap >= 0.0) and (bend is None or bend > radius):
            way_out = f"equilibrium = {i} does not touch itself"
            break
    else:
        way_out = "none of the equilibria found keeps clear of itself"
    raise InvalidTubeError(f"{'; '.join(spoilt)} ({way_out})")


def _refuse_spoilt_fit(cable: Cable, fit: Any) -> None:
    """The same two conditions on the curve that is going to be built."""
    from cablecad.self_gap import self_gap

    radius = cable.section.radius
    kappa, at = fit.greatest_curvature()
    if kappa * radius >= 1.0:
        raise InvalidTubeError(
            f"the fitted centreline bends to {1.0 / kappa:.6g} mm at s = {at:.6g} mm, not more than the cable's radius "
            f"{radius:.6g} mm; ask for a smaller tolerance or take a thinner cable"
        )
    gap = self_gap(fit, radius)
    if gap is not None and gap < 0.0 and not cable.allow_contact:
        raise InvalidTubeError(
            f"the fitted centreline overlaps itself by {-gap:.6g} mm; ask for a smaller tolerance, or set "
            "allow_contact = true"
        )


@contextmanager
def _timed(seconds: dict[str, float], stage: str) -> Iterator[None]:
    begun = time.perf_counter()
    try:
        yield
    finally:
        seconds[stage] = seconds.get(stage, 0.0) + time.perf_counter() - begun


# --- a scene ------------------------------------------------------------------------------------------------------


@dataclass
class SceneRun:
    """A scene on its way: what became of each cable and part, and all that went wrong.

    Attributes:
        scene: What was asked.
        outcomes: One a cable.
        solids: Number of solids of each part by name, None where it was not read.
        errors: Everything that keeps the scene from being written.
        seconds: Time by stage.
    """

    scene: Scene
    outcomes: list[CableOutcome] = field(default_factory=list)
    solids: dict[str, int | None] = field(default_factory=dict)
    errors: list[CablecadError] = field(default_factory=list)
    seconds: dict[str, float] = field(default_factory=dict)

    def report(self, *, points: int | None = None) -> dict[str, Any]:
        """Report format 1."""
        return scene_report(self.scene, self.outcomes, solids=self.solids, seconds=self.seconds, points=points)

    @property
    def exit_code(self) -> int:
        """0, or the code that speaks for all errors."""
        codes = {error.exit_code for error in self.errors}
        return next((code for code in EXIT_ORDER if code in codes), 0)

    def raise_first(self) -> None:
        """Raise the error with the first claim, the others as notes on it."""
        if self.errors:
            first, *others = sorted(self.errors, key=lambda error: EXIT_ORDER.index(error.exit_code))
            for other in others:
                first.add_note(str(other))
            raise first


def solve_scene(scene: Scene, *, search: Search = "answer", progress: Progress | None = None) -> SceneRun:
    """Solve the cables of a scene together; one that has no solution does not keep the others from theirs.

    Raises:
        SceneError: Data that contradict each other, of all cables at once.
    """
    run = SceneRun(scene)
    with _timed(run.seconds, "cables"):
        results = solve_many(scene.cables, search=search)
    mistakes: list[Mistake] = []
    for cable, result in zip(scene.cables, results, strict=True):
        _tell(progress, cable.name)
        # Solved together, the cables share the time.
        outcome = CableOutcome(cable, seconds={"solve": run.seconds["cables"] / len(results)})
        run.outcomes.append(outcome)
        if isinstance(result, SceneError):
            mistakes += [mistake.under(f"cables.{cable.name}") for mistake in result.mistakes]
        elif isinstance(result, CablecadError):
            _fail(run, outcome, result)
        else:
            outcome.solution = result
    if mistakes:
        raise SceneError(mistakes, source=str(scene.source or ""))
    run.seconds["total"] = run.seconds["cables"]
    return run


def check_scene(scene: Scene, *, strict: bool = True, progress: Progress | None = None) -> SceneRun:
    """Solve a scene, read its parts and make and check every solid, writing nothing.

    Args:
        scene: What to check.
        strict: Whether a broken `min_bend_radius` is an error rather than a warning.
        progress: Told of each cable and part.

    Raises:
        SceneError: Data that contradict each other.
    """
    return _run_scene(scene, None, strict=strict, progress=progress)


def run_build(scene: Scene, path: Path, *, strict: bool = False, progress: Progress | None = None) -> SceneRun:
    """Build a scene into a STEP file; with any error nothing is written and the errors are in the result.

    Raises:
        SceneError: Data that contradict each other.
        UsageError: The output is one of the inputs, or is no STEP file by its name.
        ExchangeError: The output cannot be written.
    """
    check_output(scene, path)
    return _run_scene(scene, path, strict=strict, progress=progress)


def build_scene(scene: Scene, path: str | PathLike[str], *, strict: bool = False) -> dict[str, Any]:
    """Build a scene into one STEP file: parts and cables as an assembly.

    Args:
        scene: From `load_scene`, or made in Python.
        path: The STEP file, written whole or not at all.
        strict: Whether a broken `min_bend_radius` is an error rather than a warning.

    Returns:
        Report format 1.

    Raises:
        CablecadError: The first thing that went wrong; the others are notes on it.
    """
    run = run_build(scene, Path(fspath(path)), strict=strict)
    run.raise_first()
    return run.report()


def _run_scene(scene: Scene, path: Path | None, *, strict: bool, progress: Progress | None) -> SceneRun:
    begun = time.perf_counter()
    run = solve_scene(scene, progress=progress)
    if scene.parts or any(outcome.solution for outcome in run.outcomes):
        with _timed(run.seconds, "import"):
            import cablecad.brep.kernel  # noqa: F401 - most of the time of a small build; named apart in the report
    with _timed(run.seconds, "read"):
        placed = _read_parts(run, progress)
    with _timed(run.seconds, "cables"):
        solids = _make_solids(run, progress)
    if strict:
        run.errors += _broken_rules(run.outcomes)
    if path is not None and not run.errors:
        with _timed(run.seconds, "write"):
            from cablecad.brep.step import write_step as write_document

            write_document(path, scene.name, placed, solids)
    run.seconds["total"] = time.perf_counter() - begun
    return run


def _read_parts(run: SceneRun, progress: Progress | None) -> list[tuple[Part, Document]]:
    """Read every part's file once; one that cannot be read does not hide another."""
    by_file: dict[str, list[Part]] = {}
    for part in run.scene.parts:
        by_file.setdefault(os.path.realpath(part.step), []).append(part)
    found: dict[str, tuple[Part, Document]] = {}
    for parts in by_file.values():
        from cablecad.brep.step import read_parts

        for part in parts:
            _tell(progress, part.name)
        try:
            found |= {part.name: (part, document) for part, document in read_parts(parts)}
        except CablecadError as error:
            names = " and ".join(part.name for part in parts)
            run.errors.append(ExchangeError(f"part {names}: {error}"))
    run.solids = {part.name: document.solids for part, document in found.values()}
    return [found[part.name] for part in run.scene.parts if part.name in found]


def _make_solids(run: SceneRun, progress: Progress | None) -> list[CableSolid]:
    """Make the solid of every cable that was solved.

    Raises:
        SceneError: A tolerance that cannot be kept, of all cables at once.
    """
    made = []
    mistakes: list[Mistake] = []
    for outcome in run.outcomes:
        _tell(progress, outcome.cable.name)
        if outcome.solution is not None:
            from cablecad.brep.document import CableSolid

            try:
                solid = _make_solid(outcome, outcome.solution, run.scene.tolerance)
                made.append(CableSolid(outcome.cable.name, solid, outcome.cable.color))
            except SceneError as error:  # a tolerance that cannot be kept
                mistakes += error.mistakes
            except CablecadError as error:
                _fail(run, outcome, error)
    if mistakes:
        raise SceneError(mistakes, source=str(run.scene.source or ""))
    return made


def write_step(items: Iterable[Built | Part], path: str | PathLike[str], *, name: str | None = None) -> None:
    """Write built cables and rigid parts as one assembly in a STEP file.

    Args:
        items: In any order; names must be unique.
        path: The STEP file, written whole or not at all.
        name: Of the assembly; the file's name without its suffix if not given.

    Raises:
        SceneError: Two items of one name.
        UsageError: The output is one of the parts' files, or is no STEP file by its name.
        ExchangeError: A part cannot be read, or the output not written.
    """
    items, path = list(items), Path(fspath(path))
    parts = tuple(item for item in items if isinstance(item, Part))
    cables = [item for item in items if isinstance(item, Built)]
    scene = Scene(name if name is not None else path.stem, tuple(built.cable for built in cables), parts)
    check_output(scene, path)
    from cablecad.brep.document import CableSolid
    from cablecad.brep.step import read_parts
    from cablecad.brep.step import write_step as write_document

    solids = [CableSolid(built.name, built.solid.wrapped, built.cable.color) for built in cables]
    write_document(path, scene.name, read_parts(parts), solids)


def _fail(run: SceneRun, outcome: CableOutcome, error: CablecadError) -> None:
    """Keep what went wrong with a cable: as it is for the cable's report, with its name for the scene's errors."""
    outcome.error = error
    named = type(error)(f"cable {outcome.cable.name}: {error}")
    named.__cause__ = error
    run.errors.append(named)


def _broken_rules(outcomes: Iterable[CableOutcome]) -> list[CablecadError]:
    """The user's rules that solved cables break, an error each."""
    return [
        RuleError(f"cable {outcome.cable.name}: {message}") for outcome in outcomes for message in outcome.broken_rules
    ]


def check_output(scene: Scene, path: Path, *, suffixes: tuple[str, ...] = (".step", ".stp")) -> None:
    """Refuse an output that cannot be meant, before any work is done.

    Raises:
        UsageError: Another suffix, or one of the scene's own inputs.
    """
    if path.suffix.lower() not in suffixes:
        raise UsageError(f"output {path}: its name must end in {' or '.join(suffixes)}")
    for source in scene.inputs:
        if same_file(path, source):
            raise UsageError(f"output {path} is also an input of the scene; write to another file")


def _tell(progress: Progress | None, name: str) -> None:
    if progress is not None:
        progress(name)
