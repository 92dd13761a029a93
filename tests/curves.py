"""Curves that tests share: a space curve, chains of lines and arcs in a plane, and pinned arches."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cablecad.centreline import Arc, Array, Centreline, Frames, Line, Piece, Placement
from cablecad.rod.elastica import Inflexional
from cablecad.rod.elliptic import complete_k


@dataclass(frozen=True)
class Helix:
    """A helix about z with a rotation-minimising frame: a piece of a centreline that lies in no plane.

    By arclength its angle is s / c, c = hypot(radius, rise), its curvature radius / c^2 and its torsion rise / c^2. The
    rotation-minimising normal turns back from the Frenet normal by torsion times s, so that
    k1 + i k2 = curvature exp(i torsion s).
    """

    radius: float
    rise: float  # along z, a radian
    length: float

    @classmethod
    def of_turns(cls, radius: float, pitch: float, turns: float) -> Helix:
        rise = pitch / (2.0 * math.pi)
        return cls(radius, rise, 2.0 * math.pi * turns * math.hypot(radius, rise))

    @property
    def c(self) -> float:
        return math.hypot(self.radius, self.rise)

    @property
    def curvature(self) -> float:
        return self.radius / self.c**2

    @property
    def torsion(self) -> float:
        return self.rise / self.c**2

    def frames(self, s: Array) -> Frames:
        angle = s / self.c
        cos, sin, one = np.cos(angle), np.sin(angle), np.ones_like(angle)
        position = np.stack([self.radius * cos, self.radius * sin, self.rise * angle], axis=1)
        tangent = np.stack([-self.radius * sin, self.radius * cos, self.rise * one], axis=1) / self.c
        inward = np.stack([-cos, -sin, 0.0 * one], axis=1)
        back = (self.torsion * s)[:, None]
        across = np.cross(tangent, inward)
        normal = np.cos(back) * inward - np.sin(back) * across
        return Frames(position, tangent, normal, np.sin(back) * inward + np.cos(back) * across)

    def states(self, s: Array) -> tuple[Frames, Array]:
        return self.frames(s), self.bishop(s, 0)[0]

    def bishop(self, s: Array, order: int) -> Array:
        derivatives = np.arange(order + 1)[:, None]
        values = self.curvature * (1j * self.torsion) ** derivatives * np.exp(1j * self.torsion * s)
        return np.stack([values.real, values.imag], axis=2)

    def turns(self, _s: Array, _order: int) -> None:
        return None

    def greatest_curvature(self) -> tuple[float, float]:
        return self.curvature, self.length / 2.0


def chain(
    *stretches: tuple[float, float],
    origin: Sequence[float] = (0, 0, 0),
    e1: Array | None = None,
    e2: Array | None = None,
) -> Centreline:
    """Lines and arcs one after the other, each given by (length, signed curvature); it sets out along e1."""
    pieces: list[Piece] = []
    position, tangent, normal = np.array(origin, dtype=float), e1, e2
    tangent = np.array([1.0, 0.0, 0.0]) if tangent is None else tangent
    normal = np.array([0.0, 1.0, 0.0]) if normal is None else normal
    for length, kappa in stretches:
        placement = Placement(position, tangent, normal)
        piece = Line(placement, length) if kappa == 0.0 else Arc(placement, length, kappa)
        end = piece.frames(np.array([length]))
        position, tangent, normal = end.position[0], end.tangent[0], end.normal[0]
        pieces.append(piece)
    return Centreline(pieces)


def u_turn(leg: float, radius: float) -> Centreline:
    """Two parallel legs and a half circle."""
    return chain((leg, 0.0), (math.pi * radius, 1.0 / radius), (leg, 0.0))


def arch(
    k: float, length: float, *, m1: float | None = None, mode: int = 1, origin: Sequence[float] = (0, 0, 0)
) -> Centreline:
    """A rod pinned at both ends in its first mode, or a higher one; the chord along x, the first arch towards -y."""
    m = k * k
    m1 = 1.0 - m if m1 is None else m1
    quarter = complete_k(m, m1)
    placement = Placement(np.array(origin, dtype=float), np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]))
    return Centreline([Inflexional(placement, length, 2.0 * mode * quarter / length, m, m1, -quarter)])
