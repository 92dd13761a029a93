"""Stability of planar elastica: the least eigenvalue of the second variation of the energy, in and out of the plane.

Units: L = EI = 1. An equilibrium has angle theta(s), curvature kappa = theta' and constant internal force n (tension
positive), theta'' = n_x sin(theta) - n_y cos(theta). With t = (cos theta, sin theta) the second variation is

* in the plane, for a turn phi: int phi'^2 + (n.t) phi^2, where int phi sin(theta) = int phi cos(theta) = 0 (the ends
  stay where they are);
* out of the plane, for a tilt v: int v'^2 + (n.t - kappa^2) v^2 [+ GJ/EI (int kappa v)^2], where int v = 0. The last
  term is there only where both ends hold the cable's spin; without it each cross-section is free to spin.

phi and v vanish at a clamp and are free at a pin.

**Normalisation of the margins.** A margin is the least value of that form where int phi^2 ds = 1 (out of the plane:
int v^2 ds = 1), in units of EI/L^2 for a cable of length L: the least eigenvalue of -phi'' + (n.t) phi = lambda phi
(+ multipliers). It does not depend on the basis, has a meaning for clamps and pins alike, and is the one that gives a
cable pinned at both ends +0.18, -0.30, -1.12 at end angles of 130, 132 and 160 degrees. (The same form over int phi'^2
has the same sign, is at most 1, and exists for clamped ends only.) Positive: stable.

**Zero modes.** Turning the whole cable about an axis that its ends leave free costs no energy; such a mode is an
eigenfunction with eigenvalue 0 and all others are orthogonal to it in this normalisation, so that it is left out
exactly: v = sin(theta - angle of the axis) out of the plane, phi = 1 in the plane for two pins at one point.
`Stability.free_turn` says that there was one.

Limits: theta and kappa are taken at the nodes of a `TrialSpace` and must be resolved there.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from cablecad.rod.trial import PANEL_MODES, Array, TrialSpace, refine, trial_space

PARALLEL = 1e-9
"""Sine of an angle, or chord over length, below which an axis counts as met: squares of it are below rounding."""

NEUTRAL = 1e-8
"""Margins closer to zero are rounding: eps times the largest eigenvalue (4e5 for 44 functions), and some reserve."""


class Judged(Protocol):
    """What is asked of the stability of one equilibrium; see `Stability`."""

    @property
    def in_plane(self) -> Any: ...  # noqa: D102
    @property
    def out_of_plane(self) -> Any: ...  # noqa: D102
    @property
    def free_turn(self) -> Any: ...  # noqa: D102
    @property
    def spin(self) -> str: ...  # noqa: D102
    @property
    def stable_in_plane(self) -> Any: ...  # noqa: D102
    @property
    def stable_out_of_plane(self) -> Any: ...  # noqa: D102


@dataclass(frozen=True, slots=True)
class Stability:
    """Margins of one equilibrium (floats) or of many (shape (n,)); see the module for their normalisation.

    Attributes:
        in_plane: Least eigenvalue in the plane.
        out_of_plane: Least eigenvalue out of the plane, zero modes left out.
        free_turn: Whether a turn about an axis of the ends was left out of `out_of_plane`.
        spin: ``"clamped"`` where the twist's stiffness took part, else ``"free"``.
    """

    in_plane: Any
    out_of_plane: Any
    free_turn: Any
    spin: str

    @property
    def stable_in_plane(self) -> Any:
        """Whether every small motion in the plane costs energy."""
        return self.in_plane > NEUTRAL

    @property
    def stable_out_of_plane(self) -> Any:
        """Whether every small motion out of the plane costs energy, turns about free axes left out."""
        return self.out_of_plane > NEUTRAL


def stability(
    theta: Callable[[Array], Any],
    kappa: Callable[[Array], Any],
    n: Any,
    *,
    start_clamped: bool,
    end_clamped: bool,
    torsion_ratio: float | None = None,
    chord: Any = None,
) -> Stability:
    """Judge one equilibrium given as functions of arclength.

    Args:
        theta: Angle of the tangent at an array of arclengths in [0, 1], without jumps [rad].
        kappa: Curvature theta' there, in units of 1/L.
        n: Internal force, shape (2,), in units of EI/L^2.
        start_clamped: Whether the direction at s = 0 is held.
        end_clamped: Whether the direction at s = 1 is held.
        torsion_ratio: GJ/EI where both ends hold the spin; None: spin is free. Ignored as soon as an end is a pin.

        chord: From start to end, shape (2,), where it is known better than by quadrature.

    Returns:
        The margins, each of shape ().

    Accuracy: 1e-9 relative to the largest of 1, |n| and the margin; tests/rod/test_stability.py.
    """
    force = np.asarray(n, dtype=float)
    breaks = refine(kappa, omega=float(np.sqrt(np.hypot(force[0], force[1]))))
    if len(breaks) <= 5:
        # Up to four panels' turn: one polynomial is cheaper than panels and converges faster.
        space = trial_space(start_clamped, end_clamped)
    else:
        space = trial_space(start_clamped, end_clamped, breaks, PANEL_MODES)
    return stability_at_nodes(
        space,
        np.asarray(theta(space.s), dtype=float),
        np.asarray(kappa(space.s), dtype=float),
        force,
        np.asarray(theta(np.array([0.0, 1.0])), dtype=float),
        start_clamped=start_clamped,
        end_clamped=end_clamped,
        torsion_ratio=torsion_ratio,
        chord=chord,
    )


def stability_at_nodes(
    space: TrialSpace,
    theta: Array,
    kappa: Array,
    n: Array,
    ends: Array,
    *,
    start_clamped: bool,
    end_clamped: bool,
    torsion_ratio: Any = None,
    chord: Any = None,
) -> Stability:
    """Judge one equilibrium or many, given at the nodes of a trial space made for the same ends.

    Args:
        space: From `trial_space(start_clamped, end_clamped, ...)`.
        theta: Angles at `space.s`, shape (..., q) [rad].
        kappa: Curvatures there, shape (..., q).
        n: Internal forces, shape (..., 2).
        ends: Angles at s = 0 and s = 1, shape (..., 2) [rad].
        start_clamped: Whether the direction at s = 0 is held.
        end_clamped: Whether the direction at s = 1 is held.
        torsion_ratio: GJ/EI, shape () or (...,), where both ends hold the spin; None: spin is free.

        chord: From start to end, shape (..., 2), where it is known better than by quadrature.

    Returns:
        The margins, each of shape (...,).
    """
    cosine, sine = np.cos(theta), np.sin(theta)
    forms, free = forms_at_nodes(
        space,
        cosine,
        sine,
        kappa,
        n,
        ends,
        start_clamped=start_clamped,
        end_clamped=end_clamped,
        torsion_ratio=torsion_ratio,
        chord=_chord(space, cosine, sine) if chord is None else chord,
    )
    least = np.linalg.eigvalsh(forms)[..., 0]
    held = start_clamped and end_clamped and torsion_ratio is not None
    return Stability(least[0], least[1], free, "clamped" if held else "free")


def forms_at_nodes(
    space: TrialSpace,
    cosine: Array,
    sine: Array,
    kappa: Array,
    n: Array,
    ends: Array,
    *,
    start_clamped: bool,
    end_clamped: bool,
    torsion_ratio: Any,
    chord: Array,
    planes: tuple[int, ...] = (0, 1),
) -> tuple[Array, Any]:
    """The second variations in (0) and out of (1) the plane, their eigenvalues' matrices; arguments as before.

    Args as for `stability_at_nodes`, but for the tangents (`cosine`, `sine`) at the nodes, shape (..., q) each.

    Returns:
        Matrices of shape (planes, ..., m, m) on the motions that the ends allow; whether a free turn was left out, if
        those out of the plane are asked for.
    """
    tension = n[..., :1] * cosine + n[..., 1:] * sine
    pins = not start_clamped and not end_clamped
    if planes == (0,):
        return restricted(*_in_plane(space, cosine, sine, tension, chord, pins))[None], False
    held = start_clamped and end_clamped and torsion_ratio is not None
    tilted, free = _out_of_plane(
        space, cosine, sine, tension, kappa, ends, chord, start_clamped, end_clamped, torsion_ratio if held else None
    )
    if planes == (1,):
        return restricted(*tilted)[None], free
    flat = _in_plane(space, cosine, sine, tension, chord, pins)
    # Both at once: at this size calls cost more than arithmetic.
    rows = np.zeros((2, *tilted[1].shape))
    rows[0, ..., : flat[1].shape[-2], :], rows[1] = flat[1], tilted[1]
    return restricted(np.stack([flat[0], tilted[0]]), rows), free


def form_in_plane(
    space: TrialSpace, cosine: Array, sine: Array, n: Array, *, start_clamped: bool, end_clamped: bool, chord: Array
) -> Array:
    """The form in the plane alone, shape (..., m, m); arguments as for `forms_at_nodes`."""
    tension = n[..., :1] * cosine + n[..., 1:] * sine
    return restricted(*_in_plane(space, cosine, sine, tension, chord, not start_clamped and not end_clamped))


def _chord(space: TrialSpace, cosine: Array, sine: Array) -> Array:
    return np.stack([cosine @ space.weights, sine @ space.weights], axis=-1)


def _in_plane(
    space: TrialSpace, cosine: Array, sine: Array, tension: Array, chord: Array, pins: bool
) -> tuple[Array, Array]:
    """The form in the plane, and the rows that motions are normal to."""
    return space.form(tension), _held_rows(
        space, cosine, sine, np.hypot(chord[..., 0], chord[..., 1]) <= PARALLEL if pins else None
    )


def _out_of_plane(
    space: TrialSpace,
    cosine: Array,
    sine: Array,
    tension: Array,
    kappa: Array,
    ends: Array,
    chord: Array,
    start_clamped: bool,
    end_clamped: bool,
    torsion_ratio: Any,
) -> tuple[tuple[Array, Array], Any]:
    """The form out of the plane and its rows; and whether a free turn is among them. `torsion_ratio` None: free."""
    length = np.hypot(chord[..., 0], chord[..., 1])
    held = torsion_ratio is not None
    modes, free = _zero_modes(space, cosine, sine, chord, length, ends, start_clamped, end_clamped, held)
    form = space.form(tension - kappa**2)
    if held:
        twist = kappa @ space.weighted
        form += (np.asarray(torsion_ratio)[..., None] * twist)[..., :, None] * twist[..., None, :]
    flat = np.broadcast_to(space.mean, modes[0].shape)
    return (form, np.stack([flat, *modes], axis=-2)), free


def _held_rows(space: TrialSpace, cosine: Array, sine: Array, turn_free: Any) -> Array:
    """What motions in the plane are normal to: the ends stay, and a free turn is left out."""
    rows = np.stack([sine @ space.weighted, cosine @ space.weighted], axis=-2)
    if turn_free is not None and np.any(turn_free):
        turn = np.broadcast_to(space.mean, rows[..., :1, :].shape)
        rows = np.concatenate([rows, np.where(np.asarray(turn_free)[..., None, None], turn, 0.0)], axis=-2)
    return rows


def _zero_modes(
    space: TrialSpace,
    cosine: Array,
    sine: Array,
    chord: Array,
    length: Array,
    ends: Array,
    start_clamped: bool,
    end_clamped: bool,
    held: bool,
) -> tuple[list[Array], Any]:
    """Rows, zero where there is none, of the turns about axes the ends leave free: sin(theta - axis angle).

    An axis passes through both end points and along the tangent of each clamp. Ends at one point leave the axis of a
    clamp, or every axis (two rows) where both are pins. Held frames also need t1 = +t0: else the twist answers.
    """
    coincident = length <= PARALLEL
    axis = chord / np.where(coincident, 1.0, length)[..., None]
    start, end = (np.stack([np.cos(ends[..., i]), np.sin(ends[..., i])], axis=-1) for i in (0, 1))
    one = np.ones_like(length, dtype=bool)
    if start_clamped or end_clamped:
        axis = np.where(coincident[..., None], start if start_clamped else end, axis)
        free = one
        for clamped, tangent in ((start_clamped, start), (end_clamped, end)):
            if clamped:
                free = free & (np.abs(axis[..., 0] * tangent[..., 1] - axis[..., 1] * tangent[..., 0]) <= PARALLEL)
        if held:
            free = free & (np.sum(start * end, axis=-1) > 0.0)
        second = one & False
    else:
        axis = np.where(coincident[..., None], np.array([1.0, 0.0]), axis)
        free, second = one, coincident
    about = axis[..., :1] * sine - axis[..., 1:] * cosine
    across = axis[..., :1] * cosine + axis[..., 1:] * sine
    rows = [np.where(free[..., None], about, 0.0), np.where(second[..., None], across, 0.0)]
    return [row @ space.weighted for row in rows], free


def restricted(form: Array, rows: Array) -> Array:
    """Symmetric matrices on the null space of a few rows, and out of the way elsewhere.

    Args:
        form: Shape (..., m, m), symmetric.
        rows: Shape (..., r, m); rows may be zero or depend on each other (a straight cable: sin(theta) = 0).

    Returns:
        Shape (..., m, m): the same form, but larger than anything in it along the rows; symmetric but for rounding.
    """
    count = rows.shape[-2]
    unit = np.zeros_like(rows)
    sizes = np.sqrt(np.einsum("...ij,...ij->...i", rows, rows))
    for i in range(count):
        row = rows[..., i, :]
        if not row.any():
            continue  # most cables have no free turn
        for _ in range(2 if i else 0):  # twice is enough: the second pass removes what rounding left of the first
            row = row - ((row[..., None, :] @ np.swapaxes(unit[..., :i, :], -1, -2)) @ unit[..., :i, :])[..., 0, :]
        left = np.sqrt(np.einsum("...i,...i->...", row, row)) if i else sizes[..., 0]
        # A row that lost all but a few units of rounding depends on those before it. A hair of slack makes for a short
        # one; what has no square is zero.
        good = left > np.maximum(1e-14 * sizes[..., i], 1e-150)
        unit[..., i, :] = row * np.where(good, 1.0 / np.where(good, left, 1.0), 0.0)[..., None]
    across = np.swapaxes(unit, -1, -2)
    image = form @ across
    inner = unit @ image
    # Lifted above everything else, the constrained directions cannot be the least.
    lift = 1.0 + 2.0 * np.max(np.abs(np.diagonal(form, axis1=-2, axis2=-1)), axis=-1)[..., None, None]
    lifted = inner + lift * np.eye(inner.shape[-1])
    # P form P + across lifted unit, P = 1 - across unit, with half of what is taken off; the other is its transpose.
    half = (image - across @ (lifted / 2.0)) @ unit
    projected: Array = form - half
    projected -= np.swapaxes(half, -1, -2)
    return projected
