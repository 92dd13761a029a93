"""A scene on one page: parts and cables, solved together, made, checked and written; what became of each is kept."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from os import PathLike, fspath
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cablecad.errors import CablecadError, Mistake, SceneError, UsageError
from cablecad.model import Scene
from cablecad.pipeline.cable import Built, Search, Solid, solve_many
from cablecad.pipeline.clock import timed
from cablecad.pipeline.parts import ends_resolved, import_kernel, read_parts_of, read_scene_parts
from cablecad.pipeline.ports import Resolved
from cablecad.pipeline.run import Progress, SceneRun, tell
from cablecad.pipeline.write import MESH_SUFFIXES, MODEL_SUFFIXES, cable_solid, check_output, write_model
from cablecad.report import CableOutcome

if TYPE_CHECKING:
    from cablecad.pipeline.documents import Documents
    from cablecad.rod.solution import RodSolution


def solve_scene(scene: Scene, *, search: Search = "answer", progress: Progress | None = None) -> SceneRun:
    """Solve the cables of a scene together; one that has no solution does not keep the others from theirs.

    Raises:
        SceneError: Data that contradict each other, of all cables at once.
    """
    (run,) = solve_scenes([scene], search=search, progress=progress)
    if isinstance(run, SceneError):
        raise run
    return run


def solve_scenes(
    scenes: Sequence[Scene],
    *,
    search: Search = "answer",
    progress: Progress | None = None,
    documents: Documents | None = None,
    measured: bool = True,
) -> list[SceneRun | SceneError]:
    """Solve the cables of many scenes together, in a fraction of the time; a bad scene costs no other.

    Args:
        scenes: What to solve.
        search: As for `solve`.
        progress: Told of each cable and part.
        documents: Keeps what was read of parts; without it the files of each scene are read anew.
        measured: Whether to find the self-gaps of the answers together, for what is said of them; False where
            `measure_scenes` follows, which finds those of all.

    Returns:
        For each scene its run, or the error for data that contradict each other.
    """
    begun = [_begun(scene, progress, documents) for scene in scenes]
    known = [cable for one in begun if not isinstance(one, SceneError) for cable in one[1].known]
    started = time.perf_counter()
    solved = solve_many(known, search=search, measured=False)
    if measured and len(known) > 1:
        from cablecad.rod.room import measure_gaps

        measure_gaps(one.equilibrium for one in solved if not isinstance(one, CablecadError))
    results = iter(solved)
    # Solved together, the cables share the time.
    share = (time.perf_counter() - started) / max(len(known), 1)
    return [
        one
        if isinstance(one, SceneError)
        else _solved(*one, [next(results) for _ in one[1].known], share=share, progress=progress)
        for one in begun
    ]


def _begun(
    scene: Scene, progress: Progress | None, documents: Documents | None
) -> tuple[SceneRun, Resolved] | SceneError:
    """The run of a scene with numbers in place of the ends on parts, or the error that keeps it from one."""
    run = SceneRun(scene, kept=documents)
    started = time.perf_counter()
    try:
        resolved = ends_resolved(run, progress)
    except SceneError as error:
        return error
    run.seconds["total"] = time.perf_counter() - started
    return run, resolved


def _solved(
    run: SceneRun,
    resolved: Resolved,
    results: list[RodSolution | CablecadError],
    *,
    share: float,
    progress: Progress | None,
) -> SceneRun | SceneError:
    """The run of a scene whose cables were solved in `share` seconds each."""
    mistakes: list[Mistake] = []
    for cable, result in zip(run.scene.cables, resolved.answers(results), strict=True):
        tell(progress, cable.name)
        outcome = CableOutcome(cable, seconds={"solve": share})
        outcome.origins += resolved.remarks.get(cable.name, [])
        run.outcomes.append(outcome)
        if isinstance(result, SceneError):
            mistakes += [mistake.under(f"cables.{cable.name}") for mistake in result.mistakes]
        elif isinstance(result, CablecadError):
            run.fail(outcome, result)
        else:
            outcome.solution = result
    if mistakes:
        return run.scene_error(mistakes)
    run.seconds["cables"] = share * len(results)
    run.seconds["total"] += run.seconds["cables"]
    return run


def resolve_ends(scene: Scene) -> SceneRun:
    """Put numbers in place of the ends on parts, as `solve_scene` does before it solves; nothing is solved.

    Raises:
        SceneError: A point that does not tell which feature of its part is meant.
    """
    run = SceneRun(scene)
    resolved = ends_resolved(run, None)
    for name, error in resolved.errors.items():
        run.errors.append(type(error)(f"cable {name}: {error}"))
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


def run_build(
    scene: Scene,
    path: Path,
    *,
    strict: bool = False,
    mesh_tolerance: float | None = None,
    progress: Progress | None = None,
    documents: Documents | None = None,
) -> SceneRun:
    """Build a scene into a file; with any error nothing is written and the errors are in the result.

    Args:
        scene: What to build.
        path: Its suffix says of which format: .step, .stp, .glb, .stl or .brep.
        strict: Whether a broken `min_bend_radius` is an error rather than a warning.
        mesh_tolerance: For .glb and .stl: bound on the distance between triangles and surfaces [mm]; from the sizes
            if not given.
        progress: Told of each cable and part.
        documents: Keeps what was read of the parts for the next scene; without it every file is read anew.

    Raises:
        SceneError: Data that contradict each other.
        UsageError: The output is one of the inputs, or of no such format by its name; a mesh tolerance that is not
            positive, needs too many triangles, or meets a format without any.
        ExchangeError: The output cannot be written.
    """
    check_output(scene, path, suffixes=MODEL_SUFFIXES)
    if mesh_tolerance is not None:
        if path.suffix.lower() not in MESH_SUFFIXES:
            formats = " and ".join(MESH_SUFFIXES)
            raise UsageError(f"a mesh tolerance is for {formats}; {path} holds exact surfaces: leave it out")
        if not 0.0 < mesh_tolerance < math.inf:
            raise UsageError(f"a mesh tolerance must be a positive number of mm; got {mesh_tolerance!r}")
    return _run_scene(scene, path, strict=strict, mesh_tolerance=mesh_tolerance, progress=progress, documents=documents)


def build_scene(scene: Scene, path: str | PathLike[str], *, strict: bool = False) -> dict[str, Any]:
    """Build a scene into one file: parts and cables as an assembly.

    Args:
        scene: From `load_scene`, or made in Python.
        path: Its suffix says of which format: .step, .stp, .glb, .stl or .brep. Written whole or not at all.
        strict: Whether a broken `min_bend_radius` is an error rather than a warning.

    Returns:
        Report format 1.

    Raises:
        CablecadError: The first thing that went wrong; the others are notes on it.
    """
    run = run_build(scene, Path(fspath(path)), strict=strict)
    run.raise_first()
    return run.report()


def make_scene(scene: Scene) -> tuple[SceneRun, list[Built]]:
    """Solve a scene, read its parts and make every solid, writing nothing: for hosts with documents of their own.

    Returns:
        The run, its parts in `documents`, and the cables that could be built.

    Raises:
        SceneError: Data that contradict each other.
    """
    run = solve_scene(scene)
    import_kernel(run)
    read_parts_of(run, scene.parts, None)
    return run, _make_solids(run, None)


def _run_scene(
    scene: Scene,
    path: Path | None,
    *,
    strict: bool,
    progress: Progress | None,
    mesh_tolerance: float | None = None,
    documents: Documents | None = None,
) -> SceneRun:
    begun = time.perf_counter()
    (run,) = solve_scenes([scene], progress=progress, documents=documents)
    if isinstance(run, SceneError):
        raise run
    if scene.parts or any(outcome.solution for outcome in run.outcomes):
        import_kernel(run)
    placed = read_scene_parts(run, progress)
    run.solids = {part.name: document.solids for part, document in placed}
    with timed(run.seconds, "cables"):
        built = _make_solids(run, progress)
    if strict:
        run.errors += run.broken_rules()
    if path is not None and not run.errors:
        with timed(run.seconds, "write"):
            solids = [cable_solid(one) for one in built]
            write_model(path, scene.name, placed, solids, mesh_tolerance=mesh_tolerance)
    run.seconds["total"] = time.perf_counter() - begun
    return run


def _make_solids(run: SceneRun, progress: Progress | None) -> list[Built]:
    """Make the solid of every cable that was solved.

    Raises:
        SceneError: A tolerance that cannot be kept, of all cables at once.
    """
    from cablecad.pipeline.solid import make_solids

    made = []
    mistakes: list[Mistake] = []
    solids = make_solids([outcome for outcome in run.outcomes if outcome.solution is not None], run.scene.tolerance)
    for outcome in run.outcomes:
        tell(progress, outcome.cable.name)
        if outcome.solution is None:
            continue
        solid = next(solids)
        if isinstance(solid, SceneError):  # a tolerance that cannot be kept
            mistakes += solid.mistakes
        elif isinstance(solid, CablecadError):
            run.fail(outcome, solid)
        else:
            made.append(Built(outcome.cable, outcome.solution, Solid(solid), outcome))
    if mistakes:
        raise run.scene_error(mistakes)
    return made
