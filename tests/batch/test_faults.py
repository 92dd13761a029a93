"""What can happen to a night of variants, with real processes: nothing is lost and nothing is written twice.

A row that hangs is one whose part is a pipe nobody writes to; a row that kills its process is the same, and the process
is killed by us.
"""

from __future__ import annotations

import contextlib
import os
import resource
import shutil
import signal
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from threading import Thread

import pytest
from variants import (
    CONNECTOR,
    PART,
    SAMPLES,
    STRAIGHT,
    assert_same,
    children,
    journal,
    lines_in,
    make_fifo,
    wait_until,
    write,
)

pytest.importorskip("OCP", reason="solids need the kernel")

from cablecad.batch import grid_rows, run_batch, table_rows
from cablecad.batch.run import BLOCK
from cablecad.batch.schedule import InlineExecutor
from cablecad.errors import ExchangeError

GOOD = "connector.step"
CLAMPED = SAMPLES / "clamped.toml"


@pytest.fixture
def scene(tmp_path):
    shutil.copy(CONNECTOR, tmp_path / GOOD)
    return write(tmp_path / "scene.toml", STRAIGHT + PART)


def parts(scene, *names):
    """A table of part files of a straight cable, with the ids r0, r1, ..."""
    rows = "".join(f"r{i},{name},{3 + i / 10}\n" for i, name in enumerate(names))
    return write(scene.with_name("table.csv"), f"id,parts.housing.step,cables.W1.diameter\n{rows}")


@pytest.fixture
def undisturbed(scene, tmp_path):
    """Six good rows, and what comes of them when nothing happens."""
    table = parts(scene, *[GOOD] * 6)
    run_batch(table_rows(table, scene), folder=tmp_path / "whole", workers=0)
    return table


def opened(fifo) -> bool:
    """Whether somebody waits for a pipe to be written to."""
    try:
        os.close(os.open(fifo, os.O_WRONLY | os.O_NONBLOCK))
    except OSError:
        return False
    return True


# --- processes that die or hang ---------------------------------------------------------------------------------------


def test_killed_workers_cost_nothing(scene, undisturbed, tmp_path, process):
    """Whatever row a worker is at when it is killed, that row is tried again."""
    batch = process("batch", undisturbed, "--scene", scene, "-o", tmp_path / "out", "-j", 2)
    for done in (1, 3):
        wait_until(lambda done=done: lines_in(tmp_path / "out") >= done or batch.poll() is not None)
        for pid in children(batch.pid)[:1]:
            os.kill(pid, signal.SIGKILL)
    assert batch.wait() == 0
    assert_same(tmp_path / "whole", tmp_path / "out")


def test_a_row_that_kills_its_process_twice_has_crashed_and_the_others_are_done(scene, tmp_path, process):
    fifo = make_fifo(tmp_path / "deadly.step")
    batch = process("batch", parts(scene, GOOD, fifo.name, GOOD), "--scene", scene, "-o", tmp_path / "out", "-j", 1)
    killed = []
    for _ in range(2):
        # The pipe has a reader while a worker waits at the row; a writer that opens and closes lets it go on, so kill.
        (pid,) = wait_until(lambda: [pid for pid in children(batch.pid) if pid not in killed and waits(pid, fifo)])
        os.kill(pid, signal.SIGKILL)
        killed.append(pid)
    assert batch.wait() == 6
    lines = journal(tmp_path / "out")
    assert {key: line["status"] for key, line in lines.items()} == {"r0": "done", "r1": "crashed", "r2": "done"}
    assert lines["r1"]["error"] == "its process died (signal SIGKILL) (twice)"
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == [
        "r0.step",
        "r2.step",
        "reports.jsonl",
        "results.csv",
    ]
    # A row that crashed is tried again.
    fifo.unlink()
    shutil.copy(CONNECTOR, fifo)
    summary = run_batch(table_rows(scene.with_name("table.csv"), scene), folder=tmp_path / "out", resume=True)
    assert (summary.counts, summary.kept) == ({"done": 3}, 2)


