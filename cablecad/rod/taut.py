"""The taut cable between misaligned clamps: two boundary layers under tension, in closed form.

With psi the angle from the tension n, omega = sqrt(|n|), a and b the values of psi at the ends,

    psi(s) = 4 atan(tan(a/4) exp(-omega s)) + 4 atan(tan(b/4) exp(-omega (1 - s))),

exact but for exp(-omega): from omega = 36 on to rounding. Along and across n the end lies at 1 - 2 S/omega and
2 V/omega, S = 2 - cos(a/2) - cos(b/2), V = sin(a/2) + sin(b/2), and the energy is 2 omega S. Angles are from the chord;
the direction -g of n follows from one scalar equation in which a hair of slack is not subtracted from anything.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

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
    # Every way round for each end: all go through one iteration together.
    options = [
        np.stack([angle, angle - 2.0 * np.pi * np.where(angle > 0.0, 1.0, -1.0)])
        if clamped
        else np.zeros((1, len(angle)))
        for angle, clamped in ((start, start_clamped), (end, end_clamped))
    ]
    fixed_a = np.repeat(options[0], len(options[1]), axis=0)
    fixed_b = np.tile(options[1], (len(options[0]), 1))
    held = float(start_clamped), float(end_clamped)
    # omega < 2 S/excess, were the force along the chord; it turns by a good radian at most.
    reach = [
        np.minimum(np.abs(angle) + 1.0, 2.0 * np.pi) * h for angle, h in zip((fixed_a, fixed_b), held, strict=True)
    ]
    way, scene = np.nonzero(2.0 * _shortening(reach[0], reach[1]) > SEED * excess)
    if not len(scene):
        return Taut(scene, *[np.zeros(0)] * 4)
    excess = excess[scene]
    g, a, b = _direction(fixed_a[way, scene], fixed_b[way, scene], held, excess)
    with np.errstate(divide="ignore", invalid="ignore"):
        omega = 2.0 * _shortening(a, b) / (2.0 * np.sin(g / 2.0) ** 2 + excess * np.cos(g))
    # The other way round is taken where it is not much the longer.
    other_a, other_b = way >= len(options[1]), way % len(options[1]) == 1
    wide = (~other_a | (np.abs(a) < 2.0 * np.pi - _OTHER_WRAP)) & (~other_b | (np.abs(b) < 2.0 * np.pi - _OTHER_WRAP))
    good = wide & (omega > SEED) & np.isfinite(omega)
    return Taut(scene[good], -g[good], omega[good], a[good], b[good])


def _direction(fixed_a: Array, fixed_b: Array, held: tuple[float, float], excess: Array) -> tuple[Array, Array, Array]:
    """Newton's method for g: S d sin(g) = V (2 sin^2(g/2) + excess cos(g)), a = fixed_a + g, b = fixed_b + g."""
    d = 1.0 - excess
    g, last = np.zeros_like(excess), np.full_like(excess, np.inf)
    for i in range(20):
        a, b = (fixed_a + g) * held[0], (fixed_b + g) * held[1]
        s, v = _shortening(a, b), np.sin(a / 2.0) * held[0] + np.sin(b / 2.0) * held[1]
        ds = v / 2.0
        dv = (np.cos(a / 2.0) * held[0] + np.cos(b / 2.0) * held[1]) / 2.0
        sine, cosine = np.sin(g), np.cos(g)
        short = 2.0 * np.sin(g / 2.0) ** 2 + excess * cosine
        f = s * d * sine - v * short
        df = ds * d * sine + s * d * cosine - dv * short - v * d * sine
        step = np.where(np.abs(df) > 1e-300, -f / np.where(df == 0.0, 1.0, df), 0.0)
        step = np.clip(step, -0.5, 0.5)
        g = g + step
        size = np.abs(step)
        # Late steps that no longer halve are rounding.
        if not np.any((size > 1e-16 + 4e-16 * np.abs(g)) & ((i < 6) | (size < 0.5 * last))):
            break
        last = size
    return g, (fixed_a + g) * held[0], (fixed_b + g) * held[1]
