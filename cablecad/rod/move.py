"""A solved cable whose end moves: the same equilibrium followed, not searched for again.

Dragging a connector goes through here. The branch is followed by Newton's method from the last shape; where it ends at
a fold the move is refused, where it loses its stability the solution says so.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial

import numpy as np

from cablecad.centreline import Array
from cablecad.errors import InfeasibleError, SolveError, UsageError
from cablecad.model import Cable, Clamp, Pin, Port, Toward, Vector, as_moved_end, unit
from cablecad.rod.elastica import Inflexional
from cablecad.rod.equilibria import Equilibria
from cablecad.rod.follow import follow_planar
from cablecad.rod.pinned import first_arch
from cablecad.rod.plane import bulge_direction
from cablecad.rod.select import select_model
from cablecad.rod.solution import RodSolution
from cablecad.rod.solve import solve_rod
from cablecad.rod.span import Span, span_of
from cablecad.rod.trace import Trace
from cablecad.rod.two_point import equilibrium_of, solution_of, torsion_ratio
from cablecad.rod.vector import cross, dot, minus, plus, scaled

_JUMP = 0.25
"""A shape that turns this much further than its ends do may have jumped to another branch [rad]; neighbouring branches
at a fold are that far apart as soon as one step leaves it behind."""

_LEAST_ASKED, _TURNED, _SAME = 0.01, 0.35, 1e-6
"""Angles [rad]: of clamps, above which the other side of a plane is looked at; by which a plane turned about the chord;
and within which clamps stand as they stood."""

_HALF_TURN = math.pi - 1e-6
"""Clamps that turn this much against the chord [rad] may as well turn the other way: halves tell which is meant."""

_ALONG = math.cos(math.radians(5.0))
"""A bulge within five degrees of the chord does not say enough of a side."""

_OPPOSITE = 1e-12
"""One and the cosine between two directions that are opposite but for rounding."""

_OPPOSED = 0.99
"""Cosine from which directions are opposed, for a note."""

_HALVINGS = 6
"""A move is cut into 64 parts at most."""


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
        start: The start's new place, of the same kind; None leaves it. A frame of CadQuery or build123d, a `Location`
            or `Plane`, is a port with the straight part that was there.
        end: The end's new place, likewise.
        length: The new length [mm]; None keeps it.

    Returns:
        The same equilibrium there, as the only one of its list. A cable pinned at both ends keeps its mode and side.

    Raises:
        InfeasibleError: The moved ends are out of reach.
        NotPlanarError: The moved ends do not lie in one plane.
        SolveError: The equilibrium ceased to exist on the way; solve anew for another.
        UsageError: A clamp became a pin or the reverse, the distance of the ends was never given, or the ends of a
            pinned cable have crossed, which positions do not tell.
    """
    cable = _moved_cable(last, start, end, length)
    if _clamped(cable) != _clamped(last.cable):
        raise UsageError("a moved end must stay what it was, a clamp or a pin; solve the changed cable anew")
    trace = last.equilibrium.trace
    if trace is None:  # a closed form of its own: nothing is cheaper than solving it again
        bent = last.centreline.pieces[0]
        if not isinstance(bent, Inflexional):
            return solve_rod(cable)
        if last.chord < 0.0:
            raise UsageError(
                f"the ends of cable {cable.name} have crossed (chord {last.chord:.6g} mm): between two positions a "
                "cable has not, so it cannot be followed to them; solve the moved cable anew"
            )
        x, y, z = (-bent.placement.e2 * first_arch(last.equilibrium.inflections + 1)).tolist()
        bulge, way = _side(last, cable, (x, y, z))
        anew = solve_rod(replace(cable, bulge=bulge, equilibrium=last.index - last.index % 2 + way))
        return replace(anew, cable=cable, reason=f"{last.reason}; followed")
    assert isinstance(cable.length, int | float)
    try:
        span = _moved_span(last, cable, trace)
    except InfeasibleError:  # nothing is left to bend, which is a cable too where the ends look at each other
        if select_model(cable).model == "straight":
            return solve_rod(cable)
        raise
    ratio = torsion_ratio(cable, span)
    row = _follow(trace.row, span.start_angle, span.end_angle, span.excess, ratio, _HALVINGS)
    if row is None:
        raise SolveError(
            f"the equilibrium of cable {cable.name} ceased to exist on the way to the moved ends, or the move was too "
            "large to follow; solve the moved cable anew, or move in smaller steps"
        )
    reached = equilibrium_of(cable, Trace(span, row), row.numbers()[0], ratio)
    solution = solution_of(cable, float(cable.length), span, (reached,), 0, "followed from the last solution")
    # Without its own notes the last one does not keep all the ones before it.
    before = replace(last, find_notes=None)
    return replace(solution, find_notes=partial(_notes, before, solution, trace.span.e3, span.e3))


