"""The stages, one after the other."""

from __future__ import annotations

import gc
import time
from collections.abc import Callable, Sequence
from importlib.util import find_spec
from pathlib import Path

from cablecad.bench.report import BenchReport, StageResult
from cablecad.bench.stage import Effort, Stage, Tell
from cablecad.errors import MissingDependencyError


def run_bench(
    stages: Sequence[Stage],
    effort: Effort,
    *,
    folder: Path | None = None,
    tell: Tell | None = None,
    done: Callable[[StageResult], None] | None = None,
) -> BenchReport:
    """Run stages; after each its tables are handed on and all that is known is written.

    Args:
        stages: Of `STAGES`.
        effort: How much of each.
        folder: To write report.json, tables.md and the CSV files to; must exist. None: nothing is written.
        tell: Called with what is measured next.
        done: Called with each stage's result.

    Raises:
        MissingDependencyError: The only stage asked for needs Open Cascade, which is not there.
        ExchangeError: A file cannot be written.
    """
    report = BenchReport(effort.quick)
    for stage in stages:
        begun = time.perf_counter()
        result = StageResult(stage.name)
        if stage.needs_kernel and find_spec("OCP") is None:
            result.skipped = 'it needs Open Cascade: pip install "cablecad[ocp]"'
            if len(stages) == 1:
                raise MissingDependencyError(f"stage {stage.name}: {result.skipped}")
        else:
            gc.collect()
            gc.freeze()  # what the stages before have left is not looked through again and again by this one
            result.tables = stage.run(effort, tell or _be_silent)
        result.seconds = time.perf_counter() - begun
        report.stages.append(result)
        report.complete = len(report.stages) == len(stages)
        if done is not None:
            done(result)
        if folder is not None:
            report.write(folder)
    return report


def _be_silent(_step: str) -> None:
    """Tell nobody."""
