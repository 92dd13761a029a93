"""A scene on its way through the pipeline: what became of each cable and part, and all that went wrong."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from cablecad.errors import CablecadError, Mistake, RuleError, SceneError
from cablecad.model import Scene
from cablecad.report import CableOutcome, scene_report

if TYPE_CHECKING:
    from cablecad.brep.document import Document
    from cablecad.pipeline.documents import Documents

EXIT_ORDER = (1, 2, 5, 3, 4)
"""Which exit code speaks for several failures at once."""

Progress = Callable[[str], None]
"""Called with the name of each cable or part as its turn comes."""


@dataclass
class SceneRun:
    """A scene on its way: what became of each cable and part, and all that went wrong.

    Attributes:
        scene: What was asked; once solved, with numbers in place of the ends on parts.
        outcomes: One a cable.
        remarks: What the user should know that is no warning: which features of parts were taken for ends.
        documents: The parts that were read, by name.
        solids: Number of solids of each part by name, None where it was not read.
        errors: Everything that keeps the scene from being written.
        seconds: Time by stage.
        looked_at: Names of the parts whose files were read, or could not be.
        kept: What was read for other scenes; None where every file is read anew.
        measured: Whether `measure_scenes` was here.
    """

    scene: Scene
    outcomes: list[CableOutcome] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)
    documents: dict[str, Document] = field(default_factory=dict)
    solids: dict[str, int | None] = field(default_factory=dict)
    errors: list[CablecadError] = field(default_factory=list)
    seconds: dict[str, float] = field(default_factory=dict)
    looked_at: set[str] = field(default_factory=set)
    kept: Documents | None = None
    measured: bool = False

    def report(self, *, points: int | None = None) -> dict[str, Any]:
        """Report format 1."""
        if not self.measured:
            measure_scenes([self])
        return scene_report(self.scene, self.outcomes, solids=self.solids, seconds=self.seconds, points=points)

    @property
    def exit_code(self) -> int:
        """0, or the code that speaks for all errors."""
        codes = {error.exit_code for error in self.errors}
        return next((code for code in EXIT_ORDER if code in codes), 0)

    def broken_rules(self) -> list[CablecadError]:
        """The user's rules that solved cables break, an error each; `errors` has them only where they were strict."""
        return [
            RuleError(f"cable {outcome.cable.name}: {message}")
            for outcome in self.outcomes
            for message in outcome.broken_rules
        ]

    def fail(self, outcome: CableOutcome, error: CablecadError) -> None:
        """Keep what went wrong with a cable: as it is for the cable's report, with its name for the scene's errors."""
        outcome.error = error
        named = type(error)(f"cable {outcome.cable.name}: {error}")
        named.__cause__ = error
        self.errors.append(named)

    def scene_error(self, mistakes: list[Mistake]) -> SceneError:
        """The error for mistakes in the scene's data, what went wrong besides as notes on it."""
        error = SceneError(mistakes, source=str(self.scene.source or ""))
        for other in self.errors:
            error.add_note(str(other))
        return error

    def raise_first(self) -> None:
        """Raise the error with the first claim, the others as notes on it."""
        if self.errors:
            first, *others = sorted(self.errors, key=lambda error: EXIT_ORDER.index(error.exit_code))
            for other in others:
                first.add_note(str(other))
            raise first


def measure_scenes(runs: Iterable[SceneRun]) -> None:
    """Find all that reports tell of the equilibria of many scenes, together."""
    from cablecad.rod.measure import measure_solutions

    runs = list(runs)
    solutions = [outcome.solution for run in runs for outcome in run.outcomes if outcome.solution is not None]
    alone = len(runs) == 1
    for solution in solutions if alone else ():
        _ = solution.self_gap  # as a build does, which asks for the answers' first: the last digits are the same then
    # A build draws every shape: of one scene the last digits are to be the same.
    measure_solutions(solutions, outlines=not alone)
    for run in runs:
        run.measured = True


def tell(progress: Progress | None, name: str) -> None:
    """Say whose turn it is, where someone listens."""
    if progress is not None:
        progress(name)
