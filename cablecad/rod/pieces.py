"""Solved shapes as pieces of a centreline, in mm: the exact flow from mid-span, and the taut closed form.

Both take a shape of length one from the solver and give it its length and its place. Shapes of every regime are the
same piece: the formulas of `cablecad.rod.flow` divide by nothing that vanishes.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cablecad.centreline import Array, ComplexArray, Frames, Placement
from cablecad.rod.course import ALIKE, CREST_WITHIN, Course, Points
from cablecad.rod.elastica import elastica_derivatives, in_own_frame
from cablecad.rod.elasticas import Elasticas
from cablecad.rod.midpoint import State
from cablecad.rod.taut import Taut


def samples_of(omega: float) -> int:
    """How many samples tell where the curvature is greatest."""
    return 65 + 8 * int(omega)


@dataclass(frozen=True)
class _Shape(ABC):
    """What the two pieces share; `placement.e1` lies along the compression -n (any direction where there is none)."""

    placement: Placement
    length: float

    @abstractmethod
    def _points(self, s: Array) -> Points:
        """The shape at arclengths over the length, in the frame of its compression, positions from its start."""

    @property
    @abstractmethod
    def _omega(self) -> float:
        """sqrt(P) times the length."""

    @property
    def force(self) -> float:
        """P, the size of the force per unit EI [1/mm^2]."""
        return (self._omega / self.length) ** 2

    def frames(self, s: Array) -> Frames:
        """Positions and frames at `s`, shape (n, 3) each."""
        return self._frames(self._points(s / self.length))

    def states(self, s: Array) -> tuple[Frames, Array]:
        """Positions and frames at `s`, and the curvature, shape (n, 2), in the first of the two components."""
        at = self._points(s / self.length)
        return self._frames(at), np.column_stack([at.kappa / self.length, np.zeros_like(s)])

    def _frames(self, at: Points) -> Frames:
        return self.placement.frames(self.length * at.along, self.length * at.across, at.cosine, at.sine)

    def ends(self) -> Frames:
        """Positions and frames at both ends, shape (2, 3) each."""
        return self.frames(np.array([0.0, self.length]))

    def bishop(self, s: Array, order: int) -> Array:
        """Derivatives 0..order of the curvature, in the first of the two components."""
        values = np.zeros((order + 1, len(s), 2))
        at = self._points(s / self.length)
        values[:, :, 0] = elastica_derivatives(at.kappa / self.length, at.sine, at.cosine, self.force, order)[0]
        return values

    def turns(self, s: Array, order: int) -> ComplexArray:
        """Derivatives 0..order of the tangent by the share of the length, in the frame at `s`, shape (order + 1, n)."""
        at = self._points(s / self.length)
        return in_own_frame(elastica_derivatives(at.kappa, at.sine, at.cosine, self._omega**2, order)[1])


@dataclass(frozen=True)
class Elastica(_Shape):
    """A stretch of any elastica, from its state at mid-span.

    Attributes:
        placement: Origin at the start; e1 along the compression.
        length: [mm].
        state: Of a rod of length one.
    """

    state: State

    @property
    def _omega(self) -> float:
        return self.state.omega

    @cached_property
    def _course(self) -> Course:
        return Course(self.state)

    @cached_property
    def _marks(self) -> tuple[Array, Points]:
        """The start, the first crest of |kappa| between the ends if there is one, and the end, in one go.

        Returns:
            Their arclengths from mid-span over the length, and the points there from mid-span.
        """
        s = self._course.crest()
        places = np.array([-0.5, min(s, 0.5), 0.5] if s <= CREST_WITHIN else [-0.5, 0.5])
        return places, self._course.at(places)

    def keep(self, places: Array, at: Points, ends: Frames, tightest: tuple[float, float] | None) -> None:
        """Have at hand what was found together with that of others: marks, ends, and the greatest curvature if known.

        Args:
            places: The marks' arclengths from mid-span over the length.
            at: The points there.
            ends: Frames at both ends.
            tightest: Greatest |curvature| and its arclength, of the shape of length one.
        """
        own = self.__dict__
        own["_marks"], own["_ends"] = (places, at), ends
        if tightest is not None:
            own["_greatest_curvature"] = tightest[0] / self.length, tightest[1] * self.length

    @classmethod
    def bundle(cls, pieces: Sequence[Elastica]) -> Elasticas:
        """Some of them, evaluated together."""
        return Elasticas(pieces)

    def ends(self) -> Frames:
        """Positions and frames at both ends, shape (2, 3) each."""
        return self._ends

    @cached_property
    def _ends(self) -> Frames:
        return self._frames(self._from_start(Points(*(each[[0, -1]] for each in self._marks[1]))))

    def greatest_curvature(self) -> tuple[float, float]:
        """At an end, or at a crest of |kappa|, where the tangent lies along the compression."""
        return self._greatest_curvature

    @cached_property
    def _greatest_curvature(self) -> tuple[float, float]:
        """In closed form, if the shape itself bears it out."""
        places, at = self._marks
        found = np.abs(at.kappa)
        crest_kappa = self.state.crest_kappa
        if len(found) == 3 and abs(found[1] - crest_kappa) > ALIKE * crest_kappa:
            return self._sampled_crest()
        i = int(np.argmax(found >= (1.0 - ALIKE) * found.max()))
        return float(found.max()) / self.length, (float(places[i]) + 0.5) * self.length

    def _sampled_crest(self) -> tuple[float, float]:
        """By Newton's method from samples."""
        s = np.linspace(0.0, self.length, samples_of(self._omega))
        kappa = np.abs(self.bishop(s, 0)[0, :, 0])
        # A crest between two samples may be above a sample, or an end, that is the greatest of them.
        wide = np.pad(kappa, 1)
        crests = np.flatnonzero((kappa >= wide[:-2]) & (kappa >= wide[2:]) & (kappa > 0.97 * kappa.max()))
        best = s[crests]
        for _ in range(6):
            slope, bend = self.bishop(best, 2)[1:, :, 0]
            step = np.where(bend != 0.0, -slope / np.where(bend != 0.0, bend, 1.0), 0.0)
            step[np.abs(step) > 2.0 * s[1]] = 0.0  # not the crest it began at
            best = np.minimum(np.maximum(best + step, 0.0), self.length)
            if np.abs(step).max(initial=0.0) <= 1e-9 * s[1]:
                break
        # Of crests alike but for rounding the first, whoever worked them out.
        at = np.append(best, s[int(np.argmax(kappa >= (1.0 - ALIKE) * kappa.max()))])
        refined = np.abs(self.bishop(at, 0)[0, :, 0])
        i = int(np.argmin(np.where(refined >= (1.0 - ALIKE) * refined.max(), at, np.inf)))
        return float(refined.max()), float(at[i])

    def _points(self, s: Array) -> Points:
        return self._from_start(self._course.at(s - 0.5))

    def _from_start(self, at: Points) -> Points:
        start = self._marks[1]
        return at._replace(along=at.along - start.along[0], across=at.across - start.across[0])


