"""What all tests share: the command line, called in this process or as one of its own."""

from __future__ import annotations

import os
import signal
import subprocess
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import pytest
from command_line import COMMAND_LINE
from hypothesis import settings

# As the command line does, before numpy is loaded: threads only hinder on small matrices.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# A run in the background of a script is deaf to Ctrl-C, and so would be the commands it starts.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

settings.register_profile("seeded", derandomize=True)
settings.load_profile("seeded")  # the same examples every run: a failure can be looked into


@dataclass(frozen=True)
class Ended:
    """How a command ended: its exit code and all that came out of it."""

    code: int
    out: str
    err: str


@pytest.fixture
def cli(capfd: pytest.CaptureFixture[str]) -> Callable[..., Ended]:
    """Call the command line in this process: ``cli("solve", path)``; what Open Cascade prints is caught too."""
    from cablecad.cli.group import cablecad
    from cablecad.cli.session import run_command

    def call(*arguments: object) -> Ended:
        capfd.readouterr()
        code = run_command(cablecad, [os.fspath(a) if isinstance(a, os.PathLike) else str(a) for a in arguments])
        return Ended(code, *capfd.readouterr())

    return call


@pytest.fixture
def process() -> Iterator[Callable[..., subprocess.Popen[str]]]:
    """Start the command line as a process of its own: ``process("build", path, cwd=...)``; none outlives the test."""
    started: list[subprocess.Popen[str]] = []

    def start(*arguments: object, **options: object) -> subprocess.Popen[str]:
        options = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True, **options}
        started.append(subprocess.Popen([*COMMAND_LINE, *map(str, arguments)], **options))
        return started[-1]

    yield start
    for one in started:
        one.kill()
        with one:  # closes its pipes and waits for it
            pass


@pytest.fixture(scope="session")
def draws() -> None:
    """VTK can draw here: it needs a library of the system, without which there is no picture to look at."""
    from cablecad.errors import MissingDependencyError
    from cablecad.picture.offscreen import offscreen_window

    try:
        offscreen_window(16, 16)
    except MissingDependencyError as error:
        missing = str(error).partition("\n")[0]
        pytest.skip(f"no picture can be drawn on this system: {missing}")
