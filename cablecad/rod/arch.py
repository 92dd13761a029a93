"""The first mode of a rod pinned at both ends, the paper's cable, up to its scale.

With k = sin(beta_0 / 2) and omega = sqrt(F / EI) everything about it is known in closed form:

    length = 2 K / omega        chord = 2 (2 E - K) / omega       rise = 2 k / omega
    bend_radius = 1 / (2 k omega)       force = EI omega^2        angle = 2 asin(k)

so that a datum is either a length times a function of k alone, or a function of k alone (the angle, the slack).

Source: the paper's equations (8)-(20), which were checked in high precision; beta_0 may be anything up to 180 degrees.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

from cablecad.rod.elliptic import complete_2e_minus_k, complete_d, complete_e, complete_k


@dataclass(frozen=True)
class Arch:
    """The first mode of a rod pinned at both ends, up to its scale.

    Attributes:
        m: k^2.
        m1: 1 - m, to its own relative precision.
    """

    m: float
    m1: float

    @classmethod
    def at(cls, t: float) -> Arch:
        """The arch with ln(m / m1) = t."""
        small = math.exp(-abs(t))
        near, far = small / (1.0 + small), 1.0 / (1.0 + small)
        return cls(far, near) if t > 0.0 else cls(near, far)

    @classmethod
    def of_angle(cls, angle: float) -> Arch:
        """The arch whose ends make `angle` with the chord [rad], 0 to pi exclusive."""
        return cls(math.sin(angle / 2.0) ** 2, math.cos(angle / 2.0) ** 2)

    @cached_property
    def k(self) -> float:
        """The modulus, sin(beta_0 / 2)."""
        return math.sqrt(self.m)

    @cached_property
    def K(self) -> float:
        """Complete integral of the first kind."""
        return float(complete_k(self.m, self.m1))

    @cached_property
    def E(self) -> float:
        """Complete integral of the second kind."""
        return float(complete_e(self.m, self.m1))

    @cached_property
    def excess_ratio(self) -> float:
        """(length - chord) / length, to full relative precision however small it is."""
        return 2.0 * self.m * float(complete_d(self.m, self.m1)) / self.K

    @property
    def angle(self) -> float:
        """beta_0 [rad]."""
        return 2.0 * math.atan2(self.k, math.sqrt(self.m1))

    @property
    def energy_ratio(self) -> float:
        """Strain energy times length per EI: 8 K (E - m1 K), formed without cancellation at small m."""
        return 8.0 * self.K * self.m * (self.K - float(complete_d(self.m, self.m1)))

    def size(self, datum: str) -> float:
        """What a length-like datum is in units of 1 / omega."""
        match datum:
            case "length":
                return 2.0 * self.K
            case "chord":
                return 2.0 * float(complete_2e_minus_k(self.m, self.m1))
            case "rise":
                return 2.0 * self.k
            case "bend_radius":
                return 0.5 / self.k
            case "force":
                return 1.0  # sqrt(EI / F) is the unit itself
            case _:
                raise KeyError(datum)


FIGURE_EIGHT = Arch(0.82611476598497033618, 0.17388523401502966382)
"""The arch whose ends meet, 2 E = K: end angle 130.70991070789999 degrees."""

HIGHEST = Arch(0.70132746066310042473, 0.29867253933689957527)
"""The arch with the greatest rise for its length, 0.40314018970565024 of it."""

WIDEST_BEND = Arch(0.35230205567376911206, 0.64769794432623088794)
"""The arch with the greatest chord for its least bend radius, 2.6055682448656876 of it."""
