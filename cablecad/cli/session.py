"""What every subcommand shares: exit codes, the error stream, verbosity and progress."""

from __future__ import annotations

import logging
import os
import sys
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

import click

from cablecad.errors import CablecadError, ExchangeError

F = TypeVar("F", bound=Callable[..., Any])

INTERRUPTED = 130
BUG = 1

_log = logging.getLogger("cablecad")


def scene_argument(function: F) -> F:
    """The SCENE argument; whether it can be read is the loader's to say, with the right exit code."""
    return click.argument("scene_path", metavar="SCENE", type=click.Path(path_type=Path))(function)


def verbosity_options(function: F) -> F:
    """-q and -v, understood by every command."""
    function = click.option("-q", "--quiet", is_flag=True, expose_value=False, callback=_quiet, help="Errors only.")(
        function
    )
    return click.option(
        "-v", "--verbose", is_flag=True, expose_value=False, callback=_verbose, help="Say more, with tracebacks."
    )(function)


def _quiet(_context: click.Context, _parameter: click.Parameter, value: bool) -> None:
    if value:
        _log.setLevel(logging.ERROR)


def _verbose(_context: click.Context, _parameter: click.Parameter, value: bool) -> None:
    if value:
        _log.setLevel(logging.DEBUG)


def say(message: str) -> None:
    """A remark on stderr, unless the user asked for quiet."""
    if _log.getEffectiveLevel() <= logging.WARNING:
        click.echo(message, err=True)


def say_error(message: str) -> None:
    """An error on stderr."""
    click.echo(click.style("error: ", fg="red", bold=True) + message, err=True)


def run_command(command: click.Command, arguments: list[str] | None) -> int:
    """Run the command line and return its exit code; nothing escapes as a traceback unless -v asks for it."""
    _log.setLevel(logging.WARNING)
    try:
        result = command.main(args=arguments, prog_name="cablecad", standalone_mode=False)
        sys.stdout.flush()
    except (click.exceptions.Exit, click.ClickException) as ended:
        if isinstance(ended, click.ClickException):
            ended.show()
        return ended.exit_code
    except (KeyboardInterrupt, click.Abort):
        click.echo("interrupted", err=True)
        return INTERRUPTED
    except CablecadError as error:
        _show(error)
        return error.exit_code
    except BrokenPipeError:
        # The reader of stdout went away (`cablecad schema | head`): end quietly, and keep Python from flushing again.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except Exception as error:  # noqa: BLE001 - the last line of defence: exit code 1 means a bug, never a raw traceback
        say_error(f"this is a bug in cablecad: {type(error).__name__}: {error} (run with -v for the traceback)")
        if _log.level == logging.DEBUG:
            traceback.print_exc()
        return BUG
    return result if isinstance(result, int) else 0


def _show(error: CablecadError) -> None:
    if isinstance(error, ExchangeError) and error.filename is not None:
        say_error(f"{error.filename}: {error.strerror}")
    else:
        say_error(str(error))
    if _log.level == logging.DEBUG:
        traceback.print_exc()


def show_errors(errors: list[CablecadError]) -> None:
    """Every error of a scene, a line each."""
    for error in errors:
        _show(error)


@contextmanager
def progress_bar(total: int) -> Iterator[Callable[[str], None] | None]:
    """A progress bar on stderr where that is a terminal; yields what to call as each step begins, or None."""
    if not sys.stderr.isatty() or _log.level == logging.ERROR or total < 2:
        yield None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task("", total=total)

        def advance(name: str) -> None:
            progress.update(task, description=name, advance=1)

        yield advance
