"""The pinned elastica by mpmath at 50 digits: an implementation of its own, by Fourier-free closed forms of mpmath."""

from __future__ import annotations

import mpmath as mp
import numpy as np

mp.mp.dps = 50


class PinnedOracle:
    """First mode of length L and modulus k, start at the origin, chord along +x, arch towards +y."""

    def __init__(self, length: float, *, m: mp.mpf | None = None, angle_deg: float | None = None) -> None:
        self.length = mp.mpf(length)
        self.m = mp.sin(mp.radians(mp.mpf(angle_deg)) / 2) ** 2 if m is None else mp.mpf(m)
        self.k = mp.sqrt(self.m)
        self.K, self.E = mp.ellipk(self.m), mp.ellipe(self.m)
        self.omega = 2 * self.K / self.length

    @property
    def data(self) -> dict[str, mp.mpf]:
        """Every datum of the cable; the force is per unit EI."""
        chord = (4 * self.E - 2 * self.K) / self.omega
        return {
            "length": self.length,
            "chord": chord,
            "rise": 2 * self.k / self.omega,
            "bend_radius": 1 / (2 * self.k * self.omega),
            "force": self.omega**2,
            "angle_deg": mp.degrees(2 * mp.asin(self.k)),
            "slack": (self.length - chord) / chord,
        }

    def point(self, s: float) -> tuple[mp.mpf, mp.mpf]:
        """Position at arclength s from the start."""
        u = self.omega * mp.mpf(s) - self.K
        phi = mp.asin(mp.ellipfun("sn", u, m=self.m))  # |u| <= K, where asin is the amplitude
        epsilon = mp.ellipe(phi, self.m)
        x = (2 * (epsilon + self.E) - (u + self.K)) / self.omega
        y = 2 * self.k / self.omega * mp.ellipfun("cn", u, m=self.m)
        return x, y

    def points(self, s: np.ndarray) -> np.ndarray:
        """Positions at arclengths, shape (n, 2), rounded to doubles."""
        return np.array([[float(x) for x in self.point(value)] for value in s])