def waits(pid, fifo) -> bool:
    """Whether a process sleeps in opening a pipe: its system call is open or openat, which of a file takes no time."""
    seen = set()
    for _ in range(5):
        try:
            seen.add(Path(f"/proc/{pid}/syscall").read_text().split()[0])
        except (OSError, IndexError):
            return False
        time.sleep(0.02)
    return seen <= {"2", "257", "56"} and fifo.exists()


def test_a_row_that_hangs_has_timed_out_and_the_others_are_done(scene, tmp_path):
    make_fifo(tmp_path / "pipe.step")
    table = table_rows(parts(scene, GOOD, "pipe.step", GOOD), scene)
    summary = run_batch(table, folder=tmp_path / "out", timeout=5.0)
    assert summary.counts == {"done": 2, "timed_out": 1}
    line = journal(tmp_path / "out")["r1"]
    assert (line["status"], line["error"]) == ("timed_out", "took longer than the 5 s of --timeout")


def test_rows_solved_together_are_parted_from_the_one_that_hangs(tmp_path):
    """Scene files are read where they are worked on: one that is a pipe hangs."""
    from cablecad.batch import Row

    good = [write(tmp_path / f"r{i}.toml", STRAIGHT) for i in range(5)]
    pipe = make_fifo(tmp_path / "r9.toml")
    rows = [Row(path.stem, path) for path in [*good[:2], pipe, *good[2:]]]
    summary = run_batch(rows, folder=tmp_path / "out", output="none", timeout=3.0)
    assert summary.counts == {"done": 5, "timed_out": 1}
    assert journal(tmp_path / "out")["r9"]["status"] == "timed_out"


def test_a_broken_executor_is_left_for_processes_of_our_own(scene, undisturbed, tmp_path, caplog):
    caplog.set_level("WARNING", logger="cablecad")
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as executor:
        pid = executor.submit(os.getpid).result()
        killer = Thread(
            target=lambda: (wait_until(lambda: lines_in(tmp_path / "out") >= 1), os.kill(pid, signal.SIGKILL))
        )
        killer.start()
        summary = run_batch(table_rows(undisturbed, scene), folder=tmp_path / "out", executor=executor)
        killer.join()
    assert summary.counts == {"done": 6}
    assert_same(tmp_path / "whole", tmp_path / "out")
    assert any("the executor broke" in message for message in caplog.messages)


def test_the_start_of_an_executor_is_in_no_rows_time(scene, undisturbed, tmp_path):
    """Nor are the imports of its processes."""
    context = get_context("spawn")
    with ProcessPoolExecutor(2, mp_context=context, initializer=time.sleep, initargs=(4.0,)) as executor:
        table = table_rows(undisturbed, scene)
        summary = run_batch(table, folder=tmp_path / "out", executor=executor, timeout=3.0)
    assert summary.counts == {"done": 6}
    assert_same(tmp_path / "whole", tmp_path / "out")


def test_an_executor_that_breaks_before_it_is_ready(scene, undisturbed, tmp_path):
    with ProcessPoolExecutor(1, mp_context=get_context("spawn"), initializer=os._exit, initargs=(3,)) as executor:
        summary = run_batch(table_rows(undisturbed, scene), folder=tmp_path / "out", executor=executor, timeout=60.0)
    assert summary.counts == {"done": 6}


def test_an_executor_whose_workers_all_hang_ends_the_batch(scene, tmp_path):
    fifo = make_fifo(tmp_path / "pipe.step")
    table = table_rows(parts(scene, "pipe.step", GOOD), scene)
    with ThreadPoolExecutor(1) as executor:
        with pytest.raises(ExchangeError, match="all 1 workers of the executor hang"):
            run_batch(table, folder=tmp_path / "out", executor=executor, timeout=3.0)
        wait_until(lambda: opened(fifo))  # lets the thread go on: its part is empty


