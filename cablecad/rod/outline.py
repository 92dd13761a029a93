"""What reports tell of shapes, found of many at once: ends, residual, rise, end angle, where they bend most.

It is what drawing each shape and asking it would give (`two_point`, `pieces`), by the same formulas, in arrays: at this
size calls of numpy cost more than the arithmetic. No centreline is made; who asks for one gets it as ever.

Taut equilibria, and those with closed forms of their own, are left to themselves.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import fields
from typing import Any

import numpy as np

from cablecad.centreline import Array
from cablecad.rod.pieces import samples_of
from cablecad.rod.polish import Middle
from cablecad.rod.rise import SAMPLES, SETTLED, STEPS, missed_height, tops
from cablecad.rod.solution import EndState, RodSolution
from cablecad.rod.span import Span
from cablecad.rod.trace import Trace, gathered

_FEWEST = 3
"""So many solutions are measured together, fewer one by one."""

_BLOCK = 256
"""Solutions measured at once: 30 MB."""


def measure_outlines(solutions: Iterable[RodSolution]) -> None:
    """Find what a report tells of the shapes of solutions, which then have it at hand."""
    plain = [(one, trace) for one in solutions if (trace := _plain_trace(one)) is not None]
    if len(plain) < _FEWEST:
        return
    for low in range(0, len(plain), _BLOCK):
        some = plain[low : low + _BLOCK]
        _tell([one for one, _ in some], _Outlines([trace for _, trace in some]))


def _plain_trace(one: RodSolution) -> Trace | None:
    """The solver's own state of a solution whose free part is one elastica that nobody has drawn yet."""
    chosen = one.equilibrium
    if chosen.trace is None or chosen.trace.is_taut or "shape" in chosen.__dict__ or "ends" in chosen.__dict__:
        return None
    return chosen.trace


def _tell(solutions: list[RodSolution], outlines: _Outlines) -> None:
    """Give each solution what was found of it."""
    begin = np.array([one.cable.start_support.position for one in solutions])
    finish = np.array([one.cable.end_support.position for one in solutions])  # type: ignore[union-attr]
    lengths = np.array([one.length for one in solutions])
    residual = outlines.residual(begin, finish, lengths).tolist()
    rise = outlines.rise(begin, finish).tolist()
    end_angle = _end_angle(outlines.tangent[:, 0], finish - begin)
    tightest = outlines.greatest_curvature()
    states = [outlines.wrench(0), outlines.wrench(1)]
    for i, one in enumerate(solutions):
        own = one.__dict__
        own["residual"], own["rise"], own["end_angle_deg"] = residual[i], rise[i], end_angle[i]
        chosen = one.equilibrium.__dict__
        if (bend := tightest[i]) is not None:
            chosen["greatest_curvature"] = bend
        chosen["ends"] = tuple(
            EndState(outlines.place[i, end], outlines.tangent[i, end], states[end][0][i], states[end][1][i])
            for end in (0, 1)
        )


