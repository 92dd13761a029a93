"""The planar elastica in closed form: the shape of a weightless uniform rod under end loads in a plane.

With n the constant internal force (tension positive), P = |n| per unit EI, omega = sqrt(P) and psi the angle of the
tangent from the direction of -n (the direction of compression), the rod obeys psi'' = -P sin(psi), the equation of a
pendulum. The inflexional branch swings (m < 1):

    psi = 2 asin(k sn u),   kappa = 2 k omega cn u,   u = u0 + omega s,
    x = (2 (E(u) - E(u0)) - (u - u0)) / omega,   y = -(2 k / omega) (cn u - cn u0),

with x along -n and y across it, E(u) Jacobi's epsilon, k = sqrt(m).

Source: A. E. H. Love, A Treatise on the Mathematical Theory of Elasticity, 4th ed., sections 262-263; the formulas
were checked against 26-digit integrations of the differential equation.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cablecad.centreline import Array, ComplexArray, Frames, Placement
from cablecad.rod.elliptic import complete_k, jacobi
from cablecad.rod.jacobian import Jacobian

_FACTORIALS = np.array([[math.factorial(n)] for n in range(20)], dtype=float)


def elastica_derivatives(
    kappa: Array, sine: Array, cosine: Array, force: float | Array, order: int
) -> tuple[Array, ComplexArray]:
    """Derivatives 0..order by arclength of the curvature and of the tangent of any elastica.

    Args:
        kappa: Curvature psi', shape (n,) [1/mm].
        sine: sin(psi), shape (n,).
        cosine: cos(psi), shape (n,).
        force: P, the force per unit EI, one or shape (n,) [1/mm^2].
        order: Highest derivative.

    Returns:
        Of the curvature, by kappa' = -P sin(psi), and of exp(i psi), by its derivative i kappa exp(i psi): a recursion
        for Taylor coefficients, shape (order + 1, n) each.
    """
    # The curvature as complex numbers too: a product of two kinds is taken by way of copies.
    bends, turns = np.zeros((2, order + 1, len(kappa)), dtype=complex)
    bends[0], turns[0].real, turns[0].imag = kappa, cosine, sine
    for n in range(1, order + 1):
        np.multiply(turns[n - 1].imag, -force / n, out=bends[n].real)
        turns[n] = np.einsum("jn,jn->n", turns[n - 1 :: -1], bends[:n]) * (1j / n)
    factorials = _FACTORIALS[: order + 1]
    turns *= factorials
    return bends.real * factorials, turns


def in_own_frame(turns: ComplexArray) -> ComplexArray:
    """Derivatives of the tangent turned to the frame in which the tangent itself is 1, shape (order + 1, n)."""
    turned: ComplexArray = turns * turns[0].conj()
    return turned


@dataclass(frozen=True)
class Inflexional:
    """A stretch of the inflexional elastica, as a piece of a centreline.

    Attributes:
        placement: Origin at the stretch's start; e1 along the compression -n, e3 the axis kappa is signed about.
        length: [mm].
        omega: sqrt(P) [1/mm].
        m: k^2, in (0, 1).
        m1: 1 - m, carried on its own because it may be far below the rounding of m.
        u0: Elliptic argument at the start.

    Accuracy: positions to 4 eps (length + (1 + |u0|) / omega), those across e1 to k times that; tangents to
    8 eps (1 + |u|); measured against mpmath in tests/rod/test_elastica.py. A stretch much shorter than 1 / omega loses
    digits by it.
    """

    placement: Placement
    length: float
    omega: float
    m: float
    m1: float
    u0: float

    @property
    def force(self) -> float:
        """P, the compression per unit EI [1/mm^2]."""
        return self.omega**2

    @property
    def k(self) -> float:
        """The modulus, sqrt(m)."""
        return math.sqrt(self.m)

    @cached_property
    def _jacobian(self) -> Jacobian:
        return Jacobian(self.m, self.m1)

    @cached_property
    def _start(self) -> tuple[float, float]:
        """Jacobi's epsilon and cn at the start."""
        at = jacobi(self.u0, self.m, self.m1)
        return at.epsilon, at.cn

    def frames(self, s: Array) -> Frames:
        """Positions and frames at `s`, shape (n, 3) each."""
        return self._curve(s)[0]

    def states(self, s: Array) -> tuple[Frames, Array]:
        """Positions and frames at `s`, and the curvature, shape (n, 2), in the first of the two components."""
        frames, cn = self._curve(s)
        return frames, np.column_stack([(2.0 * self.k * self.omega) * cn, np.zeros_like(s)])

    def _curve(self, s: Array) -> tuple[Frames, Array]:
        """Frames, and cn, which the curvature is proportional to."""
        advance = self.omega * s
        u = self.u0 + advance
        sn, cn, dn, swing = self._jacobian(u)
        epsilon0, cn0 = self._start
        epsilon = self._jacobian.mean_dn2 * u + self.m * swing
        x = (2.0 * (epsilon - epsilon0) - advance) / self.omega
        y = (-2.0 * self.k / self.omega) * (cn - cn0)
        return self.placement.frames(x, y, dn * dn - self.m * (sn * sn), (2.0 * self.k) * sn * dn), cn

    def bishop(self, s: Array, order: int) -> Array:
        """Derivatives 0..order of the curvature, in the first of the two components."""
        values = np.zeros((order + 1, len(s), 2))
        values[:, :, 0] = self._derivatives(s, order, 1.0)[0]
        return values

    def turns(self, s: Array, order: int) -> ComplexArray:
        """Derivatives 0..order of the tangent by the share of the length, in the frame at `s`, shape (order + 1, n)."""
        return in_own_frame(self._derivatives(s, order, self.length)[1])

    def _derivatives(self, s: Array, order: int, unit: float) -> tuple[Array, ComplexArray]:
        """`elastica_derivatives`, lengths in a unit."""
        sn, cn, dn, _ = self._jacobian(self.u0 + self.omega * s)
        sine, cosine, omega = (2.0 * self.k) * sn * dn, dn * dn - self.m * (sn * sn), self.omega * unit
        return elastica_derivatives((2.0 * self.k * omega) * cn, sine, cosine, omega**2, order)

    def greatest_curvature(self) -> tuple[float, float]:
        """2 k omega where cn u = +-1 inside the stretch, else the greater of the two ends."""
        half_period = 2.0 * float(complete_k(self.m, self.m1))
        crest = math.ceil(self.u0 / half_period - 1e-12) * half_period
        s = (crest - self.u0) / self.omega
        if s <= self.length * (1.0 + 1e-12):
            return 2.0 * self.k * self.omega, min(max(s, 0.0), self.length)
        ends = np.abs(self.bishop(np.array([0.0, self.length]), 0)[0, :, 0])
        i = int(np.argmax(ends))
        return float(ends[i]), (0.0, self.length)[i]
