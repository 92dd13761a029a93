"""What equilibria are judged for only if someone asks: their margins of stability, and their modes.

The answers are written into the arrays they were missing in, so that no one pays twice: a slice shares its arrays with
the whole.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from typing import Any

import numpy as np

from cablecad.rod.equilibria import SHARP_MODES, SMOOTH_MODES, SMOOTH_OMEGA, Equilibria
from cablecad.rod.midpoint import State, curvature
from cablecad.rod.ritz import ritz
from cablecad.rod.stability import in_plane_at_nodes, out_of_plane_at_nodes, stability_at_nodes
from cablecad.rod.trial import Array, TrialSpace, legendre, trial_space


@lru_cache(maxsize=16)
def nodes(start_clamped: bool, end_clamped: bool, modes: int) -> tuple[TrialSpace, Array, Array]:
    """Trial functions for the stability, and the Ritz functions and their slopes at their nodes."""
    space = trial_space(start_clamped, end_clamped, (0.0, 1.0), modes)
    slopes, values = legendre(space.s, modes)
    one = np.ones_like(space.s)
    return space, np.column_stack([1.0 - space.s, space.s, values]), np.column_stack([-one, one, slopes])


def judge_in_plane(found: Equilibria) -> Array:
    """Margins in the plane, shape (n,); those not yet known are found."""
    margins = found.margins[:, 0]
    if len(found) == 1 and np.isnan(found.margins).all():
        judge_out_of_plane(found)  # both at once cost little more than one
    for rows, space, theta, _, some in _unjudged(found, margins):
        margins[rows] = in_plane_at_nodes(
            space,
            theta,
            some.force,
            start_clamped=bool(some.held[0, 0]),
            end_clamped=bool(some.held[0, 1]),
            chord=_chord(some),
        )
    return margins


def judge_out_of_plane(found: Equilibria) -> Array:
    """Margins out of the plane, shape (n,), and `free_turns`; those not yet known are found."""
    margins = found.margins[:, 1]
    for rows, space, theta, kappa, some in _unjudged(found, margins):
        given = (space, theta, kappa, some.force, np.stack([some.theta0, some.theta1], axis=-1))
        ends: dict[str, Any] = {
            "start_clamped": bool(some.held[0, 0]),
            "end_clamped": bool(some.held[0, 1]),
            "torsion_ratio": None if np.isnan(some.torsion_ratio[0]) else some.torsion_ratio,
            "chord": _chord(some),
        }
        if np.isnan(some.margins[:, 0]).all():
            judged = stability_at_nodes(*given, **ends)
            found.margins[rows, 0] = judged.in_plane
            margins[rows], found.free_turns[rows] = judged.out_of_plane, judged.free_turn
        else:
            margins[rows], found.free_turns[rows] = out_of_plane_at_nodes(*given, **ends)
    return margins


def _unjudged(found: Equilibria, margins: Array) -> Iterator[tuple[np.ndarray, TrialSpace, Array, Array, Equilibria]]:
    """Rows without a margin, alike in their ends and fineness; their trial space, angles and curvatures there."""
    missing = np.flatnonzero(np.isnan(margins))
    if not len(missing):
        return
    discretise(found)
    kinds = np.column_stack([found.held, found.omega < SMOOTH_OMEGA, np.isnan(found.torsion_ratio)])[missing]
    for kind in np.unique(kinds, axis=0) if len(missing) > 1 else kinds:
        rows = missing[(kinds == kind).all(axis=1)]
        some = found.take(rows) if len(rows) < len(found) else found
        modes = SMOOTH_MODES if some.omega[0] < SMOOTH_OMEGA else SHARP_MODES
        space, values, slopes = nodes(bool(some.held[0, 0]), bool(some.held[0, 1]), modes)
        z = some.z[:, : modes + 2]
        # z is in the frame of the chord; full turns do not matter to stability.
        yield rows, space, z @ values.T + some.frame[:, None], z @ slopes.T, some


def _chord(some: Equilibria) -> Array:
    """From start to end, shape (n, 2)."""
    chord: Array = (1.0 - some.excess)[:, None] * np.stack([np.cos(some.frame), np.sin(some.frame)], axis=-1)
    return chord


def discretise(found: Equilibria) -> Array:
    """Modes of all rows, shape (n, 46); missing ones as c_j = int kappa p_j ds over the exact shape."""
    unknown = np.isnan(found.z[:, 0])
    if unknown.any():
        for smooth in (True, False):
            rows = np.flatnonzero(unknown & ((found.omega < SMOOTH_OMEGA) == smooth))
            if len(rows):
                some = found.take(rows) if len(rows) < len(found) else found
                modes = SMOOTH_MODES if smooth else SHARP_MODES
                s, weighted = _projection(modes)
                if len(some) == 1 and not some.taut[0]:
                    kappa = curvature(State(*(getattr(some, name).item() for name in State._fields)), s - 0.5)[None]
                else:
                    kappa = some.at(s)[1]
                found.z[rows] = 0.0
                found.z[rows, 0], found.z[rows, 1] = some.theta0 - some.frame, some.theta1 - some.frame
                found.z[rows, 2 : modes + 2] = kappa @ weighted
    return found.z


@lru_cache(maxsize=4)
def _projection(modes: int) -> tuple[Array, Array]:
    """Gauss nodes, and the Legendre polynomials at them times the weights."""
    space = ritz(True, True, modes)
    polynomial, _ = legendre(space.s, modes)
    return space.s, space.weights[:, None] * polynomial
