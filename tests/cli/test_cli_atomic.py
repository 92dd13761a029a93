"""Builds that are killed or interrupted at any moment leave the old file or the whole new one, nothing beside it."""

from __future__ import annotations

import random
import resource
import signal
import subprocess
import sys
import time

import pytest
from command_line import COMMAND_LINE
from loom import PVC, cable, names, scene, write

BUILD = ("build", "scene.toml", "-o", "out.step", "--report", "out.json")
FILES = ["out.json", "out.step", "scene.toml"]

ANNOUNCED = "import cablecad.cli; print('up', flush=True); cablecad.cli.main()"
"""The command line, saying when the interpreter has started: before that an interrupt is Python's own affair."""


SCENE = scene(cable(material='"pvc"'), head=PVC)


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write(tmp_path / "scene.toml", SCENE)
    return tmp_path


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The STEP file as an undisturbed build writes it."""
    folder = tmp_path_factory.mktemp("whole")
    write(folder / "scene.toml", SCENE)
    subprocess.run([*COMMAND_LINE, *BUILD], cwd=folder, check=True)
    return (folder / "out.step").read_bytes()


def put_old(here):
    write(here / "out.step", b"old")
    write(here / "out.json", b"old")


def assert_old_or_whole(here, whole):
    assert (here / "out.step").read_bytes() in (b"old", whole)
    report = (here / "out.json").read_bytes()
    assert report == b"old" or report.endswith(b"}\n")


def test_kill_at_any_moment(process, here, whole):
    begun = time.perf_counter()
    assert process(*BUILD).wait() == 0
    lasts = time.perf_counter() - begun
    moment = random.Random(20240229)
    left = 0
    for i in range(12):
        put_old(here)
        one = process(*BUILD)
        time.sleep(lasts * (i + moment.random()) / 12.0)  # one in every twelfth of the run
        one.kill()
        one.wait()
        assert_old_or_whole(here, whole)
        left += any(name.endswith(".tmp") for name in names(here))
    assert left > 0  # some were killed while they wrote
    assert process(*BUILD).wait() == 0
    assert names(here) == FILES
    assert (here / "out.step").read_bytes() == whole


def test_kill_in_the_middle_of_writing(process, here, whole):
    """As soon as the file aside is there: without a report it is there only while it is written."""
    killed = 0
    for _ in range(2):
        put_old(here)
        one = process(*BUILD[:4])
        while one.poll() is None:
            if any(name.startswith(".out.step.") for name in names(here)):
                one.kill()
                killed += 1
                break
        one.wait()
        assert_old_or_whole(here, whole)
    assert killed > 0
    assert process(*BUILD[:4]).wait() == 0
    assert names(here) == FILES
    assert (here / "out.step").read_bytes() == whole


def interrupted(here, whole, after, *, begun):
    """Interrupt a build `after` seconds, of its start or of the moment its report was begun; its exit code."""
    put_old(here)
    command = [sys.executable, "-c", ANNOUNCED, *BUILD]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as one:
        assert one.stdout.readline() == "up\n"
        while begun and one.poll() is None and not any(name.endswith(".tmp") for name in names(here)):
            time.sleep(0.001)
        time.sleep(after)
        one.send_signal(signal.SIGINT)
        out, err = one.communicate()
    assert_old_or_whole(here, whole)
    assert names(here) == FILES
    if one.returncode == 0:  # it was done before
        assert (out, err) == ("out.step\nout.json\n", "")
        assert (here / "out.step").read_bytes() == whole
    else:
        assert err.strip() == "interrupted"
    return one.returncode


@pytest.mark.parametrize(("after", "begun"), [(0.03, False), (0.0, True), (0.1, True), (0.2, True)])
def test_interrupt(here, whole, after, begun):
    """While its modules load, and while Open Cascade does, which begins with the report and takes a second."""
    assert interrupted(here, whole, after, begun=begun) == 130


@pytest.mark.parametrize("after", [0.4, 0.7, 1.0])
def test_interrupt_late(here, whole, after):
    """While it solves, writes or ends, on a machine that is neither fast nor slow."""
    assert interrupted(here, whole, after, begun=True) in (0, 130)


@pytest.mark.slow
def test_interrupt_at_any_moment(here, whole):
    codes = [interrupted(here, whole, 0.01 + 0.02 * i, begun=False) for i in range(100)]
    assert set(codes) <= {0, 130}
    assert codes[0] == 130


def test_interrupt_that_a_library_turns_into_another_error(cli, here, monkeypatch):
    """As loading Open Cascade does: an ImportError, which would read as a kernel that is not installed."""
    from cablecad.cli.interrupt import interrupt
    from cablecad.errors import MissingDependencyError

    def solve(*_arguments, **_options):
        with pytest.raises(KeyboardInterrupt):
            interrupt(signal.SIGINT, None)
        raise MissingDependencyError("no kernel")

    monkeypatch.setattr(interrupt, "came", False)
    monkeypatch.setattr("cablecad.pipeline.scene.solve_many", solve)
    ended = cli("solve", "scene.toml")
    assert (ended.code, ended.out, ended.err) == (130, "", "interrupted\n")


def test_interrupt_is_ignored_where_the_caller_ignores_it(here):
    """A job that a shell put in the background, or that runs under nohup."""
    command = [sys.executable, "-c", ANNOUNCED, *BUILD[:4]]
    code = f"import os, signal; signal.signal(signal.SIGINT, signal.SIG_IGN); os.execv({command[0]!r}, {command!r})"
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as one:
        assert one.stdout.readline() == "up\n"
        one.send_signal(signal.SIGINT)
        assert one.communicate()[0] == "out.step\n"
    assert one.returncode == 0


@pytest.mark.parametrize("limit", [100, 15_000])
def test_no_room(process, here, whole, limit):
    """15 kB is room for the report of a cable, not for its STEP file of 26."""
    put_old(here)
    one = process(*BUILD, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit)))
    out, err = one.communicate()
    assert (one.returncode, out) == (5, "")
    assert "out.step cannot be written: it would be larger than the file system or a limit allows" in err
    assert names(here) == FILES
    assert [(here / name).read_bytes() for name in FILES[:2]] == [b"old", b"old"]


def test_two_builds_of_one_file_at_once(process, here, whole):
    ones = [process(*BUILD) for _ in range(2)]
    assert [one.wait() for one in ones] == [0, 0]
    assert names(here) == FILES
    assert (here / "out.step").read_bytes() == whole
