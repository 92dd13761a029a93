"""From solved cables to their solids: shape, refusals, fit, tube, check.

What is done in numpy is done for many cables together, for theirs are small arrays. Open Cascade makes their faces one
by one, and checks some solids at once, on all processors.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from itertools import repeat
from typing import TYPE_CHECKING, NamedTuple, ParamSpec

from cablecad.errors import CablecadError, GeometryError, InvalidTubeError, Mistake, SceneError
from cablecad.model import Cable, Clamp, Pin, Toward, tolerance_floor
from cablecad.pipeline.cable import solve
from cablecad.pipeline.clock import timed
from cablecad.report import CableOutcome

if TYPE_CHECKING:
    from OCP.TopoDS import TopoDS_Solid

    from cablecad.brep.measure import Measured
    from cablecad.brep.spline import FittedCentreline
    from cablecad.brep.tube import Method
    from cablecad.rod.solution import RodSolution

P = ParamSpec("P")
Supports = tuple[Clamp | Pin, Clamp | Pin | Toward]
"""Of a cable's start and end."""

WORST_DEVIATION = 1.0 / 20.0
"""A shape tolerance above this share of the radius is lowered to it: beyond it the tube is no tube."""

_NEARLY_FOLDED = 0.9
"""From this kappa r on the side of the tube that is built is looked at itself for folds."""

_LEAST_RADIUS = 1e-6
"""Of a solid [mm]: Open Cascade takes points within 1e-7 mm for one, and loses much thinner ones when it reads STEP."""

_LEAST_STRAIGHT = 1e-6
"""Of a solid's piece [mm]: a shorter one may be valid here and not in what is read of the file."""

_ROOM = 4.0
"""Self-gaps of more deviations than this need not be measured again on the fit: its own is less by two at most."""

_TOGETHER = 128
"""Cables drawn and fitted at once; more are no faster."""

_CHECKED = 32
"""Solids checked at once; more are no faster, and who waits for them sees no progress."""


def make_solids(
    outcomes: Sequence[CableOutcome], tolerance: float, method: Method = "direct"
) -> Iterator[TopoDS_Solid | CablecadError]:
    """Make the solids of solved cables; fills in the outcomes as it goes.

    Args:
        outcomes: Of cables that have solutions.
        tolerance: Bound on the distance between the solids' sides and the exact tubes [mm].
        method: How to make the tubes.

    Yields:
        Of each cable, as it is done, its solid, or why there is none: an `InvalidTubeError` where the tube would cut
        into itself, a `GeometryError` where the solid failed its check, a `SceneError` for a tolerance below what
        numbers can keep.
    """
    for low in range(0, len(outcomes), _TOGETHER):
        some = outcomes[low : low + _TOGETHER]
        begun = time.perf_counter()
        prepared = _prepared(some, tolerance, method)
        share = (time.perf_counter() - begun) / len(some)
        for outcome in some:
            outcome.seconds["tube"] = outcome.seconds.get("tube", 0.0) + share
        for first in range(0, len(some), _CHECKED):
            own = slice(first, first + _CHECKED)
            yield from _finished(some[own], prepared[own], method)


class Prepared(NamedTuple):
    """A centreline fit for a tube, and what that tube measures; None where its solid is to be measured itself."""

    fit: FittedCentreline
    measured: Measured | None


def _solution(outcome: CableOutcome) -> RodSolution:
    assert outcome.solution is not None
    return outcome.solution


def _prepared(outcomes: Sequence[CableOutcome], tolerance: float, method: Method) -> list[Prepared | CablecadError]:
    """The fitted centrelines of cables, or why there is to be no tube around them."""
    from cablecad.brep.fit import fit_centrelines
    from cablecad.brep.measure import measure_tubes
    from cablecad.brep.spline import FittedPiece, find_tightest
    from cablecad.rod.draw import draw_together

    draw_together(_solution(outcome).equilibrium for outcome in outcomes)
    results: dict[int, Prepared | CablecadError] = {}
    usable: dict[int, float] = {}
    for i, outcome in enumerate(outcomes):
        supports = outcome.cable.start_support, outcome.cable.end_support
        try:
            _refuse_too_small(outcome.cable, supports)
            usable[i] = _usable_tolerance(outcome, supports, tolerance)
            _refuse_spoilt_tube(_solution(outcome))
        except CablecadError as error:
            results[i] = error
    good = [i for i in usable if i not in results]
    radii = [outcome.cable.section.radius for outcome in outcomes]
    fits = fit_centrelines(
        [_solution(outcomes[i]).centreline for i in good], [radii[i] for i in good], [usable[i] for i in good]
    )
    fitted: dict[int, FittedCentreline] = {}
    for i, fit in zip(good, fits, strict=True):
        if isinstance(fit, GeometryError):
            results[i] = fit
        else:
            fitted[i] = fit
    find_tightest([piece for fit in fitted.values() for piece in fit.pieces if isinstance(piece, FittedPiece)])
    measured = measure_tubes(list(fitted.values()), [radii[i] for i in fitted]) if method == "direct" else repeat(None)
    results |= {i: Prepared(fit, size) for (i, fit), size in zip(fitted.items(), measured, strict=False)}
    return [results[i] for i in range(len(outcomes))]


