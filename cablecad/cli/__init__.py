"""The command line: `cablecad build | solve | check | resolve | schema | new | bench`, one file a subcommand.

stdout carries the result alone, stderr all else.
"""

from __future__ import annotations

import contextlib
import gc
import os
import sys

INTERRUPTED = 130
"""What shells say of a program that Ctrl-C ended: 128 + SIGINT."""


def main(arguments: list[str] | None = None) -> None:
    """Run the command line as a process of its own, and exit with its code."""
    # Matrices here have some 40 rows: threads of BLAS cost more than they bring, many times so on a busy machine.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    # Loading makes a hundred thousand objects that stay: looking through them even once, or at the end, would take a
    # tenth of a short run.
    gc.set_threshold(200_000, 20, 20)
    try:  # All imports are in here, so that Ctrl-C is understood from the first moment on.
        from cablecad.cli.group import cablecad
        from cablecad.cli.interrupt import interrupt
        from cablecad.cli.session import run_command, use_utf8

        with interrupt:
            use_utf8()
            code = run_command(cablecad, arguments)
    except KeyboardInterrupt:
        sys.stderr.write("interrupted\n")
        code = INTERRUPTED
    if code == INTERRUPTED:
        # Nobody waits for what Ctrl-C has ended: unloading Open Cascade takes a third of a second, and ten times that
        # on a busy machine.
        _leave(code)
    gc.freeze()
    raise SystemExit(code)


def _leave(code: int) -> None:
    """End the process at once, with all that was written."""
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(OSError, ValueError, AttributeError):
            stream.flush()
    os._exit(code)
