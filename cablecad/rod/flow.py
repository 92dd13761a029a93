"""The exact planar elastica from its state at one point, in every regime by one formula.

With psi the angle of the tangent from the compression -n, p = sin(psi/2), c = cos(psi/2), h = kappa/2 and
omega = sqrt(|n|): p' = h c, c' = -h p, h' = -omega^2 p c, so that W^2 = h^2 + omega^2 p^2 is constant. The addition
theorems of Jacobi's functions carry a state p0, c0, h0 over the arclength s,

    p = (p0 C D + h0 c0 S)/N,  c = (c0 D - p0 h0 S C)/N,  h = (h0 C - omega^2 p0 c0 S D)/N,  N = C^2 + c0^2 omega^2 S^2,

where S, C, D depend on omega, W and s alone: S = sn(omega s, k)/omega, C = cn, D = dn for k = W/omega <= 1
(inflexional), else S = sn(W s, k)/W, C = dn, D = cn for k = omega/W (non-inflexional). Nothing is divided by a
quantity that vanishes in some regime: a circle is omega = 0, a line omega = W = 0, the separatrix k = 1. N is a sum of
squares, so that a cable under tension, whose middle has c0 ~ exp(-omega/2), reaches its ends with all digits.

Source: NIST DLMF 22.8 (addition), 22.7(i) (descending Landen transformation), 22.6 (duplication).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cablecad.rod.trial import Array

CLOSE = 0.05
"""Below this m1, m is close to 1, and the amplitude near pi/2 loses the digits of its cosine."""

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


class _Landen(NamedTuple):
    sn: Array
    cn: Array
    dn: Array
    sine_square: Array  # int m sn^2 du
    cosine_square: Array  # int cn^2 du
    rate: Array  # pi/(2 K): mean slope of the amplitude


def _landen(u: Array, m: Array, m1: Array) -> _Landen:
    """Jacobi's functions by descending Landen steps, m and m1 of shape (n, 1), u of shape (n, k)."""
    a, g = np.ones_like(m), np.sqrt(m1)
    # c_i/m beside c_i: integrals of cn^2 divide by m, and a circle has m = 0.
    ratio = 1.0 / (2.0 * (1.0 + g))
    steps: list[tuple[Array, Array, Array]] = []
    lag = np.zeros_like(m)  # sum 2^(i-1) c_i^2/m
    power = 1.0
    while True:
        a, g = (a + g) / 2.0, np.sqrt(a * g)
        c = m * ratio
        lag = lag + power * c * ratio
        steps.append((c, g, ratio))
        power *= 2.0
        # The next c/m is about c/16 of this one: nothing is left below 1e-16. Eleven steps reach m1 = 1e-100.
        if len(steps) == 14 or not np.any(c > 1e-16):
            break
        ratio = ratio * c / (4.0 * ((a + g) / 2.0))
    phi = power * a * u
    swing = np.zeros_like(u)
    for c, g, ratio in reversed(steps):
        sine, cosine = np.sin(phi), np.cos(phi)
        swing = swing + ratio * sine
        phi = (phi + np.arctan2(c * sine, np.sqrt(g * g + (c * cosine) ** 2))) / 2.0
    sn, cn = np.sin(phi), np.cos(phi)
    sine_square = m * (u * (0.5 + lag) - swing)
    return _Landen(sn, cn, np.sqrt(m1 + m * cn * cn), sine_square, u * (0.5 - lag) + swing, a)


def _double(f: _Landen, m: Array, m1: Array) -> _Landen:
    """The functions of 2u from those of u: sums of positive terms keep cn and dn relative near the separatrix."""
    s2, c2 = f.sn * f.sn, f.cn * f.cn
    below = c2 * (1.0 + s2) + m1 * s2 * s2
    sn = 2.0 * f.sn * f.cn * f.dn / below
    shift = s2 * sn
    return _Landen(
        sn,
        (c2 * c2 - m1 * s2 * s2) / below,
        (c2 * c2 + m1 * s2 * (1.0 + c2)) / below,
        2.0 * f.sine_square + m * shift,
        2.0 * f.cosine_square - shift,
        f.rate,
    )


def doublings(u: float) -> int:
    """How often an argument is halved where m1 < `CLOSE`: to 2.5, where cos(am) still has its digits.

    Each doubling costs a factor of two of them, no more than the argument's own rounding does.
    """
    return max(2, math.ceil(math.log2(max(abs(u), 1e-300) / 2.5)))


def _functions(u: Array, m: Array, m1: Array) -> _Landen:
    """`_landen`, with cn and dn good relative to themselves where m is close to 1."""
    close = m1 < CLOSE
    if not close.any():
        return _landen(u, m, m1)
    count = doublings(float(np.max(np.abs(u[close[:, 0]]))))
    f = _landen(np.where(close, np.ldexp(u, -count), u), m, m1)
    far = f
    for _ in range(count):
        far = _double(far, m, m1)
    return _Landen(*(np.where(close, b, a) for a, b in zip(f, far, strict=True)))


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
    f = _functions(r * s, m, m1)
    S = f.sn / r
    C, D = np.where(swings, f.cn, f.dn), np.where(swings, f.dn, f.cn)
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
    mean = np.sign(h0) * f.rate * (r * s)
    half = np.where(swings, half, half + _TURN * np.rint((mean - half) / _TURN))
    first = np.where(swings, np.arctan2(omega * p0, h0), np.arctan2(p0, c0))
    swung = np.arctan2(omega * p, h) - first
    swung = swung + _TURN * np.rint((f.rate * (r * s) - swung) / _TURN)
    phase = first + np.where(swings, swung, half)
    # s - int cos psi over two, int sin^2(psi/2) = int p^2, less the boundary term of the addition theorem.
    base = np.where(swings, f.sine_square, r * s - f.cosine_square) / r
    square = s - base - p0 * p * S
    along = s - 2.0 * base - 2.0 * p0 * p * S
    # lift - p0^2 S^2 as a product: far out in a layer under tension the two are equal but for exp(-omega s).
    across = 2.0 / below * (p0 * c0 * S * D + h0 * lift * (c0 * c0 - p0 * p0 * C))
    return Jump(2.0 * half, 2.0 * h, p, c, along, across, square, phase)
