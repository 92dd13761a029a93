"""One cable on one page: model choice, solve, centreline, tube, check, report."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

from cablecad.errors import CablecadError, GeometryError, InvalidTubeError, Mistake, SceneError
from cablecad.model import SHAPE_TOLERANCE, Cable, Toward, tolerance_floor
from cablecad.report import CableOutcome, cable_report

if TYPE_CHECKING:
    from OCP.TopoDS import TopoDS_Solid

    from cablecad.brep.spline import FittedCentreline
    from cablecad.rod.solution import RodSolution

WORST_DEVIATION = 1.0 / 20.0
"""A shape tolerance above this share of the radius is lowered to it: beyond it the tube is no tube."""

_LEAST_RADIUS = 1e-6
"""Of a solid [mm]: Open Cascade takes points within 1e-7 mm for one, and loses much thinner ones when it reads STEP."""

_ROOM = 4.0
"""Self-gaps of more deviations than this need not be measured again on the fit: its own is less by two at most."""

Search = Literal["answer", "wide"]
"""How far to look for equilibria: for the answer alone, or for more of them."""


@dataclass(frozen=True)
class Solid:
    """A solid of the kernel, `wrapped` as CadQuery and build123d wrap theirs."""

    wrapped: TopoDS_Solid


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


def build(
    cable: Cable, *, tolerance: float = SHAPE_TOLERANCE, method: Literal["direct", "pipe_shell"] = "direct"
) -> Built:
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
    return build_outcome(CableOutcome(solution.cable), solution, tolerance)


def build_outcome(
    outcome: CableOutcome, solution: RodSolution, tolerance: float, method: Literal["direct", "pipe_shell"] = "direct"
) -> Built:
    """Make the solid of a solved cable; fills in the outcome as it goes, and raises as `make_solid`."""
    outcome.solution = solution
    solid = make_solid(outcome, solution, tolerance, method)
    return Built(outcome.cable, solution, Solid(solid), outcome)


def make_solid(
    outcome: CableOutcome, solution: RodSolution, tolerance: float, method: Literal["direct", "pipe_shell"] = "direct"
) -> TopoDS_Solid:
    """Make the solid of a solved cable: centreline, tube, check; fills in the outcome as it goes.

    Raises:
        InvalidTubeError: The tube would cut into itself.
        GeometryError: The solid failed its check.
        SceneError: A tolerance below what numbers can keep.
    """
    radius = outcome.cable.section.radius
    with timed(outcome.seconds, "tube"):
        tolerance = _usable_tolerance(outcome, solution, tolerance)
        _refuse_spoilt_tube(solution)
        from cablecad.brep.spline import fit_centreline

        fit = fit_centreline(solution.centreline, radius, tolerance=tolerance)
        _refuse_spoilt_fit(solution, fit)
        from cablecad.brep.tube import build_tube

        solid = build_tube(fit, radius, method=method)
    with timed(outcome.seconds, "check"):
        from cablecad.brep.check import check_solid, check_tube

        if method == "direct":
            check = check_tube(solid, fit, radius)
        else:
            check = check_solid(solid, radius=radius, length=fit.length)
    outcome.fit, outcome.check = fit, check
    # Pappus: the volume of a tube with a side off by e differs by 2 e / r at most, 4 e / r with room for its ends.
    allowed = 4.0 * max(fit.deviation, 0.0 if method == "direct" else 1e-7) / radius + 1e-6
    if not check.valid or abs(check.volume_error) > allowed:
        raise GeometryError(
            f"the solid failed its check (BRepCheck {'valid' if check.valid else 'not valid'}, "
            f"volume off by {check.volume_error:.3g} of pi r^2 L, {allowed:.3g} allowed); try another tolerance"
        )
    return solid


def _usable_tolerance(outcome: CableOutcome, solution: RodSolution, tolerance: float) -> float:
    """The tolerance within what numbers can keep and what a tube can bear."""
    cable = outcome.cable
    radius, place = cable.section.radius, f"cables.{cable.name}.diameter"
    if radius < _LEAST_RADIUS:
        problem = (
            "is too small for a solid, for Open Cascade takes points within 1e-7 mm for one: "
            f"{2.0 * _LEAST_RADIUS:g} mm is the least; give the scene in larger units"
        )
        raise SceneError([Mistake(place, problem, cable.diameter)])
    supports = (cable.start_support, cable.end_support)
    reach = max(abs(x) for support in supports if not isinstance(support, Toward) for x in support.position)
    floor = tolerance_floor(reach + solution.length)
    if tolerance < floor:
        problem = f"is below {floor:.3g} mm, the least that numbers can keep for cable {cable.name} at its place"
        raise SceneError([Mistake("tolerance.shape", problem, tolerance)])
    most = WORST_DEVIATION * radius
    if most < floor:
        problem = (
            f"is too small at its place: a solid may be off by {most:.3g} mm, a twentieth of the radius, and numbers "
            f"keep {floor:.3g} mm there; bring the scene nearer to the origin"
        )
        raise SceneError([Mistake(place, problem, cable.diameter)])
    if tolerance > most:
        outcome.notes.append(
            f"tolerance {tolerance:g} mm was lowered to {most:g} mm, a twentieth of the cable's radius"
        )
    return min(tolerance, most)


def _refuse_spoilt_tube(solution: RodSolution) -> None:
    """Refuse a tube that would cut into itself, naming the first equilibrium that would not."""
    spoilt = [violation.message for violation in solution.violations if violation.spoils_tube]
    if not spoilt:
        return
    radius = solution.cable.section.radius
    # An index counts in the wide list, which is what the cable gets when it asks for one.
    for i, other in enumerate(solve(solution.cable, search="wide").equilibria):
        gap, bend = other.self_gap, other.bend_radius_min
        if (gap is None or gap >= 0.0) and (bend is None or bend > radius):
            way_out = f"equilibrium = {i} does not touch itself"
            break
    else:
        way_out = "none of the equilibria found keeps clear of itself"
    raise InvalidTubeError(f"{'; '.join(spoilt)} ({way_out})")


def _refuse_spoilt_fit(solution: RodSolution, fit: FittedCentreline) -> None:
    """The same two conditions on the curve that is going to be built."""
    cable, radius = solution.cable, solution.cable.section.radius
    kappa, at = fit.greatest_curvature()
    if kappa * radius >= 1.0:
        raise InvalidTubeError(
            f"the fitted centreline bends to {1.0 / kappa:.6g} mm at s = {at:.6g} mm, not more than the cable's radius "
            f"{radius:.6g} mm; ask for a smaller tolerance or take a thinner cable"
        )
    exact = solution.self_gap
    if exact is None or exact > _ROOM * fit.deviation or cable.allow_contact:
        return  # both ends of a distance are off by the deviation at most
    from cablecad.self_gap import self_gap

    gap = self_gap(fit, radius)
    if gap is not None and gap < 0.0:
        raise InvalidTubeError(
            f"the fitted centreline overlaps itself by {-gap:.6g} mm; ask for a smaller tolerance, or set "
            "allow_contact = true"
        )


@contextmanager
def timed(seconds: dict[str, float], stage: str) -> Iterator[None]:
    """Add the time of what runs inside to a stage [s]."""
    begun = time.perf_counter()
    try:
        yield
    finally:
        seconds[stage] = seconds.get(stage, 0.0) + time.perf_counter() - begun
