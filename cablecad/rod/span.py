"""The free part of a cable between its connectors, in its plane and scaled to length one.

The straight lead-outs are taken off, the plane is found from the ends, and what is left is a two-point problem: where
the end is, seen from the start, and the angles of the clamps. The plane holds the chord exactly; clamps within 1e-6 rad
of it are turned into it, and by how much is reported.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cablecad.centreline import Array
from cablecad.errors import InfeasibleError, NotPlanarError
from cablecad.model import Cable, Clamp, Pin, Vector, unit
from cablecad.rod.plane import bulge_direction
from cablecad.rod.vector import across, cross, dot, minus, norm, plus, scaled

IN_PLANE = 1e-6
"""Clamps within this angle of the plane [rad] are turned into it: the accuracy of a modelled connector. Where chord and
clamps are within it of one line, that line leaves the plane open and the bulge decides."""

_SMALL_TILT, _NO_TILT = 1e-3, 1e-12
"""The same for a hair of excess: in units of the root of excess over length, and what is rounding at any [rad]."""

_TANGENT = "tangent of the ends, which coincide,"

EPS = float(np.finfo(float).eps)

COINCIDENT = 1e-12
"""Ends nearer than this over the length have no chord: a difference of positions that is all rounding."""


@dataclass(frozen=True)
class Span:
    """The free part of a cable.

    Attributes:
        start: Where the free part begins [mm], shape (3,).
        end: Where it ends [mm], shape (3,).
        e1: Unit chord, or the start's tangent where the ends coincide, shape (3,).
        e2: Unit vector across it in the plane, towards the bulge, shape (3,).
        length: Of the free part [mm].
        excess: (length - chord) / length, to its own precision.
        start_angle: Of the tangent from e1 towards e2 [rad]; 0 at a pin, where it is not known.
        end_angle: Likewise.
        start_clamped: Whether the start's direction is held.
        end_clamped: Whether the end's direction is held.
        lead_out: Straight length held at the start [mm].
        lead_in: Straight length held at the end [mm].
        out_of_plane: Greatest angle by which a clamp was turned into the plane [rad].
    """

    start: Array
    end: Array
    e1: Array
    e2: Array
    length: float
    excess: float
    start_angle: float
    end_angle: float
    start_clamped: bool
    end_clamped: bool
    lead_out: float
    lead_in: float
    out_of_plane: float

    @property
    def e3(self) -> Array:
        """The plane's normal."""
        return np.array(cross(self.e1.tolist(), self.e2.tolist()))

    @property
    def end_point(self) -> tuple[float, float]:
        """The end seen from the start in (e1, e2), over the length."""
        chord = self.end - self.start
        return float(chord @ self.e1) / self.length, float(chord @ self.e2) / self.length


