"""Scenes, tables and real processes for the tests of batches."""

from __future__ import annotations

import csv
import json
import os
import time
from pathlib import Path

SAMPLES = Path(__file__).parents[2] / "samples"
CONNECTOR = SAMPLES / "parts" / "connector.step"

CLAMPED = """\
format = 1
name = "clamped"
[materials.pvc]
youngs_modulus = 3890.0
poissons_ratio = 0.25
[[cables]]
name = "W1"
diameter = 4.0
length = 350.0
material = "pvc"
min_bend_radius = 20.0
start = { position = [0, 0, 0], outward = [0, 0, 1] }
end = { position = [0, 120, 0], outward = [0, 0, 1] }
"""

PART = """\
[[parts]]
name = "housing"
step = "connector.step"
"""

STRAIGHT = """\
format = 1
[[cables]]
name = "W1"
diameter = 4.0
length = 300.0
start = { position = [0, 0, 0] }
end = { position = [300, 0, 0] }
"""
"""A cable that takes no time to solve."""


def write(path: Path, text: str) -> Path:
    path.write_text(text, encoding="utf-8")
    return path


def lengths(path: Path, values, *, ids: bool = True) -> Path:
    """A table of lengths of W1, with the ids r0, r1, ..."""
    head = "id,cables.W1.length" if ids else "cables.W1.length"
    rows = [f"r{i},{value}" if ids else f"{value}" for i, value in enumerate(values)]
    return write(path, "\n".join([head, *rows]) + "\n")


def journal(folder: Path) -> dict[str, dict]:
    """The lines of a journal by id; fails where an id has two."""
    lines = [json.loads(line) for line in (folder / "reports.jsonl").read_text(encoding="utf-8").splitlines()]
    found = {line["id"]: line for line in lines}
    assert len(found) == len(lines)
    return found


def timeless(value):
    """A report without its seconds, and without the checksum of a line that has some."""
    if isinstance(value, dict):
        return {key: timeless(part) for key, part in value.items() if key not in ("seconds", "checksum")}
    return [timeless(part) for part in value] if isinstance(value, list) else value


def results(folder: Path) -> list[dict[str, str]]:
    """The lines of results.csv, seconds aside."""
    with (folder / "results.csv").open(encoding="utf-8", newline="") as file:
        return [{key: cell for key, cell in row.items() if key != "seconds"} for row in csv.DictReader(file)]


def assert_same(one: Path, other: Path) -> None:
    """Two batches came to the same: reports, results and STEP files to the byte, seconds aside."""
    assert timeless(journal(one)) == timeless(journal(other))
    assert results(one) == results(other)
    steps = {path.name: path.read_bytes() for path in one.glob("*.step")}
    assert steps == {path.name: path.read_bytes() for path in other.glob("*.step")}
    assert {path.name for path in one.iterdir()} == {path.name for path in other.iterdir()}


def children(pid: int) -> list[int]:
    """The processes a process has started, by what Linux tells."""
    found: list[int] = []
    for task in Path(f"/proc/{pid}/task").glob("*/children"):
        try:
            found += map(int, task.read_text().split())
        except OSError:  # the thread is gone
            continue
    return found


def wait_until(condition, seconds: float = 60.0):
    """The first true value of a condition; fails where it does not come."""
    end = time.monotonic() + seconds
    while not (value := condition()):
        assert time.monotonic() < end, "it never came to that"
        time.sleep(0.02)
    return value


def lines_in(folder: Path) -> int:
    path = folder / "reports.jsonl"
    return path.read_bytes().count(b"\n") if path.exists() else 0


def make_fifo(path: Path) -> Path:
    """A part's file that whoever reads it waits for without end."""
    os.mkfifo(path)
    return path
