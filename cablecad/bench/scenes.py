"""Two-point problems to measure with. Units: L = EI = 1, the start is the origin."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablecad.model import Cable, Clamp, Material, Pin

Array = NDArray[np.float64]

TURN = 2.0 * np.pi

# GJ/EI of 0.8, so that the twist takes part: Poisson's ratio of 1/4. The size of the modulus does not matter.
_MATERIAL = Material(youngs_modulus=1000.0, poissons_ratio=0.25)


class Scenes(NamedTuple):
    """Two-point problems: angles at the ends, shape (n,), and the place of the end, shape (n, 2)."""

    a: Array
    b: Array
    end: Array

    def take(self, index: slice | NDArray[np.int64]) -> Scenes:
        """Some of them."""
        return Scenes(self.a[index], self.b[index], self.end[index])


def random_scenes(count: int, seed: int, *, excess: bool = False) -> Scenes:
    """Chord/length uniform in 0..0.999 (or the excess log-uniform in 1e-10..1e-2), all directions and angles."""
    rng = np.random.default_rng(seed)
    d = 1.0 - 10.0 ** rng.uniform(-10.0, -2.0, count) if excess else rng.uniform(0.0, 0.999, count)
    toward, a, b = (rng.uniform(-np.pi, np.pi, count) for _ in range(3))
    if excess:
        # Every other one with angles of the order its slack allows without boundary layers.
        small = 3.0 * np.sqrt(1.0 - d) / np.pi
        a, b = (toward + angle * np.where(np.arange(count) % 2, small, 1.0) for angle in (a, b))
    return Scenes(a, b, d[:, None] * np.stack([np.cos(toward), np.sin(toward)], axis=-1))


def scene_cables(scenes: Scenes, *, start_clamped: bool = True, end_clamped: bool = True) -> list[Cable]:
    """Scenes as cables of 1 mm."""
    made = []
    for a, b, (x, y) in zip(scenes.a, scenes.b, scenes.end, strict=True):
        begin, finish = (0.0, 0.0, 0.0), (float(x), float(y), 0.0)
        made.append(
            Cable(
                "bench",
                1e-3,
                Clamp(begin, (math.cos(a), math.sin(a), 0.0)) if start_clamped else Pin(begin),
                Clamp(finish, (math.cos(b), math.sin(b), 0.0)) if end_clamped else Pin(finish),
                length=1.0,
                material=_MATERIAL,
                bulge=(1e-3, 1.0, 0.0),
            )
        )
    return made
