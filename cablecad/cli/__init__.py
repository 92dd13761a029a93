"""The command line: `cablecad build | solve | check | schema | new`, one file a subcommand.

stdout carries the result alone, stderr all else. Nothing heavy is imported here, so that Ctrl-C is understood from the
first moment on.
"""

from __future__ import annotations

import sys
from typing import NoReturn

from cablecad.cli.interrupt import INTERRUPTED, interrupt


def main(arguments: list[str] | None = None) -> NoReturn:
    """Run the command line as a process of its own, and exit with its code."""
    with interrupt:
        try:
            from cablecad.cli.group import cablecad
            from cablecad.cli.session import run_command, use_utf8

            use_utf8()
            code = run_command(cablecad, arguments)
        except KeyboardInterrupt:  # before run_command could see to it
            sys.stderr.write("interrupted\n")
            code = INTERRUPTED
    raise SystemExit(code)
