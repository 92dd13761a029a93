"""Collocation, as the planar solver's rival: `scipy.integrate.solve_bvp` on the rod's boundary value problem.

Units: L = EI = 1, the start is the origin. It finds one equilibrium, whichever lies near its start, and knows nothing
of the stability of it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from cablecad.bench.scenes import TURN, Array

GAUSS = np.polynomial.legendre.leggauss(5)

UNMET = 1e-3
"""Largest unmet end condition of a solution; `solve_bvp` may report success at more."""


FEW_NODES, MANY_NODES = 1000, 20_000
"""Its default, and what 1e-9 needs."""


class Guess(NamedTuple):
    """Where it starts: at equal arclengths angles without jumps and curvatures, shape (n,), places (n, 2); force."""

    theta: Array
    kappa: Array
    place: Array
    force: Array


class Found(NamedTuple):
    """What it found: energy, infinite without success, and nine points at equal arclengths, shape (9, 2)."""

    energy: float
    points: Array


def naive_guess(a: float, b: float, end: Array, nodes: int = 9) -> Guess:
    """The angle turning evenly the shorter way, places along the chord, no force: what one has without a solution."""
    s = np.linspace(0.0, 1.0, nodes)
    turn = (b - a + np.pi) % TURN - np.pi
    return Guess(a + turn * s, np.full(nodes, turn), s[:, None] * end, np.zeros(2))


def boundary_value(a: float, end: Array, guess: Guess, *, tolerance: float = 1e-6) -> Callable[[], Found]:
    """Solve from a guess, 1 % off.

    Args:
        a: Angle at the start.
        end: Place of the end, shape (2,).
        guess: Its last angle is the angle at the end, full turns included.
        tolerance: Relative residual of the collocation.

    Returns:
        Reads off what was found; that is not part of the work a time is taken of.
    """
    from scipy.integrate import solve_bvp

    theta, kappa, place, force = guess

    def slope(_: Array, y: Array, p: Array) -> Array:
        return np.vstack([y[1], p[0] * np.sin(y[0]) - p[1] * np.cos(y[0]), np.cos(y[0]), np.sin(y[0])])

    def unmet(u: Array, v: Array, _: Array) -> Array:
        return np.array([u[0] - a, u[2], u[3], v[0] - theta[-1], v[2] - end[0], v[3] - end[1]])

    s = np.linspace(0.0, 1.0, len(theta))
    most = FEW_NODES if tolerance > 1e-8 else MANY_NODES
    start = np.vstack([theta, kappa, place.T]) * 1.01
    with np.errstate(all="ignore"):
        found = solve_bvp(slope, unmet, s, start, p=force * 1.01, tol=tolerance, max_nodes=most)

    def read() -> Found:
        ends = found.sol(np.array([0.0, 1.0]))
        off = np.abs(unmet(ends[:, 0], ends[:, 1], np.asarray(found.p))).max()
        if found.status != 0 or not off <= UNMET:
            return Found(np.inf, np.full((9, 2), np.nan))
        step = np.diff(found.x)[:, None]
        places = (found.x[:-1, None] + step * (GAUSS[0] + 1.0) / 2.0).ravel()
        bend = found.sol(places)[1].reshape(-1, len(GAUSS[0]))
        energy = float((bend**2 @ GAUSS[1] * step[:, 0] / 2.0).sum() / 2.0)
        return Found(energy, found.sol(np.linspace(0.0, 1.0, 9))[2:].T)

    return read
