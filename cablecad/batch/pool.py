"""Worker processes that may die or hang: an executor in which a dead process costs the one task it was working on.

`concurrent.futures.ProcessPoolExecutor` is broken for good by one dead process, does not tell which task killed it and
cannot end one that hangs. Here each worker is a process and a thread of ours that waits for it: the thread sends a task
down a pipe and reads the answer from another. No answer, but the end of the pipe: the process is dead, the task's
future says so, and the next task gets a new process.

The processes are started anew (`python -c`), and nothing of `__main__` is imported in them: scripts need no guard.
Ctrl-C is not theirs to hear; they end when their pipe does, whatever became of us.
"""

from __future__ import annotations

import contextlib
import json
import math
import multiprocessing.spawn
import os
import pickle
import queue
import signal
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import Executor, Future
from typing import Any, TypeVar

from cablecad.errors import OvertimeError, UsageError, WorkerDiedError, WorkerStartError

T = TypeVar("T")

_MOST_TASKS = 2000
"""A process is replaced after so many tasks: Open Cascade keeps some 16 kB of each."""

_STARTS = 3
"""So often a process is started before it is said that none can be: one may be killed as any other may."""

_CODE = (
    "import json, sys; sys.path[:] = json.loads(sys.argv[1]); from cablecad.batch.child import serve; "
    "serve(sys.argv[2:])"
)

_GOODBYE = 5.0
"""How long a process that was told to end may take [s]; then it is killed."""


def check_timeout(timeout: float | None) -> None:
    """Refuse a timeout that is none.

    Raises:
        UsageError: It is not finite, or not more than 0.
    """
    if timeout is not None and not 0.0 < timeout < math.inf:
        raise UsageError(
            f"the timeout is {timeout:g} s, but must be more than 0 and finite; leave it out to wait without end"
        )


