"""The same curves by Gauss-Legendre quadrature: the paper's own evaluation, and a check on every closed form.

Two rules. `gauss_incomplete` spreads n nodes over the whole amplitude [0, phi], as the paper does in its equations (15)
to (20), and `pinned_points` makes its pinned cable of them. The error falls like rho^(-2 n), where rho belongs to the
integrand's nearest singularity, phi = pi/2 + i arcosh(1/k): quick for a slack arch, useless as k goes to 1 (measured
over a quarter wave in ``test_error_by_number_of_nodes``; 8 nodes leave 3e-12 at m = 0.117, 5e-4 at m = 0.97).
At given phi 8 nodes take about the time `cablecad.rod.elliptic` takes to be exact to rounding; at given arclength,
where Newton's method has to find phi first, ten times that. It stays for the report of speed against error.

`integrate_tangent` integrates any plane curve from its tangent angle, panel by panel. It knows nothing of elasticity.

Source: the paper is "Physical modeling and deformation simulation of flexible cable under the plane constraint"; there
k = sin(beta_0/2) is the modulus, so m = k^2, and Omega = sqrt(F_0/EI).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cablecad.errors import UsageError

Array = NDArray[np.float64]

_HALF_TURN = math.pi / 2.0

# Bisection alone narrows [0, pi/2] to one unit of rounding in 53 halvings; Newton's steps only shorten this.
_MOST_STEPS = 54

# The rule's sum is itself rounded by a few eps; steps below 8 eps only follow that noise.
_SETTLED = 8.0 * 2.0**-52


@lru_cache(maxsize=64)
def gauss_legendre(nodes: int) -> tuple[Array, Array]:
    """Nodes and weights of the Gauss-Legendre rule on [0, 1], exact for polynomials of degree 2 nodes - 1.

    Args:
        nodes: Number of nodes, 1 or more; numpy's rule is tested to 100.

    Returns:
        Nodes, ascending, and weights; read-only, for they are shared by all callers.

    Raises:
        UsageError: nodes < 1.
    """
    if nodes < 1:
        message = f"nodes = {nodes}: a quadrature rule needs 1 node or more"
        raise UsageError(message)
    x, w = np.polynomial.legendre.leggauss(nodes)
    rule = 0.5 * (1.0 + x), 0.5 * w
    for array in rule:
        array.flags.writeable = False
    return rule


def gauss_incomplete(phi: ArrayLike, m: float, m1: float, *, nodes: int) -> tuple[Array, Array]:
    """F(phi | m) and E(phi | m) by one rule over [0, phi]: the integrals of the paper's equation (19).

    Args:
        phi: Amplitude; beyond a quarter turn the rule still holds but needs ever more nodes [rad].
        m: Parameter in [0, 1].
        m1: 1 - m.
        nodes: Nodes of the rule.

    Returns:
        F and E, of the shape of phi.
    """
    phi = np.asarray(phi, dtype=np.float64)
    x, w = gauss_legendre(nodes)
    delta = _delta(phi[..., np.newaxis] * x, m, m1)
    return phi * ((1.0 / delta) @ w), phi * (delta @ w)


def gauss_amplitude(u: ArrayLike, m: float, m1: float, *, nodes: int) -> Array:
    """The amplitude am(u | m), by Newton's method on the n-node F(phi) = u: the paper's equations (16) and (17).

    Args:
        u: Argument, |u| <= K; beyond the rule's own quarter period the answer is a quarter turn.
        m: Parameter in [0, 1].
        m1: 1 - m.
        nodes: Nodes of the rule for F.

    Returns:
        phi in [-pi/2, pi/2], of the shape of u [rad]. It solves the n-node equation to rounding; the error against the
        true amplitude is that of the rule.
    """
    u = np.asarray(u, dtype=np.float64)
    x, w = gauss_legendre(nodes)
    target = np.abs(u)
    low, high = np.zeros_like(target), np.full_like(target, _HALF_TURN)
    phi = np.minimum(target, _HALF_TURN)  # F(phi) >= phi: the answer lies below
    for _ in range(_MOST_STEPS):
        angle = phi[..., np.newaxis] * x
        integrand = 1.0 / _delta(angle, m, m1)
        gap = phi * (integrand @ w) - target
        # The derivative of the rule itself, not the integrand it stands for: with few nodes they differ by far.
        slope = (integrand + angle * (0.5 * m) * np.sin(2.0 * angle) * integrand**3) @ w
        low, high = np.where(gap < 0.0, phi, low), np.where(gap > 0.0, phi, high)
        newton = phi - gap / slope
        trial = np.where((newton >= low) & (newton <= high), newton, 0.5 * (low + high))
        settled = np.abs(trial - phi) <= _SETTLED * trial
        phi = trial
        if settled.all():
            break
    return np.asarray(np.copysign(phi, u))


def pinned_points(phi: ArrayLike, m: float, m1: float, omega: float, *, nodes: int) -> Array:
    """Points of the paper's pinned cable at amplitudes phi: y by its equation (13), z by (20).

    The origin is the middle of the chord's line, z along the chord; phi = 0 is mid-span and -pi/2, pi/2 are the ends.
    At arclength s from mid-span phi is ``gauss_amplitude(omega * s, m, m1, nodes=nodes)``.

    Args:
        phi: Amplitude [rad].
        m: k^2, k = sin(beta_0/2) with beta_0 the end angle.
        m1: 1 - m.
        omega: sqrt(F_0/EI), the paper's Omega [1/mm].
        nodes: Nodes of the rule.

    Returns:
        (y, z) along the last axis, after the shape of phi [mm].
    """
    f_phi, e_phi = gauss_incomplete(phi, m, m1, nodes=nodes)
    y = (2.0 * math.sqrt(m) / omega) * np.cos(phi)
    return np.stack([y, (2.0 * e_phi - f_phi) / omega], axis=-1)


def integrate_tangent(angle: Callable[[Array], Array], s: ArrayLike, *, nodes: int = 16, panels: int = 4) -> Array:
    """Positions of a plane curve by integrating its tangent (cos angle, sin angle).

    Each interval between successive `s` is cut into `panels` equal panels with one Gauss-Legendre rule each; the error
    falls with order 2 nodes in the panel's length while the angle is smooth inside the intervals. Put an `s` at every
    break of the curvature.

    Args:
        angle: Tangent angle at an array of arclengths of any shape, of that shape [rad].
        s: Arclengths, shape (n,), n >= 1; need not be equally spaced nor ascending [mm].
        nodes: Nodes a panel.
        panels: Panels between successive `s`.

    Returns:
        Positions relative to the point at s[0], shape (n, 2) [mm].

    Raises:
        UsageError: nodes or panels < 1, or s empty or not one row.

    Accuracy: rounding, about eps times the length, once the panels resolve the angle: ``test_orders_of_the_panels``.
    """
    s = np.asarray(s, dtype=np.float64)
    if s.ndim != 1 or s.size == 0:
        message = f"s has shape {s.shape}: give a row of one arclength or more"
        raise UsageError(message)
    if panels < 1:
        message = f"panels = {panels}: an interval needs 1 panel or more"
        raise UsageError(message)
    x, w = gauss_legendre(nodes)
    within = (np.arange(panels)[:, np.newaxis] + x).ravel() / panels
    step = np.diff(s)
    theta = angle(s[:-1, np.newaxis] + step[:, np.newaxis] * within)
    weights = np.tile(w / panels, panels)
    points = np.zeros((s.size, 2))
    np.cumsum(step * (np.cos(theta) @ weights), out=points[1:, 0])
    np.cumsum(step * (np.sin(theta) @ weights), out=points[1:, 1])
    return points


def _delta(angle: Array, m: float, m1: float) -> Array:
    """sqrt(1 - m sin^2), written as a sum so that it keeps its digits near a quarter turn."""
    return np.asarray(np.sqrt(m1 + m * np.cos(angle) ** 2))
