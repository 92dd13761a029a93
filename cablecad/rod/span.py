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
from cablecad.model import Cable, Clamp, Pin
from cablecad.rod.plane import bulge_direction, unit_vector

IN_PLANE = 1e-6
"""Clamps within this angle of the plane [rad] are turned into it: the accuracy of a modelled connector. Where chord and
clamps are within it of one line, that line leaves the plane open and the bulge decides."""

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
        return np.cross(self.e1, self.e2)

    @property
    def end_point(self) -> tuple[float, float]:
        """The end seen from the start in (e1, e2), over the length."""
        chord = self.end - self.start
        return float(chord @ self.e1) / self.length, float(chord @ self.e2) / self.length


@dataclass(frozen=True)
class _End:
    """One end without its lead-out: position (3,) [mm], unit direction of travel (3,) or None, lead-out [mm]."""

    position: Array
    direction: Array | None
    straight: float


def _ends(cable: Cable) -> tuple[_End, _End]:
    ends = []
    for support, way in ((cable.start_support, 1.0), (cable.end_support, -1.0)):
        assert isinstance(support, Clamp | Pin)  # a cable with `toward` is the pinned model's
        position = np.array(support.position)
        if isinstance(support, Clamp):
            direction = unit_vector(support.direction)
            ends.append(_End(position + way * support.straight * direction, direction, support.straight))
        else:
            ends.append(_End(position, None, 0.0))
    return ends[0], ends[1]


def span_of(cable: Cable, length: float) -> Span:
    """Reduce a cable with positions at both ends to its free part.

    Args:
        cable: With two positions.
        length: Of the whole cable [mm]; `cable.slack`, where given, is the primary datum of the excess.

    Raises:
        InfeasibleError: The free part is shorter than the distance it has to span.
        NotPlanarError: The clamps do not lie in one plane with the chord.
        SceneError: The bulge is along the chord.
    """
    start, end = _ends(cable)
    free = length - start.straight - end.straight
    if free <= 0.0:
        raise InfeasibleError(
            f"the straight lengths {start.straight:g} mm and {end.straight:g} mm held by the connectors leave nothing "
            f"of the cable's {length:.12g} mm to bend; make the cable longer or the straights shorter"
        )
    chord = end.position - start.position
    distance = float(np.linalg.norm(chord))
    excess = free - distance
    if cable.slack is not None:
        ends_apart = float(np.linalg.norm(np.subtract(cable.end_support.position, cable.start_support.position)))  # type: ignore[union-attr]
        excess = cable.slack * ends_apart + (ends_apart - start.straight - end.straight - distance)
    if excess <= 0.0:
        held = "" if free == length else f" of it {free:.12g} mm free,"
        raise InfeasibleError(
            f"length {length:.12g} mm,{held} is {-excess:.6g} mm less than the distance it has to span, "
            f"{distance:.12g} mm; make the cable longer or bring the ends together"
        )
    e1, e2, out_of_plane = _plane(cable, chord, distance / free, start.direction, end.direction)
    angles = [
        0.0 if direction is None else math.atan2(float(direction @ e2), float(direction @ e1))
        for direction in (start.direction, end.direction)
    ]
    return Span(
        start=start.position,
        end=end.position,
        e1=e1,
        e2=e2,
        length=free,
        excess=excess / free,
        start_angle=angles[0],
        end_angle=angles[1],
        start_clamped=start.direction is not None,
        end_clamped=end.direction is not None,
        lead_out=start.straight,
        lead_in=end.straight,
        out_of_plane=out_of_plane,
    )


def _plane(
    cable: Cable, chord: Array, ratio: float, start: Array | None, end: Array | None
) -> tuple[Array, Array, float]:
    """Axes of the plane, e2 towards the bulge, and the greatest angle of a clamp from it [rad]."""
    directions = [direction for direction in (start, end) if direction is not None]
    e1 = unit_vector(chord) if ratio > COINCIDENT else directions[0]
    bulge = bulge_direction(e1, cable.bulge)
    across = [direction - (direction @ e1) * e1 for direction in directions]
    if max(float(np.linalg.norm(vector)) for vector in across) <= IN_PLANE:
        e2 = bulge  # all on one line: the plane is open
    else:
        _, _, axes = np.linalg.svd(np.array(across))
        e2 = unit_vector(axes[0] - (axes[0] @ e1) * e1)
        lean = float(e2 @ bulge)
        # Across the bulge neither side is towards it; the largest coordinate decides, so that the choice is stable.
        towards = lean if abs(lean) > IN_PLANE else float(e2[np.argmax(np.abs(e2))])
        e2 = e2 if towards > 0.0 else -e2
    normal = np.cross(e1, e2)
    off = max(math.asin(min(1.0, abs(float(direction @ normal)))) for direction in directions)
    if off > IN_PLANE:
        raise NotPlanarError(
            f"the ends do not lie in one plane: a clamp's axis is {math.degrees(off):.6g} degrees out of the best plane "
            f"through the chord, and {math.degrees(IN_PLANE):.2g} are allowed; turn a connector, or leave out the axis "
            "of one end to pin it"
        )
    return e1, e2, off