# --- the user and the machine -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("workers", [pytest.param(0, marks=pytest.mark.slow), 2])
def test_ctrl_c_and_resume(scene, undisturbed, tmp_path, process, workers):
    arguments = ("batch", undisturbed, "--scene", scene, "-o", tmp_path / "out")
    batch = process(*arguments, "-j", workers, start_new_session=True)
    wait_until(lambda: lines_in(tmp_path / "out") >= 2)
    os.killpg(batch.pid, signal.SIGINT)  # as a terminal does: to the workers too
    _, err = batch.communicate()
    assert batch.returncode == 130
    told = [line for line in err.splitlines() if line]
    assert told == [
        f"the rows finished so far are kept in {tmp_path / 'out'}: --resume goes on with the others",
        "interrupted",
    ]
    assert not list((tmp_path / "out").glob(".*"))
    kept = journal(tmp_path / "out")
    assert 2 <= len(kept) < 6
    resumed = process(*arguments, "--resume", "-j", workers)
    _, err = resumed.communicate()
    assert resumed.returncode == 0
    assert f"6 rows: 6 done, {len(kept)} of them by an earlier run" in err
    assert journal(tmp_path / "out").items() >= kept.items()
    assert_same(tmp_path / "whole", tmp_path / "out")


@pytest.mark.parametrize("workers", [0, 2])
@pytest.mark.parametrize("lines", [0, BLOCK])
def test_ctrl_c_and_resume_of_results_only(scene, tmp_path, process, workers, lines):
    """In the middle of a block, of which nothing is kept, and between imports and the first of them."""
    arguments = ("batch", "--scene", CLAMPED, "--grid", f"cables.W1.length=300:400:{3 * BLOCK}", "--output", "none")
    rows = grid_rows(CLAMPED, [f"cables.W1.length=300:400:{3 * BLOCK}"])
    run_batch(rows, folder=tmp_path / "whole", output="none", workers=0)
    out = tmp_path / "out"
    batch = process(*arguments, "-o", out, "-j", workers, start_new_session=True)
    wait_until(lambda: (out / "reports.jsonl").exists() and lines_in(out) >= lines)
    time.sleep(0.1)
    begun = time.monotonic()
    os.killpg(batch.pid, signal.SIGINT)
    batch.communicate()
    assert time.monotonic() - begun < 2.0
    assert batch.returncode == 130
    assert lines_in(out) < 3 * BLOCK
    assert not (out / "results.csv").exists()
    assert process(*arguments, "-o", out, "-j", workers, "--resume").wait() == 0
    assert_same(tmp_path / "whole", out)


def test_a_ctrl_c_that_is_swallowed_ends_the_batch_all_the_same():
    """While Open Cascade loads it comes out as an ImportError, which must not become the bug of a row."""

    def loads(*, collect):
        try:
            os.kill(os.getpid(), signal.SIGINT)
            time.sleep(5.0)
        except KeyboardInterrupt:
            raise ImportError("initialization failed") from None

    def forgets(*, collect):
        with contextlib.suppress(KeyboardInterrupt):
            os.kill(os.getpid(), signal.SIGINT)
            time.sleep(5.0)

    before = signal.getsignal(signal.SIGINT)
    for function in (loads, forgets):
        with pytest.raises(KeyboardInterrupt):
            InlineExecutor().submit(function)
        assert signal.getsignal(signal.SIGINT) is before
    with ThreadPoolExecutor(1) as elsewhere:  # signals are the main thread's
        assert elsewhere.submit(lambda: InlineExecutor().submit(dict).result()).result() == {"collect": False}


def test_ctrl_c_ends_a_worker_that_hangs(scene, tmp_path, process):
    fifo = make_fifo(tmp_path / "pipe.step")
    batch = process("batch", parts(scene, fifo.name), "--scene", scene, "-o", tmp_path / "out", "-j", 1)
    (pid,) = wait_until(lambda: [pid for pid in children(batch.pid) if waits(pid, fifo)])
    batch.send_signal(signal.SIGINT)
    assert batch.wait(timeout=60) == 130
    assert not Path(f"/proc/{pid}").exists()


