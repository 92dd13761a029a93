"""Worker processes: what they return and raise, how they die, hang and end; real processes throughout."""

from __future__ import annotations

import math
import os
import signal
import subprocess
import sys
import time
from concurrent.futures import CancelledError
from pathlib import Path

import pytest
from variants import children, wait_until

from cablecad.batch import WorkerPool
from cablecad.errors import OvertimeError, UsageError, WorkerDiedError, WorkerStartError


def workers() -> list[int]:
    """The worker processes of this one; others, such as multiprocessing's resource tracker, stay for good."""
    return [
        pid for pid in children(os.getpid()) if b"cablecad.batch.child" in Path(f"/proc/{pid}/cmdline").read_bytes()
    ]


@pytest.fixture
def pool():
    made = WorkerPool(1)
    yield made
    made.kill()


def test_calls_return_and_raise_as_here(pool):
    assert pool.submit(math.hypot, 3.0, 4.0).result() == 5.0
    with pytest.raises(ZeroDivisionError):
        pool.submit(divmod, 1, 0).result()
    with pytest.raises(RuntimeError, match="cannot be sent"):
        pool.submit(eval, "lambda: 0").result()
    assert pool.submit(sum, range(10)).result() == 45


def test_a_worker_takes_one_thread(pool):
    from cablecad.brep.check import ONE_THREAD

    for name in (ONE_THREAD, "OPENBLAS_NUM_THREADS"):
        assert pool.submit(os.getenv, name).result() == "1"


def test_what_is_printed_is_no_answer(pool):
    assert pool.submit(print, "hello").result() is None
    assert pool.submit(os.system, "echo hello").result() == 0


def test_calls_are_made_in_another_process_which_is_kept(pool):
    first, second = pool.submit(os.getpid).result(), pool.submit(os.getpid).result()
    assert first == second != os.getpid()


@pytest.mark.parametrize(
    ("function", "argument", "how"),
    [(os._exit, 7, "exit code 7"), (os.abort, None, "signal SIGABRT"), (signal.raise_signal, 9, "signal SIGKILL")],
)
def test_a_death_costs_its_call_only(pool, function, argument, how):
    dying = pool.submit(function, *(() if argument is None else (argument,)))
    next_one = pool.submit(os.getpid)
    with pytest.raises(WorkerDiedError, match=how):
        dying.result()
    assert next_one.result() > 0


def test_last_words_of_a_process_are_told(pool):
    with pytest.raises(WorkerDiedError, match="saying 'terminate called after throwing'"):
        pool.submit(os.system, "echo terminate called after throwing >&2; kill -9 $PPID").result()


def test_a_process_killed_while_it_waits_costs_nothing(pool):
    pid = pool.submit(os.getpid).result()
    os.kill(pid, signal.SIGKILL)
    wait_until(lambda: _is_gone(pid))
    assert pool.submit(os.getpid).result() != pid


def test_a_call_that_takes_too_long_is_ended():
    pool = WorkerPool(1, timeout=0.5)
    try:
        pool.submit(os.getpid).result()  # its start does not count
        hanging, next_one = pool.submit(time.sleep, 600), pool.submit(os.getpid)
        with pytest.raises(OvertimeError, match=r"took longer than 0\.5 s"):
            hanging.result()
        assert next_one.result() > 0
    finally:
        pool.kill()


@pytest.mark.parametrize("timeout", [math.inf, math.nan, 0.0, -1.0])
def test_a_timeout_that_is_none(timeout):
    with pytest.raises(UsageError, match="must be more than 0 and finite"):
        WorkerPool(1, timeout=timeout)


def test_a_timeout_longer_than_a_thread_can_wait():
    with WorkerPool(1, timeout=1e300) as pool:
        assert pool.submit(math.sqrt, 4.0).result() == 2.0


def test_shutdown_waits_for_what_was_submitted():
    with WorkerPool(2) as pool:
        futures = [pool.submit(math.sqrt, i) for i in range(20)]
    assert [future.result() for future in futures] == [math.sqrt(i) for i in range(20)]
    with pytest.raises(RuntimeError, match="after shutdown"):
        pool.submit(os.getpid)
    assert workers() == []


def test_kill_ends_everything_now():
    pool = WorkerPool(1)
    hanging, waiting = pool.submit(time.sleep, 600), pool.submit(os.getpid)
    wait_until(hanging.running)
    pool.kill()
    with pytest.raises((WorkerDiedError, WorkerStartError)):
        hanging.result(timeout=60)
    with pytest.raises(CancelledError):
        waiting.result(timeout=60)
    assert workers() == []


def test_a_process_that_cannot_start_is_told_once(pool, monkeypatch):
    monkeypatch.setattr("cablecad.batch.pool._CODE", "import sys; sys.exit('no such luck')")
    with pytest.raises(WorkerStartError, match="ended before it was ready, saying 'no such luck'"):
        pool.submit(os.getpid).result()


def test_a_script_needs_no_guard(tmp_path):
    """Nothing of the script is run again in the processes."""
    script = tmp_path / "script.py"
    script.write_text(
        "print('once')\nfrom cablecad.batch import WorkerPool\n"
        "import os\nwith WorkerPool(1) as pool:\n    print(pool.submit(os.getpid).result() != os.getpid())\n"
    )
    ended = subprocess.run([sys.executable, script], capture_output=True, text=True, check=False)
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, "once\nTrue\n", "")


def test_processes_are_deaf_to_ctrl_c(pool):
    pid = pool.submit(os.getpid).result()
    sleeping = pool.submit(time.sleep, 0.5)
    wait_until(sleeping.running)
    os.kill(pid, signal.SIGINT)
    assert sleeping.result() is None
    assert pool.submit(os.getpid).result() == pid


def test_processes_end_with_the_one_that_started_them():
    code = (
        "import os, time\nfrom cablecad.batch import WorkerPool\npool = WorkerPool(1)\n"
        "print(pool.submit(os.getpid).result(), flush=True)\ntime.sleep(600)\n"
    )
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as parent:
        pid = int(parent.stdout.readline())
        parent.kill()
    wait_until(lambda: "\nState:\tZ" in _status(pid))


def _status(pid):
    try:
        return Path(f"/proc/{pid}/status").read_text()
    except OSError:  # gone altogether
        return "\nState:\tZ"


def _is_gone(pid: int) -> bool:
    """Whether all threads of a process have ended, so that nothing but its exit status is left."""
    return "\nState:\tZ" in _status(pid) and len(list(Path(f"/proc/{pid}/task").iterdir())) == 1