class WorkerPool(Executor):
    """Processes that work on tasks, one at a time each.

    Attributes:
        timeout: How long a task may take [s], from the moment it is begun; None for as long as it wants.
        max_workers: How many processes there are at most.
    """

    def __init__(self, workers: int, *, timeout: float | None = None, preload: Sequence[str] = ()) -> None:
        """Begin with no process: each is started when there is a task for it.

        Args:
            workers: How many processes.
            timeout: As the attribute.
            preload: Modules that are imported before a process is ready, so that it is in no task's time.

        Raises:
            UsageError: The timeout is not finite, or not more than 0.
        """
        check_timeout(timeout)
        # Some 300 years, on which a thread cannot wait any longer.
        self.timeout = timeout = None if timeout is None else min(timeout, threading.TIMEOUT_MAX)
        self.max_workers = workers
        self._tasks: queue.SimpleQueue[tuple[Future[Any], bytes] | None] = queue.SimpleQueue()
        self._stopped = False
        self._workers = [_Worker(self._tasks, timeout, preload) for _ in range(workers)]

    def submit(self, fn: Callable[..., T], /, *args: Any, **kwargs: Any) -> Future[T]:
        """Have a function called in one of the processes; it and its arguments are pickled.

        The future raises `WorkerDiedError` or `OvertimeError` where the process came to an end.
        """
        if self._stopped:
            raise RuntimeError("cannot schedule new futures after shutdown")
        future: Future[T] = Future()
        self._tasks.put((future, pickle.dumps((fn, args, kwargs), pickle.HIGHEST_PROTOCOL)))
        for worker in self._workers:
            if worker.start():
                break
        return future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the processes once all tasks are done, or at once those that are not begun."""
        self._stopped = True
        if cancel_futures:
            self._cancel_waiting()
        for _ in self._workers:
            self._tasks.put(None)
        if wait:
            for worker in self._workers:
                worker.join()

    def kill(self) -> None:
        """End everything now; what was not done is cancelled or raises `WorkerDiedError`."""
        self._stopped = True
        self._cancel_waiting()
        for worker in self._workers:
            self._tasks.put(None)
            worker.kill()
        for worker in self._workers:
            worker.join()

    def _cancel_waiting(self) -> None:
        with contextlib.suppress(queue.Empty):
            while True:
                waiting = self._tasks.get_nowait()
                if waiting is not None:
                    waiting[0].cancel()


class _Worker:
    """A thread and the process it waits for."""

    def __init__(
        self,
        tasks: queue.SimpleQueue[tuple[Future[Any], bytes] | None],
        timeout: float | None,
        preload: Sequence[str],
    ) -> None:
        self._tasks = tasks
        self._preload = preload
        self._timeout = timeout
        self._thread: threading.Thread | None = None
        self._child: _Child | None = None
        self._killed = False

    def start(self) -> bool:
        """Start the thread; False if it has been already."""
        if self._thread is not None:
            return False
        self._thread = threading.Thread(target=self._run, name="cablecad worker", daemon=True)
        self._thread.start()
        return True

    def join(self) -> None:
        """Wait for the thread."""
        if self._thread is not None:
            self._thread.join(_GOODBYE + 5.0)

    def kill(self) -> None:
        """End the process now, for good."""
        self._killed = True
        child = self._child
        if child is not None:
            child.kill()

    def _run(self) -> None:
        if hasattr(signal, "pthread_sigmask"):
            # Inherited by the processes, so that they are deaf to Ctrl-C from the first moment on.
            signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        while True:
            item = self._tasks.get()
            if item is None:
                break
            future, call = item
            if self._killed:
                future.cancel()
            elif future.set_running_or_notify_cancel():
                self._settle(future, call)
        self._dismiss()

    def _settle(self, future: Future[Any], call: bytes) -> None:
        """Have a call made, and tell its future how that ended."""
        try:
            ok, value = self._ready_child().call(call, self._timeout)
        except Exception as error:  # noqa: BLE001 - a future that nobody settles is waited for without end
            self._dismiss()
            future.set_exception(error)
            return
        if ok:
            future.set_result(value)
        else:
            future.set_exception(value)
        if self._child is not None and self._child.calls >= _MOST_TASKS:
            self._dismiss()

    def _ready_child(self) -> _Child:
        """The process, started if there is none or it has died since its last answer.

        Raises:
            WorkerStartError: It died before it was ready, `_STARTS` times.
        """
        if self._child is not None and not self._child.died:
            return self._child
        told = ""
        for _ in range(_STARTS):
            self._dismiss()
            child = self._child = _Child(self._preload)
            if self._killed:  # in between
                child.kill()
            if child.begin():
                return child
            told = child.last_words()
        self._dismiss()
        raise WorkerStartError(
            f"a worker process ended before it was ready{told}; is there enough memory? -j 0 works without any"
        )

    def _dismiss(self) -> None:
        child, self._child = self._child, None
        if child is not None:
            child.end()


class _Child:
    """A process that answers calls; it is `cablecad.batch.child` on the other side."""

    def __init__(self, preload: Sequence[str]) -> None:
        self.calls = 0
        self._stderr = tempfile.TemporaryFile()  # noqa: SIM115 - closed by end()
        # Matrices here have some 40 rows: threads of BLAS cost more than they bring. The processors are taken by
        # workers, so that Open Cascade's checks take one thread each (`brep.check.ONE_THREAD`).
        environment = {"OPENBLAS_NUM_THREADS": "1", "CABLECAD_ONE_THREAD": "1", **os.environ}
        python = os.fsdecode(multiprocessing.spawn.get_executable() or sys.executable)
        self._process = subprocess.Popen(
            [python, "-c", _CODE, json.dumps(sys.path), *preload],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._stderr,
            env=environment,
        )

    @property
    def died(self) -> bool:
        """Whether it is no more."""
        return self._process.poll() is not None

    def begin(self) -> bool:
        """Wait until it is ready; False if it died before."""
        try:
            return bool(pickle.load(self._process.stdout))  # type: ignore[arg-type]
        except (EOFError, OSError, pickle.UnpicklingError):
            return False

    def call(self, call: bytes, timeout: float | None) -> tuple[bool, Any]:
        """Have a call made: whether it returned, and what it returned or raised.

        Raises:
            OvertimeError: It was killed for taking too long.
            WorkerDiedError: It died.
        """
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self.calls += 1
        lock, answered, overtime = threading.Lock(), False, False

        def expire() -> None:
            nonlocal overtime
            with lock:
                if not answered:
                    overtime = True
                    self.kill()

        timer = None if timeout is None else threading.Timer(timeout, expire)
        if timer is not None:
            timer.daemon = True
            timer.start()
        try:
            self._process.stdin.write(call)
            self._process.stdin.flush()
            answer: tuple[bool, Any] = pickle.load(self._process.stdout)
            with lock:
                answered = True
            if overtime:  # it was killed with the answer in the pipe
                self._process.wait()
        except (EOFError, OSError, pickle.UnpicklingError):
            self._process.wait()
            if overtime:
                raise OvertimeError(f"took longer than {timeout:g} s") from None
            code = self._process.returncode
            how = f"signal {_signal_name(-code)}" if code < 0 else f"exit code {code}"
            raise WorkerDiedError(f"its process died ({how}){self.last_words()}") from None
        finally:
            if timer is not None:
                timer.cancel()
        return answer

    def last_words(self) -> str:
        """The last line it wrote to stderr, as a clause."""
        with contextlib.suppress(OSError, ValueError):
            self._stderr.seek(0, os.SEEK_END)
            self._stderr.seek(max(self._stderr.tell() - 2000, 0))
            lines = self._stderr.read().decode(errors="replace").split("\n")
            said = [line.strip() for line in lines if line.strip()]
            if said:
                return f", saying {said[-1][:300]!r}"
        return ""

    def kill(self) -> None:
        """End it now."""
        with contextlib.suppress(OSError):
            self._process.kill()

    def end(self) -> None:
        """Let it end by itself, and see that it does."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        with contextlib.suppress(OSError):
            self._process.stdin.close()
        try:
            self._process.wait(_GOODBYE)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._process.stdout.close()
        self._stderr.close()


def _signal_name(number: int) -> str:
    try:
        return signal.Signals(number).name
    except ValueError:
        return str(number)
