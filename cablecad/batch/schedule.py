"""Hands tasks to an executor and survives what happens to them.

A task whose process died is tried once more. One that failed so twice, or took too long, is done row by row, until the
one that is to blame is alone: `crashed` or `timed_out`; the others are done. An executor that is broken for good by one
dead process is left for processes of our own. No more tasks are on their way than keep the workers busy, so that memory
does not grow with the number of rows.
"""

from __future__ import annotations

import contextlib
import logging
import math
import os
import platform
import signal
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Executor, Future, wait
from dataclasses import dataclass, replace
from types import FrameType
from typing import Any

from cablecad.batch.pool import WorkerPool
from cablecad.batch.task import RowResult, Status, Task, get_ready, run_task
from cablecad.errors import ExchangeError, MissingDependencyError, OvertimeError, UsageError, WorkerStartError

_log = logging.getLogger(__name__)

_POLL = 0.2
"""How often overdue tasks of an executor that is not ours are looked for [s]."""

_PAUSE = 0.1
"""How long a worker that is ready leaves the others their turn [s]."""

_NO_MORE = 5.0
"""So long after the last new worker answered no other is waited for [s]: there may be fewer than is told."""

Done = Callable[[Task, list[RowResult]], None]
"""Called with a task and the results of its rows, as they come."""


