"""From cables to their solutions, by the models that were selected; one cable or many at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import get_args

import numpy as np

from cablecad.errors import CablecadError, Mistake, SceneError, SolveError, UsageError
from cablecad.model import LARGEST, Cable, Toward
from cablecad.rod.select import select_model
from cablecad.rod.solution import RodSolution
from cablecad.rod.straight import solve_straight
from cablecad.rod.two_point import Search, solve_two_point


def solve_rod(cable: Cable, *, search: Search = "answer") -> RodSolution:
    """Solve a cable as an elastic rod: weightless, uniform, straight when free.

    Args:
        cable: What holds it and how long it is.
        search: "answer" covers every winding that can still win by the energy bound; "wide" looks for more
            equilibria, in windings -2..2 from more starts. Neither is proved complete.

    Returns:
        The equilibria found and the chosen one, with residual, stability and warnings.

    Raises:
        InfeasibleError: Physics forbids the shape.
        NotPlanarError: The ends do not lie in one plane.
        SolveError: No solution was found.
        SceneError: Data that contradict each other, a bulge along the chord, an equilibrium that was not found.
    """
    (result,) = solve_many([cable], search=search)
    if isinstance(result, CablecadError):
        raise result
    return result


def solve_many(cables: Sequence[Cable], *, search: Search = "answer") -> list[RodSolution | CablecadError]:
    """Solve cables together: the same answers as one by one, in a fraction of the time.

    Of the equilibria behind an answer a search may meet one more or less when it goes through with others.

    Args:
        cables: Of any kinds.
        search: As for `solve_rod`.

    Returns:
        For each cable its solution, or the error that `solve_rod` would raise; a bad cable costs no other.

    Raises:
        UsageError: There is no such search.
    """
    if search not in get_args(Search):
        raise UsageError(f"no search {search!r}; take one of {', '.join(get_args(Search))}")
    results: list[RodSolution | CablecadError] = [SolveError("not solved")] * len(cables)
    together: list[int] = []
    lengths: list[float] = []
    remarks: dict[int, str] = {}
    for i, cable in enumerate(cables):
        try:
            length, said = _length(cable)
            if said:
                remarks[i] = said
            sized = replace(cable, length=length) if cable.length == "shortest" else cable
            selection = select_model(sized)
            if selection.model == "straight":
                results[i] = _straight(sized, selection.reason)
            elif cable.is_pinned:
                from cablecad.rod.pinned import solve_pinned_cable  # a closed form of its own, not often asked for

                results[i] = solve_pinned_cable(sized, reason=selection.reason)
            else:
                assert length is not None  # two positions and a clamp: the length was asked for
                together.append(i)
                lengths.append(length)
        except CablecadError as error:
            results[i] = error
    for i, result in zip(together, solve_two_point([cables[i] for i in together], lengths, search=search), strict=True):
        results[i] = result
    for i, said in remarks.items():
        result = results[i]
        if isinstance(result, RodSolution):
            results[i] = replace(result, cable=cables[i], reason=f"{result.reason}; {said}")
    return results


def _length(cable: Cable) -> tuple[float | None, str]:
    """The length [mm], None where the data of a pinned cable leave it open; and what there is to say of it."""
    if cable.length == "shortest":
        from cablecad.rod.shortest import shortest_length

        return shortest_length(cable)
    if isinstance(cable.length, int | float):
        return float(cable.length), ""
    end = cable.end_support
    if cable.slack is None or isinstance(end, Toward):
        return None, ""
    chord = float(np.linalg.norm(np.subtract(end.position, cable.start_support.position)))
    if chord == 0.0:
        problem = "is a share of the distance of the ends, which coincide here; give the length"
        raise SceneError([Mistake("slack", problem, cable.slack)])
    if chord * (1.0 + cable.slack) >= LARGEST:
        problem = f"makes the cable longer than the {LARGEST:g} mm that can be computed with; give less"
        raise SceneError([Mistake("slack", problem, cable.slack)])
    if cable.is_pinned:
        return None, ""
    return chord * (1.0 + cable.slack), ""


def _straight(cable: Cable, reason: str) -> RodSolution:
    start, end = cable.start_support, cable.end_support
    assert not isinstance(end, Toward)  # a chord in space was measured
    assert isinstance(cable.length, int | float)
    return solve_straight(cable, np.array(start.position), np.array(end.position), length=cable.length, reason=reason)
