"""Equilibria of planar rods as arrays: shapes at any arclength, joining, ordering."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from operator import attrgetter
from typing import Any, NamedTuple

import numpy as np

from cablecad.rod.polish import Middle
from cablecad.rod.taut import Taut, wrap
from cablecad.rod.trial import Array

SHARP_MODES = 44
"""Legendre modes of the finest discretisation: boundary layers of omega = 36 to 1e-8."""

_MODES = ((7.0, 24), (11.0, 32))
"""Legendre modes that do up to an omega: they give the angles of 999 in 1000 shapes to 5e-6, from where few steps of
Newton's method on the middle go to rounding (tests/experiments/planar_counts.py)."""

_SKETCH_MODES = ((7.0, 14), (11.0, 16))
"""Legendre modes from which Newton's method on the middle mostly ends where it does from more, in half the time
(tests/experiments/planar_counts.py)."""

_FORCELESS = 1e-6
"""Below this omega, force over EI times length squared of 1e-12, a shape is a circle or a line: rounding of the ends
makes less than a tenth of it."""

_FLAT = 1e-7
"""Below this curvature such a shape is a line."""

_TURN = 2.0 * np.pi


class Numbers(NamedTuple):
    """What there is to say of one equilibrium in single numbers; see `Equilibria`."""

    winding: int
    side: int
    inflections: int
    energy: float
    kappa_max: float
    omega: float
    kappa: float
    lean: float
    tension: bool

    @property
    def branch(self) -> str:
        """What the pendulum does: swings, goes over the top, or feels no force."""
        if self.omega < _FORCELESS:
            return "circle" if abs(self.kappa) > _FLAT else "line"
        half = self.lean / 2.0
        cosine = math.sin(half) if self.tension else math.cos(half)  # of half the angle from the compression
        return "inflexional" if abs(self.kappa) <= 2.0 * self.omega * abs(cosine) else "non-inflexional"


