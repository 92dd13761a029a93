"""A batch on one page: look the rows over, keep what is finished, do the rest, sum it up."""

from __future__ import annotations

import contextlib
import logging
import os
import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Executor
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import Literal

from cablecad.batch.inputs import Inputs
from cablecad.batch.journal import REPORTS, Folder, Journal, forget, keep_finished
from cablecad.batch.keys import RowKeys
from cablecad.batch.pool import WorkerPool, check_timeout
from cablecad.batch.results import RESULTS, write_results
from cablecad.batch.rows import Row, check_id, same_id
from cablecad.batch.schedule import InlineExecutor, Schedule, preload, processors
from cablecad.batch.summary import Summary
from cablecad.batch.task import RowResult, Task, step_path
from cablecad.errors import ExchangeError, Mistake, SceneError, UsageError
from cablecad.files import explained, remove_leftovers

_log = logging.getLogger(__name__)

BLOCK = 250
"""Rows solved together. Numbers differ in their last digit by who was solved along, so a block is always the same rows,
whoever works on it and however often the batch was interrupted."""

LEAST_BUILT = 16
"""Rows with solids below which the start of workers is not made up for: see `tests/experiments/batch_workers.py`."""

LEAST_SOLVED = 400
"""The same for results only."""

Output = Literal["step", "none"]


@dataclass
class Standing:
    """How a batch stands.

    Attributes:
        total: Rows there are.
        kept: Of them, finished by an earlier run.
        done: Of them, ended in this run, well or not.
        failed: Of `done`, not well.
        latest: The results that just came in.
    """

    total: int
    kept: int = 0
    done: int = 0
    failed: int = 0
    latest: list[RowResult] = field(default_factory=list)


def run_batch(
    rows: Iterable[Row],
    *,
    folder: str | PathLike[str],
    output: Output = "step",
    executor: Executor | None = None,
    workers: int | None = None,
    timeout: float | None = None,
    resume: bool = False,
    force: bool = False,
    strict: bool = False,
    progress: Callable[[Standing], None] | None = None,
) -> Summary:
    """Build or solve many scenes; one that fails costs no other.

    Writes into the folder: ``ID.step`` for each row, ``reports.jsonl`` with a line a row as it is done, and
    ``results.csv`` made from that. On Ctrl-C worker processes are ended and `KeyboardInterrupt` goes on; what was
    finished is kept for `resume`.

    Args:
        rows: From `table_rows`, `grid_rows`, `scene_rows`, or made in Python. They are gone through twice or more
            often; a generator is put into a list first.
        folder: Where everything goes; made if it is not there.
        output: "step" for solids, "none" for results only.
        executor: Any `concurrent.futures.Executor`; its processes need the folder and the parts at the same paths. It
            is not shut down. None for `workers`.
        workers: Worker processes of our own; 0 works in this process. None takes as many as there are processors where
            the work outweighs their start.
        timeout: How long a row may take [s]; then its process is ended and the row is `timed_out`. Processes of
            another's executor cannot be ended: such a row goes on unheard. Their start is not counted, but that of one
            which comes later, in the place of another, is.
        resume: Skip rows that an earlier run finished with the same input; those that crashed or timed out are tried
            again.
        force: Forget an earlier run; overwrite a ``results.csv`` of which no journal tells whose it is.
        strict: Whether a broken `min_bend_radius` fails its row.
        progress: Called whenever rows were done.

    Returns:
        What all rows amount to.

    Raises:
        SceneError: Ids that cannot name files, or that two rows have.
        UsageError: The folder holds an earlier run, and neither `resume` nor `force` is given; or it is in use; or
            an output is also an input; or SOURCE_DATE_EPOCH is not a time.
        ExchangeError: The output cannot be written; or a row, or a file it reads, changed while the batch ran.
        MissingDependencyError: Solids are asked for and there is no Open Cascade.
    """
    _check_settings(executor, workers, timeout, resume, force)
    begun = time.perf_counter()
    rows = list(rows) if isinstance(rows, Iterator) else rows
    with Folder(Path(folder)) as place:
        batch = _Batch(place.path, output, strict)
        batch.look_over(rows)
        batch.open(resume=resume, force=force)
        standing = Standing(len(batch.keys), kept=sum(batch.finished))
        try:
            if standing.kept < standing.total:
                theirs = executor is not None
                doing = executor if executor is not None else _executor(batch, workers, timeout, isolated=resume)
                try:
                    batch.work(rows, doing, timeout, standing, progress)
                except BaseException:
                    if isinstance(doing, WorkerPool) and not theirs:
                        doing.kill()
                    batch.tidy()
                    raise
                if not theirs:
                    doing.shutdown()
            batch.journal.sync()
        finally:
            batch.journal.close()
        summary = Summary(place.path, kept=standing.kept)
        write_results(place.path / REPORTS, place.path / RESULTS, batch.keys, summary)
        summary.seconds = time.perf_counter() - begun
    return summary