class InlineExecutor(Executor):
    """Works in this process, at once."""

    max_workers = 1

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Call the function; its future is done.

        Raises:
            KeyboardInterrupt: Ctrl-C was pressed meanwhile, whatever became of the exception where it was raised.
        """
        future: Future[Any] = Future()
        with _interruptible():
            try:
                future.set_result(fn(*args, **{**kwargs, "collect": False}))
            except Exception as error:  # noqa: BLE001 - raised again by whoever asks the future
                future.set_exception(error)
        return future


@contextlib.contextmanager
def _interruptible() -> Iterator[None]:
    """Let no Ctrl-C get lost inside.

    Raised while Open Cascade loads, KeyboardInterrupt comes out as an ImportError, which a row would keep as a bug; and
    raised while an object is deleted it is gone.

    Raises:
        KeyboardInterrupt: It came, and something else or nothing came out.
    """
    before = signal.getsignal(signal.SIGINT)
    came = False

    def note(number: int, frame: FrameType | None) -> None:
        nonlocal came
        came = True
        if callable(before):
            before(number, frame)

    if not callable(before) or threading.current_thread() is not threading.main_thread():
        yield  # a signal that is ignored, or is not for this thread
        return
    signal.signal(signal.SIGINT, note)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
    if came:
        raise KeyboardInterrupt


@dataclass
class _Flight:
    """A task on its way.

    Attributes:
        task: What is done.
        deaths: How many processes died of it.
        begun: When it was handed out.
    """

    task: Task
    deaths: int = 0
    begun: float = 0.0


class Schedule:
    """The tasks of a batch, those on their way, and those to be tried again."""

    def __init__(
        self, executor: Executor, tasks: Iterator[Task], done: Done, *, builds: bool, timeout: float | None
    ) -> None:
        self._executor = executor
        self._builds = builds
        self._tasks = tasks
        self._done = done
        self._timeout = timeout
        self._flights: dict[Future[list[RowResult]], _Flight] = {}
        self._again: deque[_Flight] = deque()
        self._own: WorkerPool | None = None
        self._hung: set[Future[list[RowResult]]] = set()

    def run(self) -> None:
        """Do all tasks.

        Raises:
            ExchangeError: The output cannot be written, or the executor is gone.
            MissingDependencyError: There is no Open Cascade.
            UsageError: SOURCE_DATE_EPOCH is not a time.
            WorkerStartError: No process of our own can be started.
        """
        try:
            self._get_ready()
            self._fill()
            while self._flights:
                timeout = None if self._timeout is None else _POLL
                done, _ = wait(self._flights, timeout=timeout, return_when=FIRST_COMPLETED)
                for future in done:
                    self._settle(future, self._flights.pop(future))
                self._expire()
                self._fill()
        except BaseException:
            for future in self._flights:
                future.cancel()
            if self._own is not None:
                self._own.kill()
            raise
        if self._own is not None:
            self._own.shutdown()

    @property
    def rows_in_flight(self) -> list[str]:
        """The ids of the rows that were begun and are not done."""
        return [row.id for flight in self._flights.values() for row in flight.task.rows]

    def _get_ready(self) -> None:
        """Have the workers of an executor that is not ours start and import, where tasks are timed from outside.

        Raises:
            ExchangeError: The executor is gone.
        """
        if self._timeout is None or self._ends_overtime:
            return
        workers = max_workers(self._executor)
        seen: set[tuple[str, int, int]] = set()
        last = math.inf
        try:
            while len(seen) < workers and time.monotonic() < last + _NO_MORE:
                calls = [self._executor.submit(get_ready, preload(self._builds), _PAUSE) for _ in range(workers)]
                for worker in (call.result() for call in calls):
                    if worker[:2] == (platform.node(), os.getpid()):  # threads of this process share what is imported
                        return
                    if worker not in seen:
                        seen.add(worker)
                        last = time.monotonic()
        except CancelledError as error:
            raise _gave_up() from error
        except BrokenExecutor:
            self._leave_broken()
        except Exception as error:  # noqa: BLE001 - what ails the executor the tasks will tell of
            _log.info("the executor is not ready: %r", error)

    def _fill(self) -> None:
        """Send off as many tasks as keep the workers busy."""
        while len(self._flights) < self._room():
            flight = self._again.popleft() if self._again else None
            if flight is None:
                task = next(self._tasks, None)
                if task is None:
                    return
                flight = _Flight(task)
            flight.begun = time.monotonic()
            try:
                future = self._executor.submit(run_task, flight.task)
            except BrokenExecutor:
                self._leave_broken()
                self._again.appendleft(flight)
                continue
            self._flights[future] = flight

    def _settle(self, future: Future[list[RowResult]], flight: _Flight) -> None:
        """Take the results of a task, or find out what became of it."""
        try:
            results = future.result()
        except (ExchangeError, MissingDependencyError, UsageError, WorkerStartError):
            raise  # of every row
        except CancelledError as error:
            raise _gave_up() from error
        except BrokenExecutor:  # which task broke it is not told: all of them are done anew, where it will be
            self._leave_broken()
            self._again.append(flight)
        except OvertimeError:
            self._part_or_end(flight, "timed_out", self._overtime())
        except Exception as error:  # noqa: BLE001 - our side raises no other: this is how an executor tells of a death
            flight.deaths += 1
            if flight.deaths == 1:
                self._again.append(flight)
            else:
                self._part_or_end(flight, "crashed", f"{error} (twice)" if str(error) else repr(error))
        else:
            self._done(flight.task, results)

    def _part_or_end(self, flight: _Flight, status: Status, error: str) -> None:
        """Do the rows of a task one by one, or give up the one row of it."""
        rows = flight.task.rows
        if len(rows) == 1:
            self._done(flight.task, [RowResult(rows[0].id, status, error, exit_code=4)])
            return
        # All at once and not by halves: a row that hangs keeps a worker for its whole time each time it is tried.
        self._again.extend(_Flight(replace(flight.task, rows=(row,))) for row in rows)

    def _expire(self) -> None:
        """Give up tasks that take too long, where the executor is not ours and does not do it itself."""
        if self._timeout is None or self._ends_overtime:
            return
        now = time.monotonic()
        for future, flight in list(self._flights.items()):
            if now - flight.begun > self._timeout:
                if not future.cancel():
                    self._hung.add(future)  # it runs on, where nobody can end it, and its result is forgotten
                del self._flights[future]
                self._part_or_end(flight, "timed_out", self._overtime())

    @property
    def _ends_overtime(self) -> bool:
        """Whether the executor itself ends what takes too long."""
        return isinstance(self._executor, WorkerPool) and self._executor.timeout is not None

    def _room(self) -> int:
        """How many tasks may be on their way: one being done and one waiting for each worker.

        Raises:
            ExchangeError: All workers hang.
        """
        if isinstance(self._executor, InlineExecutor):
            return 1
        workers = max_workers(self._executor)
        if self._timeout is None or self._ends_overtime:
            return 2 * workers
        # Only what is not waiting for another can be timed from outside.
        self._hung = {future for future in self._hung if not future.done()}
        if len(self._hung) >= workers:
            raise ExchangeError(
                f"all {workers} workers of the executor hang in rows that took longer than {self._timeout:g} s; start "
                "it again, and the batch with --resume"
            )
        return workers - len(self._hung)

    def _overtime(self) -> str:
        return f"took longer than the {self._timeout:g} s of --timeout"

    def _leave_broken(self) -> None:
        """Go on with processes of our own after the executor broke."""
        if self._own is None:
            _log.warning("the executor broke, as a process of it died; going on with worker processes of our own")
            workers = max_workers(self._executor)
            self._own = WorkerPool(workers, timeout=self._timeout, preload=preload(self._builds))
        self._executor = self._own
        self._hung.clear()


def _gave_up() -> ExchangeError:
    return ExchangeError(
        "the executor gave up its tasks (a scheduler that stopped, a shutdown); start it again, and the batch with "
        "--resume"
    )


def max_workers(executor: Executor) -> int:
    """How many tasks an executor works on at one time, as far as it tells."""
    for name in ("max_workers", "_max_workers"):
        count = getattr(executor, name, None)
        if isinstance(count, int) and count > 0:
            return count
    client = getattr(executor, "_client", None)  # of Dask
    if client is not None and hasattr(client, "nthreads"):
        return max(sum(int(count) for count in client.nthreads().values()), 1)
    return processors()


def preload(builds: bool) -> tuple[str, ...]:
    """The modules a worker needs, which take a second or two to import."""
    solving = ("cablecad.scene", "cablecad.rod.solve", "scipy.linalg")
    return (*solving, "cablecad.brep.step", "cablecad.brep.check") if builds else solving


def processors() -> int:
    """How many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
