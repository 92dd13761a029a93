"""From an equilibrium of a rod of length one to a cable's shape: its curve in space, and what its supports apply."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from cablecad.centreline import Array, Centreline, Line, Piece, Placement
from cablecad.rod.elasticas import Elasticas
from cablecad.rod.midpoint import State
from cablecad.rod.pieces import Elastica, TautCable
from cablecad.rod.solution import EndState, Equilibrium, Shape
from cablecad.rod.span import Span
from cablecad.rod.taut import Taut
from cablecad.rod.trace import Trace
from cablecad.rod.vector import cross

_FEWEST = 3
"""So many shapes are drawn together, fewer one by one."""


def draw(trace: Trace) -> Shape:
    """The shape of one equilibrium."""
    return _shape(trace, _taut(trace) if trace.is_taut else _elastica(trace))


def draw_together(equilibria: Iterable[Equilibrium]) -> None:
    """Draw equilibria, which then have their shapes at hand."""
    plain = [
        (one, one.trace)
        for one in equilibria
        if one.trace is not None and not one.trace.is_taut and "shape" not in one.__dict__
    ]
    if len(plain) < _FEWEST:
        return
    pieces = [_elastica(trace) for _, trace in plain]
    Elasticas(pieces).mark()
    for (one, trace), piece in zip(plain, pieces, strict=True):
        one.__dict__["shape"] = _shape(trace, piece)


def _taut(trace: Trace) -> TautCable:
    span, row = trace.span, trace.row
    shape = Taut(np.zeros(1, dtype=int), row.direction, row.omega, row.a, row.b)
    return TautCable(_placement(span, float(row.direction[0]) + math.pi), span.length, shape)


def _elastica(trace: Trace) -> Elastica:
    state = State(*(getattr(trace.among, name)[trace.place].item() for name in State._fields))
    return Elastica(_placement(trace.span, state.compression), trace.span.length, state)


def _placement(span: Span, angle: float) -> Placement:
    """The frame at the span's start whose e1 is `angle` from the span's."""
    cosine, sine = math.cos(angle), math.sin(angle)
    return Placement(span.start, cosine * span.e1 + sine * span.e2, cosine * span.e2 - sine * span.e1)


def _shape(trace: Trace, free: Elastica | TautCable) -> Shape:
    """The centreline, `free` and its lead-outs, and the supports' wrenches about the cable's own end points."""
    span, found, place, ends = trace.span, trace.among, trace.place, free.ends()
    pieces: list[Piece] = [free]
    tangents, normals = ends.tangent, ends.normal
    begin, finish = span.start, ends.position[1]
    if span.lead_out > 0.0:
        begin = span.start - span.lead_out * tangents[0]
        pieces.insert(0, Line(Placement(begin, tangents[0], normals[0]), span.lead_out))
    if span.lead_in > 0.0:
        pieces.append(Line(Placement(ends.position[1], tangents[1], normals[1]), span.lead_in))
        finish = ends.position[1] + span.lead_in * tangents[1]
    along, across = found.force[place].tolist()
    pull = (along * span.e1 + across * span.e2) / span.length**2
    bend = found.kappa0[place] * span.start_clamped / span.length, found.kappa1[place] * span.end_clamped / span.length
    start_moment = _moment(span.start - begin, -pull) - bend[0] * span.e3
    end_moment = _moment(ends.position[1] - finish, pull) + bend[1] * span.e3
    return Shape(
        Centreline(pieces),
        EndState(begin, tangents[0], 0.0 - pull, start_moment),
        EndState(finish, tangents[1], pull, end_moment),
    )


def _moment(arm: Array, force: Array) -> Array:
    """arm x force, in a tenth of the time of np.cross."""
    return np.array(cross(arm.tolist(), force.tolist()))
