"""The exact planar elastica from its state at one point, in every regime by one formula.

With psi the angle of the tangent from the compression -n, p = sin(psi/2), c = cos(psi/2), h = kappa/2 and
omega = sqrt(|n|): p' = h c, c' = -h p, h' = -omega^2 p c, so that W^2 = h^2 + omega^2 p^2 is constant. The addition
theorems of Jacobi's functions carry a state p0, c0, h0 over the arclength s,

    p = (p0 C D + h0 c0 S)/N,  c = (c0 D - p0 h0 S C)/N,  h = (h0 C - omega^2 p0 c0 S D)/N,  N = C^2 + c0^2 omega^2 S^2,

where S, C, D depend on omega, W and s alone: S = sn(omega s, k)/omega, C = cn, D = dn for k = W/omega <= 1
(inflexional), else S = sn(W s, k)/W, C = dn, D = cn for k = omega/W (non-inflexional). Nothing is divided by a
quantity that vanishes in some regime: a circle is omega = 0, a line omega = W = 0, the separatrix k = 1. N is a sum of
squares, so that a cable under tension, whose middle has c0 ~ exp(-omega/2), reaches its ends with all digits.

Source: NIST DLMF 22.8 (addition).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cablecad.rod.jacobian import Jacobian
from cablecad.rod.trial import Array

_TURN = 2.0 * np.pi


class Jump(NamedTuple):
    """What lies between a state and the points at arclengths `s` from it, arrays of shape (n, k).

    Attributes:
        turn: theta(s) - theta(0), counted over full turns [rad].
        kappa: Curvature at s.
        p, c: sin and cos of half the angle psi at s.
        along, across: Position relative to the state's, along the compression and 90 degrees ahead of it.
        square: int c^2 ds, from which the energy follows under tension.
        phase: Of a swing (omega p, kappa/2) the polar angle, of a revolution half the angle psi, counted from the
            state's own without jumps: the curvature vanishes where a swing's cosine does, p where the sine does.
    """

    turn: Array
    kappa: Array
    p: Array
    c: Array
    along: Array
    across: Array
    square: Array
    phase: Array

    def take(self, index: np.ndarray) -> Jump:
        """Some of the states' rows."""
        return Jump(*(value[index] for value in self))


def jump(p0: Array, c0: Array, kappa0: Array, omega: Array, s: Array) -> Jump:
    """Carry states along their elasticas.

    Args:
        p0: sin(psi/2) of n states, shape (n,).
        c0: cos(psi/2), shape (n,); not negative, so that psi is in [-pi, pi].
        kappa0: Curvature, shape (n,).
        omega: sqrt(|n|), shape (n,).
        s: Arclengths from the states, of either sign, shape (k,) or (n, k).

    Accuracy: 1e-15 (1 + omega |s|) absolute in positions and angles; under tension also relative in the distance of
        the angle from that of n. tests/rod/test_flow.py.
    """
    p0, c0, omega, h0 = p0[:, None], c0[:, None], omega[:, None], kappa0[:, None] / 2.0
    o2 = omega * omega
    w2 = h0 * h0 + o2 * p0 * p0
    gap = (omega * c0 - np.abs(h0)) * (omega * c0 + np.abs(h0))  # omega^2 - W^2 without losing its digits
    swings = gap >= 0.0
    r2 = np.where(swings, o2, w2)
    # A line has r = 0, and then any scale does.
    r = np.sqrt(np.where(r2 > 1e-200, r2, 1e-200))
    m = np.where(swings, w2, o2) / (r * r)
    # The separatrix is met only within rounding: 1e-100 is as good as 0 and lets the means converge.
    # A line has m1 = 1.
    m1 = np.where(r2 > 1e-200, np.maximum(np.abs(gap) / (r * r), 1e-100), 1.0)
    f = Jacobian(m, m1)
    u = r * s
    sn, cn, dn, swing = f(u)
    S = sn / r
    C, D = np.where(swings, cn, dn), np.where(swings, dn, cn)
    below = C * C + c0 * c0 * o2 * S * S
    p = (p0 * C * D + h0 * c0 * S) / below
    c = (c0 * D - p0 * h0 * S * C) / below
    h = (h0 * C - o2 * p0 * c0 * S * D) / below
    # (1 - C)/omega^2, where 1 - C cancels for small omega and 1 + C vanishes at half a period.
    positive = C >= 0.0
    lift = np.where(positive, S * S / np.where(positive, 1.0 + C, 1.0), (1.0 - C) / np.where(positive, 1.0, o2))
    half_sine = (h0 * S * (c0 * c0 + p0 * p0 * C) - p0 * c0 * D * o2 * lift) / below
    half_cosine = (D * (c0 * c0 + p0 * p0 * C) + p0 * c0 * h0 * S * (o2 * lift)) / below
    half = np.arctan2(half_sine, half_cosine)
    # Beyond a full turn only the non-inflexional branch goes; its amplitude strays less than pi from the mean slope.
    mean = np.sign(h0) * f.rate * u
    half = np.where(swings, half, half + _TURN * np.rint((mean - half) / _TURN))
    first = np.where(swings, np.arctan2(omega * p0, h0), np.arctan2(p0, c0))
    swung = np.arctan2(omega * p, h) - first
    swung = swung + _TURN * np.rint((f.rate * u - swung) / _TURN)
    phase = first + np.where(swings, swung, half)
    # s - int cos psi over two, int sin^2(psi/2) = int p^2, less the boundary term of the addition theorem.
    base = np.where(swings, m * (f.mean_sn2 * u - swing), u - (f.mean_cn2 * u + swing)) / r
    square = s - base - p0 * p * S
    along = s - 2.0 * base - 2.0 * p0 * p * S
    # lift - p0^2 S^2 as a product: far out in a layer under tension the two are equal but for exp(-omega s).
    across = 2.0 / below * (p0 * c0 * S * D + h0 * lift * (c0 * c0 - p0 * p0 * C))
    return Jump(2.0 * half, 2.0 * h, p, c, along, across, square, phase)
