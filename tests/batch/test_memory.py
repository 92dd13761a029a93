"""The memory of the process that runs a batch does not grow with the number of its rows."""

from __future__ import annotations

import gc
from pathlib import Path

import pytest
from variants import STRAIGHT, lengths, write

from cablecad.batch import run, run_batch, table_rows

PAGE = 4096  # bytes, where /proc/self/statm is


def grown(tmp_path, rows: int, workers: int) -> float:
    """By how many MB this process has grown between the first tenth of a batch and its end."""
    scene = write(tmp_path / "scene.toml", STRAIGHT)
    table = table_rows(lengths(tmp_path / "table.csv", (300.0 for _ in range(rows))), scene)
    sizes: dict[int, int] = {}

    def weigh(done: int) -> None:
        gc.collect()
        sizes[done] = int(Path("/proc/self/statm").read_text().split()[1]) * PAGE

    summary = run_batch(
        table, folder=tmp_path / "out", output="none", workers=workers, progress=lambda now: weigh(now.done)
    )
    weigh(rows + 1)  # with results.csv written
    assert summary.counts == {"done": rows}
    return (sizes[rows + 1] - min(size for done, size in sizes.items() if done >= rows // 10)) / 1e6


def test_a_thousand_rows(tmp_path):
    """A report and its result take some 10 kB each in memory: kept, a thousand would be more than this."""
    assert grown(tmp_path, 1000, 0) < 5.0


@pytest.mark.slow
@pytest.mark.parametrize("workers", [0, 2])
def test_ten_thousand_rows(tmp_path, workers):
    assert run.BLOCK < 1000
    assert grown(tmp_path, 10_000, workers) < 50.0
