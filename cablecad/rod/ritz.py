"""A rod between two points over Legendre modes, and Newton's method towards its equilibria; `descent` goes before it.

theta(s) = a0 (1 - s) + a1 s + sum c_j B_j(s), B_j the integrals of orthonormal Legendre polynomials, so that the energy
is (a1 - a0)^2/2 + |c|^2/2. Angles are from the chord; the end is then met where

    int 2 sin^2(theta/2) ds = excess,   int sin(theta) ds = 0,

which keeps all digits of a hair of slack. With multipliers (n_x, -n_y) the Lagrangian's Hessian is the energy's plus
int (n.t) phi_i phi_j ds. a0 and a1 are given at a clamp and unknown at a pin.

Rows of arrays are independent problems: scenes, windings and starts go through one iteration together.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from cablecad.rod.quadrature import gauss_legendre
from cablecad.rod.trial import Array, integrals, legendre, products

CAP = 1.0
"""Largest change of an angle in one step [rad]; beyond it the quadratic model of sin and cos means nothing."""

SETTLED = 1e-5
"""Last relative change of the angles. The next one is its square, less than the modes themselves leave."""

_SETTLED_SMALL = 1e-7
"""That of small angles, whose square is rounding: their energy has no other source."""

_BLOCK = 128
"""Systems set up and solved at once: their matrices, 1 MB, keep to memory that is there already. With all of 400 at
once new memory takes as long as the arithmetic."""

SIGNS = np.array([1.0, -1.0])
"""From the multipliers to the force (n_x, n_y), and back."""


@dataclass(frozen=True, slots=True)
class Ritz:
    """The functions of a discretisation at its quadrature nodes.

    Attributes:
        s: Gauss nodes, shape (q,).
        weights: Gauss weights, shape (q,).
        functions: 1 - s, s and the modes at the nodes, shape (q, m + 2).
        halves: Half of `functions`, transposed: half the angles are what cos(theta) - 1 needs.
        stiffness: Of the energy, shape (m + 2, m + 2).
        free: Indices of the unknowns: the modes, and a0, a1 where they are pins.
        middle: Functions at s = 1/2, and in the second row their slopes, shape (2, m + 2).
        bending: The stiffness of the unknowns, shape (d, d).
        products: Of two unknowns' functions at each node times its weight, shape (q, d d).
    """

    s: Array
    weights: Array
    functions: Array
    halves: Array
    stiffness: Array
    free: np.ndarray
    middle: Array
    bending: Array
    products: Array


@lru_cache(maxsize=32)
def ritz(start_clamped: bool, end_clamped: bool, modes: int) -> Ritz:
    """The discretisation for given ends; 1.5 Gauss points a mode and a few integrate sin(theta) as well as theta."""
    s, weights = gauss_legendre((3 * modes) // 2 + 6)
    _, modal = legendre(s, modes)
    half = np.array([0.5])
    slopes, values = legendre(half, modes)
    functions = np.column_stack([1.0 - s, s, modal])
    middle = np.stack([np.r_[0.5, 0.5, values[0]], np.r_[-1.0, 1.0, slopes[0]]])
    stiffness = np.eye(modes + 2)
    stiffness[0, 1] = stiffness[1, 0] = -1.0
    ends = [i for i, clamped in enumerate((start_clamped, end_clamped)) if not clamped]
    free = np.array([*ends, *range(2, modes + 2)])
    return Ritz(
        s,
        weights,
        functions,
        functions.T / 2.0,
        stiffness,
        free,
        middle,
        stiffness[np.ix_(free, free)],
        products(functions[:, free], weights),
    )


def gap(space: Ritz, z: Array, excess: Array) -> tuple[Array, Array, Array]:
    """sin(theta), cos(theta) at the nodes, shape (n, q), and what is missing at the end, shape (n, 2)."""
    half = z @ space.halves
    s = np.sin(half)
    sine, short = np.sin(2.0 * half), 2.0 * s * s
    miss = np.empty((len(z), 2))
    miss[:, 0], miss[:, 1] = short @ space.weights - excess, sine @ space.weights
    return sine, 1.0 - short, miss


def hessian(space: Ritz, tension: Array) -> Array:
    """Hessian of the Lagrangian in the unknowns, from n.t at the nodes, shape (n, d, d)."""
    return integrals(space.products, tension, space.bending)


def respond(space: Ritz, force: Array, sine: Array, cosine: Array) -> tuple[Array, Array]:
    """The equations of a small change of elastica, for all right sides one may ask for.

    Args:
        space: The discretisation.
        force: Shape (n, 2).
        sine: sin(theta) at the nodes, by `gap`, shape (n, q).
        cosine: Likewise.

    Returns:
        Matrix of the bordered system, shape (n, d + 2, d + 2), for unknowns (free z, n_x, -n_y), and tension n.t at
        the nodes.
    """
    functions = space.functions[:, space.free]
    tension = force[:, :1] * cosine + force[:, 1:] * sine
    d = len(space.free)
    system = np.zeros((len(force), d + 2, d + 2))
    system[:, :d, :d] = hessian(space, tension)
    system[:, d, :d] = (sine * space.weights) @ functions
    system[:, d + 1, :d] = (cosine * space.weights) @ functions
    system[:, :d, d:] = np.swapaxes(system[:, d:, :d], 1, 2)
    return system, tension


def newton(
    space: Ritz,
    z: Array,
    force: Array,
    excess: Array,
    *,
    iterations: int = 12,
    contraction: float = np.inf,
    settled: float = SETTLED,
) -> tuple[Array, Array, Array]:
    """Newton's method on the stationarity conditions, towards whatever equilibrium is near.

    Args:
        space: The discretisation.
        z: Near solutions, shape (n, m + 2).
        force: Their forces, shape (n, 2).
        excess: 1 - chord, shape (n,).
        iterations: At most so many. Where two branches are about to meet each step only halves the last: of 1000 random
            scenes 8 found 2307 stable equilibria, 12 found 2312, 16 found 2315 in a tenth more time.
        contraction: A step longer than this of the one before ends a row without convergence: it was not near.
        settled: Last relative change of the angles that is asked for.

    Returns:
        z, force, and the last relative change of the angles, shape (n,): above `settled` it did not converge.
    """
    parts = [
        _newton_on(space, z[own], force[own], excess[own], iterations, contraction, settled) for own in blocks(len(z))
    ]
    z, force, change = (np.concatenate(part) for part in zip(*parts, strict=True))
    return z, force, change


def blocks(count: int) -> list[slice]:
    """So many systems in blocks; one block at least."""
    return [slice(low, low + _BLOCK) for low in range(0, max(count, 1), _BLOCK)]


def _newton_on(
    space: Ritz, z: Array, force: Array, excess: Array, iterations: int, contraction: float, settled: float
) -> tuple[Array, Array, Array]:
    """`newton` for one block."""
    z, force = z.copy(), force.copy()
    functions = space.functions[:, space.free]
    d = len(space.free)
    change = np.full(len(z), np.inf)
    rows, last = np.arange(len(z)), np.full(len(z), np.inf)
    for _ in range(iterations):
        sine, cosine, miss = gap(space, z[rows], excess[rows])
        system, _ = respond(space, force[rows], sine, cosine)
        lam = force[rows] * SIGNS
        slope = (z[rows] @ space.stiffness)[:, space.free] + (lam[:, None, :] @ system[:, d:, :d])[:, 0]
        right = -np.concatenate([slope, miss], axis=1)
        step = solve(system, right[:, :, None])[:, :, 0]
        bend = np.max(np.abs(step[:, :d] @ functions.T), axis=1)
        if np.isfinite(contraction):
            near = bend <= contraction * last[rows]
            change[rows[~near]] = np.inf
            rows, step, bend = rows[near], step[near], bend[near]
            last[rows] = bend
            if not len(rows):
                break
        shrink = np.minimum(1.0, CAP / np.maximum(bend, 1e-300))[:, None]
        moved = z[rows]
        moved[:, space.free] += shrink * step[:, :d]
        z[rows] = moved
        force[rows] += shrink * step[:, d:] * SIGNS
        scale = np.minimum(1.0, np.max(np.abs(moved @ space.functions.T), axis=1))
        change[rows] = bend / np.maximum(scale, 1e-300)
        rows = rows[change[rows] > np.where(scale < 0.5, _SETTLED_SMALL, settled)]
        if not len(rows):
            break
    return z, force, change


def solve(system: Array, right: Array) -> Array:
    """Solve many systems; a singular one gives zeros instead of ending the batch."""
    try:
        return np.asarray(np.linalg.solve(system, right), dtype=np.float64)
    except np.linalg.LinAlgError:
        out = np.zeros_like(right)
        for i in range(len(system)):
            try:
                out[i] = np.linalg.solve(system[i], right[i])
            except np.linalg.LinAlgError:
                continue
        return out
