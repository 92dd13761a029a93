"""One cable on one page: model choice, solve, centreline, tube, check, report."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

from cablecad.errors import CablecadError
from cablecad.model import SHAPE_TOLERANCE, Cable, checked_tolerance
from cablecad.pipeline.clock import timed
from cablecad.report import CableOutcome, cable_report

if TYPE_CHECKING:
    from OCP.TopoDS import TopoDS_Solid

    from cablecad.brep.tube import Method
    from cablecad.rod.solution import RodSolution

Search = Literal["answer", "wide"]
"""How far to look for equilibria: for the answer alone, or for more of them."""


@dataclass(frozen=True)
class Solid:
    """A solid of the kernel, `wrapped` as CadQuery and build123d wrap theirs."""

    wrapped: TopoDS_Solid

    def __reduce__(self) -> tuple[object, ...]:
        from cablecad.brep.binary import pack_shape

        return _unpacked_solid, (pack_shape(self.wrapped),)


def _unpacked_solid(data: bytes) -> Solid:
    from cablecad.brep.binary import unpack_shape
    from cablecad.brep.kernel import TopoDS

    return Solid(TopoDS.Solid(unpack_shape(data)))


@dataclass(frozen=True)
class Built:
    """A cable with its solid.

    Attributes:
        cable: What was asked.
        solution: The solved rod.
        solid: `solid.wrapped` is the `TopoDS_Solid`.
        outcome: What the report is made of.
    """

    cable: Cable
    solution: RodSolution
    solid: Solid
    outcome: CableOutcome

    @cached_property
    def report(self) -> dict[str, Any]:
        """As `cablecad build --report` writes it for a cable; made when asked for, as it measures every equilibrium."""
        return cable_report(self.outcome)

    @property
    def name(self) -> str:
        """The cable's name."""
        return self.cable.name


def solve(cable: Cable, *, search: Search = "answer") -> RodSolution:
    """Solve a cable as an elastic rod; see `cablecad.rod.solve.solve_rod`."""
    from cablecad.rod.solve import solve_rod

    return solve_rod(cable, search=search)


def solve_many(
    cables: Sequence[Cable], *, search: Search = "answer", measured: bool = True
) -> list[RodSolution | CablecadError]:
    """Solve cables together and measure what was found, never raising for one of them.

    Args:
        cables: Of any kinds.
        search: As for `solve`.
        measured: Whether to find self-gaps, stability, residuals and the like together, for a third of the time of
            solving. Without it each is found when asked for: for shapes alone, or a few of the answers.

    Returns:
        For each cable its solution, or the error that `solve` would raise.
    """
    from cablecad.rod.solve import solve_many as solve_rods

    solved = solve_rods(cables, search=search)
    if measured:
        from cablecad.rod.measure import measure_solutions

        measure_solutions(one for one in solved if not isinstance(one, CablecadError))
    return solved


def build(cable: Cable, *, tolerance: float = SHAPE_TOLERANCE, method: Method = "direct") -> Built:
    """Solve a cable and make its solid.

    Args:
        cable: What holds it and how long it is.
        tolerance: Bound on the distance between the solid's side and the exact tube [mm].
        method: "direct", or "pipe_shell" for Open Cascade's own sweep (slower, to 1e-6 mm).

    Raises:
        InfeasibleError: Physics forbids the shape.
        SolveError: No solution was found.
        InvalidTubeError: The tube would cut into itself.
        GeometryError: The solid failed its check.
        SceneError: Contradicting data, or a tolerance below what numbers can keep.
    """
    tolerance = checked_tolerance(tolerance)
    outcome = CableOutcome(cable)
    with timed(outcome.seconds, "solve"):
        solution = solve(cable)
    return build_outcome(outcome, solution, tolerance, method)


def build_solution(solution: RodSolution, *, tolerance: float = SHAPE_TOLERANCE) -> Built:
    """Make the solid of a cable that was solved before, as `build` does.

    Raises:
        InvalidTubeError: The tube would cut into itself.
        GeometryError: The solid failed its check.
        SceneError: A tolerance below what numbers can keep.
    """
    return build_outcome(CableOutcome(solution.cable), solution, checked_tolerance(tolerance))


def build_outcome(outcome: CableOutcome, solution: RodSolution, tolerance: float, method: Method = "direct") -> Built:
    """Make the solid of a solved cable; fills in the outcome as it goes, and raises as `build_solution`."""
    outcome.solution = solution
    from cablecad.pipeline.solid import make_solids

    (solid,) = make_solids([outcome], tolerance, method)
    if isinstance(solid, CablecadError):
        raise solid
    return Built(outcome.cable, solution, Solid(solid), outcome)