def span_of(cable: Cable, length: float, *, near: Vector | None = None) -> Span:
    """Reduce a cable with positions at both ends to its free part.

    Args:
        cable: With two positions.
        length: Of the whole cable [mm]; `cable.slack`, where given, is the primary datum of the excess.
        near: Unit normal of the plane it was in before it moved: it decides the side, and the plane where the
            ends leave it open, in place of the bulge.

    Raises:
        InfeasibleError: The free part is shorter than the distance it has to span.
        NotPlanarError: The clamps do not lie in one plane with the chord.
        SceneError: The bulge is along the chord.
    """
    supports = (cable.start_support, cable.end_support)
    places: list[Vector] = []
    given: list[Vector | None] = []
    straights: list[float] = []
    for support in supports:
        assert isinstance(support, Clamp | Pin)  # a cable with `toward` is the pinned model's
        places.append(support.position)
        given.append(unit(support.direction) if isinstance(support, Clamp) else None)
        straights.append(support.straight if isinstance(support, Clamp) else 0.0)
    free = length - straights[0] - straights[1]
    if free <= 0.0:
        raise InfeasibleError(
            f"the straight lengths {straights[0]:g} mm and {straights[1]:g} mm held by the connectors leave nothing "
            f"of the cable's {length:.12g} mm to bend; make the cable longer or the straights shorter"
        )
    apart = minus(places[1], places[0])
    distance = norm(apart)
    # Nearer than this the direction of the chord is rounding, and must not decide the plane.
    nowhere = COINCIDENT * length + 8.0 * EPS * max(abs(x) for place in places for x in place)
    normal, off = _plane_normal(
        cable, apart if distance > nowhere else None, given, near, _open_below(cable, free, apart, given, straights)
    )
    directions = [None if d is None else unit(across(d, normal)) for d in given]
    start, end = (
        place if direction is None else plus(place, direction, way * straight)
        for place, direction, straight, way in zip(places, directions, straights, (1.0, -1.0), strict=True)
    )
    chord = minus(end, start)
    gap = norm(chord)
    excess = free - gap if cable.slack is None else cable.slack * distance + (distance - sum(straights) - gap)
    if excess <= 0.0:
        held = "" if free == length else f" (of it {free:.12g} mm free)"
        short = "no more than" if excess == 0.0 else f"{-excess:.6g} mm less than"
        raise InfeasibleError(
            f"length {length:.12g} mm{held} is {short} the distance it has to span, {gap:.12g} mm; make the cable "
            "longer or bring the ends together"
        )
    e1 = unit(chord) if gap > nowhere else next(d for d in directions if d is not None)
    e2 = unit(cross(normal, e1))
    line = "chord" if gap > nowhere else _TANGENT
    lean = dot(normal, near) if near is not None else dot(e2, bulge_direction(e1, cable.bulge, line))
    # Across the bulge neither side is towards it; the largest coordinate decides, so that the choice is stable.
    if (lean if abs(lean) > IN_PLANE else max(e2, key=abs)) <= 0.0:
        e2 = scaled(e2, -1.0)
    angles = [0.0 if d is None else math.atan2(dot(d, e2), dot(d, e1)) for d in directions]
    return Span(
        start=np.array(start),
        end=np.array(end),
        e1=np.array(e1),
        e2=np.array(e2),
        length=free,
        excess=excess / free,
        start_angle=angles[0],
        end_angle=angles[1],
        start_clamped=directions[0] is not None,
        end_clamped=directions[1] is not None,
        lead_out=straights[0],
        lead_in=straights[1],
        out_of_plane=off,
    )


def _open_below(cable: Cable, free: float, apart: Vector, given: list[Vector | None], straights: list[float]) -> float:
    """The angle of clamps from the chord [rad] below which they leave the plane open.

    A cable with a hair of excess is nearly straight itself, at angles that go with the root of the excess: what is
    far below these decides nothing, and what is not decides the shape.
    """
    for direction, straight in zip(given, straights, strict=True):
        if direction is not None:
            apart = plus(apart, direction, -straight)
    excess = max(0.0, free - norm(apart)) if cable.slack is None else cable.slack * free
    return min(IN_PLANE, max(_NO_TILT, _SMALL_TILT * math.sqrt(excess / free)))


def _plane_normal(
    cable: Cable, chord: Vector | None, given: list[Vector | None], near: Vector | None, open_below: float
) -> tuple[Vector, float]:
    """Normal of the plane through the ends' chord (None where they coincide) and the clamp that leans from it most.

    Returns:
        The normal, and the greatest angle of a clamp from the plane [rad].
    """
    directions = [d for d in given if d is not None]
    axis = unit(chord) if chord is not None else directions[0]
    leaning = [across(d, axis) for d in directions]
    if max((norm(vector) for vector in leaning), default=0.0) <= open_below:
        # All on one line: the plane is open.
        line = "chord" if chord is not None else _TANGENT
        side = bulge_direction(axis, cable.bulge, line) if near is None else cross(near, axis)
        if norm(side) <= IN_PLANE:  # it moved onto the normal of the plane it was in
            side = bulge_direction(axis, None)
    else:
        side = max(leaning, key=norm)
    normal = unit(cross(axis, side))
    off = max((math.asin(min(1.0, abs(dot(d, normal)))) for d in directions), default=0.0)
    if off > IN_PLANE:
        raise NotPlanarError(
            f"the ends do not lie in one plane: a clamp's axis is {math.degrees(off):.6g} degrees out of the plane "
            f"through the ends, and {math.degrees(IN_PLANE):.2g} are allowed; turn a connector, or "
            "leave out the axis of one end to pin it"
        )
    return normal, off
