"""What no choice of axes, unit or direction of travel may change in a pinned cable."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from cablecad.model import Cable, Pin
from cablecad.rod.solve import solve_rod

RATIOS = st.floats(1e-6, 0.999999)
COORDINATES = st.floats(-1000.0, 1000.0)
VECTORS = st.tuples(COORDINATES, COORDINATES, COORDINATES)
ANGLES = st.floats(-np.pi, np.pi)


def arch(start, end, length, bulge) -> np.ndarray:
    cable = Cable("c", 1e-3, Pin(start), Pin(end), length=length, bulge=bulge)
    return solve_rod(cable).points(41)


def rotation(a: float, b: float, c: float) -> np.ndarray:
    """Of three Euler angles."""

    def about(axis: int, angle: float) -> np.ndarray:
        i, j = [k for k in range(3) if k != axis]
        matrix = np.eye(3)
        matrix[i, i] = matrix[j, j] = np.cos(angle)
        matrix[i, j], matrix[j, i] = -np.sin(angle), np.sin(angle)
        return matrix

    return about(0, a) @ about(1, b) @ about(2, c)


def allowed(ratio: float, reach: float, length: float) -> float:
    """Rounding of the ends is amplified by 1/sqrt(slack) in a nearly straight cable, and turns a short chord."""
    return length * 1e-12 + 100 * np.finfo(float).eps * (reach + length) * (1.0 / np.sqrt(1.0 - ratio) + 1.0 / ratio)


@given(RATIOS, ANGLES, ANGLES, ANGLES, VECTORS)
@settings(max_examples=60, deadline=None)
def test_rigid_motion(ratio: float, a: float, b: float, c: float, move) -> None:
    turn = rotation(a, b, c)
    plain = arch((0, 0, 0), (100 * ratio, 0, 0), 100.0, (0, 0, 1))
    place = lambda x: tuple(turn @ np.array(x) + move)
    moved = arch(place((0, 0, 0)), place((100 * ratio, 0, 0)), 100.0, tuple(turn @ [0, 0, 1]))
    np.testing.assert_allclose(moved, plain @ turn.T + move, atol=allowed(ratio, np.abs(move).max(), 100.0))


@given(RATIOS, st.floats(-6, 6))
@settings(max_examples=60, deadline=None)
def test_scale(ratio: float, exponent: float) -> None:
    factor = 10.0**exponent
    plain = arch((0, 0, 0), (100 * ratio, 0, 0), 100.0, None)
    scaled = arch((0, 0, 0), (100 * ratio * factor, 0, 0), 100.0 * factor, None)
    np.testing.assert_allclose(scaled / factor, plain, atol=allowed(ratio, 0.0, 100.0))


@given(RATIOS)
@settings(max_examples=30, deadline=None)
def test_mirror(ratio: float) -> None:
    up = arch((0, 0, 0), (100 * ratio, 0, 0), 100.0, (0, 0, 1))
    down = arch((0, 0, 0), (100 * ratio, 0, 0), 100.0, (0, 0, -1))
    np.testing.assert_allclose(down, up * [1, 1, -1], atol=1e-12)


@given(RATIOS, VECTORS)
@settings(max_examples=30, deadline=None)
def test_reversal(ratio: float, start) -> None:
    end = (start[0] + 100 * ratio, start[1], start[2])
    there, back = arch(start, end, 100.0, None), arch(end, start, 100.0, None)
    np.testing.assert_allclose(back[::-1], there, atol=allowed(ratio, np.abs(start).max(), 100.0))