def _finished(
    outcomes: Sequence[CableOutcome], prepared: Sequence[Prepared | CablecadError], method: Method
) -> Iterator[TopoDS_Solid | CablecadError]:
    """The solids of some cables, or why there are none."""
    from cablecad.brep.check import all_valid

    made = [
        one if isinstance(one, CablecadError) else _or_error(make_solid, outcome, one, method)
        for outcome, one in zip(outcomes, prepared, strict=True)
    ]
    solids = [one for one in made if not isinstance(one, CablecadError)]
    begun = time.perf_counter()
    known_valid = len(solids) > 1 and all_valid(solids)
    share = (time.perf_counter() - begun) / max(len(solids), 1)
    for outcome, one, solid in zip(outcomes, prepared, made, strict=True):
        if isinstance(one, CablecadError) or isinstance(solid, CablecadError):
            yield solid
            continue
        outcome.seconds["check"] = outcome.seconds.get("check", 0.0) + share
        yield _or_error(_checked, outcome, one, solid, method, known_valid)


def _or_error(do: Callable[P, TopoDS_Solid], *arguments: P.args, **named: P.kwargs) -> TopoDS_Solid | CablecadError:
    """The solid something makes, or the error it raises."""
    try:
        return do(*arguments, **named)
    except CablecadError as error:
        return error


def make_solid(outcome: CableOutcome, prepared: Prepared, method: Method = "direct") -> TopoDS_Solid:
    """Make the solid around a fitted centreline.

    Raises:
        InvalidTubeError: The tube would cut into itself.
        GeometryError: Open Cascade failed.
    """
    fit, radius = prepared.fit, outcome.cable.section.radius
    with timed(outcome.seconds, "tube"):
        _refuse_spoilt_fit(_solution(outcome), fit)
        from cablecad.brep.tube import build_tube

        return build_tube(fit, radius, method=method)


def _checked(
    outcome: CableOutcome, prepared: Prepared, solid: TopoDS_Solid, method: Method, known_valid: bool
) -> TopoDS_Solid:
    """The solid, if it is what it should be.

    Raises:
        GeometryError: It failed its check, or Open Cascade at checking it.
    """
    from cablecad.brep.check import check_solid, check_tube

    fit, radius = prepared.fit, outcome.cable.section.radius
    with timed(outcome.seconds, "check"):
        if method == "direct":
            check = check_tube(solid, fit, radius, prepared.measured, known_valid=known_valid)
        else:
            check = check_solid(solid, radius=radius, length=fit.length, known_valid=known_valid)
    outcome.fit, outcome.check = fit, check
    # Pappus: the volume of a tube with a side off by e differs by 2 e / r at most, 4 e / r with room for its ends.
    allowed = 4.0 * max(fit.deviation, 0.0 if method == "direct" else 1e-7) / radius + 1e-6
    if not check.valid or abs(check.volume_error) > allowed:
        raise GeometryError(
            f"the solid failed its check (BRepCheck {'valid' if check.valid else 'not valid'}, "
            f"volume off by {check.volume_error:.3g} of pi r^2 L, {allowed:.3g} allowed); try another tolerance"
        )
    return solid


def _refuse_too_small(cable: Cable, supports: Supports) -> None:
    """Refuse what Open Cascade would lose, by name."""
    problem = "is too {} for a solid, for Open Cascade takes points within 1e-7 mm for one: {:g} mm is the least; {}"
    if cable.section.radius < _LEAST_RADIUS:
        said = problem.format("small", 2.0 * _LEAST_RADIUS, "give the scene in larger units")
        raise SceneError([Mistake(f"cables.{cable.name}.diameter", said, cable.diameter)])
    for key, support in zip(("start", "end"), supports, strict=True):
        if isinstance(support, Clamp) and 0.0 < support.straight < _LEAST_STRAIGHT:
            said = problem.format("short", _LEAST_STRAIGHT, "leave it out")
            raise SceneError([Mistake(f"cables.{cable.name}.{key}.straight", said, support.straight)])


def _usable_tolerance(outcome: CableOutcome, supports: Supports, tolerance: float) -> float:
    """The tolerance within what numbers can keep and what a tube can bear."""
    cable = outcome.cable
    radius, place = cable.section.radius, f"cables.{cable.name}.diameter"
    reach = max(abs(x) for support in supports if not isinstance(support, Toward) for x in support.position)
    floor = tolerance_floor(reach + _solution(outcome).length)
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
        if i == solution.index:
            continue
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
    if kappa * radius > _NEARLY_FOLDED:
        stretch, at = fit.least_stretch(radius)
        if stretch <= 0.0:
            raise InvalidTubeError(
                f"the tube's side would fold at s = {at:.6g} mm, where the cable bends to {1.0 / kappa:.6g} mm, hardly "
                f"more than its radius {radius:.6g} mm; ask for a smaller tolerance or take a thinner cable"
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
