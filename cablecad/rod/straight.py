"""The straight cable: no excess length and ends that look at each other. Its solid is a cylinder."""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from cablecad.centreline import Array, Centreline, Line, Placement
from cablecad.model import Cable, Clamp
from cablecad.rod.plane import bulge_direction, unit_vector
from cablecad.rod.solution import EndState, Equilibrium, RodSolution, Shape, choose
from cablecad.rod.stability import Stability, stability


def solve_straight(cable: Cable, start: Array, end: Array, *, length: float, reason: str) -> RodSolution:
    """The line from `start` to `end`, shape (3,) each [mm], of given `length` [mm]; no force, no moment."""
    chord = float(np.linalg.norm(end - start))
    axis = (end - start) / chord
    x, y, z = axis.tolist()
    piece = Line(Placement(start, axis, np.array(bulge_direction((x, y, z), cable.bulge))), chord)
    nothing = np.zeros(3)
    supports = (cable.start_support, cable.end_support)
    held = [isinstance(support, Clamp) for support in supports]

    centreline = Centreline([piece])
    line = Equilibrium(
        winding=0,
        side=0,
        inflections=0,
        branch="line",
        energy_per_EI=0.0,
        draw=partial(
            Shape,
            centreline,
            EndState(start, axis, nothing, nothing),
            EndState(centreline.position(chord)[0], axis, nothing, nothing),
        ),
        judge=partial(_judge, *held),
        diameter=cable.diameter,
    )
    unmet = float(np.linalg.norm(line.end.position - end)) / chord
    for support in supports:
        if isinstance(support, Clamp):
            direction = unit_vector(support.direction)
            unmet = max(unmet, math.atan2(float(np.linalg.norm(np.cross(direction, axis))), float(direction @ axis)))
    return RodSolution(
        cable=cable,
        model="straight",
        reason=reason,
        equilibria=(line,),
        index=choose(cable, (line,)),
        length=length,
        chord=chord,
        slack=(length - chord) / chord,
        measure_rise=partial(float, 0.0),
        measure_end_angle=partial(float, 0.0),
        measure_residual=partial(float, unmet),
    )


def _judge(start_clamped: bool, end_clamped: bool) -> Stability:
    found = stability(np.zeros_like, np.zeros_like, (0.0, 0.0), start_clamped=start_clamped, end_clamped=end_clamped)
    return Stability(float(found.in_plane), float(found.out_of_plane), bool(found.free_turn), found.spin)
