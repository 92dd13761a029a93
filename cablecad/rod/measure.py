"""All that a report tells of solutions, found of many together.

A solution finds its self-gap, its margins, its residual and the rest when it is asked for them. One after the other
that takes twenty times as long as solving many cables does; together it takes a third of it.
"""

from __future__ import annotations

from collections.abc import Iterable

from cablecad.rod.outline import measure_outlines
from cablecad.rod.room import judge_together, measure_gaps
from cablecad.rod.solution import RodSolution


def measure_solutions(solutions: Iterable[RodSolution], *, outlines: bool = True) -> None:
    """Find the self-gap and the stability of every equilibrium, and what there is to tell of the chosen ones' shapes.

    Args:
        solutions: They have it at hand afterwards.
        outlines: Whether to find residual, rise, angles, wrenches and the tightest bend, which a shape that is drawn
            tells as well, to other last digits.
    """
    solutions = list(solutions)
    found = [one for solution in solutions for one in solution.equilibria]
    measure_gaps(found)
    judge_together(found)
    if outlines:
        measure_outlines(solutions)