def _check_settings(
    executor: Executor | None, workers: int | None, timeout: float | None, resume: bool, force: bool
) -> None:
    if executor is not None and workers is not None:
        raise UsageError("give either an executor or a number of workers, and not both")
    if workers is not None and workers < 0:
        raise UsageError(f"the number of workers is {workers}, but must be 0 (in this process) or more")
    check_timeout(timeout)
    if timeout is not None and workers == 0:
        raise UsageError("a timeout needs worker processes, which can be ended: give 1 or more")
    epoch = os.environ.get("SOURCE_DATE_EPOCH") or "0"
    if not (epoch.isascii() and epoch.isdigit()):  # numpy stumbles over it before our own check when writing
        raise UsageError(
            f"SOURCE_DATE_EPOCH is {epoch!r}, but must be whole seconds since 1970; set it so, or unset it"
        )
    if resume and force:
        raise UsageError("resume goes on with an earlier run and force forgets it; give one of them")


class _Batch:
    """A batch on its way."""

    def __init__(self, folder: Path, output: Output, strict: bool) -> None:
        self.folder, self.strict = folder, strict
        self.builds = output == "step"
        self.epoch = os.environ.get("SOURCE_DATE_EPOCH")
        self.keys = RowKeys()
        self.inputs: Inputs
        self.finished = bytearray()
        self.journal: Journal
        self.schedule: Schedule | None = None

    def look_over(self, rows: Iterable[Row]) -> None:
        """Learn the rows' ids, their inputs and the hashes of these.

        Raises:
            SceneError: Ids that cannot name files, or that two rows have.
            UsageError: An output is also an input.
        """
        self.inputs = Inputs(rows, (self.builds, self.strict, self.epoch if self.builds else None))
        for row in rows:
            check_id(row)
            self.keys.add(row.id, self.inputs.look_at(row))
        suspects = set(self.keys.settle())
        if suspects:
            _refuse_doubles((row.id for i, row in enumerate(rows) if i in suspects), sorted(suspects))
        for name in (REPORTS, RESULTS):
            self.inputs.check_output(self.folder / name)
        if self.builds:
            for row in rows:
                self.inputs.check_output(step_path(self.folder, row.id))

    def open(self, *, resume: bool, force: bool) -> None:
        """Open the journal, and find out which rows it has.

        Raises:
            UsageError: It is there, and nobody said what to do with it; or results are without it.
            ExchangeError: It cannot be read or written.
        """
        path, results = self.folder / REPORTS, self.folder / RESULTS
        for output in (path, results):  # before anything is removed, and before a pipe keeps us waiting
            if output.exists() and not output.is_file():
                raise ExchangeError(
                    f"{output} cannot be written: it is a folder, a pipe or a device; move it away, or give another "
                    "folder"
                )
        if results.exists() and not path.exists() and not force:
            raise UsageError(
                f"{results} is there without {REPORTS}, so that no earlier run is known to have written it: --force "
                "overwrites it; or give another folder"
            )
        self.finished = bytearray(len(self.keys))
        if path.exists() and path.stat().st_size:
            if resume:
                self.finished = keep_finished(path, self.keys, self.folder, self.inputs, builds=self.builds)
            elif force:
                forget(path, self.folder, self.inputs)
            else:
                raise UsageError(
                    f"{path} is of an earlier run: --resume goes on with it, --force forgets it; or give another folder"
                )
        with explained(str(results)):
            results.unlink(missing_ok=True)  # of an earlier run: it must not be taken for this one's
        self.journal = Journal(path)

    def work(
        self,
        rows: Iterable[Row],
        executor: Executor,
        timeout: float | None,
        standing: Standing,
        progress: Callable[[Standing], None] | None,
    ) -> None:
        """Do what is not finished."""
        remarks: set[str] = set()

        def done(task: Task, results: list[RowResult]) -> None:
            places = {result.id: self._row(result.id) for result in results}
            fresh = [result for result in results if not self.finished[places[result.id]]]
            by_id = {row.id: row for row in task.rows}
            for result in fresh:
                self._check_inputs(places[result.id], by_id[result.id])
                self._check_written(result)
            self.journal.append(
                [(result, self.keys.input_hash(places[result.id]), by_id[result.id].overrides) for result in fresh]
            )
            for result in fresh:
                self.finished[places[result.id]] = 1
                for remark in result.remarks:
                    if remark not in remarks and len(remarks) < 1000:
                        remarks.add(remark)
                        _log.warning("%s", remark)
            standing.done += len(fresh)
            standing.failed += sum(result.status != "done" for result in fresh)
            standing.latest = fresh
            if progress is not None:
                progress(standing)

        self.schedule = Schedule(executor, self._tasks(rows), done, builds=self.builds, timeout=timeout)
        self.schedule.run()

    def _row(self, row_id: str) -> int:
        row = self.keys.row(row_id)
        assert row is not None  # it was looked over
        return row

    def _tasks(self, rows: Iterable[Row]) -> Iterator[Task]:
        """The work, in the order of the rows; without solids in blocks, which are done whole for the sake of one row.

        Raises:
            ExchangeError: The rows are not those that were looked over.
        """
        folder = str(self.folder.absolute()) if self.builds else None
        most = 1 if self.builds else BLOCK
        block: list[Row] = []
        count = 0
        for row in _read_again(rows):
            if not self.keys.is_row(count, row.id):
                raise ExchangeError(
                    f"the rows changed while they were worked on: row {count + 1} was not {row.id!r} before"
                )
            block.append(row)
            count += 1
            if len(block) == most:
                yield from self._task(count, block, folder)
                block = []
        if block:
            yield from self._task(count, block, folder)
        if count != len(self.keys):
            raise ExchangeError(f"the rows changed while they were worked on: {count} are left of {len(self.keys)}")

    def _task(self, end: int, block: list[Row], folder: str | None) -> Iterator[Task]:
        """The task of the rows before a place, if one of them is not finished."""
        first = end - len(block)
        self.inputs.check_handed_out(first, block, self.keys)
        if not all(self.finished[first:end]):
            yield Task(tuple(block), folder, self.strict, self.epoch if self.builds else None)

    def _check_inputs(self, place: int, row: Row) -> None:
        """See that a row was worked on with the input it is to have; if not, no file of it is left.

        Raises:
            ExchangeError: One of its files changed meanwhile.
        """
        try:
            self.inputs.check_done(place, row, self.keys)
        except ExchangeError:
            self._remove_step(row.id)
            raise

    def _remove_step(self, row_id: str) -> None:
        """Remove the STEP file of a row that has none: a killed run's, or one that was there before."""
        path = step_path(self.folder, row_id)
        if self.builds and (path.is_file() or path.is_symlink()):
            with explained(str(path)):
                path.unlink()

    def _check_written(self, result: RowResult) -> None:
        """See that a STEP file is where it is said to be, and that there is none of a row without.

        Raises:
            ExchangeError: A process of another machine wrote it where this one cannot see it.
        """
        if not self.builds:
            return
        path = step_path(self.folder, result.id)
        if result.status in ("crashed", "timed_out"):
            remove_leftovers(path)
        if result.size is None:
            self._remove_step(result.id)
        elif not (path.is_file() and path.stat().st_size == result.size):
            raise ExchangeError(
                f"{path} is not what a worker says it has written there; all workers must see this folder at one path"
            )

    def tidy(self) -> None:
        """Remove what ended processes left of the files they were writing."""
        if self.builds and self.schedule is not None:
            for row_id in self.schedule.rows_in_flight:
                with contextlib.suppress(OSError):
                    remove_leftovers(step_path(self.folder, row_id))


