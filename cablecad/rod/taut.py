"""The taut cable between misaligned clamps: two boundary layers under tension, in closed form.

With psi the angle from the tension n, omega = sqrt(|n|), a and b the values of psi at the ends,

    psi(s) = 4 atan(tan(a/4) exp(-omega s)) + 4 atan(tan(b/4) exp(-omega (1 - s))),

exact but for exp(-omega): from omega = 36 on to rounding. Along and across n the end lies at 1 - 2 S/omega and
2 V/omega, S = 2 - cos(a/2) - cos(b/2), V = sin(a/2) + sin(b/2), and the energy is 2 omega S. Angles are from the chord;
the direction -g of n follows from one scalar equation in which a hair of slack is not subtracted from anything.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from cablecad.rod.trial import Array

EXACT = 36.0
"""exp(-36) = 2e-16."""

SEED = 14.0
"""From here on the closed form is close enough to start Newton's method from."""

_OTHER_WRAP = 2.2
"""Ends turned further than this from the force may as well go round the other way [rad]."""


@dataclass(frozen=True, slots=True)
class Taut:
    """Taut cables, arrays of shape (n,).

    Attributes:
        scene: Which scene each belongs to.
        direction: Angle of n from the chord.
        omega: sqrt(|n|).
        a, b: Angle from n at the start and the end, in (-2 pi, 2 pi).
    """

    scene: np.ndarray
    direction: Array
    omega: Array
    a: Array
    b: Array

    @property
    def energy(self) -> Array:
        """Bending energy."""
        value: Array = 2.0 * self.omega * _shortening(self.a, self.b)
        return value

    def psi(self, s: Array) -> Array:
        """Angle from n at arclengths `s`, shape (k,) -> (n, k)."""
        w = self.omega[:, None]
        left = np.arctan(np.tan(self.a / 4.0)[:, None] * np.exp(-w * s))
        value: Array = 4.0 * (left + np.arctan(np.tan(self.b / 4.0)[:, None] * np.exp(-w * (1.0 - s))))
        return value

    def curvature(self, s: Array) -> Array:
        """psi' at arclengths `s`; each layer has psi' = -+2 omega sin(psi/2)."""
        w = self.omega[:, None]
        left = 4.0 * np.arctan(np.tan(self.a / 4.0)[:, None] * np.exp(-w * s))
        right = 4.0 * np.arctan(np.tan(self.b / 4.0)[:, None] * np.exp(-w * (1.0 - s)))
        value: Array = 2.0 * w * (np.sin(right / 2.0) - np.sin(left / 2.0))
        return value

    def position(self, s: Array) -> tuple[Array, Array]:
        """Along and across n from the start at arclengths `s`, each of shape (n, k)."""
        w = self.omega[:, None]
        left = 2.0 * np.arctan(np.tan(self.a / 4.0)[:, None] * np.exp(-w * s))
        right = 2.0 * np.arctan(np.tan(self.b / 4.0)[:, None] * np.exp(-w * (1.0 - s)))
        a = self.a[:, None] / 2.0
        # 1 - cos as a product, so that small angles keep their digits.
        short = np.sin((a + left) / 2.0) * np.sin((a - left) / 2.0) + np.sin(right / 2.0) ** 2
        return s - 4.0 / w * short, 2.0 / w * (np.sin(a) - np.sin(left) + np.sin(right))

    def among(self, scenes: np.ndarray) -> Taut:
        """The same with `scenes[i]` for scene i."""
        return Taut(scenes[self.scene], self.direction, self.omega, self.a, self.b)

    def take(self, index: np.ndarray) -> Taut:
        """Some of them."""
        return Taut(*(getattr(self, f.name)[index] for f in fields(self)))

    def margins(self) -> tuple[Array, Array]:
        """Least eigenvalues in and out of the plane, but for a relative 1/omega.

        Each layer is the Poeschl-Teller well omega^2 (1 - l (l + 1) sech^2), l = 1 in the plane and 2 out of it, cut
        off where the clamp is: sinh-like bound states omega^2 (1 - q^2), with T = tanh of the clamp's place in it.
        """
        inside, outside = [], []
        for end in (self.a, self.b):
            # tan(|a|/4) = exp(-y): y > 0 up to a turned by pi, T = tanh y = cos(a/2).
            t = np.cos(end / 2.0)
            inside.append(1.0 - np.minimum(t, 0.0) ** 2)
            q = np.maximum((np.sqrt(np.maximum(4.0 - 3.0 * t * t, 0.0)) - 3.0 * t) / 2.0, 0.0)
            outside.append(1.0 - q * q)
        w2 = self.omega**2
        return w2 * np.minimum(*inside), w2 * np.minimum(*outside)


