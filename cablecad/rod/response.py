"""How a solved cable answers small changes of its length and of the poses of its ends: exact derivatives.

They come from the linear system that the solution satisfies, not from differences. A pose is a position in the plane of
the cable and an angle in it; a pin has no angle and its columns are zero. Moves out of the plane leave the planar model
and change wrenches and points to first order only by turning the plane.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from cablecad.centreline import Array
from cablecad.errors import UsageError
from cablecad.model import Pin
from cablecad.rod.equilibria import Equilibria
from cablecad.rod.planar import ONE_POINT, solve_planar
from cablecad.rod.sensitivity import sensitivity
from cablecad.rod.solution import RodSolution
from cablecad.rod.span import Span, span_of
from cablecad.rod.trace import Trace

INPUTS = ("length", "start_x", "start_y", "start_angle", "end_x", "end_y", "end_angle")
"""The last axis of every derivative: length and positions [mm], angles [rad]."""


@dataclass(frozen=True)
class Response:
    """Derivatives of a solved cable; the last axis runs over `inputs`.

    Attributes:
        e1: Direction of the inputs ``_x`` in space, shape (3,).
        e2: Direction of the inputs ``_y``, shape (3,); angles turn e1 towards e2.
        inputs: Their names, in order.
        start_force_per_EI: Of what the start's support applies, shape (3, 7) [1/mm^2 per input].
        end_force_per_EI: The same at the end.
        start_moment_per_EI: Of the moment about the start's own end point, shape (3, 7) [1/mm per input].
        end_moment_per_EI: The same at the end.
        bend_radius_min: Of the least bend radius, shape (7,) [mm per input]. Where two places are equally tight, as the
            ends between parallel clamps may be, it has a kink, and this is the derivative to one of its sides.
        points: Of the points at the arclengths asked for, kept at the same share of their piece, shape (k, 3, 7).
    """

    e1: Array
    e2: Array
    inputs: tuple[str, ...]
    start_force_per_EI: Array
    end_force_per_EI: Array
    start_moment_per_EI: Array
    end_moment_per_EI: Array
    bend_radius_min: Array
    points: Array


def respond_to_ends(solution: RodSolution, s: ArrayLike = ()) -> Response:
    """Differentiate a solution by its length and the poses of its ends.

    Args:
        solution: Of a bent cable with positions at both ends.
        s: Arclengths of points whose derivatives are wanted, shape (k,) [mm]. As the length changes, a point of the
            free part keeps its share of it, and a point of a lead-out its distance from the end.

    Raises:
        UsageError: A straight cable, whose answer to a change is not a derivative, or one given by `toward`.

    Accuracy: 1e-7 of the largest entry against fourth-order differences (tests/rod/test_sensitivity.py), which are no
        better. Nearly straight cables answer like 1/sqrt(slack); below a slack of 1e-14 the force's own answer to the
        distance of the ends is rounding.
    """
    trace = _trace(solution)
    span, length = trace.span, trace.span.length
    at = np.atleast_1d(np.asarray(s, dtype=np.float64)).ravel()
    free = (at >= span.lead_out) & (at <= span.lead_out + length)
    inner = sensitivity(trace.row, (at[free] - span.lead_out) / length)
    units = np.array([1.0, 1.0, 1.0, length, length])  # x, y, length are over the length; angles are not

    def scaled(value: Array, power: int) -> Array:
        """From a rod of length one to the span: the value in length^power, inputs in mm and rad."""
        return np.asarray(value * units * length ** (power - 1))

    force = scaled(inner.force, -2)
    kappa0 = scaled(inner.kappa0, -1) * span.start_clamped  # a pin holds no moment, whatever moves
    kappa1 = scaled(inner.kappa1, -1) * span.end_clamped
    radius, points = scaled(inner.bend_radius, 1), scaled(inner.points, 1)
    chain = _ends_of_span(span)
    plane = np.stack([span.e1, span.e2])  # rows: in-plane components to space
    start_tangent, end_tangent = _tangents(trace.row)
    pull = (trace.row.force[0] / length**2) @ plane
    d_pull = plane.T @ (force @ chain)
    # Moments about the cable's own end points, the lead-outs between: M = -+kappa e3 + (q - p) x F.
    d_out, d_in = _lever(span.lead_out, start_tangent, 3), -_lever(span.lead_in, end_tangent, 6)
    out = span.lead_out * (start_tangent @ plane)
    back = -span.lead_in * (end_tangent @ plane)
    start_moment = -np.outer(span.e3, kappa0 @ chain) - _cross(plane.T @ d_out, pull) - _cross(out, d_pull)
    end_moment = np.outer(span.e3, kappa1 @ chain) + _cross(plane.T @ d_in, pull) + _cross(back, d_pull)
    answer = np.zeros((len(at), 3, 7))
    # A point of the free part rides on the span's start, and answers the motion of its end.
    ride = np.zeros((2, 7))
    ride[:, 1:3] = np.eye(2)
    for axis, row in zip((0, 1), (points @ chain).transpose(1, 0, 2), strict=True):
        answer[free] += (row + ride[axis] + d_out[axis])[:, None, :] * plane[axis][None, :, None]
    for i in np.flatnonzero(~free):
        before = at[i] < span.lead_out
        rigid = np.zeros((2, 7))
        rigid[:, 1:3] = np.eye(2) if before else 0.0
        rigid[:, 4:6] = 0.0 if before else np.eye(2)
        along = at[i] if before else at[i] - span.lead_out - length - span.lead_in
        rigid += _lever(along, start_tangent if before else end_tangent, 3 if before else 6)
        answer[i] = plane.T @ rigid
    return Response(
        e1=span.e1,
        e2=span.e2,
        inputs=INPUTS,
        start_force_per_EI=-d_pull,
        end_force_per_EI=d_pull,
        start_moment_per_EI=start_moment,
        end_moment_per_EI=end_moment,
        bend_radius_min=radius @ chain,
        points=answer,
    )


def _ends_of_span(span: Span) -> Array:
    """How (x, y, length, start angle, end angle) of the free span follow from the inputs, shape (5, 7)."""
    start, end = (np.array([np.cos(angle), np.sin(angle)]) for angle in (span.start_angle, span.end_angle))
    chain = np.zeros((5, 7))
    chain[:2, 1:3], chain[:2, 4:6] = -np.eye(2), np.eye(2)
    chain[:2] -= _lever(span.lead_out, start, 3) + _lever(span.lead_in, end, 6)
    chain[2, 0] = 1.0
    chain[3, 3] = float(span.start_clamped)
    chain[4, 6] = float(span.end_clamped)
    return chain


def _lever(arm: float, tangent: Array, column: int) -> Array:
    """Motion of a point `arm` along a tangent (2,) as its angle, the input of `column`, turns; shape (2, 7)."""
    motion = np.zeros((2, 7))
    motion[:, column] = arm * np.array([-tangent[1], tangent[0]])
    return motion


def _tangents(row: Equilibria) -> tuple[Array, Array]:
    """Unit tangents at the ends of the free part, in the plane's axes, shape (2,) each."""
    first, last = (np.array([np.cos(angle[0]), np.sin(angle[0])]) for angle in (row.theta0, row.theta1))
    return first, last