def killed(process, table, scene, folder):
    """The journal of a batch that was killed when two rows were done, and what is in it."""
    batch = process("batch", table, "--scene", scene, "-o", folder, "-j", 1)
    wait_until(lambda: lines_in(folder) >= 2)
    batch.kill()
    batch.wait()
    return folder / "reports.jsonl", (folder / "reports.jsonl").read_bytes()


def test_a_file_without_its_line_is_not_left_to_a_row_that_fails(scene, undisturbed, tmp_path, process):
    """A kill may come between the two, and the row may be another when the batch is resumed."""
    path, content = killed(process, undisturbed, scene, tmp_path / "out")
    path.write_bytes(content[: content.index(b"\n") + 1])
    assert (tmp_path / "out" / "r1.step").exists()
    table = table_rows(parts(scene, GOOD, "none.step"), scene)
    summary = run_batch(table, folder=tmp_path / "out", workers=0, resume=True)
    assert summary.counts == {"done": 1, "failed": 1}
    assert not (tmp_path / "out" / "r1.step").exists()


def test_a_line_torn_by_a_kill_is_done_anew(scene, undisturbed, tmp_path, process):
    path, content = killed(process, undisturbed, scene, tmp_path / "out")
    path.write_bytes(content[: content.index(b"\n") + 100])  # all of the first line, some of the second
    summary = run_batch(table_rows(undisturbed, scene), folder=tmp_path / "out", workers=0, resume=True)
    assert (summary.kept, summary.counts) == (1, {"done": 6})
    assert_same(tmp_path / "whole", tmp_path / "out")


@pytest.mark.parametrize("workers", [pytest.param(0, marks=pytest.mark.slow), 1])
def test_a_full_disk_is_one_error_and_nothing_is_lost(scene, undisturbed, tmp_path, process, workers):
    """The limit of a file's size stands for the disk: six lines of the journal are more than it allows."""
    whole = (tmp_path / "whole" / "reports.jsonl").stat().st_size
    largest = max(path.stat().st_size for path in (tmp_path / "whole").glob("*.step"))
    arguments = ("batch", undisturbed, "--scene", scene, "-o", tmp_path / "out", "-j", workers)
    for limit in (whole * 2 // 3, largest - 1):
        batch = process(*arguments, "--resume", preexec_fn=lambda limit=limit: _limit(limit))
        _, err = batch.communicate()
        assert batch.returncode == 5
        errors = [line for line in err.splitlines() if line.startswith("error: ")]
        assert len(errors) == 1
        assert "cannot be written: it would be larger than the file system or a limit allows" in errors[0]
        assert not list((tmp_path / "out").glob(".*"))
    resumed = process(*arguments, "--resume")
    assert resumed.wait() == 0
    assert_same(tmp_path / "whole", tmp_path / "out")


def _limit(size: int) -> None:
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))


def test_a_folder_that_cannot_be_made_is_one_error(scene, undisturbed, tmp_path, cli):
    write(tmp_path / "file", "")
    for folder in (tmp_path / "file", tmp_path / "file" / "out"):
        ended = cli("batch", undisturbed, "--scene", scene, "-o", folder)
        assert (ended.code, ended.out, ended.err.count("error: ")) == (5, "", 1)
        assert "cannot be written" in ended.err


def test_two_batches_do_not_write_to_one_folder_and_a_hanging_worker_ends_with_its_batch(scene, tmp_path, process):
    fifo = make_fifo(tmp_path / "pipe.step")
    arguments = ("batch", parts(scene, fifo.name), "--scene", scene, "-o", tmp_path / "out", "-j", 1)
    first = process(*arguments)
    wait_until((tmp_path / "out" / "reports.jsonl").exists)
    second = process(*arguments)
    _, err = second.communicate()
    assert second.returncode == 2
    assert "another batch is writing to" in err
    (pid,) = wait_until(lambda: [pid for pid in children(first.pid) if waits(pid, fifo)])
    first.kill()
    first.wait()
    wait_until(lambda: not Path(f"/proc/{pid}").exists() or "\nState:\tZ" in Path(f"/proc/{pid}/status").read_text())
