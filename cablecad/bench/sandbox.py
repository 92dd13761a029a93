"""Work that may kill the process or never end, in a forked copy of it: Open Cascade's sweeps do both.

A fork has Open Cascade loaded already. Where there is none (Windows) nothing is tried that could kill the benchmark.
"""

from __future__ import annotations

import faulthandler
import os
import pickle
import select
import signal
import time
import warnings
from collections.abc import Callable
from typing import TypeVar

T = TypeVar("T")

PATIENCE = 20.0
"""How long work may take [s]."""


class SandboxError(Exception):
    """The work ended otherwise than by a result; the message says how."""


def in_sandbox(work: Callable[[], T]) -> T:
    """Run work in a copy of the process and give its result, which must be picklable.

    Raises:
        SandboxError: It raised, took too long, or killed its process.
    """
    if not hasattr(os, "fork"):
        raise SandboxError("not tried: this system cannot fork")
    reading, writing = os.pipe()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # forks beside threads: BLAS's and Open Cascade's sleep
        child = os.fork()
    if child == 0:
        _answer(work, reading, writing)
    os.close(writing)
    try:
        data = _read(reading, time.monotonic() + PATIENCE)
    except TimeoutError:
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
        raise SandboxError(f"no result within {PATIENCE:g} s") from None
    except BaseException:  # Ctrl-C: leave no child behind
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
        raise
    finally:
        os.close(reading)
    status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    if status < 0:
        raise SandboxError(f"killed the process ({signal.Signals(-status).name})")
    good, result = pickle.loads(data)
    if not good:
        raise SandboxError(result)
    found: T = result
    return found


def _answer(work: Callable[[], object], reading: int, writing: int) -> None:
    """The child: write what became of the work, and end without a word."""
    os.close(reading)
    faulthandler.disable()  # a death is told by the parent
    quiet = os.open(os.devnull, os.O_WRONLY)
    os.dup2(quiet, 1)
    os.dup2(quiet, 2)
    try:
        answer: tuple[bool, object] = True, work()
    except BaseException as error:  # noqa: BLE001 - whatever it is, the parent tells of it
        answer = False, (str(error).splitlines() or [type(error).__name__])[0]
    with os.fdopen(writing, "wb") as pipe:
        pickle.dump(answer, pipe)
    os._exit(0)


def _read(pipe: int, deadline: float) -> bytes:
    parts: list[bytes] = []
    while True:
        ready, _, _ = select.select([pipe], [], [], max(0.0, deadline - time.monotonic()))
        if not ready:
            raise TimeoutError
        part = os.read(pipe, 65536)
        if not part:
            return b"".join(parts)
        parts.append(part)
