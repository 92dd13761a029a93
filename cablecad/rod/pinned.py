"""The paper's cable in space: its data turned into an arch, its modes, their plane and their stability.

Mode j of a cable pinned at both ends is j arches of the same shape one after the other, alternately to either side:
j times the force factor omega, j^2 times the energy. Only the first can be stable, and only while its ends have not
crossed; modes 1 to 3 are listed, each with its mirror twin.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from cablecad.centreline import Array, Centreline, Placement
from cablecad.errors import Mistake, SceneError, SolveError
from cablecad.model import PINNED_DATA, Cable, Pin, Toward
from cablecad.rod.elastica import Inflexional
from cablecad.rod.elliptic import jacobi
from cablecad.rod.pinned_data import Pinned, solve_pinned
from cablecad.rod.plane import bulge_direction, unit_vector
from cablecad.rod.solution import EndState, Equilibrium, RodSolution, Shape, choose
from cablecad.rod.stability import Stability, stability

MODES = (1, 2, 3)
"""Higher modes are unstable and never what a user means."""

CROSSING_ANGLE_DEG = 130.70991070789999
"""End angle at which the ends of the first mode meet; beyond it the arch has crossed itself and is unstable."""


_EPS = 2.0**-52

_RESIDUAL = 1e-9
"""An end missed by more, over the length, is no answer."""


def solve_pinned_cable(cable: Cable, *, reason: str) -> RodSolution:
    """Solve a cable pinned at both ends from any two independent data.

    Args:
        cable: With pins at both ends, or a pin and a `Toward`.
        reason: Why this model was taken.

    Raises:
        InfeasibleError: No such cable.
        SolveError: The data are beyond what numbers tell apart.
        SceneError: Contradicting data, a bulge along the chord, or an equilibrium that was not found.
    """
    origin = np.array(cable.start_support.position)
    end, axis, data, names = _data(cable, origin)
    blur = 0.0 if end is None else _EPS * float(max(np.abs(origin).max(), np.abs(end).max()))
    EI = cable.material.EI(cable.section) if cable.material else None
    solved = solve_pinned(data, EI=EI, names=names, blur=blur)
    x, y, z = axis.tolist()
    side = np.array(bulge_direction((x, y, z), cable.bulge))
    twins = _modes(cable, solved, origin, axis, side)
    index = choose(cable, twins)
    chosen = twins[index]
    target = end if end is not None else origin + solved.chord * axis
    reached = chosen.centreline.frames([0.0, solved.length]).position
    unmet = np.linalg.norm(reached - np.array([origin, target]), axis=1).max() / solved.length
    if not unmet <= _RESIDUAL:
        raise SolveError(
            f"the arch that has these data misses an end by {unmet:.2g} of its length: they are beyond what numbers "
            "tell apart; give other data, such as the length and the positions of both ends"
        )
    arch = solved.arch
    return RodSolution(
        cable=cable,
        model="planar",
        reason=reason,
        equilibria=twins,
        index=index,
        length=solved.length,
        chord=solved.chord,
        slack=_slack(cable, solved),
        measure_rise=partial(float, arch.size("rise") / solved.omega / MODES[index // 2]),
        measure_end_angle=partial(math.degrees, arch.angle),
        measure_residual=partial(float, unmet),
        notes=tuple(_notes(solved)),
    )


def _slack(cable: Cable, solved: Pinned) -> float | None:
    if cable.slack is not None:
        return cable.slack
    return solved.datum("slack") if solved.chord > 0.0 else None


def _data(cable: Cable, origin: Array) -> tuple[Array | None, Array, dict[str, float], dict[str, str]]:
    """The end point (None with `toward`), the unit chord, the data, and what to call them in messages."""
    given = {
        key: float(value) for key in ("length", "slack", *PINNED_DATA) if (value := getattr(cable, key)) is not None
    }
    support = cable.end_support
    if isinstance(support, Toward):
        return None, unit_vector(support.direction), given, {}
    assert isinstance(support, Pin)  # a clamp does not come here
    end = np.array(support.position)
    distance = float(np.linalg.norm(end - origin))
    if "chord" in given and abs(given["chord"] - distance) > 1e-6 * max(distance, abs(given["chord"])):
        problem = f"contradicts the ends' positions, which are {distance:.9g} mm apart; write that, or leave it out"
        raise SceneError([Mistake("chord", problem, cable.chord)])
    if distance == 0.0:
        # Pins at one point leave the loop free to turn about it: it is drawn along X, or Y where the bulge is along X.
        bulge = unit_vector(cable.bulge if cable.bulge is not None else (0.0, 0.0, 1.0))
        axis = np.eye(3)[1 if abs(bulge[0]) > 0.9 else 0]
        axis = unit_vector(axis - (axis @ bulge) * bulge)
    else:
        axis = unit_vector(end - origin)
    return end, axis, given | {"chord": distance}, {"chord": "end.position"}


def _modes(cable: Cable, solved: Pinned, origin: Array, axis: Array, side: Array) -> tuple[Equilibrium, ...]:
    """Modes 1 to 3, each towards the bulge and away from it."""
    found = []
    for mode in MODES:
        judged = _Verdict(solved, mode)
        found += [_mode(cable, solved, mode, way, judged, origin, axis, side) for way in (1, -1)]
    return tuple(found)


def _mode(
    cable: Cable,
    solved: Pinned,
    mode: int,
    way: int,
    judged: Callable[[], Stability],
    origin: Array,
    axis: Array,
    side: Array,
) -> Equilibrium:
    """One mode on the side `way` of the bulge."""
    return Equilibrium(
        winding=0,
        side=way,
        inflections=mode - 1,
        branch="inflexional",
        energy_per_EI=mode**2 * solved.arch.energy_ratio / solved.length,
        draw=partial(_draw, solved, mode, Placement(origin, axis, -way * first_arch(mode) * side)),
        judge=judged,
        diameter=cable.diameter,
    )


def first_arch(mode: int) -> int:
    """On which side the first arch of a mode lies, seen from that of the whole: 1, or -1 on the other.

    The side is that of the middle, as of any cable; where the middle lies on the chord, that of the quarter point.
    """
    return -1 if mode == 3 else 1


def _draw(solved: Pinned, mode: int, placement: Placement) -> Shape:
    """The shape of a mode, its first arch on the side of -e2."""
    arch, omega = solved.arch, mode * solved.omega
    # Starting a quarter wave before the crest, psi rises from -beta_0.
    centreline = Centreline([Inflexional(placement, solved.length, omega, arch.m, arch.m1, -arch.K)])
    frames = centreline.frames([0.0, solved.length])
    push, no_moment = omega**2 * placement.e1, np.zeros(3)
    return Shape(
        centreline,
        EndState(frames.position[0], frames.tangent[0], push, no_moment),
        EndState(frames.position[1], frames.tangent[1], 0.0 - push, no_moment),
    )


@dataclass(frozen=True)
class _Verdict:
    """The stability of a mode, found once for both twins when it is asked for."""

    solved: Pinned
    mode: int

    def __call__(self) -> Stability:
        return self._found

    @cached_property
    def _found(self) -> Stability:
        return _judge(self.solved, self.mode)


def _judge(solved: Pinned, mode: int) -> Stability:
    """The stability of a mode; it does not depend on its side, nor on the spin, which pins leave free."""
    arch, turns = solved.arch, 2.0 * mode * solved.arch.K

    def theta(s: Array) -> Array:
        return 2.0 * np.arcsin(arch.k * jacobi(turns * s - arch.K, arch.m, arch.m1).sn)

    def kappa(s: Array) -> Array:
        return 2.0 * arch.k * turns * jacobi(turns * s - arch.K, arch.m, arch.m1).cn

    found = stability(theta, kappa, (-(turns**2), 0.0), start_clamped=False, end_clamped=False)
    margins = float(found.in_plane), float(found.out_of_plane)
    if mode > 1 or solved.chord < 0.0:
        # Unstable, by how little ever: near 180 degrees the margins are exponentially small, below their rounding.
        margins = min(margins[0], 0.0), min(margins[1], 0.0)
    return Stability(*margins, bool(found.free_turn), found.spin)


def _notes(solved: Pinned) -> list[str]:
    """What the data give to say: redundant ones, another answer, ends that have crossed."""
    said = list(solved.notes)
    if solved.other is not None:
        said.append(
            f"two cables meet these data: the one with the smaller end angle, {_described(solved)}, was taken; the "
            f"other has {_described(solved.other)}"
        )
    if solved.chord < 0.0:
        said.append(
            f"the ends have crossed: the end angle {solved.datum('angle_deg'):.7g} degrees is above "
            f"{CROSSING_ANGLE_DEG:.7g}, where they meet"
        )
    return said


def _described(solved: Pinned) -> str:
    angle = solved.datum("angle_deg")
    return f"{angle:.7g} degrees (length {solved.length:.7g} mm, chord {solved.chord:.7g} mm)"