def _executor(batch: _Batch, workers: int | None, timeout: float | None, *, isolated: bool) -> Executor:
    """What works on a batch.

    Processes where the work outweighs their start, where a row must be ended after a time, and where an earlier run may
    have died of a row; else this process.
    """
    left = len(batch.keys) - sum(batch.finished)
    tasks = left if batch.builds else -(-left // BLOCK)
    if workers is None:
        workers = min(processors(), tasks)
        if left < (LEAST_BUILT if batch.builds else LEAST_SOLVED) or workers == 1:
            workers = 1 if timeout is not None or (isolated and batch.builds) else 0
    if not workers:
        return InlineExecutor()
    return WorkerPool(min(workers, tasks), timeout=timeout, preload=preload(batch.builds))


def _read_again(rows: Iterable[Row]) -> Iterator[Row]:
    """The rows once more.

    Raises:
        ExchangeError: They cannot be made any more.
    """
    try:
        yield from rows
    except SceneError as error:
        raise ExchangeError(f"the rows changed while they were worked on: {error}") from error


def _refuse_doubles(ids: Iterable[str], rows: list[int]) -> None:
    """Refuse ids that more than one row has.

    Raises:
        SceneError: Each such id and its rows.
    """
    found: dict[str, list[tuple[int, str]]] = {}
    for row, row_id in zip(rows, ids, strict=True):
        found.setdefault(same_id(row_id), []).append((row + 1, row_id))
    mistakes = []
    for places in found.values():
        if len(places) > 1:
            listed = ", ".join(str(row) for row, _ in places[:5]) + (", ..." if len(places) > 5 else "")
            problem = f"is the id of rows {listed}; each names its own files, and capitals make no difference"
            mistakes.append(Mistake("id", problem, places[0][1]))
    if mistakes:
        raise SceneError(mistakes, source="rows")
