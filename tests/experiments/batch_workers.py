"""From how many rows on do worker processes pay: the experiment behind `LEAST_BUILT` and `LEAST_SOLVED` of
`cablecad.batch.run`.

    python tests/experiments/batch_workers.py

Each count of rows of the clamped sample is done in a fresh process, in that process alone and by as many workers as
there are processors, by turns; the least of three times is printed.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from pathlib import Path

SCENE = Path(__file__).parents[2] / "samples" / "clamped.toml"
COUNTS = {"step": (6, 12, 24, 48), "none": (150, 300, 600, 1000, 1500)}


def seconds(count: int, output: str, workers: int) -> float:
    """The time of a batch from the start of its process to its end [s]."""
    from cablecad.batch.schedule import processors

    with tempfile.TemporaryDirectory() as folder:
        axis = f"cables.W1.length=300:400:{count}"
        code = (
            "import os; os.environ['OPENBLAS_NUM_THREADS'] = '1'\n"
            "from cablecad.batch import grid_rows, run_batch\n"
            f"run_batch(grid_rows({str(SCENE)!r}, [{axis!r}]), folder={folder!r}, output={output!r}, "
            f"workers={workers and processors()})"
        )
        begun = time.perf_counter()
        subprocess.run([sys.executable, "-c", code], check=True)
        return time.perf_counter() - begun


def main() -> None:
    for output, counts in COUNTS.items():
        for count in counts:
            times = [[seconds(count, output, workers) for workers in (0, 1)] for _ in range(3)]
            here, there = (min(column) for column in zip(*times, strict=True))
            sys.stdout.write(
                f"--output {output}, {count} rows: {here:.2f} s in this process, {there:.2f} s by workers\n"
            )
            sys.stdout.flush()


if __name__ == "__main__":
    main()
