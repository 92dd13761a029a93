"""PyElastica on one of the reference scenes: ``python -m cablecad.bench.pyelastica [SEGMENTS]``, some minutes.

Not a stage of `cablecad bench`: PyElastica is no dependency, and integrates in time. Install it beside cablecad with
``pip install pyelastica``. A rod starts at rest in the shape of a neighbouring scene, which our solver gives it; its
ends move to their places within a unit of time; then damping brings it to rest. Printed every tenth of a unit: seconds
of work so far, and the largest component of the error of nine points over the length, against the reference.

The rod is as slender as its wave speed allows: what stays of the error is its stretch, its shear and its segments.
"""

from __future__ import annotations

import math
import sys
import time
from typing import Any

import numpy as np

from cablecad.bench.scenes import Array, Scenes, scene_cables
from cablecad.bench.truth import PlanarTruth, planar_truths
from cablecad.rod.solution import RodSolution
from cablecad.rod.solve import solve_many

SCENE = "random04"
RADIUS = 0.01
"""Of the rod of length 1: a force of 100 EI/L^2 stretches it by 2.5e-3; a thinner one takes more steps."""

DAMPING = 12.0
"""A little less than critical for the slowest mode, whose frequency is about 22 in units of sqrt(EI/(rho A))/L^2."""

MOVING, RESTING = 1.0, 2.0
"""Units of time in which the ends move, and in which the rod comes to rest."""

COURANT = 0.3
"""Time step over the time a wave takes along a segment."""


def main(segments: int) -> None:
    """Print the approach to the reference."""
    import elastica as ea

    truth = next(truth for truth in planar_truths() if truth.name == SCENE)
    neighbour = _neighbour(truth)
    nodes = neighbour.points(segments + 1).T
    tangents = np.diff(nodes, axis=1)
    tangents /= np.linalg.norm(tangents, axis=0)
    area, inertia = math.pi * RADIUS**2, math.pi * RADIUS**4 / 4.0
    modulus = 1.0 / inertia

    class Simulator(ea.BaseSystemCollection, ea.Constraints, ea.Damping):  # type: ignore[misc]
        """The parts of a simulation."""

    class Moved(ea.ConstraintBase):  # type: ignore[misc]
        """Ends on their way from where they are to where they shall be."""

        def __init__(self, *arguments: Any, **named: Any) -> None:
            super().__init__(*arguments, **named)
            self.finish = (np.zeros(2), truth.end)
            self.turn = (truth.a, truth.b)
            self.begin = (nodes[:2, 0].copy(), nodes[:2, -1].copy())
            self.angle = tuple(math.atan2(*neighbour.tangent([s])[0, 1::-1]) for s in (0.0, neighbour.length))

        def constrain_values(self, system: Any, time: float) -> None:
            share = min(1.0, time / MOVING)
            for i, (node, element, inner) in enumerate(((0, 0, 1), (-1, -1, -2))):
                system.position_collection[:2, node] = self.begin[i] + share * (self.finish[i] - self.begin[i])
                system.position_collection[2, node] = 0.0
                turn = math.remainder(self.turn[i] - self.angle[i], 2.0 * math.pi)
                clamp = self.angle[i] + share * turn
                # The clamp is at the node, the director half a segment further in: a third of the way to the next
                # one. With the clamp's own direction there the rod is as good as shorter, by a whole segment.
                tangent = system.director_collection[2, :, inner]
                bend = math.remainder(math.atan2(tangent[1], tangent[0]) - clamp, 2.0 * math.pi)
                system.director_collection[..., element] = _director(clamp + bend / 3.0)

        def constrain_rates(self, system: Any, time: float) -> None:
            for i, (node, element) in enumerate(((0, 0), (-1, -1))):
                moving = (self.finish[i] - self.begin[i]) / MOVING if time < MOVING else np.zeros(2)
                system.velocity_collection[:2, node] = moving
                system.velocity_collection[2, node] = 0.0
                system.omega_collection[..., element] = 0.0

    rod = ea.CosseratRod.straight_rod(
        segments,
        start=np.zeros(3),
        direction=tangents[:, 0],
        normal=np.array([0.0, 0.0, 1.0]),
        base_length=1.0,
        base_radius=RADIUS,
        density=1.0 / area,
        youngs_modulus=modulus,
        shear_modulus=modulus / 2.5,
        position=nodes,
        directors=np.stack([_director(math.atan2(t[1], t[0])) for t in tangents.T], axis=2),
    )
    simulator = Simulator()
    simulator.append(rod)
    simulator.constrain(rod).using(Moved, constrained_position_idx=(0, -1), constrained_director_idx=(0, -1))
    step = COURANT / segments / math.sqrt(modulus * area)
    simulator.dampen(rod).using(ea.AnalyticalLinearDamper, uniform_damping_constant=DAMPING, time_step=step)
    simulator.finalize()
    stepper = ea.PositionVerlet()
    begun = time.perf_counter()
    now = np.float64(0.0)
    for tenth in range(1, round(10.0 * (MOVING + RESTING)) + 1):
        while now < tenth / 10.0:
            now = stepper.step(simulator, now, np.float64(step))
        error = np.abs(_nine(rod.position_collection) - truth.points).max()
        sys.stdout.write(f"time {now:.1f}: {time.perf_counter() - begun:.1f} s, error over length {error:.2e}\n")
        sys.stdout.flush()


def _neighbour(truth: PlanarTruth) -> RodSolution:
    """A scene whose ends are some per cent and some degrees away, solved."""
    scenes = Scenes(np.array([truth.a + 0.1]), np.array([truth.b - 0.1]), truth.end[None] * 0.95)
    (answer,) = solve_many(scene_cables(scenes))
    if not isinstance(answer, RodSolution):
        raise answer
    return answer


def _director(angle: float) -> Array:
    """Rows: the normal of the plane, the normal in it, the tangent."""
    cosine, sine = math.cos(angle), math.sin(angle)
    return np.array([[0.0, 0.0, 1.0], [sine, -cosine, 0.0], [cosine, sine, 0.0]])


def _nine(positions: Array) -> Array:
    """Nine points at equal arclengths, by lines between the nodes."""
    s = np.linspace(0.0, 1.0, positions.shape[1])
    nine = np.linspace(0.0, 1.0, 9)
    return np.stack([np.interp(nine, s, positions[i]) for i in range(2)], axis=1)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 32)