def _cross(a: Array, b: Array) -> Array:
    """Cross products with derivatives in columns: a (3,) and b (3, 7), or a (3, 7) and b (3,); shape (3, 7)."""
    columns = np.cross(a.T if a.ndim == 2 else a[None, :], b.T if b.ndim == 2 else b[None, :])
    result: Array = columns.T
    return result


def _trace(solution: RodSolution) -> Trace:
    """The solver's own state of a solution; of a cable pinned at both ends, found anew."""
    kept = solution.equilibrium.trace
    if kept is not None:
        return kept
    if solution.model == "straight" or solution.chord <= ONE_POINT * solution.length:
        raise UsageError(
            f"cable {solution.cable.name} has no derivatives by its ends: "
            + (
                "it is straight, and a change bends it like a square root"
                if solution.model == "straight"
                else "its ends coincide or have crossed"
            )
        )
    start, end = (tuple(state.position.tolist()) for state in (solution.equilibrium.start, solution.equilibrium.end))
    cable = replace(
        solution.cable,
        start=Pin(start),
        end=Pin(end),
        length=solution.length,
        # The one datum has the digits of nearly straight cables, the other of those whose ends nearly meet.
        slack=solution.slack if solution.slack is not None and solution.slack < 1.0 else None,
        chord=None,
        force=None,
        angle_deg=None,
        rise=None,
        bend_radius=None,
    )
    span = span_of(cable, solution.length)
    rows = solve_planar(
        [0.0], [0.0], [span.end_point], excess=[span.excess], start_clamped=False, end_clamped=False, search="wide"
    ).equilibria
    wanted = solution.equilibrium
    for i in range(len(rows)):
        if rows.inflections[i] == wanted.inflections and rows.side[i] == wanted.side:
            return Trace(span, rows, i)
    raise UsageError(f"the equilibrium of cable {solution.cable.name} was not found again between pins")
