"""`cablecad solve`: what the cables of a scene are like, without solids."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, TextIO

import click

from cablecad.cli.session import note_all, progress_bar, say, scene_argument, show_errors, verbosity_options, warn_of

if TYPE_CHECKING:
    from cablecad.report import CableOutcome


_EXAMPLES = """\b
Examples:
  cablecad solve loom.toml
  cablecad solve loom.toml --table | less
  cablecad solve loom.toml --json --points 200 > loom.json
"""


@click.command(epilog=_EXAMPLES)
@scene_argument
@click.option("--json", "as_json", is_flag=True, help="Print the whole report as JSON.")
@click.option(
    "--points",
    type=click.IntRange(min=2, max=10_000_000),
    metavar="N",
    help="With --json: N points at equal arclengths, ends included.",
)
@click.option(
    "--equilibria",
    "wide",
    is_flag=True,
    help="Look for more equilibria: windings -2..2, more starts. The report lists all that were found.",
)
@click.option(
    "--table/--lines",
    "table",
    default=None,
    help="A few lines a cable for people, with warnings, or one line a cable for programs; if neither is given the "
    "table on a terminal and lines elsewhere.",
)
@verbosity_options
def solve(scene_path: Path, as_json: bool, points: int | None, wide: bool, table: bool | None) -> int:
    """Solve SCENE and print what its cables are like, or the report as JSON: lengths in mm, forces in N.

    On a terminal a table a cable: model and why, length, bend radius, forces, stability, warnings; elsewhere one line
    a cable. Makes no solids, and needs no Open Cascade unless an end is taken from a part's geometry (near).
    """
    from cablecad.pipeline import solve_scene
    from cablecad.report import to_json
    from cablecad.scene import load_scene

    if points is not None and not as_json:
        say("warning: --points goes into the report: add --json to see it")
    scene = load_scene(scene_path)
    with progress_bar(len(scene.cables)) as progress:
        run = solve_scene(scene, search="wide" if wide else "answer", progress=progress)
    on_terminal = _is_terminal(sys.stdout)
    if as_json:
        click.echo(to_json(run.report(points=points)), nl=False)
    elif table or (table is None and on_terminal):
        _print_table(run.outcomes)
        if on_terminal and _is_terminal(sys.stderr):  # what is to be said of a cable has been read in the table
            told = [outcome.error for outcome in run.outcomes if outcome.error is not None]
            note_all(run.remarks)
            show_errors(error for error in run.errors if error.__cause__ not in told)
            return run.exit_code
    else:
        for outcome in run.outcomes:
            solution = outcome.solution
            click.echo(f"{outcome.cable.name}: {outcome.result}" if solution is None else solution.summary)
    note_all(run.remarks)
    for outcome in run.outcomes:
        warn_of(outcome.cable.name, outcome.warnings)
        warn_of(outcome.cable.name, outcome.violations)
    show_errors(run.errors)
    return run.exit_code


def _is_terminal(stream: TextIO | None) -> bool:
    return stream is not None and stream.isatty()


def _print_table(outcomes: list[CableOutcome]) -> None:
    """A table a cable, with an empty line between two; in colour on a terminal that is not asked to do without."""
    import shutil

    from cablecad.cli.table import cable_table

    width = min(shutil.get_terminal_size().columns, 120)
    text = "\n\n".join(cable_table(outcome, width) for outcome in outcomes)
    if outcomes:
        # https://no-color.org
        click.echo(text, color=False if os.environ.get("NO_COLOR") else None)