@dataclass(frozen=True, slots=True)
class Equilibria:
    """Equilibria of many scenes, arrays of shape (n,) sorted by scene, in-plane stable ones first, each by energy.

    Angles are absolute; theta(0) is the given start angle where the start is a clamp.

    Attributes:
        scene: Index of the scene.
        theta: Angle at mid-span, in the turn that leads to theta0.
        kappa: Curvature at mid-span.
        lean, direction, omega, tension: The same state in the frame of the force: theta = direction + lean but for
            full turns, n = +-omega^2 (cos direction, sin direction), + where `tension`. Under tension at large omega
            only `lean` has the digits that matter.
        force: n, shape (n, 2).
        theta0, theta1, kappa0, kappa1: Angles and curvatures at the ends.
        energy: Bending energy.
        kappa_max: Greatest |curvature|.
        winding: Full turns of theta1 beyond the given end angle; 0 where an end is a pin.
        inflections: Zeros of the curvature strictly inside.
        heights: Of the middle and of the quarter point left of the chord, shape (n, 2).
        side: +1 where the middle lies left of the chord, -1 right; where on it, that of the quarter point.
        residual: Largest unmet end condition.
        verdict: Whether each is stable in and out of the plane, shape (n, 2): 1, -1 where it is not, 0 where not yet
            judged: read `stable_in_plane` and `stable_out_of_plane`, which judge where need be.
        margins: Least eigenvalues in and out of the plane, shape (n, 2), NaN where not yet judged: read
            `margin_in_plane` and `margin_out_of_plane`, likewise.
        free_turns: Whether a turn about a free axis was left out of the latter, known with it: read `free_turn`.
        torsion_ratio: GJ/EI where both ends hold the spin, else NaN.
        taut: Whether the shape is the closed form of `Taut` rather than the flow from mid-span.
        a, b: Angles from n at the ends of a taut cable, else 0.
        z: Angles at the ends and Legendre coefficients in the frame of the chord, shape (n, 46): a warm start. NaN
            where nobody asked yet: read `modes`. Zero for taut cables.
        held: Whether start and end are clamps, shape (n, 2).
        frame: Angle of the chord, by which `z` is turned.
        excess: 1 - chord.
    """

    scene: np.ndarray
    theta: Array
    kappa: Array
    lean: Array
    direction: Array
    omega: Array
    tension: np.ndarray
    force: Array
    theta0: Array
    theta1: Array
    kappa0: Array
    kappa1: Array
    energy: Array
    kappa_max: Array
    winding: np.ndarray
    inflections: np.ndarray
    heights: Array
    side: np.ndarray
    residual: Array
    verdict: np.ndarray
    margins: Array
    free_turns: np.ndarray
    torsion_ratio: Array
    taut: np.ndarray
    a: Array
    b: Array
    z: Array
    held: np.ndarray
    frame: Array
    excess: Array

    def __len__(self) -> int:
        return len(self.scene)

    @property
    def margin_in_plane(self) -> Array:
        """Least eigenvalue in the plane, see `stability`."""
        self._judge()
        return self.margins[:, 0]

    @property
    def margin_out_of_plane(self) -> Array:
        """Least eigenvalue out of the plane."""
        self._judge()
        return self.margins[:, 1]

    @property
    def free_turn(self) -> np.ndarray:
        """Whether a turn about an axis that the ends leave free was left out of the margin out of the plane."""
        self._judge()
        return self.free_turns

    def _judge(self) -> None:
        from cablecad.rod.judge import judge

        judge(self)

    @property
    def modes(self) -> Array:
        """`z`, found from the exact shape where it is not yet known."""
        from cablecad.rod.judge import discretise

        return discretise(self)

    @property
    def stable_in_plane(self) -> np.ndarray:
        """Whether each is a strict minimum in the plane."""
        from cablecad.rod.judge import decide

        return decide(self, 0) > 0

    @property
    def stable_out_of_plane(self) -> np.ndarray:
        """Whether each is one out of the plane, free turns left out."""
        from cablecad.rod.judge import decide

        return decide(self, 1) > 0

    def take(self, index: Any) -> Equilibria:
        """Some of them."""
        return Equilibria(*[array[index] for array in _arrays(self)])

    def numbers(self) -> list[Numbers]:
        """Of each the single numbers."""
        return list(map(Numbers._make, zip(*(getattr(self, name).tolist() for name in Numbers._fields), strict=True)))

    def of(self, scene: int) -> Equilibria:
        """Those of one scene, best first."""
        low, high = np.searchsorted(self.scene, [scene, scene + 1])
        return self.take(slice(low, high))

    def tangents(self, s: Array) -> tuple[Array, Array, Array]:
        """cos and sin of the angle, and the curvature, at arclengths `s`, shape (k,): shape (n, k) each."""
        if self.taut.any():
            theta, kappa, _ = self.at(s)
            return np.cos(theta), np.sin(theta), kappa
        middle = Middle(*(getattr(self, f.name) for f in fields(Middle)))
        x, y, kappa = middle.courses.take(np.s_[:, None]).tangent(s - 0.5)
        cosine, sine = np.cos(middle.compression)[:, None], np.sin(middle.compression)[:, None]
        return cosine * x - sine * y, sine * x + cosine * y, kappa

    def at(self, s: Array) -> tuple[Array, Array, Array]:
        """Angle, curvature and position at arclengths `s`, shape (k,): shapes (n, k), (n, k), (n, k, 2)."""
        s = np.asarray(s, dtype=float)
        theta, kappa = np.empty((len(self), len(s))), np.empty((len(self), len(s)))
        position = np.empty((len(self), len(s), 2))
        rod, pulled = np.flatnonzero(~self.taut), np.flatnonzero(self.taut)
        if len(rod):
            middle = Middle(*(getattr(self, f.name)[rod] for f in fields(Middle)))
            there = middle.jump(np.append(s, 0.0) - 0.5)
            theta[rod], kappa[rod] = self.theta[rod, None] + there.turn[:, :-1], there.kappa[:, :-1]
            along, across = (value[:, :-1] - value[:, -1:] for value in (there.along, there.across))
            cosine, sine = np.cos(middle.compression)[:, None], np.sin(middle.compression)[:, None]
            position[rod] = np.stack([cosine * along - sine * across, sine * along + cosine * across], axis=-1)
        if len(pulled):
            shape = Taut(pulled, *(getattr(self, name)[pulled] for name in ("direction", "omega", "a", "b")))
            theta[pulled] = shape.psi(s) + (self.theta0[pulled] - self.a[pulled])[:, None]
            kappa[pulled] = shape.curvature(s)
            along, across = shape.position(s)
            cosine, sine = np.cos(shape.direction)[:, None], np.sin(shape.direction)[:, None]
            position[pulled] = np.stack([cosine * along - sine * across, sine * along + cosine * across], axis=-1)
        return theta, kappa, position


_arrays = attrgetter(*(f.name for f in fields(Equilibria)))


def modes_for(omega: Array) -> np.ndarray:
    """How many Legendre modes discretise shapes of these omega, shape (n,)."""
    return _by_omega(_MODES, omega)


def sketch_modes_for(omega: Array) -> np.ndarray:
    """How many Legendre modes, mostly, lead to shapes of these omega, shape (n,)."""
    return _by_omega(_SKETCH_MODES, omega)


