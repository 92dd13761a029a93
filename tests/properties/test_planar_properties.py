"""What no choice of axes, unit, side or direction of travel may change in a cable between clamps and pins."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from test_pinned_properties import ANGLES, VECTORS, rotation

from cablecad.model import Cable, Clamp, Pin
from cablecad.rod.solve import solve_rod

RATIOS = st.floats(0.0, 0.999)
UNTURNED = np.eye(3)
LIMITED = settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.too_slow])


def solution(end, a, b, *, length=100.0, turn=UNTURNED, move=(0.0, 0.0, 0.0), bulge=(1e-3, 1.0, 0.0), mirror=1.0):
    """A cable in the x-y plane, its ends at angles a and b (None: a pin), then turned and moved."""

    def support(position, angle):
        place = tuple(turn @ np.array([position[0], mirror * position[1], 0.0]) + move)
        if angle is None:
            return Pin(place)
        return Clamp(place, tuple(turn @ np.array([math.cos(angle), mirror * math.sin(angle), 0.0])))

    bent = tuple(turn @ np.array([bulge[0], mirror * bulge[1], bulge[2]]))
    return solve_rod(Cable("c", 1e-6 * length, support((0, 0), a), support(end, b), length=length, bulge=bent))


def allowed(ratio: float, reach: float = 0.0) -> float:
    """Of the length: 1e-9, and the rounding of positions that a nearly straight cable amplifies."""
    return 1e-9 + 100 * np.finfo(float).eps * (1.0 + reach) / math.sqrt(1.0 - ratio)


def least_gap(one, other) -> float:
    """The relative distance of the two lowest energies: where they meet, the answer may be either."""
    energies = sorted(
        e.energy_per_EI * s.length for s in (one, other) for e in s.equilibria if e.stability.stable_in_plane
    )
    distinct = [e for e in energies[1:] if e > energies[0] * (1 + 1e-7) + 1e-12]
    return (distinct[0] / energies[0] - 1.0) if distinct and energies[0] > 0 else 1.0


def agree(one, other, points, expected, room) -> None:
    """The answer's energy is the same, and so is its shape or that of a twin of equal energy."""
    assert other.equilibrium.energy_per_EI * other.length == np.float64(
        np.clip(
            other.equilibrium.energy_per_EI * other.length,
            one.equilibrium.energy_per_EI * one.length * (1 - 1e-7) - 1e-10,
            one.equilibrium.energy_per_EI * one.length * (1 + 1e-7) + 1e-10,
        )
    )
    if least_gap(one, other) > 1e-6:
        energy = other.equilibrium.energy_per_EI
        twins = [e for e in other.equilibria if abs(e.energy_per_EI - energy) <= 1e-7 * energy]
        off = min(np.abs(points(twin.centreline) - expected).max() for twin in twins)
        assert off <= room * one.length


ENDS = st.tuples(RATIOS, ANGLES)
CLAMPS = st.one_of(st.none(), st.floats(-3.1, 3.1))


@given(ENDS, st.floats(-3.1, 3.1), CLAMPS, ANGLES, ANGLES, ANGLES, VECTORS)
@LIMITED
def test_rigid_motion_in_space(end, a, b, x, y, z, move) -> None:
    ratio, direction = end
    place = (100 * ratio * math.cos(direction), 100 * ratio * math.sin(direction))
    turn = rotation(x, y, z)
    plain = solution(place, a, b)
    moved = solution(place, a, b, turn=turn, move=np.array(move))
    room = allowed(ratio, np.abs(move).max() / 100.0) + (
        100 * 2.2e-16 * (1 + np.abs(move).max() / 100) / max(ratio, 1e-3)
    )
    agree(plain, moved, lambda c: c.points(41), plain.points(41) @ turn.T + move, room)


@given(ENDS, st.floats(-3.1, 3.1), CLAMPS, st.floats(-6, 6))
@example((0.9856001547526344, 2.232421875), 0.0, None, 1.0)  # taut beyond what the flow from mid-span resolved
@LIMITED
def test_scale(end, a, b, exponent) -> None:
    ratio, direction = end
    place = np.array([100 * ratio * math.cos(direction), 100 * ratio * math.sin(direction)])
    factor = 10.0**exponent
    plain = solution(place, a, b)
    scaled = solution(place * factor, a, b, length=100.0 * factor)
    agree(plain, scaled, lambda c: c.points(41) / factor, plain.points(41), allowed(ratio))


@given(ENDS, st.floats(-3.1, 3.1), CLAMPS)
@LIMITED
def test_mirror(end, a, b) -> None:
    ratio, direction = end
    place = (100 * ratio * math.cos(direction), 100 * ratio * math.sin(direction))
    plain, mirrored = solution(place, a, b), solution(place, a, b, mirror=-1.0)
    agree(plain, mirrored, lambda c: c.points(41), plain.points(41) * [1, -1, 1], allowed(ratio))


@given(ENDS, st.floats(-3.1, 3.1), CLAMPS)
@LIMITED
def test_reversal(end, a, b) -> None:
    ratio, direction = end
    place = np.array([100 * ratio * math.cos(direction), 100 * ratio * math.sin(direction), 0.0])
    plain = solution(place[:2], a, b)

    def clamp(position, angle, turned=True):
        if angle is None:
            return Pin(position)
        return Clamp(position, (-math.cos(angle), -math.sin(angle), 0.0))

    backwards = solve_rod(
        Cable("c", 1e-4, clamp(tuple(place), b), clamp((0, 0, 0), a), length=100.0, bulge=(1e-3, 1.0, 0.0))
    )
    agree(plain, backwards, lambda c: c.points(41)[::-1], plain.points(41), allowed(ratio) + 2.2e-14 / max(ratio, 1e-3))