def _shortening(a: Array, b: Array) -> Array:
    value: Array = 2.0 * (np.sin(a / 4.0) ** 2 + np.sin(b / 4.0) ** 2)
    return value


def wrap(angle: Array) -> Array:
    """The angle in [-pi, pi]; pi stays pi."""
    value: Array = angle - 2.0 * np.pi * np.rint(angle / (2.0 * np.pi))
    return value


def taut(start: Array, end: Array, start_clamped: bool, end_clamped: bool, excess: Array) -> Taut:
    """All taut cables with omega > `SEED`.

    Args:
        start: Angle from the chord at s = 0, in [-pi, pi], shape (n,); not read at a pin.
        end: Angle at s = 1.
        start_clamped: Whether the start's direction is held; a pin has no layer.
        end_clamped: Whether the end's direction is held.
        excess: 1 - chord/length, in (0, 1].
    """
    held = np.array([start_clamped, end_clamped])
    found: list[tuple[Any, ...]] = []
    for other_a in (0.0, 1.0) if start_clamped else (0.0,):
        for other_b in (0.0, 1.0) if end_clamped else (0.0,):
            # omega < 2 S/excess, were the force along the chord; it turns by a good radian at most.
            reach = [
                np.where(h, (2.0 * np.pi - np.abs(angle) if other else np.abs(angle)) + 1.0, 0.0)
                for h, angle, other in ((held[0], start, other_a), (held[1], end, other_b))
            ]
            bound = 2.0 * _shortening(*(np.minimum(r, 2.0 * np.pi) for r in reach))
            near = np.flatnonzero(bound > SEED * excess)
            g, a, b = _direction(start[near], end[near], held, excess[near], other_a, other_b)
            s = _shortening(a, b)
            with np.errstate(divide="ignore", invalid="ignore"):
                omega = 2.0 * s / (2.0 * np.sin(g / 2.0) ** 2 + excess[near] * np.cos(g))
            wide = np.ones(len(near), dtype=bool)
            for other, end_angle in ((other_a, a), (other_b, b)):
                if other:
                    wide &= np.abs(end_angle) < 2.0 * np.pi - _OTHER_WRAP
            good = wide & (omega > SEED) & np.isfinite(omega)
            found.append((near[good], -g[good], omega[good], a[good], b[good]))
    joined = [np.concatenate(parts) for parts in zip(*found, strict=True)] if found else [np.zeros(0)] * 5
    return Taut(joined[0].astype(int), *joined[1:])


def _direction(
    start: Array, end: Array, held: np.ndarray, excess: Array, other_a: float, other_b: float
) -> tuple[Array, Array, Array]:
    """Newton's method for g: S d sin(g) = V (2 sin^2(g/2) + excess cos(g)), a = start + g, b = end + g."""
    d = 1.0 - excess
    turn_a = 2.0 * np.pi * np.where(start > 0.0, -other_a, other_a) * held[0]
    turn_b = 2.0 * np.pi * np.where(end > 0.0, -other_b, other_b) * held[1]
    fixed_a, fixed_b = (start + turn_a), (end + turn_b)
    g = np.zeros_like(excess)
    for _ in range(20):
        a, b = (fixed_a + g) * held[0], (fixed_b + g) * held[1]
        s, v = _shortening(a, b), np.sin(a / 2.0) * held[0] + np.sin(b / 2.0) * held[1]
        ds = v / 2.0
        dv = (np.cos(a / 2.0) * held[0] + np.cos(b / 2.0) * held[1]) / 2.0
        short = 2.0 * np.sin(g / 2.0) ** 2 + excess * np.cos(g)
        f = s * d * np.sin(g) - v * short
        df = ds * d * np.sin(g) + s * d * np.cos(g) - dv * short - v * d * np.sin(g)
        step = np.where(np.abs(df) > 1e-300, -f / np.where(df == 0.0, 1.0, df), 0.0)
        step = np.clip(step, -0.5, 0.5)
        g = g + step
        if not np.any(np.abs(step) > 1e-16 + 4e-16 * np.abs(g)):
            break
    return g, (fixed_a + g) * held[0], (fixed_b + g) * held[1]
