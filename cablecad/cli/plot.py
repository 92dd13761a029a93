"""`cablecad plot`: shapes, curvatures and equilibria of cables as plots."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from cablecad.cli.session import note_all, progress_bar, say, scene_argument, show_errors, verbosity_options, warn_of
from cablecad.errors import CablecadError, ExchangeError, UsageError

if TYPE_CHECKING:
    from cablecad.picture.figure import FileFormat
    from cablecad.picture.plot import Plot
    from cablecad.pipeline import Progress
    from cablecad.scene import RawScene, Target

SOME_FAILED = 6

_EXAMPLES = """\b
Examples:
  cablecad plot loom.toml -o plots
  cablecad plot loom.toml -o plots --cable W1 --format svg
  cablecad plot loom.toml -o plots --family cables.W1.length=300:400:11
"""


@click.command(epilog=_EXAMPLES)
@scene_argument
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    metavar="DIR",
    help="The folder to write to, made if need be; the scene's name with -plots if not given.",
)
@click.option(
    "--cable", "cables", multiple=True, metavar="NAME", help="Plot this cable only; may be given several times."
)
@click.option(
    "--family",
    metavar="PLACE=START:STOP:COUNT",
    help="Instead: draw one cable in one picture for COUNT values of one of its data, both ends included; or "
    "PLACE=VALUE,VALUE,...",
)
@click.option(
    "--kind",
    "kinds",
    type=click.Choice(["shape", "curvature", "equilibria"]),
    multiple=True,
    help="Make this plot of each cable only; may be given several times.",
)
@click.option(
    "--format",
    "file_format",
    type=click.Choice(["png", "svg", "pdf"]),
    default="png",
    show_default=True,
    help="Of the files.",
)
@verbosity_options
def plot(
    scene_path: Path,
    output: Path | None,
    cables: tuple[str, ...],
    family: str | None,
    kinds: tuple[str, ...],
    file_format: FileFormat,
) -> int:
    """Solve SCENE and plot its cables: three files for each.

    NAME-shape: the shape in its plane, its ends, what they apply to it, and the tightest spot. NAME-curvature: over
    arclength, with the rule of min_bend_radius. NAME-equilibria: all that a wide search finds, with their energies;
    stable ones solid, unstable ones dashed. With --family one file: how a shape changes with one of its data. Prints
    each path as it is written; about a second a cable. Colours too light for white paper are darkened, and opacity is
    not shown. Takes matplotlib (pip install "cablecad[plot]").
    """
    output = output if output is not None else scene_path.with_name(f"{scene_path.stem}-plots")
    if family is not None:
        if cables or kinds:
            raise UsageError("--family names its cable and is a plot of its own: leave out --cable and --kind")
        return _plot_family(scene_path, output, family, file_format)
    from cablecad.picture.plot import KINDS, cable_plots
    from cablecad.picture.render import with_cables
    from cablecad.pipeline import solve_scene
    from cablecad.scene import load_scene

    scene = with_cables(load_scene(scene_path), cables)
    kinds = kinds or KINDS
    if not scene.cables:
        note_all(["the scene has no cables to plot"])
    with progress_bar((1 + len(set(kinds))) * len(scene.cables)) as progress:
        run = solve_scene(scene, search="wide" if "equilibria" in kinds else "answer", progress=progress)
        note_all(run.remarks)
        for outcome in run.outcomes:
            warn_of(outcome.cable.name, outcome.warnings)
            warn_of(outcome.cable.name, outcome.violations)
        show_errors(run.errors)
        solutions = [outcome.solution for outcome in run.outcomes if outcome.solution is not None]
        _write([] if run.errors else cable_plots(solutions, kinds), output, file_format, progress)
    return run.exit_code


def _plot_family(scene_path: Path, output: Path, family: str, file_format: FileFormat) -> int:
    """Draw a family; values without a solution are left out and named."""
    from cablecad.batch import grid_rows
    from cablecad.picture.family_plot import Member
    from cablecad.picture.plot import family_plots
    from cablecad.pipeline import solve_scene

    rows = grid_rows(scene_path, [family], source="--family")
    ((target, values),) = rows.axes
    name, steps = _cable_of(target, rows.base)
    if not all(isinstance(value, int | float) and not isinstance(value, bool) for value in values):
        raise UsageError(f"{family!r}: a family is drawn over numbers; give numbers for {target.name}")
    members: list[Member] = []
    failed: list[tuple[float, CablecadError]] = []
    with progress_bar(len(values) + 1) as progress:
        for row, value in zip(rows, values, strict=True):
            try:
                scene = row.resolve()
                cables = tuple(cable for cable in scene.cables if cable.name == name)
                run = solve_scene(replace(scene, cables=cables), progress=progress)
                run.raise_first()
                members += [Member(value, one.solution) for one in run.outcomes if one.solution is not None]
            except CablecadError as problem:
                failed.append((value, problem))
        plots = list(family_plots(name, target.name, steps, members, len(failed))) if members else []
        _write(plots, output, file_format, progress)
    for value, error in failed:
        say(f"warning: {target.name} = {value:g}: {error}")
    if not members:
        show_errors([failed[0][1]])
        return failed[0][1].exit_code
    return SOME_FAILED if failed else 0


def _cable_of(target: Target, base: RawScene) -> tuple[str, tuple[str | int, ...]]:
    """The name of the cable that a target lies in, and the steps from there.

    Raises:
        UsageError: It lies in none.
    """
    kind, *steps = target.place
    cables = base.data.get("cables", [])
    if kind == "cables" and isinstance(steps[0], int):
        return str(cables[steps[0]].get("name")), tuple(steps[1:])
    listed = ", ".join(str(cable.get("name")) for cable in cables) or "none"
    raise UsageError(f"{target.name!r}: a family changes one cable: begin with cables.NAME., NAME one of {listed}")


def _write(plots: Iterable[Plot], folder: Path, file_format: FileFormat, progress: Progress | None) -> None:
    """Draw and write one plot after the other, each whole, and say where it is: what is done is not lost."""
    from cablecad.files import write_bytes

    for one in plots:
        if progress is not None:
            progress(one.name)
        data = one.data(file_format)
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise ExchangeError(
                f"the folder {folder} cannot be made: {error.strerror or error}; give another with -o"
            ) from error
        path = folder / f"{one.name}.{file_format}"
        write_bytes(path, data)
        click.echo(path)