class _Outlines:
    """Free spans of one elastica each, and the straights held before and after them.

    Attributes:
        place: Of the cable's start and end [mm], shape (n, 2, 3).
        tangent: There, shape (n, 2, 3).
    """

    def __init__(self, traces: list[Trace]) -> None:
        spans = [one.span for one in traces]
        self._rows = gathered(traces)
        middle = Middle(*(getattr(self._rows, f.name) for f in fields(Middle)))
        self._each = middle.courses
        self._courses = self._each.take(np.s_[:, None])
        self._length, self._lead_out, self._lead_in = (
            _column(spans, name) for name in ("length", "lead_out", "lead_in")
        )
        self._held = np.array([[span.start_clamped, span.end_clamped] for span in spans])
        self._angles = np.array([[span.start_angle, span.end_angle] for span in spans])
        self._e1, self._e2, self._start = (_vectors(spans, name) for name in ("e1", "e2", "start"))
        cosine, sine = np.cos(middle.compression)[:, None], np.sin(middle.compression)[:, None]
        self._axes = cosine * self._e1 + sine * self._e2, cosine * self._e2 - sine * self._e1
        ends = self._courses.at(np.array([[-0.5, 0.5]]))
        self._origin = ends.along[:, :1], ends.across[:, :1]
        self._kappa = ends.kappa / self._length
        self.tangent = self._vector(ends.cosine, ends.sine)
        step = self._vector(ends.along[:, 1:] - ends.along[:, :1], ends.across[:, 1:] - ends.across[:, :1])[:, 0]
        self._end = self._start + self._length * step
        begin = self._start - self._lead_out * self.tangent[:, 0]
        self.place = np.stack([begin, self._end + self._lead_in * self.tangent[:, 1]], axis=1)

    @property
    def _total(self) -> Array:
        """Lengths with their straights, shape (n, 1) [mm]."""
        return self._lead_out + self._length + self._lead_in

    def _vector(self, along: Array, across: Array) -> Array:
        """Vectors of space from the frames of the compressions: shape (n, k) to (n, k, 3)."""
        return along[..., None] * self._axes[0][:, None] + across[..., None] * self._axes[1][:, None]

    def wrench(self, end: int) -> tuple[Array, Array]:
        """What the support of an end applies, force and moment about the cable's own end point, per EI, (n, 3) each."""
        sign, free = (1.0, self._end) if end else (-1.0, self._start)
        pull = (self._rows.force[:, :1] * self._e1 + self._rows.force[:, 1:] * self._e2) / self._length**2
        force = sign * pull + 0.0  # a zero has no sign
        kappa = (self._rows.kappa1 if end else self._rows.kappa0)[:, None] / self._length * self._held[:, end, None]
        e3 = np.cross(self._e1, self._e2)
        moment: Array = np.cross(free - self.place[:, end], sign * pull) + sign * kappa * e3
        return force, moment

    def residual(self, begin: Array, finish: Array, length: Array) -> Array:
        """The largest unmet end condition: position over length, direction as an angle, shape (n,)."""
        off = np.linalg.norm(self.place - np.stack([begin, finish], axis=1), axis=2) / length[:, None]
        cosine, sine = np.cos(self._angles)[..., None], np.sin(self._angles)[..., None]
        wanted = cosine * self._e1[:, None] + sine * self._e2[:, None]
        turned = np.linalg.norm(self.tangent - wanted, axis=2)
        unmet = np.where(self._held, turned, np.abs(self._kappa) * length[:, None])
        worst: Array = np.maximum(off, unmet).max(axis=1)
        return worst

    def rise(self, begin: Array, finish: Array) -> Array:
        """Greatest distance from the chord, or from the point where the ends coincide, shape (n,) [mm]."""
        chord = finish - begin
        size = np.linalg.norm(chord, axis=1)[:, None]
        axis = chord / np.where(size > 0.0, size, 1.0)

        def across(vector: Array) -> Array:
            """Less its component along the chord, shape (n, k, 3)."""
            left: Array = vector - np.einsum("nki,ni->nk", vector, axis)[..., None] * axis[:, None]
            return left

        # Across the chord only the axes of the plane and the start count, which spares two thirds of the samples' sums.
        one, other = (across(axes[:, None]) for axes in self._axes)
        offset = across((self._start - begin)[:, None])
        total = self._total
        samples = np.linspace(0.0, 1.0, min(samples_of(float(self._rows.omega.max())), SAMPLES)) * total
        x, y, *_ = self._plane(np.s_[:], samples)
        parts = ((offset[..., i] + x * one[..., i] + y * other[..., i]) ** 2 for i in range(3))
        heights = np.sqrt(sum(parts, start=np.zeros(1)))
        highest: Array = heights.max(axis=1)
        missed = missed_height(self._rows.kappa_max[:, None] / self._length, samples[:, 1:2])
        rod, at_sample = np.nonzero(tops(heights, missed))
        offset, one, other, total = offset[rod], one[rod], other[rod], total[rod]

        def away(s: Array) -> tuple[Array, Array, Array]:
            """From the chord, its slope and its bend there, shape (k, 1, 3) each."""
            x, y, cosine, sine, kappa = self._plane(rod, s)
            return (
                offset + x[..., None] * one + y[..., None] * other,
                cosine[..., None] * one + sine[..., None] * other,
                kappa[..., None] * (cosine[..., None] * other - sine[..., None] * one),
            )

        best = samples[rod, at_sample][:, None]
        going = np.ones(best.shape, dtype=bool)
        for _ in range(STEPS):
            off, slope, bend = away(best)
            curve = np.sum(slope * slope + off * bend, axis=2)
            going &= curve < 0.0
            step = np.where(going, np.sum(off * slope, axis=2) / np.where(going, curve, 1.0), 0.0)
            best = np.minimum(np.maximum(best - step, 0.0), total)
            going &= np.abs(step) > SETTLED * total
            if not going.any():
                break
        np.maximum.at(highest, rod, np.linalg.norm(away(best)[0], axis=2)[:, 0])
        return highest

    def _plane(self, rod: Any, s: Array) -> tuple[Array, Array, Array, Array, Array]:
        """Position from the free start, tangent (cosine and sine) and curvature in the frames of the compressions.

        Args:
            rod: Which rods, an index.
            s: Arclengths from the cables' starts, shape (n, k) [mm].
        """
        length = self._length[rod]
        s = s - self._lead_out[rod]
        inside = np.minimum(np.maximum(s, 0.0), length)
        at, beyond = self._courses.take(rod).at(inside / length - 0.5), s - inside
        x = length * (at.along - self._origin[0][rod]) + beyond * at.cosine
        y = length * (at.across - self._origin[1][rod]) + beyond * at.sine
        return x, y, at.cosine, at.sine, np.where(beyond == 0.0, at.kappa / length, 0.0)

    def greatest_curvature(self) -> list[tuple[float, float] | None]:
        """The greatest |curvature| [1/mm] and its arclength [mm] of each, as `Elastica` finds them.

        None where the shape does not bear the closed form out, and has to be looked at alone.
        """
        marks = self._each.marks()
        kappa = marks.kappa / self._length[:, 0]
        s = marks.tightest * self._length[:, 0] + self._lead_out[:, 0]
        tightest = zip(kappa.tolist(), s.tolist(), strict=True)
        return [found if known else None for found, known in zip(tightest, marks.known.tolist(), strict=True)]


def _end_angle(tangent: Array, chord: Array) -> list[float | None]:
    """Angles between tangents and chords [degrees]; None where the ends coincide."""
    sine = np.linalg.norm(np.cross(tangent, chord), axis=1)
    angles = np.degrees(np.arctan2(sine, np.einsum("ni,ni->n", tangent, chord)))
    return [angle if one.any() else None for angle, one in zip(angles.tolist(), chord, strict=True)]


def _column(spans: list[Span], name: str) -> Array:
    return np.array([[getattr(span, name)] for span in spans])


def _vectors(spans: list[Span], name: str) -> Array:
    return np.array([getattr(span, name) for span in spans])
