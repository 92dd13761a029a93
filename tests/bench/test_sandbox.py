"""What may kill the process kills a copy of it."""

import os
import signal
import time
from pathlib import Path

import pytest

from cablecad.bench import sandbox
from cablecad.bench.sandbox import SandboxError, in_sandbox

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="there are no forks here")


def test_a_result_comes_back():
    assert in_sandbox(lambda: {"volume": 1.5, "valid": True}) == {"volume": 1.5, "valid": True}


def test_a_large_result_comes_back_whole():
    assert in_sandbox(lambda: "x" * 1_000_000) == "x" * 1_000_000


def test_the_parent_survives_a_crash_and_tells_of_it():
    with pytest.raises(SandboxError, match=r"killed the process \(SIGSEGV\)"):
        in_sandbox(lambda: os.kill(os.getpid(), signal.SIGSEGV))


def test_an_exception_is_told_by_its_message():
    def fail():
        raise ValueError("the pipe broke\nand more")

    with pytest.raises(SandboxError, match=r"^the pipe broke$"):
        in_sandbox(fail)


def test_work_that_does_not_end_is_ended(monkeypatch):
    monkeypatch.setattr(sandbox, "PATIENCE", 0.2)
    begun = time.monotonic()
    with pytest.raises(SandboxError, match=r"no result within 0\.2 s"):
        in_sandbox(lambda: time.sleep(60.0))
    assert time.monotonic() - begun < 30.0


def test_nothing_the_work_prints_is_seen(capfd):
    in_sandbox(lambda: os.write(1, b"noise"))
    assert capfd.readouterr().out == ""


def children() -> set[str]:
    """The processes of this one, by what Linux tells; other tests may have left some."""
    return {pid for task in Path("/proc/self/task").glob("*/children") for pid in task.read_text().split()}


def test_no_child_is_left_behind():
    before = children()
    in_sandbox(lambda: None)
    assert children() <= before
