"""From a cable to its solution, by the model that was selected."""

from __future__ import annotations

import numpy as np

from cablecad.errors import CablecadError
from cablecad.model import Cable, Toward
from cablecad.rod.pinned import solve_pinned_cable
from cablecad.rod.select import select_model
from cablecad.rod.solution import RodSolution
from cablecad.rod.straight import solve_straight
from cablecad.rod.two_point import solve_two_point


def solve_rod(cable: Cable) -> RodSolution:
    """Solve a cable as an elastic rod: weightless, uniform, straight when free.

    Args:
        cable: What holds it and how long it is.

    Returns:
        The equilibria found and the chosen one, with residual, stability and warnings.

    Raises:
        InfeasibleError: Physics forbids the shape.
        SolveError: No solution was found, or no model covers the ends.
        SceneError: Data that contradict each other.
    """
    selection = select_model(cable)
    if selection.model == "straight":
        start, end = cable.start_support, cable.end_support
        assert not isinstance(end, Toward)  # a chord in space was measured
        assert isinstance(cable.length, int | float)
        return solve_straight(
            cable, np.array(start.position), np.array(end.position), length=cable.length, reason=selection.reason
        )
    if cable.is_pinned:
        return solve_pinned_cable(cable, reason=selection.reason)
    (result,) = solve_two_point([cable], [_length(cable)])
    if isinstance(result, CablecadError):
        raise result
    return result


def _length(cable: Cable) -> float:
    """The length of a cable between two positions [mm]."""
    if isinstance(cable.length, int | float):
        return cable.length
    assert cable.slack is not None
    ends = (cable.start_support, cable.end_support)
    chord = float(np.linalg.norm(np.subtract(ends[1].position, ends[0].position)))
    return chord * (1.0 + cable.slack)
