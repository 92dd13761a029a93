"""Which mechanical model a cable needs, and why: the simplest that is exact for it.

straight: no excess length and ends that look at each other - a cylinder, no forces.
planar:   ends in one plane - the elastica, in closed form.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cablecad.centreline import Array
from cablecad.errors import InfeasibleError
from cablecad.model import PINNED_DATA, Cable, Clamp, Pin, Toward
from cablecad.rod.plane import unit_vector
from cablecad.rod.solution import ModelName

ALIGNED = 1e-9
"""Axes within this angle of the chord [rad] are along it: the accuracy a port is built to."""


@dataclass(frozen=True)
class Selection:
    """A model and the reason it was taken."""

    model: ModelName
    reason: str


def select_model(cable: Cable) -> Selection:
    """Choose the model for a cable.

    Raises:
        InfeasibleError: The cable is shorter than the distance of its ends, or exactly as long but not aligned.
    """
    start, end = cable.start_support, cable.end_support
    if isinstance(end, Toward):
        return Selection("planar", "pinned at both ends: the plane of the chord and the bulge, closed form")
    distance = math.dist(start.position, end.position)
    if isinstance(cable.length, int | float) and cable.slack is None:
        rounding = 4.0 * np.finfo(float).eps * (cable.length + _reach(start, end))
        if cable.length < distance - rounding:
            raise InfeasibleError(
                f"length {cable.length:.12g} mm is {distance - cable.length:.6g} mm less than the distance of the "
                f"ends, {distance:.12g} mm; make the cable longer or bring the ends together"
            )
        if cable.length <= distance + rounding:
            if distance == 0.0:
                raise InfeasibleError(
                    f"length {cable.length:.3g} mm is less than numbers tell apart at the place of its ends, "
                    f"{rounding:.3g} mm; make the cable longer or bring the scene nearer to the origin"
                )
            return _straight(cable, unit_vector(np.subtract(end.position, start.position)), distance)
    if cable.is_pinned:
        return Selection("planar", "pinned at both ends: the plane of the chord and the bulge, closed form")
    return Selection("planar", "the ends lie in one plane: planar elastica")


def _reach(start: Clamp | Pin, end: Clamp | Pin) -> float:
    """The largest coordinate of the ends [mm]: what their rounding goes with."""
    return max(abs(part) for support in (start, end) for part in support.position)


def _straight(cable: Cable, axis: Array, distance: float) -> Selection:
    """A cable as long as the distance of its ends: straight, if its ends allow it."""
    for place, support in (("start", cable.start_support), ("end", cable.end_support)):
        if isinstance(support, Clamp):
            direction = unit_vector(support.direction)
            off = math.atan2(float(np.linalg.norm(np.cross(direction, axis))), float(direction @ axis))
            if off > ALIGNED:
                raise InfeasibleError(
                    f"the cable is exactly as long as the distance of its ends, {distance:.12g} mm, so it can only be "
                    f"straight, but the axis of its {place} is {math.degrees(off):.6g} degrees off the line between "
                    "them; give it some slack or align the axis"
                )
    straights = [support.straight for support in (cable.start_support, cable.end_support) if isinstance(support, Clamp)]
    if sum(straights) > distance * (1.0 + ALIGNED):
        listed = " and ".join(f"{straight:g} mm" for straight in straights if straight)
        raise InfeasibleError(
            f"the straight lengths held by the connectors, {listed}, are more than the cable's {distance:.12g} mm; "
            "make the cable longer or the straights shorter"
        )
    extra = [key for key in PINNED_DATA if key != "chord" and getattr(cable, key) is not None]
    if extra:
        raise InfeasibleError(
            f"the cable is exactly as long as the distance of its ends, {distance:.12g} mm: it is straight and has no "
            f"{' and no '.join(extra)}; leave that out, or leave out the length"
        )
    return Selection("straight", "the length equals the distance of the aligned ends: a cylinder")
