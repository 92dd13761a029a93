"""From a cable to its solution, by the model that was selected."""

from __future__ import annotations

import numpy as np

from cablecad.model import Cable, Toward
from cablecad.rod.pinned import solve_pinned_cable
from cablecad.rod.select import select_model
from cablecad.rod.solution import RodSolution
from cablecad.rod.straight import solve_straight


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
    return solve_pinned_cable(cable, reason=selection.reason)
