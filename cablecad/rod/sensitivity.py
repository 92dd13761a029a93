"""How an equilibrium answers small changes of its ends and length: derivatives from one linear system.

A change of the end conditions changes the angle along the rod by one solve (`variation`); force, end moments, points
and least bend radius follow. Length enters by similarity: a rod of length L between fixed ends is the rod of length 1
with its end at (X, Y)/L. Units: L = EI = 1 at the equilibrium itself.

Near a fold, and as the excess goes to 0 (like 1/sqrt(excess)), derivatives grow without bound; they are what they are.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cablecad.errors import UsageError
from cablecad.rod.equilibria import Equilibria
from cablecad.rod.taut import Taut
from cablecad.rod.trial import Array
from cablecad.rod.variation import vary

INPUTS = ("x", "y", "length", "start_angle", "end_angle")
"""The order of the columns of every derivative."""

_STEP = 1e-30
"""Complex step: its square is far below rounding, so the derivative has no truncation error."""


@dataclass(frozen=True, slots=True)
class Sensitivity:
    """Derivatives of one equilibrium; the last axis runs over `INPUTS`. Columns of angles at pins are zero.

    Attributes:
        force: Of (n_x, n_y), shape (2, 5).
        kappa0, kappa1: Of the curvatures (moments over EI) at the ends, shape (5,).
        points: Of the points at given fractions of the length, shape (k, 2, 5).
        bend_radius: Of the least bend radius, shape (5,).
    """

    force: Array
    kappa0: Array
    kappa1: Array
    points: Array
    bend_radius: Array


def sensitivity(shape: Equilibria, s: Any = ()) -> Sensitivity:
    """Differentiate one equilibrium.

    Args:
        shape: One equilibrium of length 1.
        s: Fractions of the length at which points are wanted, shape (k,).

    Raises:
        UsageError: More or fewer than one equilibrium, or one too sharp.

    Accuracy: 1e-7 of the largest entry against differences, loops among them; tests/rod/test_sensitivity.py.
    """
    if len(shape) != 1:
        raise UsageError(f"sensitivity takes one equilibrium, given {len(shape)}: take one with `take`")
    at = np.asarray(s, dtype=float)
    change = _taut(shape, at) if shape.taut[0] else _bent(shape, at)
    _, _, position = shape.at(np.append(at, 1.0))
    return _with_length(shape, change, position[0])


@dataclass(frozen=True, slots=True)
class _Change:
    """Derivatives by (x, y, start angle, end angle) at unit length, last axis 4."""

    force: Array
    kappa0: Array
    kappa1: Array
    points: Array
    kappa_max: Array


def _with_length(shape: Equilibria, d: _Change, position: Array) -> Sensitivity:
    """Add the column of the length: X/L moves by -X, forces go with L^-2, curvatures with L^-1, points with L."""
    end, points = position[-1], position[:-1]

    def extend(value: Array, scaled: Any) -> Array:
        by_length = scaled - value[..., 0] * end[0] - value[..., 1] * end[1]
        return np.concatenate([value[..., :2], np.asarray(by_length)[..., None], value[..., 2:]], axis=-1)

    kappa_max = extend(d.kappa_max, -shape.kappa_max[0])
    return Sensitivity(
        extend(d.force, -2.0 * shape.force[0]),
        extend(d.kappa0, -shape.kappa0[0]),
        extend(d.kappa1, -shape.kappa1[0]),
        extend(d.points, points),
        -kappa_max / shape.kappa_max[0] ** 2,
    )


def _bent(shape: Equilibria, s: Array) -> _Change:
    frame = float(shape.frame[0])
    turn = np.array([[np.cos(frame), -np.sin(frame)], [np.sin(frame), np.cos(frame)]])
    # In the frame of the chord, in which the angles of a hair of slack keep their digits.
    change = vary(
        lambda at: shape.at(at)[0][0] - frame,
        lambda at: shape.tangents(at)[2][0],
        shape.force[0] @ turn,
        start_clamped=bool(shape.held[0, 0]),
        end_clamped=bool(shape.held[0, 1]),
    )
    # What is asked is by moves along x and y, the answers are along the chord.
    inputs = np.eye(4)
    inputs[:2, :2] = turn.T
    force, points = turn @ change.force @ inputs, turn @ change.moved(s) @ inputs
    kappa0, kappa1, theta0 = change.kappa0 @ inputs, change.kappa1 @ inputs, change.theta0 @ inputs
    return _Change(force, kappa0, kappa1, points, _sharpest(shape, force, kappa0, kappa1, theta0))


def _sharpest(shape: Equilibria, force: Array, kappa0: Array, kappa1: Array, theta0: Array) -> Array:
    """Change of the greatest |curvature|: at an end, or where the tangent meets the compression.

    There kappa^2/2 = H + |n| with H = kappa^2/2 + n.t constant along the rod, read at its start.
    """
    largest = shape.kappa_max[0]
    for kappa, change in ((shape.kappa0[0], kappa0), (shape.kappa1[0], kappa1)):
        if abs(abs(kappa) - largest) <= 1e-13 * largest:
            own: Array = np.sign(kappa) * change
            return own
    n, theta = shape.force[0], shape.theta0[0]
    tangent = np.array([np.cos(theta), np.sin(theta)])
    across = np.array([-tangent[1], tangent[0]])
    energy = shape.kappa0[0] * kappa0 + tangent @ force + (n @ across) * theta0
    pull = (n / max(float(np.hypot(n[0], n[1])), 1e-300)) @ force
    peak: Array = (energy + pull) / largest
    return peak


def _taut(shape: Equilibria, s: Array) -> _Change:
    """The closed form differentiated by complex steps in (a, b, direction, omega)."""
    data = np.array([shape.a[0], shape.b[0], shape.direction[0], shape.omega[0]])
    held = shape.held[0]
    columns = [_taut_values(data + 1j * _STEP * row, held, s).imag / _STEP for row in np.eye(4)]
    values = np.stack(columns, axis=-1)
    by_given = values @ np.linalg.inv(values[:4])
    # Inputs of the inverse are (x, y, angle or curvature at 0, at 1); a pin's column is no input.
    by_given[:, 2:] *= held
    wide = max(abs(shape.a[0]), abs(shape.b[0])) > np.pi
    force, kappa0, kappa1 = by_given[4:6], by_given[6], by_given[7]
    if wide:
        sharpest = by_given[8]
    else:
        first = abs(shape.kappa0[0]) >= abs(shape.kappa1[0])
        sharpest = np.sign(shape.kappa0[0]) * kappa0 if first else np.sign(shape.kappa1[0]) * kappa1
    return _Change(force, kappa0, kappa1, by_given[9:].reshape(len(s), 2, 4), sharpest)


def _taut_values(data: NDArray[Any], held: np.ndarray, s: Array) -> NDArray[Any]:
    """x, y, the two given end data, n_x, n_y, kappa0, kappa1, 2 omega, and the points."""
    a, b, direction, omega = (data[i : i + 1] for i in range(4))
    rod = Taut(np.zeros(1, dtype=int), direction, omega, a, b)
    along, across = rod.position(np.append(s, 1.0))
    cosine, sine = np.cos(direction), np.sin(direction)
    x, y = (cosine * along - sine * across)[0], (sine * along + cosine * across)[0]
    kappa = rod.curvature(np.array([0.0, 1.0]))[0]
    given = [(direction + angle)[0] if clamp else k for angle, k, clamp in zip((a, b), kappa, held, strict=True)]
    size = omega[0] ** 2
    points = np.stack([x[:-1], y[:-1]], axis=-1).ravel()
    fixed = [x[-1], y[-1], *given, size * cosine[0], size * sine[0], kappa[0], kappa[1], 2.0 * omega[0]]
    return np.concatenate([np.array(fixed), points])