def _by_omega(table: Sequence[tuple[float, int]], omega: Array) -> np.ndarray:
    limits, counts = zip(*table, strict=True)
    modes: np.ndarray = np.array([*counts, SHARP_MODES])[np.searchsorted(limits, omega, side="right")]
    return modes


def sides(heights: Array) -> np.ndarray:
    """Which side of the chord the middle lies on, or where it lies on the chord, the quarter point: +1, -1 or 0."""
    size = np.maximum(np.max(np.abs(heights), axis=1), 1e-300)
    middle, quarter = heights.T
    side: np.ndarray = np.where(np.abs(middle) > 1e-9 * size, np.sign(middle), np.sign(quarter)).astype(int)
    return side


def join(*parts: Equilibria) -> Equilibria:
    """Equilibria of several searches, duplicates of the same scene dropped."""
    if not parts:
        return none()
    joined = Equilibria(*(np.concatenate([getattr(p, f.name) for p in parts]) for f in fields(Equilibria)))
    if not len(joined):
        return joined
    # Relative to the size of the shape, by its state in the middle and its turn.
    size = np.minimum(1.0, joined.kappa_max)
    # Full turns common to a whole shape are no difference.
    turns = joined.theta - joined.theta0 + 0.17 * (joined.theta1 - joined.theta0) + 0.07 * np.sin(joined.theta0)
    signature = (turns + 0.31 * joined.kappa / (1.0 + joined.omega)) / size
    order = np.lexsort((signature, joined.scene))
    scene, signature, energy = joined.scene[order], signature[order], joined.energy[order]
    fresh = np.ones(len(order), dtype=bool)
    fresh[1:] = (
        (np.diff(scene) != 0)
        | (np.abs(np.diff(signature)) > 1e-6)
        | (np.abs(np.diff(energy)) > 1e-6 * (energy[1:] + energy[:-1]))
    )
    # Of one shape met in both ways the taut closed form is the exact one.
    group = np.cumsum(fresh)
    best = np.lexsort((~joined.taut[order], group))
    return joined.take(np.sort(order[best[np.flatnonzero(np.diff(group, prepend=0))]]))


def none() -> Equilibria:
    """No equilibria."""
    empty = {f.name: np.zeros(0) for f in fields(Equilibria)}
    for name in ("scene", "winding", "inflections", "side"):
        empty[name] = np.zeros(0, dtype=int)
    for name in ("tension", "free_turns", "taut"):
        empty[name] = np.zeros(0, dtype=bool)
    for name in ("force", "heights", "margins"):
        empty[name] = np.zeros((0, 2))
    empty["z"] = np.zeros((0, SHARP_MODES + 2))
    empty["verdict"] = np.zeros((0, 2), dtype=int)
    empty["held"] = np.zeros((0, 2), dtype=bool)
    return Equilibria(**empty)


def absolute(found: Equilibria, start: Array, end: Array, frame: Array) -> Equilibria:
    """From the frames of the chords to the given one, where the start and end angles are `start` and `end`."""
    if not len(found):
        return found
    given = frame[found.scene]
    begin = np.where(found.held[:, 0], start[found.scene], wrap(found.theta0 + given))
    shift = begin - found.theta0
    theta1 = found.theta1 + shift
    both = found.held.all(axis=1)
    cosine, sine = np.cos(given), np.sin(given)
    force = np.stack(
        [cosine * found.force[:, 0] - sine * found.force[:, 1], sine * found.force[:, 0] + cosine * found.force[:, 1]],
        axis=-1,
    )
    return replace(
        found,
        theta=found.theta + shift,
        theta0=begin,
        theta1=theta1,
        direction=found.direction + given,
        force=force,
        winding=np.where(both, np.rint((theta1 - end[found.scene]) / _TURN), 0.0).astype(int),
        frame=given,
    )


def ranked(found: Equilibria) -> Equilibria:
    """Sorted by scene, the stable ones in the plane first, each by energy; twins by side and winding.

    Twins have one energy but for rounding: left to themselves they would change places from machine to machine.
    """
    if not len(found):
        return found
    order = np.lexsort((found.energy, ~found.stable_in_plane, found.scene))
    found = found.take(order)
    energy = found.energy
    new = np.ones(len(order), dtype=bool)
    new[1:] = (
        (np.abs(np.diff(energy)) > 1e-9 * energy[1:])
        | (np.diff(found.scene) != 0)
        | (np.diff(found.stable_in_plane.astype(int)) != 0)
    )
    return found.take(np.lexsort((found.winding, -found.side, np.cumsum(new))))