def _notes(last: RodSolution, moved: RodSolution, before: Array, after: Array) -> tuple[str, ...]:
    """What happened on the way: stability that was lost, a plane that turned; normals before and after, shape (3,)."""
    said = [
        f"the equilibrium lost its stability {place} on the way"
        for place, then, now in (
            ("in its plane", last.stability.stable_in_plane, moved.stability.stable_in_plane),
            ("out of its plane", last.stability.stable_out_of_plane, moved.stability.stable_out_of_plane),
        )
        if then and not now
    ]
    turned = math.acos(min(1.0, abs(float(after @ before))))
    if turned > _JUMP + _swing(last, moved):
        said.append(
            f"the plane of the cable turned by {math.degrees(turned):.3g} degrees, more than its ends did: they had "
            "left it open, and now fix it"
        )
    if float(after @ before) < -_OPPOSED and last.chord > 0.0 and moved.chord > 0.0:
        one, other = _chord(last) / last.chord, _chord(moved) / moved.chord
        if float(one @ other) < -_OPPOSED:
            said.append(
                "the ends passed each other, and the plane of the cable was turned half round with them, so that the "
                "shape is as it was; move past the other end at some distance for the shape that crosses itself"
            )
    return tuple(said)


def _swing(before: RodSolution, after: RodSolution) -> float:
    """By how much the ends turned, their axes and the line between them together [rad]."""
    swung = 0.0
    pairs = []
    if isinstance(after.cable.start_support, Clamp):
        pairs.append((before.equilibrium.start.direction, after.equilibrium.start.direction))
    if isinstance(after.cable.end_support, Clamp):
        pairs.append((before.equilibrium.end.direction, after.equilibrium.end.direction))
    if before.chord > 0.0 and after.chord > 0.0:
        pairs.append((_chord(before), _chord(after)))
    for one, other in pairs:
        swung += math.atan2(float(np.linalg.norm(np.cross(one, other))), float(one @ other))
    return swung


def _chord(solution: RodSolution) -> Array:
    chord: Array = solution.equilibrium.end.position - solution.equilibrium.start.position
    return chord


def _follow(
    last: Equilibria, start_angle: float, end_angle: float, excess: float, ratio: float | None, halvings: int
) -> Equilibria | None:
    """Follow an equilibrium in the frame of its chord; None where its branch ended.

    Newton's method that finds the branch gone settles on another one, in a shape that jumped. So a step whose shape
    turns much further than its ends do is taken again in halves: along a branch the turn shrinks with the step, at a
    jump it does not.
    """
    asked = [
        math.remainder(angle - float(here[0]), 2.0 * math.pi) if held else 0.0
        for angle, here, held in zip((start_angle, end_angle), (last.theta0, last.theta1), last.held[0], strict=True)
    ]
    found = None
    if max(map(abs, asked)) < _HALF_TURN:
        end = (1.0 - excess, 0.0)
        found = follow_planar(last, start_angle, end_angle, end, excess=excess, torsion_ratio=ratio)
    elif min(map(abs, asked)) >= _HALF_TURN:
        # The chord turned round, and with it both ends the same way; by which one is as good as the other.
        asked[1] = math.copysign(asked[1], asked[0])
    if found is not None and _turned(last, found) <= _JUMP + abs(asked[0]) + abs(asked[1]):
        return found
    if not halvings:
        return None
    middle = (start_angle - asked[0] / 2.0, end_angle - asked[1] / 2.0, (excess + float(last.excess[0])) / 2.0)
    first = _follow(last, *middle, ratio, halvings - 1)
    return None if first is None else _follow(first, start_angle, end_angle, excess, ratio, halvings - 1)


def _turned(before: Equilibria, after: Equilibria) -> float:
    """How far a shape went, by its state at mid-span in the frame of the chord: angle, and curvature as an angle [rad].

    The curvature there counts by the length it acts over, 1 / omega: an arch that snaps through keeps its angle.
    """
    angle = math.remainder(float(after.theta[0] - before.theta[0]), 2.0 * math.pi)
    omega = max(float(after.omega[0]), float(before.omega[0]))
    return max(abs(angle), abs(float(after.kappa[0] - before.kappa[0])) / (2.0 * (1.0 + omega)))


