"""What a batch costs beside the work it does, as ratios within one run.

    python -m pytest -m bench -s tests/bench/test_batch_speed.py

Results only are measured against `solve_many` on the same cables: of the batch as a user starts it, which takes worker
processes for so many rows, and of one process. One process is measured against cables that are solved together and
reported one after the other, too. Solids are measured against the same rows built, written
and reported one after the other in a warm process, divided by what as many processes without a batch gain.
"""

from __future__ import annotations

import gc
import math
import subprocess
import sys
import time
from pathlib import Path

import pytest

from cablecad.batch import grid_rows, run_batch
from cablecad.batch.schedule import processors
from cablecad.pipeline import run_build, solve_many, solve_scene
from cablecad.report import CableOutcome, cable_report

pytestmark = pytest.mark.bench

SCENE = Path(__file__).parents[2] / "samples" / "clamped.toml"
ROWS = 1000
BUILT = 100


def say(line):
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


def lengths(count):
    return grid_rows(SCENE, [f"cables.W1.length=300:400:{count}"])


@pytest.fixture(scope="module")
def solved(tmp_path_factory):
    """Seconds: solved together, solved together and reported, by a batch, and by one process; the least of three."""

    def batch(**chosen):
        begun = time.perf_counter()
        run_batch(lengths(ROWS), folder=tmp_path_factory.mktemp("out"), output="none", **chosen)
        return time.perf_counter() - begun

    cables = [cable for row in lengths(ROWS) for cable in row.resolve().cables]
    solve_many(cables[:10])
    gc.collect()
    gc.freeze()  # as the command line does: what pytest holds is not looked through again and again
    alone = started = inline = math.inf
    for _ in range(3):
        begun = time.perf_counter()
        solve_many(cables)
        alone = min(alone, time.perf_counter() - begun)
        started, inline = min(started, batch()), min(inline, batch(workers=0))
    begun = time.perf_counter()
    solutions = solve_many(cables, measured=False)
    bare = time.perf_counter() - begun
    for cable, solution in zip(cables, solutions, strict=True):
        cable_report(CableOutcome(cable, solution))
    reported = time.perf_counter() - begun
    say(
        f"\n{ROWS} rows, results only: solve_many {alone:.2f} s ({bare:.2f} s without measuring, then "
        f"reported one by one {reported:.2f} s); batch as it chooses on "
        f"{processors()} processors {started:.2f} s = {started / alone:.2f} of solve_many; in one process "
        f"{inline:.2f} s = {inline / alone:.2f} of solve_many (aim 1.5), "
        f"{inline / reported:.2f} of one by one (aim 1.1)"
    )
    return alone, reported, started, inline


def test_results_only_in_one_process_against_solve_many(solved):
    alone, _, _, inline = solved
    assert inline <= 1.5 * alone


def test_results_only_as_a_user_starts_it_against_solve_many(solved):
    alone, _, started, _ = solved
    assert started <= 1.5 * alone


def test_results_only_in_one_process_against_reports_one_by_one(solved):
    _, reported, _, inline = solved
    assert inline <= 1.1 * reported


_LOOP = f"""
import sys, time
from pathlib import Path
sys.path.insert(0, {str(Path(__file__).parent)!r})
from test_batch_speed import built
built(2, Path(sys.argv[1]))
print("ready", flush=True)
sys.stdin.readline()
begun = time.perf_counter()
built({BUILT // 2}, Path(sys.argv[1]))
print(time.perf_counter() - begun, flush=True)
"""


def built(count, folder):
    """Rows built, written and reported one after the other."""
    for row in lengths(count):
        run_build(row.resolve(), folder / "one.step").report()


def gain(tmp_path, count):
    """How many times as much is done in a time by as many processes that know nothing of each other."""

    def seconds(processes):
        running = []
        for i in range(processes):
            (tmp_path / str(i)).mkdir(exist_ok=True)
            command = [sys.executable, "-c", _LOOP, str(tmp_path / str(i))]
            running.append(subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True))
        for one in running:
            assert one.stdout.readline() == "ready\n"
        for one in running:
            one.stdin.write("\n")
            one.stdin.flush()
        times = [float(one.stdout.readline()) for one in running]
        for one in running:
            with one:
                one.stdin.close()
        return max(times)

    return count * seconds(1) / seconds(count)


def test_solids_against_the_same_rows_one_after_the_other(tmp_path):
    workers = processors()
    built(2, tmp_path)
    begun = time.perf_counter()
    built(BUILT, tmp_path)
    alone = (time.perf_counter() - begun) / BUILT
    gained = gain(tmp_path, workers)
    begun = time.perf_counter()
    summary = run_batch(lengths(BUILT), folder=tmp_path / "out", workers=workers)
    batch = (time.perf_counter() - begun) / BUILT
    assert summary.counts == {"done": BUILT}
    say(
        f"\n{BUILT} rows with solids, {workers} workers, their start included: a row {batch:.3f} s; in a warm process "
        f"{alone:.3f} s, and {workers} processes gain {gained:.2f}: {batch * gained / alone:.2f} of that (aim 1.5)"
    )
    assert batch <= 1.5 * alone / gained


def test_a_table_is_read_in_no_time_beside_its_work(tmp_path):
    """Looking up to a million rows over before anything runs is a small part of solving them."""
    table = tmp_path / "table.csv"
    table.write_text("cables.W1.length\n" + "".join(f"{300 + i / 100}\n" for i in range(2000)))
    from cablecad.batch import table_rows
    from cablecad.batch.rows import row_hash

    begun = time.perf_counter()
    count = sum(1 for row in table_rows(table, SCENE) if row_hash(row))
    reading = (time.perf_counter() - begun) / count
    scene = next(iter(lengths(2))).resolve()
    begun = time.perf_counter()
    for _ in range(10):
        solve_scene(scene).report()
    solving = (time.perf_counter() - begun) / 10
    say(f"\na row is read, checked and hashed in {1e6 * reading:.0f} us, solved and reported in {1e3 * solving:.1f} ms")
    assert reading < 0.1 * solving
