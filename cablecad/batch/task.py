"""What is done with some rows of a batch, in whatever process: solved together, or one after the other made into STEP.

A row that fails is a result like any other. What would fail every row (the output cannot be written, there is no
kernel) is raised, and ends the batch.
"""

from __future__ import annotations

import contextlib
import importlib
import json
import logging
import os
import platform
import threading
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any, Literal

from cablecad.batch.rows import Row
from cablecad.errors import CablecadError, ExchangeError, MissingDependencyError, SceneError, UsageError
from cablecad.model import Scene
from cablecad.pipeline import Documents, SceneRun, check_output, measure_scenes, run_build, solve_scenes

Status = Literal["done", "failed", "crashed", "timed_out"]

JSON = json.JSONEncoder(ensure_ascii=False, allow_nan=False)
"""Of the lines of the journal."""

_REPORT = json.JSONEncoder(ensure_ascii=False, allow_nan=False, check_circular=False)
"""Of what is known to be a tree."""

BUG = 1

_EPOCH = "SOURCE_DATE_EPOCH"

# Open Cascade keeps its settings per process: threads of one process take turns.
_turn = threading.RLock()


@dataclass(frozen=True, slots=True)
class Task:
    """Rows to be worked on at one go, with all that the work depends on.

    Attributes:
        rows: Solved together where no solids are made.
        folder: Where the STEP files go; None for results only.
        strict: Whether a broken `min_bend_radius` is an error.
        epoch: SOURCE_DATE_EPOCH, which other machines may not know.
    """

    rows: tuple[Row, ...]
    folder: str | None
    strict: bool = False
    epoch: str | None = None


@dataclass(frozen=True, slots=True)
class RowResult:
    """What became of a row.

    Attributes:
        id: Of the row.
        status: "done"; "failed": see `error`; "crashed": its process died; "timed_out".
        error: Every reason, a line each.
        exit_code: What `cablecad build` or `solve` would have ended with.
        report: Report format 1 as JSON on one line; None where there is none.
        size: Of the STEP file [bytes]; None where none was written.
        remarks: What was logged, a text each.
    """

    id: str
    status: Status
    error: str = ""
    exit_code: int = 0
    report: str | None = None
    size: int | None = None
    remarks: tuple[str, ...] = ()


def step_path(folder: str | Path, row_id: str) -> Path:
    """Where the STEP file of a row goes."""
    return Path(folder) / f"{row_id}.step"


def get_ready(modules: Sequence[str], pause: float) -> tuple[str, int, int]:
    """Import what tasks need, before their time is taken; returns which worker this is: machine, process and thread.

    Args:
        modules: What is imported; one that cannot be is the first task's to tell of.
        pause: How long to wait after it, so that the others get their turn [s].
    """
    for module in modules:
        with contextlib.suppress(ImportError):
            importlib.import_module(module)
    time.sleep(pause)
    return platform.node(), os.getpid(), threading.get_ident()


def run_task(task: Task, *, collect: bool = True) -> list[RowResult]:
    """Work on the rows of a task.

    Args:
        task: What to do.
        collect: Whether what is logged goes into the results, because nobody listens in this process.

    Returns:
        A result for each row, in order.

    Raises:
        ExchangeError: The output cannot be written.
        MissingDependencyError: There is no Open Cascade.
        UsageError: SOURCE_DATE_EPOCH is not a time.
    """
    if task.folder is None:
        with _turn:  # ends on parts may need Open Cascade
            return _solve_rows(task)
    folder = Path(task.folder)
    with _turn, _environment(task.epoch):
        return [_build_row(row, step_path(folder, row.id), task.strict, collect) for row in task.rows]


# --- results only -------------------------------------------------------------------------------------------------


def _solve_rows(task: Task) -> list[RowResult]:
    results: dict[int, RowResult] = {}
    scenes: list[tuple[int, Scene]] = []
    for i, row in enumerate(task.rows):
        scene = _resolved(row)
        if isinstance(scene, RowResult):
            results[i] = scene
        else:
            scenes.append((i, scene))
    try:
        runs = solve_scenes([scene for _, scene in scenes], documents=_documents(), measured=False)
        measure_scenes(run for run in runs if not isinstance(run, SceneError))
    except Exception as error:  # noqa: BLE001 - a bug; which row shows it is found below, and the others are solved
        if len(task.rows) == 1:
            return [_bug(task.rows[0], error)]
        alone = [Task((row,), None, task.strict, task.epoch) for row in task.rows]
        return [result for one in alone for result in _solve_rows(one)]
    for (i, _), run in zip(scenes, runs, strict=True):
        row = task.rows[i]
        try:
            results[i] = _failed(row, run) if isinstance(run, SceneError) else _judged(row, run, task.strict)
        except Exception as error:  # noqa: BLE001 - a bug of this row's must not cost the others
            results[i] = _bug(row, error)
    return [results[i] for i in range(len(task.rows))]