@dataclass(frozen=True)
class TautCable(_Shape):
    """A cable pulled nearly straight between clamps that look elsewhere: two boundary layers.

    Attributes:
        placement: Origin at the start; e1 along the compression, against the pull.
        length: [mm].
        shape: The closed form for a rod of length one, arrays of shape (1,).
    """

    shape: Taut

    @property
    def _omega(self) -> float:
        return float(self.shape.omega[0])

    def _points(self, s: Array) -> Points:
        along, across = self.shape.position(s)
        psi = self.shape.psi(s)[0]  # from the tension; the compression is half a turn away
        return Points(-along[0], -across[0], -np.cos(psi), -np.sin(psi), self.shape.curvature(s)[0])

    def greatest_curvature(self) -> tuple[float, float]:
        """In a layer |kappa| = 2 omega |sin(psi/2)|: at its end, or where psi passes half a turn."""
        crests = []
        for angle, place in ((float(self.shape.a[0]), 0.0), (float(self.shape.b[0]), 1.0)):
            if abs(angle) > math.pi:
                inward = math.log(math.tan(abs(angle) / 4.0)) / self._omega
                crests.append((2.0 * self._omega, abs(place - inward)))
            else:
                crests.append((2.0 * self._omega * math.sin(abs(angle) / 2.0), place))
        kappa, at = max(crests)
        return kappa / self.length, at * self.length
