"""Trial functions on [0, 1] in which the second variation of an elastica becomes a matrix.

The functions are integrals of Legendre polynomials on each of a few panels, hats where panels meet, and 1 - s or s at
an end that is free to turn. They are made orthonormal in the plain scalar product int u v ds, so that eigenvalues of
the second variation are those of the boundary value problem and do not depend on the functions chosen. On one panel
44 of them resolve an elastica of omega = sqrt(|n|) up to about 60; sharper layers and loops need panels that get small
towards them: `refine`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cablecad.rod.quadrature import gauss_legendre

Array = NDArray[np.float64]

PANEL_MODES = 12
"""Functions a panel where there are several; each panel then turns by at most `PANEL_TURN`."""

PANEL_TURN = 2.0
"""Largest length x curvature of a panel [rad]: 12 polynomials carry sin and cos over it to 1e-13."""

_POINTS_OVER_MODES = 1.5
"""Gauss points a function: products of three smooth factors stay exact to rounding well before 2."""

_MOST_IN_PRODUCTS = 48
"""Functions up to which their products are kept: 1.4 MB. A single form of more is quicker without them."""


@dataclass(frozen=True, slots=True)
class TrialSpace:
    """Functions orthonormal on [0, 1] at their quadrature nodes.

    Attributes:
        s: Nodes, shape (q,), increasing.
        weights: Quadrature weights, shape (q,), sum 1.
        values: Functions at the nodes, shape (q, m); int v_i v_j ds = delta_ij.
        stiffness: int v_i' v_j' ds, shape (m, m).
        weighted: `values` times the weights, shape (q, m).
        mean: int v_i ds, shape (m,).
        products: Of two functions at each node times its weight, shape (q, m m); None where there are many functions.
    """

    s: Array
    weights: Array
    values: Array
    stiffness: Array
    weighted: Array
    mean: Array
    products: Array | None

    def form(self, potential: Array) -> Array:
        """int v_i' v_j' + potential v_i v_j ds for potentials at the nodes, shape (..., q), as (..., m, m)."""
        if self.products is not None:
            return integrals(self.products, potential, self.stiffness)
        form: Array = self.values.T @ (potential[..., :, None] * self.weighted)
        form += self.stiffness
        return form


def products(functions: Array, weights: Array) -> Array:
    """Of two functions at each node times its weight: `functions` of shape (q, m) give (q, m m); see `integrals`."""
    count = functions.shape[1]
    return np.asarray((functions[:, :, None] * functions[:, None, :] * weights[:, None, None]).reshape(-1, count**2))


def integrals(products: Array, potential: Array, stiffness: Array) -> Array:
    """`stiffness` and int potential v_i v_j ds for potentials at the nodes, shape (..., q), as (..., m, m).

    One product of two matrices for all of them, in half the time of as many small ones.
    """
    form: Array = (potential @ products).reshape(*potential.shape[:-1], *stiffness.shape)
    form += stiffness
    return form


def legendre(s: Array, count: int) -> tuple[Array, Array]:
    """Orthonormal Legendre polynomials of degrees 1 to `count` on [0, 1] and their integrals from 0.

    Returns:
        Polynomials and integrals, each of shape (len(s), count); the integrals vanish at 0 and at 1.
    """
    p = np.polynomial.legendre.legvander(2.0 * s - 1.0, count + 1)
    root = np.sqrt(2.0 * np.arange(1, count + 1) + 1.0)
    return p[:, 1:-1] * root, (p[:, 2:] - p[:, :-2]) / (2.0 * root)


@lru_cache(maxsize=64)
def trial_space(
    start_clamped: bool, end_clamped: bool, breaks: tuple[float, ...] = (0.0, 1.0), modes: int = 44
) -> TrialSpace:
    """Build the trial functions for given ends.

    Args:
        start_clamped: Whether the functions vanish at s = 0.
        end_clamped: Whether they vanish at s = 1.
        breaks: Where panels meet, from 0 to 1, increasing.
        modes: Integrated polynomials a panel.
    """
    node, weight = gauss_legendre(int(np.ceil(_POINTS_OVER_MODES * modes)) + 4)
    polynomial, integral = legendre(node, modes)
    panels, points = len(breaks) - 1, len(node)
    width = np.diff(np.asarray(breaks))
    s = np.concatenate([a + h * node for a, h in zip(breaks[:-1], width, strict=True)])
    weights = np.concatenate([h * weight for h in width])
    values = np.zeros((panels * points, panels * modes + panels + 1))
    slopes = np.zeros_like(values)
    for i, h in enumerate(width):
        rows = slice(i * points, (i + 1) * points)
        own = slice(i * modes, (i + 1) * modes)
        values[rows, own], slopes[rows, own] = integral, polynomial / h
        left = panels * modes + i
        values[rows, left], slopes[rows, left] = 1.0 - node, -1.0 / h
        values[rows, left + 1], slopes[rows, left + 1] = node, 1.0 / h
    first, last = panels * modes + (1 if start_clamped else 0), panels * modes + panels + (0 if end_clamped else 1)
    kept = np.r_[0 : panels * modes, first:last]
    values, slopes = values[:, kept], slopes[:, kept]
    # QR of the weighted values rather than Cholesky of their Gram matrix: half the digits would go there.
    root = np.sqrt(weights)[:, None]
    triangle = np.linalg.qr(root * values)[1]
    values = np.linalg.solve(triangle.T, values.T).T
    slopes = np.linalg.solve(triangle.T, slopes.T).T
    weighted = weights[:, None] * values
    both = products(values, weights) if values.shape[1] <= _MOST_IN_PRODUCTS else None
    return TrialSpace(s, weights, values, (slopes.T * weights) @ slopes, weighted, weights @ values, both)


def refine(
    curvature: Callable[[Array], Any], *, omega: float = 0.0, breaks: Sequence[float] = (0.0, 1.0)
) -> tuple[float, ...]:
    """Halve panels until each turns little; they get small towards loops and boundary layers and nowhere else.

    Args:
        curvature: kappa at an array of arclengths, in units of 1/L.
        omega: sqrt(|n|): panels are at least 4/omega^2 long, which ends the halving at a kink in the data.
        breaks: Panels to begin with.
    """
    shares = np.concatenate([[0.0], gauss_legendre(7)[0], [1.0]])
    starts, ends = np.asarray(breaks[:-1], dtype=float), np.asarray(breaks[1:], dtype=float)
    done: list[float] = [float(breaks[0])]
    least = min(1e-3, 4.0 / (1.0 + omega) ** 2)
    while len(starts):
        width = ends - starts
        inside = starts[:, None] + width[:, None] * shares
        bend = np.abs(np.asarray(curvature(inside.ravel()))).reshape(inside.shape).max(axis=1)
        split = (width > least) & (width * bend > PANEL_TURN)
        done += ends[~split].tolist()
        starts, ends, middle = starts[split], ends[split], ((starts + ends) / 2.0)[split]
        starts, ends = np.concatenate([starts, middle]), np.concatenate([middle, ends])
    return tuple(sorted(done))