def _judged(row: Row, run: SceneRun, strict: bool) -> RowResult:
    """The result of a scene that was solved; its report is made here, which takes time of its own."""
    begun = time.perf_counter()
    report = run.report()
    # The numbers of the report are found only as it is made, and belong to the row's time.
    run.seconds["total"] += time.perf_counter() - begun
    report["seconds"]["total"] = run.seconds["total"]
    if strict:
        run.errors += run.broken_rules()
    return _result(row, run.errors, run.exit_code, report)


# --- with solids --------------------------------------------------------------------------------------------------


@cache
def _documents() -> Documents:
    """The parts this process has read."""
    return Documents()


def _build_row(row: Row, path: Path, strict: bool, collect: bool) -> RowResult:
    remarks: list[str] = []
    with _collected(remarks) if collect else contextlib.nullcontext():
        result = _built(row, path, strict)
    return result if not remarks else _with_remarks(result, remarks)


def _built(row: Row, path: Path, strict: bool) -> RowResult:
    scene = _resolved(row)
    if isinstance(scene, RowResult):
        return scene
    try:
        check_output(scene, path)
    except UsageError as error:  # the row's own: its output is one of its parts
        return _failed(row, error)
    written = False
    try:
        run = run_build(scene, path, strict=strict, documents=_documents())
        written = not run.errors
        return _result(row, run.errors, run.exit_code, run.report(), size=path.stat().st_size if written else None)
    except (ExchangeError, MissingDependencyError, UsageError):
        raise  # a part that cannot be read is in run.errors: this is the output, and every row's
    except CablecadError as error:
        return _failed(row, error)
    except Exception as error:  # noqa: BLE001 - a bug of this row's must not cost the others
        if written:  # a row that failed leaves no file
            path.unlink(missing_ok=True)
        return _bug(row, error)


# --- both ---------------------------------------------------------------------------------------------------------


def _resolved(row: Row) -> Scene | RowResult:
    try:
        return row.resolve()
    except CablecadError as error:
        return _failed(row, error)
    except Exception as error:  # noqa: BLE001 - a bug of this row's must not cost the others
        return _bug(row, error)


def _result(
    row: Row, errors: Sequence[CablecadError], exit_code: int, report: dict[str, Any], size: int | None = None
) -> RowResult:
    status: Status = "failed" if errors else "done"
    return RowResult(row.id, status, "\n".join(map(_told, errors)), exit_code, _REPORT.encode(report), size)


def _failed(row: Row, error: CablecadError) -> RowResult:
    return RowResult(row.id, "failed", _told(error), error.exit_code)


def _bug(row: Row, error: Exception) -> RowResult:
    return RowResult(row.id, "failed", f"this is a bug in cablecad: {type(error).__name__}: {error}", BUG)


def _told(error: CablecadError) -> str:
    """An error's text; of a scene its mistakes alone, for the row says which scene."""
    return "\n".join(map(str, error.mistakes)) if isinstance(error, SceneError) else str(error)


def _with_remarks(result: RowResult, remarks: Sequence[str]) -> RowResult:
    return replace(result, remarks=tuple(dict.fromkeys(remarks)))


@contextlib.contextmanager
def _collected(remarks: list[str]) -> Iterator[None]:
    """Keep warnings that are logged inside, and let nobody else have them."""
    logger = logging.getLogger("cablecad")

    class Keep(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            remarks.append(record.getMessage())

    handler, propagate = Keep(logging.WARNING), logger.propagate
    logger.addHandler(handler)
    logger.propagate = False
    try:
        yield
    finally:
        logger.removeHandler(handler)
        logger.propagate = propagate


@contextlib.contextmanager
def _environment(epoch: str | None) -> Iterator[None]:
    """Let SOURCE_DATE_EPOCH be what it is where the batch was started."""
    found = os.environ.get(_EPOCH)
    _set_epoch(epoch)
    try:
        yield
    finally:
        _set_epoch(found)


def _set_epoch(epoch: str | None) -> None:
    if epoch is None:
        os.environ.pop(_EPOCH, None)
    else:
        os.environ[_EPOCH] = epoch
