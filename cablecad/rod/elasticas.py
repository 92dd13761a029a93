"""Many pieces of `Elastica`, evaluated together: the same points to rounding, at a fraction of the calls."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from cablecad.centreline import Array, ComplexArray, Frames
from cablecad.rod.course import Points, courses
from cablecad.rod.elastica import elastica_derivatives, in_own_frame

if TYPE_CHECKING:
    from cablecad.rod.pieces import Elastica


class Elasticas:
    """A bundle of elastica; arclengths are given in a row for each, shape (n, k) [mm].

    Attributes:
        pieces: The pieces, n of them.
    """

    def __init__(self, pieces: Sequence[Elastica]) -> None:
        self.pieces = pieces
        states = [piece.state for piece in pieces]
        half = np.array([state.half for state in states])
        kappa, self._omega = np.array([(state.kappa, state.omega) for state in states]).T
        self._each = courses(half[:, 0], half[:, 1], kappa, self._omega)
        self._courses = self._each.take(np.s_[:, None])
        self._length = np.array([[piece.length] for piece in pieces])
        placements = [piece.placement for piece in pieces]
        self._axes = np.array([(placement.e1, placement.e2) for placement in placements])
        self._origin = np.array([placement.origin for placement in placements])[:, None]
        start = self._courses.at(np.full((len(pieces), 1), -0.5))
        self._start = start.along, start.across

    def frames(self, s: Array) -> Frames:
        """Positions and frames at `s`, shape (n, k, 3) each."""
        return self._frames(self._courses.at(s / self._length - 0.5))

    def turns(self, s: Array, order: int) -> ComplexArray:
        """Derivatives 0..order of the tangent by the share of the length, in the frame at `s`, (order + 1, n, k)."""
        at = self._courses.at(s / self._length - 0.5)
        force = np.repeat(self._omega**2, s.shape[1])
        turns = elastica_derivatives(at.kappa.ravel(), at.sine.ravel(), at.cosine.ravel(), force, order)[1]
        return in_own_frame(turns).reshape(order + 1, *s.shape)

    def mark(self) -> None:
        """Find the marks, the ends and the greatest curvatures of all, which the pieces then have at hand."""
        marks = self._each.marks()
        ends = self._frames(Points(*(each[:, [0, 2]] for each in marks.at)))
        kappa, tightest = marks.kappa.tolist(), marks.tightest.tolist()
        for i, (piece, crested, known) in enumerate(
            zip(self.pieces, marks.has_crest.tolist(), marks.known.tolist(), strict=True)
        ):
            own = np.s_[i] if crested else np.s_[i, ::2]
            piece.keep(
                marks.places[own],
                Points(*[each[own] for each in marks.at]),
                Frames(*[each[i] for each in ends]),
                (kappa[i], tightest[i]) if known else None,
            )

    def _frames(self, at: Points) -> Frames:
        """Frames from points counted from mid-span, shape (n, k)."""
        along, across = self._start
        local = np.empty((3, *at.kappa.shape, 2))
        local[0, ..., 0], local[0, ..., 1] = self._length * (at.along - along), self._length * (at.across - across)
        local[1, ..., 0], local[1, ..., 1] = at.cosine, at.sine
        local[2, ..., 0], local[2, ..., 1] = -at.sine, at.cosine
        position, tangent, normal = local @ self._axes
        position += self._origin
        binormal = np.cross(self._axes[:, 0], self._axes[:, 1])[:, None]
        return Frames(position, tangent, normal, np.broadcast_to(binormal, position.shape))
