"""A solved cable whose end moves: the same equilibrium followed, not searched for again.

Dragging a connector goes through here. The branch is followed by Newton's method from the last shape; where it ends at
a fold the move is refused, where it loses its stability the solution says so.
"""

from __future__ import annotations

from dataclasses import replace

from cablecad.errors import SolveError, UsageError
from cablecad.model import Cable, Clamp, Pin, Port, Toward
from cablecad.rod.follow import follow_planar
from cablecad.rod.solution import RodSolution
from cablecad.rod.solve import solve_rod
from cablecad.rod.span import span_of
from cablecad.rod.two_point import equilibrium_of, solution_of, torsion_ratio


def move_solution(
    last: RodSolution,
    *,
    start: Clamp | Pin | Port | None = None,
    end: Clamp | Pin | Port | None = None,
    length: float | None = None,
) -> RodSolution:
    """Follow an equilibrium to moved ends or another length.

    Args:
        last: The solution before the move.
        start: The start's new place, of the same kind; None leaves it.
        end: The end's new place, of the same kind; None leaves it.
        length: The new length [mm]; None keeps it.

    Returns:
        The same equilibrium there, as the only one of its list. A cable pinned at both ends keeps its mode and side.

    Raises:
        InfeasibleError: The moved ends are out of reach.
        NotPlanarError: The moved ends do not lie in one plane.
        SolveError: The equilibrium ceased to exist on the way; solve anew for another.
        UsageError: A clamp became a pin or the reverse, or the distance of the ends was never given.
    """
    cable = _moved_cable(last, start, end, length)
    trace = last.equilibrium.trace
    if trace is None:  # a closed form of its own: nothing is cheaper than solving it again
        return replace(solve_rod(cable), reason=f"{last.reason}; followed")
    assert isinstance(cable.length, int | float)
    span = span_of(cable, float(cable.length), near=trace.span.e3)
    if (span.start_clamped, span.end_clamped) != (trace.span.start_clamped, trace.span.end_clamped):
        raise UsageError("a moved end must stay what it was, a clamp or a pin; solve the changed cable anew")
    ratio = torsion_ratio(cable, span)
    row = follow_planar(
        trace.row, span.start_angle, span.end_angle, span.end_point, excess=span.excess, torsion_ratio=ratio
    )
    if row is None:
        raise SolveError(
            f"the equilibrium of cable {cable.name} ceased to exist on the way to the moved ends, or the move was too "
            "large to follow; solve the moved cable anew, or move in smaller steps"
        )
    reached = equilibrium_of(cable, span, row, ratio)
    solution = solution_of(cable, float(cable.length), span, (reached,), 0, "followed from the last solution")
    lost = [
        f"the equilibrium lost its stability {place} on the way"
        for place, before, now in (
            ("in its plane", last.stability.stable_in_plane, reached.stability.stable_in_plane),
            ("out of its plane", last.stability.stable_out_of_plane, reached.stability.stable_out_of_plane),
        )
        if before and not now
    ]
    return replace(solution, notes=tuple(lost))


def _moved_cable(
    last: RodSolution, start: Clamp | Pin | Port | None, end: Clamp | Pin | Port | None, length: float | None
) -> Cable:
    if isinstance(last.cable.end, Toward) and end is None:
        raise UsageError("a cable given by `toward` has no end to move; give its end a position")
    # The length of the solution: a cable given by its slack, or as the shortest, does not change length by moving.
    return replace(
        last.cable,
        start=last.cable.start if start is None else start,
        end=last.cable.end if end is None else end,
        length=last.length if length is None else length,
        slack=None,
        chord=None,
        force=None,
        angle_deg=None,
        rise=None,
        bend_radius=None,
    )
