"""Twins: equilibria of one span that are mirror images of each other, or one shape run through from either end.

Each point of a pendulum's path is given by |psi|, |kappa| and omega but for a reflection: turning both signs mirrors
the elastica, turning that of psi or of kappa alone also swaps its ends. What a motion or a reflection leaves as it is,
such as a distance of two points or the energy of a small motion, is the same for twins and is found once for both.
Turned around, a cable is itself only where its ends are held alike and its straights are of one length.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from cablecad.centreline import Array
from cablecad.rod.equilibria import Equilibria
from cablecad.rod.trace import Trace

SAME = 1e-13
"""Difference of twins' states at mid-span and at the ends, as a share of their size: that of rounding is 1e-15, and
shapes that are no twins differ by more than 1e-6 in the random scenes of tests/rod/test_twins.py."""


def first_twins(traces: Sequence[Trace], rows: Equilibria) -> NDArray[np.intp]:
    """For each equilibrium the place of the first of its twins, its own where there is none before it.

    Args:
        traces: Twins stand next to each other, as in a solution's list.
        rows: The same, gathered.

    Returns:
        Places, shape (n,).
    """
    spans = [trace.span for trace in traces]
    same_span = np.array([one is other for one, other in zip(spans[1:], spans, strict=False)], dtype=bool)
    even = np.array([span.lead_out == span.lead_in for span in spans[1:]], dtype=bool)
    turnable = even & (rows.held[1:, 0] == rows.held[1:, 1])
    turned = _differ(rows.lean * rows.kappa > 0.0)
    ends = np.abs(np.stack([rows.kappa0, rows.kappa1]))
    swapped = np.where(turned, ends[::-1, :-1], ends[:, :-1])
    size = rows.omega + rows.kappa_max
    alike = np.abs(_step(np.abs(rows.lean))) <= SAME
    for off in (_step(rows.omega), _step(rows.kappa_max), _step(np.abs(rows.kappa)), *(ends[:, 1:] - swapped)):
        alike &= np.abs(off) <= SAME * size[1:]
    twin = same_span & alike & (turnable | ~turned) & ~_differ(rows.tension) & ~rows.taut[1:]
    place = np.arange(len(spans))
    place[1:][twin] = 0
    first: NDArray[np.intp] = np.maximum.accumulate(place)
    return first


def _step(values: Array) -> Array:
    return values[1:] - values[:-1]


def _differ(values: NDArray[np.bool_]) -> NDArray[np.bool_]:
    changed: NDArray[np.bool_] = values[1:] != values[:-1]
    return changed
