"""Two-point problems of one kind of ends, many scenes, each in the frame of its own chord."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cablecad.rod.trial import Array


@dataclass(frozen=True, slots=True)
class Problem:
    """What is given.

    Attributes:
        start_clamped: Whether the direction at s = 0 is held.
        end_clamped: Whether the direction at s = 1 is held.
        a: Angles from the chord at s = 0, in [-pi, pi], shape (n,); 0 at pins.
        b: Angles at s = 1.
        excess: 1 - chord, shape (n,).
        torsion_ratio: GJ/EI where both ends hold the spin, else None.
        one_point: Both ends are pins at one point. Which way the cable leaves it is free; holding the start's direction
            then fixes the shape and carries no moment, since n has no arm. Only stability tells it from a clamp.
    """

    start_clamped: bool
    end_clamped: bool
    a: Array
    b: Array
    excess: Array
    torsion_ratio: float | None = None
    one_point: bool = False

    @property
    def kind(self) -> tuple[bool, bool]:
        """Which ends are clamps."""
        return self.start_clamped, self.end_clamped

    @property
    def judged(self) -> tuple[bool, bool]:
        """Which ends are clamps to a small motion."""
        return (False, False) if self.one_point else self.kind

    @property
    def targets(self) -> Array:
        """What `polish` brings the ends to, shape (n, 2): angles, or no curvature."""
        return np.stack([self.a, self.b], axis=-1)
