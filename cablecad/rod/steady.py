"""Whether one equilibrium is stable beyond doubt, in as few calls as possible.

The forms, rows and zero modes are those of `stability`, where they are derived, for a single shape: there calls of
numpy cost more than the arithmetic, and a dragged cable asks for its verdict at every step. Eigenvalues are not found:
a Cholesky decomposition tells that all are above a bound. Motions that the ends forbid are not projected out but made
stiff, which can only lower the others: whatever passes here is stable.
"""

from __future__ import annotations

import math

import numpy as np

from cablecad.rod.stability import PARALLEL
from cablecad.rod.trial import Array, TrialSpace

_TOGETHER = 16
"""Matrices decomposed by one call: one that is not definite ends it."""

_FEW = 8
"""Rows and columns, of the longest waves, in which nearly all that are not definite can be seen not to be."""

_STIFF = 1e6
"""Stiffness of a forbidden motion over the greatest in the form: lowers the others by 1e-6 of what couples them."""


def is_steady(
    space: TrialSpace,
    cosine: Array,
    sine: Array,
    kappa: Array,
    force: tuple[float, float],
    ends: tuple[float, float],
    chord: tuple[float, float],
    *,
    start_clamped: bool,
    end_clamped: bool,
    torsion_ratio: float | None,
    above: float,
) -> tuple[bool, bool]:
    """Whether the margins of one equilibrium in and out of the plane are above a bound.

    Args:
        space: Made for the same ends.
        cosine: Of the tangent's angle at the nodes, shape (q,).
        sine: Likewise.
        kappa: Curvatures there.
        force: Internal force n.
        ends: Angles of the tangent at the ends [rad].
        chord: From start to end.
        start_clamped: Whether the direction at s = 0 is held.
        end_clamped: Whether the direction at s = 1 is held.
        torsion_ratio: GJ/EI where both ends hold the spin; None: spin is free.
        above: The bound; well above the error of the trial functions.

    Returns:
        Whether both are (False does not mean that one is not); and whether a free turn was left out.
    """
    weighted = space.weighted
    tension = force[0] * cosine + force[1] * sine
    potential = np.stack([tension, tension - kappa * kappa])
    forms = space.form(potential)
    mean, across, along = space.mean, sine @ weighted, cosine @ weighted
    pins = not start_clamped and not end_clamped
    length = math.hypot(*chord)
    flat = [across, along, mean] if pins and length <= PARALLEL else [across, along]
    tilted, free = [mean], True
    if pins:
        x, y = (chord[0] / length, chord[1] / length) if length > PARALLEL else (1.0, 0.0)
        tilted.append(x * across - y * along)
        if length <= PARALLEL:
            tilted.append(x * along + y * across)
    else:
        axis = ends[0] if start_clamped else ends[1]
        if length > PARALLEL:
            axis = math.atan2(chord[1], chord[0])
        held = [angle for angle, clamped in zip(ends, (start_clamped, end_clamped), strict=True) if clamped]
        free = all(abs(math.sin(angle - axis)) <= PARALLEL for angle in held)
        if start_clamped and end_clamped and torsion_ratio is not None:
            twist = kappa @ weighted
            forms[1] += torsion_ratio * np.outer(twist, twist)
            free = free and math.cos(ends[0] - ends[1]) > 0.0
        if free:
            tilted.append(math.cos(axis) * across - math.sin(axis) * along)
    for form, rows in zip(forms, (flat, tilted), strict=True):
        stiff = _STIFF * float(form.diagonal().max())
        for row in rows:
            size = float(row @ row)
            if size > 1e-60:  # all sines of a straight cable are zero
                np.add(form, np.multiply.outer(row * (stiff / size), row), out=form)
    forms -= above * np.eye(forms.shape[-1])
    return all_definite(forms), free


def definite(forms: Array) -> np.ndarray:
    """Which of many symmetric matrices, shape (n, m, m), are positive definite, shape (n,)."""
    are = ~_seen_indefinite(forms)
    hopeful = np.flatnonzero(are)
    for low in range(0, len(hopeful), _TOGETHER):
        own = hopeful[low : low + _TOGETHER]
        are[own] = True if all_definite(forms[own]) else [all_definite(form) for form in forms[own]]
    return are


def _seen_indefinite(forms: Array) -> np.ndarray:
    """Of which the first few rows and columns alone are not positive definite, shape (n,): by one elimination of all.

    Each of these would end a call of LAPACK for the matrices beside it, and be looked at alone.
    """
    work = np.ascontiguousarray(np.moveaxis(forms[:, :_FEW, :_FEW], 0, -1))  # matrices last: along memory
    seen = np.zeros(len(forms), dtype=bool)
    for k in range(len(work)):
        pivot = work[k, k]
        seen |= ~(pivot > 0.0)
        factor = work[k, k + 1 :] / np.where(seen, np.inf, pivot)
        work[k + 1 :, k + 1 :] -= work[k + 1 :, k, None] * factor
    return seen


def all_definite(forms: Array) -> bool:
    """Whether symmetric matrices, shape (..., m, m), are all positive definite; a third of the time of eigenvalues."""
    try:
        np.linalg.cholesky(forms)
    except np.linalg.LinAlgError:
        return False
    return True
