"""The non-inflexional branch of the planar elastica in closed form: the pendulum that goes over the top.

With q = 1/m < 1, w = omega sqrt(m) and sg the sense of turning, psi the angle from the direction of -n as in
`cablecad.rod.elastica`,

    psi = 2 sg am v,   kappa = 2 sg w dn v,   v = v0 + w s   (parameter q),
    x = (1 - 2/q) s + (2 / (q w)) (E(v) - E(v0)),   y = -sg (2 / (q w)) (dn v - dn v0).

Both coordinates lose 1/q of their digits as q goes to zero, the circle: there `cablecad.rod.series` takes over.

Source: A. E. H. Love, A Treatise on the Mathematical Theory of Elasticity, 4th ed., section 263.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cablecad.centreline import Array, Frames, Placement
from cablecad.rod.elastica import curvature_derivatives
from cablecad.rod.elliptic import complete_k, jacobi


@dataclass(frozen=True)
class NonInflexional:
    """A stretch of the non-inflexional elastica, as a piece of a centreline.

    Attributes:
        placement: Origin at the stretch's start; e1 along the compression -n, e3 the axis kappa is signed about.
        length: [mm].
        w: omega / sqrt(q), half the greatest curvature [1/mm].
        q: 1/m, in (0, 1).
        q1: 1 - q, carried on its own because it may be far below the rounding of q.
        v0: Elliptic argument at the start.
        sense: +1 or -1, the sign of the curvature.
    """

    placement: Placement
    length: float
    w: float
    q: float
    q1: float
    v0: float
    sense: int

    @property
    def force(self) -> float:
        """P, the force per unit EI [1/mm^2]."""
        return self.q * self.w**2

    @cached_property
    def _start(self) -> tuple[float, float]:
        """Jacobi's epsilon and dn at the start."""
        at = jacobi(self.v0, self.q, self.q1)
        return at.epsilon, at.dn

    def frames(self, s: Array) -> Frames:
        """Positions and frames at `s`, shape (n, 3) each."""
        at = jacobi(self.v0 + self.w * s, self.q, self.q1)
        epsilon0, dn0 = self._start
        factor = 2.0 / (self.q * self.w)
        x = (1.0 - 2.0 / self.q) * s + factor * (at.epsilon - epsilon0)
        y = (-self.sense * factor) * (at.dn - dn0)
        return self.placement.frames(x, y, at.cn**2 - at.sn**2, 2.0 * self.sense * at.sn * at.cn)

    def bishop(self, s: Array, order: int) -> Array:
        """Derivatives 0..order of the curvature, in the first of the two components."""
        at = jacobi(self.v0 + self.w * s, self.q, self.q1)
        sine, cosine = 2.0 * self.sense * at.sn * at.cn, at.cn**2 - at.sn**2
        values = np.zeros((order + 1, len(s), 2))
        kappa = 2.0 * self.sense * self.w * at.dn
        values[:, :, 0] = curvature_derivatives(kappa, sine, cosine, self.force, order)
        return values

    def greatest_curvature(self) -> tuple[float, float]:
        """2 w where dn v = 1 inside the stretch, else the greater of the two ends."""
        half_period = 2.0 * complete_k(self.q, self.q1)
        crest = math.ceil(self.v0 / half_period - 1e-12) * half_period
        s = (crest - self.v0) / self.w
        if s <= self.length * (1.0 + 1e-12):
            return 2.0 * self.w, min(max(s, 0.0), self.length)
        ends = np.abs(self.bishop(np.array([0.0, self.length]), 0)[0, :, 0])
        i = int(np.argmax(ends))
        return float(ends[i]), (0.0, self.length)[i]