def _moved_span(last: RodSolution, cable: Cable, trace: Trace) -> Span:
    """The free part of a moved cable, on the side of its plane that follows from where it was.

    The plane's normal goes with the axis of the ends. A plane that turned about that axis too may have turned by more
    than a right angle, which the normal does not tell, but the clamps do that lean from the axis.
    """
    assert isinstance(cable.length, int | float)
    old = trace.span
    near = _carried(cross(old.e1.tolist(), old.e2.tolist()), *_axes(last, cable))
    span = span_of(cable, float(cable.length), near=near)
    asked = _asked(trace, span)
    if asked > _LEAST_ASKED:
        turned = math.acos(min(1.0, abs(float(span.e3 @ near))))
        other = replace(span, e2=-span.e2, start_angle=-span.start_angle, end_angle=-span.end_angle)
        less = _asked(trace, other)
        if less < asked and (turned > _TURNED or (asked > 1.0 and less < _SAME)):
            return other
    return span


def _asked(trace: Trace, span: Span) -> float:
    """By how much the clamps' angles from the chord change [rad]."""
    row, changed = trace.row, 0.0
    angles = zip((span.start_angle, span.end_angle), (row.theta0[0], row.theta1[0]), row.held[0], strict=True)
    for angle, before, held in angles:
        if held:
            changed += abs(math.remainder(angle - float(before), 2.0 * math.pi))
    return changed


def _side(last: RodSolution, cable: Cable, side: Vector) -> tuple[Vector, int]:
    """The bulge of a moved pinned cable that lay on `side`, and whether it lies towards it (0) or away from it (1).

    The bulge that was given, wherever it says enough; else the side itself, which turns with the chord, or its
    opposite, whichever is nearer to the cable's own bulge: the default one changes with the direction of the chord.
    """
    axes = _axes(last, cable)
    if cable.bulge is not None and any(axes[1]):
        bulge = unit(cable.bulge)
        if all(abs(dot(unit(axis), bulge)) < _ALONG for axis in axes if any(axis)):
            return cable.bulge, int(dot(side, bulge) < 0.0)
    there = _carried(side, *axes)
    if cable.bulge is None and any(axes[1]) and dot(there, bulge_direction(unit(axes[1]), None)) < 0.0:
        return scaled(there, -1.0), 1
    return there, 0


def _clamped(cable: Cable) -> tuple[bool, bool]:
    """Which ends are clamps."""
    return isinstance(cable.start_support, Clamp), isinstance(cable.end_support, Clamp)


def _axes(last: RodSolution, cable: Cable) -> tuple[Vector, Vector]:
    """What a plane turns with, before and after a move: the chord, or where the ends coincide the axis of a clamp."""
    old, new = ((one.start_support, one.end_support) for one in (last.cable, cable))
    if isinstance(old[1], Toward):
        x, y, z = _chord(last).tolist()
        before = (x, y, z)
    else:  # not of the last shape, which may not have been drawn
        before = minus(old[1].position, old[0].position)
    assert not isinstance(new[1], Toward)  # a moved end has a position
    after = minus(new[1].position, new[0].position)
    if not (any(before) and any(after)):
        for one, other in zip(old, new, strict=True):
            if isinstance(one, Clamp) and isinstance(other, Clamp):
                return one.direction, other.direction
    return before, after


def _carried(vector: Vector, before: Vector, after: Vector) -> Vector:
    """A vector turned as an axis turned, the short way; as it is where an axis vanishes or turns half round."""
    if not (any(before) and any(after)):
        return vector
    one, other = unit(before), unit(after)
    cosine, middle = dot(one, other), plus(one, other)
    if cosine <= _OPPOSITE - 1.0:
        return vector
    return plus(plus(vector, middle, -dot(vector, middle) / (1.0 + cosine)), other, 2.0 * dot(vector, one))


def _moved_cable(
    last: RodSolution, start: Clamp | Pin | Port | None, end: Clamp | Pin | Port | None, length: float | None
) -> Cable:
    start, end = as_moved_end(start, last.cable.start), as_moved_end(end, last.cable.end)
    for place, moved in (("start", start), ("end", end)):
        if moved is not None and not isinstance(moved, Clamp | Pin | Port):
            raise UsageError(f"the moved {place} must be a Clamp, a Pin, a Port or a frame; got {moved!r}")
    if length is not None and (isinstance(length, bool) or not isinstance(length, int | float)):
        raise UsageError(f"the new length must be a number of mm; got {length!r}")
    if isinstance(last.cable.end, Toward) and end is None:
        raise UsageError("a cable given by `toward` has no end to move; give its end a position")
    # The length of the solution: a cable given by its slack, or as the shortest, does not change length by moving.
    return last.cable.between(
        last.cable.start if start is None else start,
        last.cable.end if end is None else end,  # type: ignore[arg-type]  # a `toward` without an end was refused
        last.length if length is None else length,
    )
