"""`cablecad batch`: many variants, from ten to a million."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import click

from cablecad.cli.session import on_terminal, say, say_error, verbosity_options
from cablecad.errors import ExchangeError, MissingDependencyError, UsageError, WorkerStartError

if TYPE_CHECKING:
    from concurrent.futures import Executor

    from cablecad.batch import Row, Standing

_EXAMPLES = """\b
Examples:
  cablecad batch variants.csv --scene loom.toml -o variants
  cablecad batch --scene loom.toml --grid cables.W1.length=300:400:11 -o sweep --output none
  cablecad batch --scene loom.toml --grid cables.W1.length=300:400:11 --grid cables.W1.material=pvc,pur -o sweep
  cablecad batch looms/*.toml -o built
  cablecad batch variants.csv --scene loom.toml -o variants --resume

\b
A table is CSV or JSON Lines. Its columns are dotted names of values of the scene, as messages print them:
  id,cables.W1.length,cables.W1.end.position[1],tolerance.shape
  short,300,120,0.01
An empty cell keeps the scene's value; null in JSON Lines takes the key out.

\b
Exit codes: 0 all rows done, 6 some failed; others as everywhere (cablecad --help).
"""

_TABLES = (".csv", ".tsv", ".jsonl", ".ndjson")

_SHOWN = 10
"""Failed rows told of while the batch runs; all are in the results."""

_DASK_WAIT = "10s"


@click.command(epilog=_EXAMPLES)
@click.argument("inputs", metavar="[TABLE | SCENE...]", nargs=-1, type=click.Path(path_type=Path))
@click.option("-o", "--folder", metavar="DIR", required=True, type=click.Path(path_type=Path), help="Where all goes.")
@click.option("--scene", "scene_path", metavar="SCENE", type=click.Path(path_type=Path), help="What the rows override.")
@click.option(
    "--grid",
    "axes",
    metavar="NAME=VALUES",
    multiple=True,
    help="Sweep a value: NAME=START:STOP:COUNT or NAME=A,B,C. Several: every combination.",
)
@click.option(
    "--output",
    type=click.Choice(["step", "none"]),
    default="step",
    show_default=True,
    help="A STEP file a row, or results only.",
)
@click.option(
    "-j",
    "--workers",
    type=click.IntRange(min=0),
    metavar="N",
    help="Worker processes; 0 works in this one. Without it as many as are worth their start.",
)
@click.option("--dask", "address", metavar="ADDRESS", help="Work on a Dask cluster, tcp://HOST:PORT of its scheduler.")
@click.option(
    "--timeout",
    type=click.FloatRange(min=0.0, min_open=True),
    metavar="SECONDS",
    help="How long a row may take; then it is ended, and the others go on.",
)
@click.option("--resume", is_flag=True, help="Skip the rows an earlier run finished with the same input.")
@click.option("--force", is_flag=True, help="Forget an earlier run in DIR, and overwrite its results.")
@click.option("--strict", is_flag=True, help="A broken min_bend_radius fails its row.")
@verbosity_options
def batch(
    inputs: tuple[Path, ...],
    folder: Path,
    scene_path: Path | None,
    axes: tuple[str, ...],
    output: Literal["step", "none"],
    workers: int | None,
    address: str | None,
    timeout: float | None,
    resume: bool,
    force: bool,
    strict: bool,
) -> int:
    """Build many variants: rows of TABLE, points of a grid, or SCENE files.

    Writes to DIR: ID.step for each row; reports.jsonl, a report a row, as they are done; at the end results.csv, a line
    a row. A row that fails costs no other. Prints the paths of the two.
    """
    from cablecad.batch import run_batch

    if address is not None and workers is not None:
        raise UsageError("--dask has workers of its own: leave out -j")
    if resume and force:
        raise UsageError("--resume goes on with an earlier run and --force forgets it; give one of them")
    if timeout is not None and workers == 0:
        raise UsageError("--timeout needs worker processes, which can be ended: give -j 1 or more")
    rows = _rows(inputs, scene_path, axes)
    with _dask(address) as executor, _remedy(folder), _progress() as show:
        summary = run_batch(
            rows,
            folder=folder,
            output=output,
            executor=executor,
            workers=workers,
            timeout=timeout,
            resume=resume,
            force=force,
            strict=strict,
            progress=show,
        )
    for line in summary.lines():
        say(line)
    if summary.failed:
        say_error(f"{summary.failed} of {summary.total} rows have no result; {folder / 'results.csv'} says why")
    click.echo(folder / "reports.jsonl")
    click.echo(folder / "results.csv")
    return summary.exit_code


def _rows(inputs: tuple[Path, ...], scene_path: Path | None, axes: tuple[str, ...]) -> Iterable[Row]:
    """The rows that are asked for."""
    from cablecad.batch import grid_rows, scene_rows, table_rows

    tables = [path for path in inputs if path.suffix.lower() in _TABLES]
    if axes:
        if scene_path is None and len(inputs) == 1 and not tables:
            scene_path, inputs = inputs[0], ()
        if scene_path is None or inputs:
            raise UsageError("--grid sweeps values of one scene: give --scene SCENE, and no table or other scenes")
        return grid_rows(scene_path, axes)
    if scene_path is not None:
        if len(inputs) != 1:
            raise UsageError(
                f"--scene needs the one table whose rows override it, or --grid; given are {len(inputs)} files"
            )
        return table_rows(inputs[0], scene_path)
    if tables:
        raise UsageError(f"{tables[0]} is a table: give --scene SCENE, the scene its rows override")
    if not inputs:
        raise UsageError("nothing to do: give a TABLE and --scene, --scene and --grid, or SCENE files")
    return scene_rows(inputs)


@contextmanager
def _dask(address: str | None) -> Iterator[Executor | None]:
    """The executor of a Dask cluster, or None."""
    if address is None:
        yield None
        return
    try:
        from distributed import Client
    except ImportError as error:
        raise MissingDependencyError('--dask needs Dask: pip install "cablecad[dask]"') from error
    try:
        client = Client(address, timeout=_DASK_WAIT, set_as_default=False)
    except (OSError, ValueError) as error:
        raise ExchangeError(f"no Dask scheduler answers at {address}: {error}; check the address") from error
    with client:
        yield client.get_executor(pure=False)


@contextmanager
def _remedy(folder: Path) -> Iterator[None]:
    """Say that nothing is lost where the batch comes to an early end."""
    try:
        yield
    except (KeyboardInterrupt, ExchangeError, WorkerStartError):
        if (folder / "reports.jsonl").is_file():
            say(f"the rows finished so far are kept in {folder}: --resume goes on with the others")
        raise


@contextmanager
def _progress() -> Iterator[Callable[[Standing], None]]:
    """What to call as rows are done: tells of the first that failed and, on a terminal, how the batch stands."""
    told = 0

    def tell(standing: Standing) -> None:
        nonlocal told
        for result in standing.latest:
            if result.status == "done":
                continue
            told += 1
            if told <= _SHOWN:
                say_error(f"row {result.id} {result.status.replace('_', ' ')}: {result.error}")
            elif told == _SHOWN + 1:
                say_error("more rows fail; results.csv will tell of all of them")

    if not on_terminal():
        yield tell
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.fields[failed]} failed, {task.fields[rate]} rows/s, left:"),
        TimeRemainingColumn(elapsed_when_finished=True),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True) as bars:
        task = bars.add_task("", total=None, failed=0, rate="?")

        def show(standing: Standing) -> None:
            tell(standing)
            speed = bars.tasks[0].speed
            bars.update(
                task,
                total=standing.total,
                completed=standing.kept + standing.done,
                failed=standing.failed,
                rate="?" if speed is None else f"{speed:.3g}",
            )

        yield show
