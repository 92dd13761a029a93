"""The worker process: calls come in on stdin, answers go out on what was stdout, both pickled."""

from __future__ import annotations

import contextlib
import importlib
import os
import pickle
import signal
import sys
import threading
import time
from collections.abc import Sequence
from typing import Any


def serve(preload: Sequence[str] = ()) -> None:
    """Answer calls until stdin ends; never returns.

    Args:
        preload: Modules to import before; one that cannot be is the first call's to tell of.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # a Ctrl-C is for the process that started this one
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # whatever is printed in here is no answer
    if hasattr(os, "getppid"):
        threading.Thread(target=_follow, args=(os.getppid(),), daemon=True).start()
    for module in preload:
        with contextlib.suppress(ImportError):
            importlib.import_module(module)
    _answer(answers, True)
    while True:
        try:
            function, arguments, keywords = pickle.load(sys.stdin.buffer)
        except (EOFError, OSError):
            os._exit(0)  # unloading Open Cascade takes a third of a second, and nobody waits for it
        try:
            answer: tuple[bool, Any] = True, function(*arguments, **keywords)
        except Exception as error:  # noqa: BLE001 - whatever it is, it is for the one who called
            answer = False, error
        try:
            _answer(answers, answer)
        except (BrokenPipeError, ValueError):
            os._exit(0)


def _follow(parent: int) -> None:
    """End with the process that started this one, even in the middle of a call that hangs."""
    while os.getppid() == parent:
        time.sleep(1.0)
    os._exit(1)


def _answer(answers: Any, answer: Any) -> None:
    try:
        data = pickle.dumps(answer, pickle.HIGHEST_PROTOCOL)
    except Exception as error:  # noqa: BLE001 - an exception of any kind may hold what cannot be pickled
        data = pickle.dumps((False, RuntimeError(f"{answer[1]!r} cannot be sent: {error!r}")))
    answers.write(data)
    answers.flush()
