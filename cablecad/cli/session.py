"""What every subcommand shares: exit codes, the two streams, verbosity and progress."""

from __future__ import annotations

import logging
import os
import sys
import traceback
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from io import TextIOWrapper, UnsupportedOperation
from pathlib import Path
from typing import Any, TypeVar

import click

from cablecad.cli import INTERRUPTED
from cablecad.cli.interrupt import interrupt
from cablecad.errors import CablecadError, ExchangeError

F = TypeVar("F", bound=Callable[..., Any])

BUG = 1

_log = logging.getLogger("cablecad")


class _Remarks(logging.Handler):
    """Shows what cablecad logs as remarks on stderr."""

    def emit(self, record: logging.LogRecord) -> None:
        click.echo(f"{record.levelname.lower()}: {record.getMessage()}", err=True)


_remarks = _Remarks()


def scene_argument(function: F) -> F:
    """The SCENE argument; whether it can be read is the loader's to say, with the right exit code."""
    return click.argument("scene_path", metavar="SCENE", type=click.Path(path_type=Path))(function)


def verbosity_options(function: F) -> F:
    """-q and -v, understood by every command."""
    function = click.option(
        "-q", "--quiet", is_flag=True, expose_value=False, callback=_quiet, help="On stderr, errors only."
    )(function)
    return click.option(
        "-v", "--verbose", is_flag=True, expose_value=False, callback=_verbose, help="Say more, with tracebacks."
    )(function)


def _quiet(_context: click.Context, _parameter: click.Parameter, value: bool) -> None:
    if value:
        _log.setLevel(logging.ERROR)


def _verbose(_context: click.Context, _parameter: click.Parameter, value: bool) -> None:
    if value:
        _log.setLevel(logging.DEBUG)


# --- the two streams ----------------------------------------------------------------------------------------------


def use_utf8() -> None:
    """Write UTF-8 to stdout where that is a file or a pipe, whatever the locale: it may be JSON, or odd paths."""
    if isinstance(sys.stdout, TextIOWrapper):
        if sys.stdout.isatty():
            sys.stdout.reconfigure(errors="backslashreplace")
        else:
            sys.stdout.reconfigure(encoding="utf-8", errors="surrogateescape")


def say(message: str) -> None:
    """A remark on stderr, unless the user asked for quiet."""
    if _log.getEffectiveLevel() <= logging.WARNING:
        click.echo(message, err=True)


def say_error(message: str) -> None:
    """An error on stderr."""
    click.echo(click.style("error: ", fg="red", bold=True) + message, err=True)


def warn_of(cable: str, messages: Iterable[str]) -> None:
    """What a user should know of a cable, a line each."""
    for message in messages:
        say(f"warning: cable {cable}: {message}")


def note_all(remarks: Iterable[str]) -> None:
    """What a user should know of a scene besides, a line each."""
    for remark in remarks:
        say(f"note: {remark}")


def show_errors(errors: Iterable[CablecadError]) -> None:
    """Every error of a scene, a line each."""
    for error in errors:
        _show(error)


def _show(error: CablecadError) -> None:
    say_error(str(error))
    _trace(error)


def _trace(error: BaseException) -> None:
    if _log.level == logging.DEBUG:
        traceback.print_exception(error)


def _forget_stdout() -> None:
    """Let what stdout still holds go nowhere, or Python would try to write it once more as it exits."""
    with suppress(UnsupportedOperation):  # a stand-in for stdout holds nothing that could be lost
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


# --- the run ------------------------------------------------------------------------------------------------------


def run_command(command: click.Command, arguments: list[str] | None) -> int:
    """Run the command line and return its exit code; nothing escapes as a traceback unless -v asks for it."""
    level = _log.level
    _log.setLevel(logging.WARNING)
    _log.addHandler(_remarks)
    try:
        result = command.main(args=arguments, prog_name="cablecad", standalone_mode=False)
    except click.ClickException as error:
        error.show()
        return error.exit_code
    except (KeyboardInterrupt, click.Abort):
        return _interrupted()
    except SystemExit as ended:
        # With 1 click ends where the reader of stdout went away (`cablecad schema | head`), which is nobody's fault.
        # With 0 it has told a shell what may follow.
        if ended.code:
            _forget_stdout()
        return 0
    except Exception as error:  # noqa: BLE001 - the last line of defence: exit code 1 means a bug, never a raw traceback
        return _interrupted() if interrupt.came else _failed(error)
    finally:  # whoever called is left with the log as it was
        _log.removeHandler(_remarks)
        _log.setLevel(level)
    return result if isinstance(result, int) else 0


def _interrupted() -> int:
    click.echo("interrupted", err=True)
    return INTERRUPTED


def _failed(error: Exception) -> int:
    """Say what went wrong and return the code for it."""
    if isinstance(error, OSError) and error.errno is not None and error.filename is None:
        # Of all that is read and written, stdout alone has no name.
        _forget_stdout()
        error = ExchangeError(f"stdout cannot be written: {error.strerror}; send it elsewhere")
    if isinstance(error, CablecadError):
        _show(error)
        for note in getattr(error, "__notes__", ()):
            say_error(note)
        return error.exit_code
    say_error(f"this is a bug in cablecad: {type(error).__name__}: {error} (run with -v for the traceback)")
    _trace(error)
    return BUG


def on_terminal() -> bool:
    """Whether somebody watches stderr and did not ask for quiet."""
    return sys.stderr is not None and sys.stderr.isatty() and _log.level != logging.ERROR


@contextmanager
def progress_bar(total: int) -> Iterator[Callable[[str], None] | None]:
    """A progress bar on stderr where that is a terminal; yields what to call as each step begins, or None."""
    if not on_terminal() or total < 2:
        yield None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    # What is printed meanwhile goes above the bar, but into a file or a pipe as ever.
    above = sys.stdout.isatty()
    with Progress(*columns, console=Console(stderr=True), transient=True, redirect_stdout=above) as progress:
        task = progress.add_task("", total=total)

        def advance(name: str) -> None:
            progress.update(task, description=name, advance=1)

        yield advance
