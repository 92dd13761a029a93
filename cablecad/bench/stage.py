"""The stages of the benchmark, and how much of each is run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module

from cablecad.bench.table import Table

Tell = Callable[[str], None]
"""Called with what is measured next."""


@dataclass(frozen=True)
class Effort:
    """How much is run: the targets stay, the counts shrink.

    Attributes:
        quick: Less than a minute for everything, instead of some minutes.
    """

    quick: bool = False

    def count(self, full: int, quick: int) -> int:
        """Of scenes, or of repeats."""
        return quick if self.quick else full


@dataclass(frozen=True)
class Stage:
    """One stage.

    Attributes:
        name: On the command line.
        title: What is measured.
        module: With the function `run(effort, tell) -> list[Table]`.
        steps_quick: How often a quick run tells what is measured next.
        steps_full: How often a full run does.
        needs_kernel: Whether it makes solids.
    """

    name: str
    title: str
    module: str
    steps_quick: int
    steps_full: int
    needs_kernel: bool = False

    def steps(self, *, quick: bool) -> int:
        """How often it tells what it measures next, for a progress bar."""
        return self.steps_quick if quick else self.steps_full

    def run(self, effort: Effort, tell: Tell) -> list[Table]:
        """Measure; the module is loaded only now."""
        tables: list[Table] = import_module(f"cablecad.bench.{self.module}").run(effort, tell)
        return tables


STAGES = (
    Stage("points", "points of a centreline", "points", 5, 12),
    Stage("solve", "two-point problems", "solving", 5, 5),
    Stage("tube", "spline and tube", "tubes", 12, 36, needs_kernel=True),
    Stage("cable", "whole cables, and starting up", "whole", 3, 3, needs_kernel=True),
    Stage("hard-cases", "the cases that break solvers and sweeps", "hard", 12, 12),
    Stage("growth", "cost against size", "growth", 8, 14, needs_kernel=True),
)
"""In the order they run; each is of use without the others."""
