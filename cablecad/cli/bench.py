"""`cablecad bench`: speed against error, beside what a user would take instead."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from cablecad.bench.stage import STAGES, Effort
from cablecad.cli.session import progress_bar, say, say_error, verbosity_options

if TYPE_CHECKING:
    from cablecad.bench.report import StageResult

MISSED = 4
"""A result that failed its check, as everywhere in cablecad."""

_EXAMPLES = """\b
Examples:
  cablecad bench --quick                   less than a minute
  cablecad bench -o figures                some minutes; tables, CSV, report.json and plots into figures/
  cablecad bench --only points --only solve

\b
Stages:
"""


@click.command(epilog=_EXAMPLES + "\n".join(f"  {stage.name:<12} {stage.title}" for stage in STAGES))
@click.option("--quick", is_flag=True, help="Less than a minute: fewer scenes and repeats, the same targets.")
@click.option(
    "-o",
    "--output",
    "folder",
    metavar="DIR",
    type=click.Path(path_type=Path),
    help="A folder for a CSV file a table, tables.md, report.json and plots; made if it is not there.",
)
@click.option(
    "--only",
    "names",
    multiple=True,
    metavar="STAGE",
    type=click.Choice([stage.name for stage in STAGES]),
    help="Only this stage; may be given more than once.",
)
@verbosity_options
def bench(quick: bool, folder: Path | None, names: tuple[str, ...]) -> int:
    """Measure speed against error, ours beside scipy's and Open Cascade's, and print a table a stage.

    Errors are taken against mpmath; rivals take turns in the same run. Every figure that is aimed at is printed
    with its target. Exit 4 if one is missed: on a busy machine, or in a quick run, times may miss what they reach
    otherwise.
    """
    from cablecad.bench.run import run_bench

    stages = [stage for stage in STAGES if not names or stage.name in names]
    if folder is not None:
        _make(folder)
    terminal = sys.stdout.isatty()

    def show(result: StageResult) -> None:
        from cablecad.bench.terminal import show_table

        if result.skipped:
            say(f"stage {result.name} is left out: {result.skipped}")
        width = shutil.get_terminal_size().columns if terminal else None
        for table in result.tables:
            click.echo(show_table(table, width=width, color=terminal))
        if folder is not None:
            _draw(result, folder)

    with progress_bar(sum(stage.steps(quick=quick) for stage in stages)) as progress:
        report = run_bench(stages, Effort(quick), folder=folder, tell=progress, done=show)
    if folder is not None:
        click.echo(folder)
    for target in report.missed:
        say_error(str(target))
    return MISSED if report.missed else 0


def _make(folder: Path) -> None:
    """Make the folder, and see that files can be written into it, before any work is done."""
    from tempfile import TemporaryFile

    from cablecad.errors import ExchangeError

    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ExchangeError(f"folder {folder} cannot be made: {error.strerror}; choose another") from error
    try:
        with TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise ExchangeError(f"folder {folder} cannot be written to: {error.strerror}; choose another") from error


def _draw(result: StageResult, folder: Path) -> None:
    """The plots of a stage; without matplotlib a remark."""
    from cablecad.bench.plot import write_plots
    from cablecad.errors import MissingDependencyError

    try:
        write_plots(result.tables, folder)
    except MissingDependencyError as error:
        say(f"warning: {error}")
