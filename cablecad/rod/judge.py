"""What equilibria are judged for only if someone asks: their margins of stability, and their modes.

The answers are written into the arrays they were missing in, so that no one pays twice: a slice shares its arrays with
the whole. How many trial functions a margin needs goes with the steepest stretch of the shape,
max(omega, greatest curvature/2); tests/experiments/margin_modes.py measured it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Literal

import numpy as np

from cablecad.rod.course import Course
from cablecad.rod.equilibria import Equilibria, modes_for
from cablecad.rod.midpoint import State
from cablecad.rod.ritz import ritz
from cablecad.rod.stability import NEUTRAL, forms_at_nodes, stability
from cablecad.rod.steady import definite, is_steady
from cablecad.rod.trace import Trace
from cablecad.rod.trial import Array, TrialSpace, legendre, trial_space

TRIAL_MODES = (
    *((4.0, 16), (5.0, 20), (6.0, 24), (7.0, 28), (8.0, 32), (9.0, 36), (10.0, 40), (11.0, 44)),
    *((18.0, 60), (60.0, 84)),
)
"""Trial functions by steepness: margins to 1e-6 (1 + steepness^2), up to 11 to 2e-7."""

SHARPEST = 60.0
"""Steeper shapes, long loops, are judged on panels that get small towards their loop, one by one."""

VERDICT_MODES = ((4.0, 12), (6.0, 16), (8.0, 24), (11.0, 32), (14.0, 44), (SHARPEST, 60))
"""As many give 1e-4 (1 + steepness^2)."""

SURE = 1e-3
"""A margin above this share of 1 + steepness^2 by `VERDICT_MODES` is stable without more ado."""

DOUBT = 1e-5
"""A margin nearer to zero than this share of 1 + steepness^2 is found again with `FINEST` functions."""

FINEST = 128

CLEAR = 0.02
"""A margin of the search's own 14 to 44 modes, right to 6e-3 (1 + steepness^2) at worst, has its sign beyond this."""


def clear_verdict(forms: Array, steepness: Array) -> np.ndarray:
    """1 or -1 where the least eigenvalue of rough forms, shape (n, m, m), has its sign beyond doubt, else 0."""
    verdict = _signs(forms, CLEAR * (1.0 + steepness**2))
    verdict[steepness > SHARPEST] = 0
    return verdict


def _signs(forms: Array, doubt: Array) -> np.ndarray:
    """Signs of the least eigenvalues of symmetric matrices, shape (n, m, m); 0 within `doubt`, (n,), or of none."""
    shift = doubt[:, None, None] * np.eye(forms.shape[-1])
    sign = definite(forms - shift).astype(int)
    rest = np.flatnonzero(sign == 0)
    undecided = definite(forms[rest] + shift[rest]) | ~np.isfinite(forms[rest]).all(axis=(1, 2))
    sign[rest] = np.where(undecided, 0, -1)
    return sign


Plane = Literal[0, 1]
"""In (0) or out of (1) the plane."""


def judge_in_plane(found: Equilibria) -> None:
    """Find the verdicts in the plane that are missing, by which the search ranks; the steepest are left for later.

    Margins are found only of those that are near zero: most equilibria of a search nobody ever asks about.
    """
    steepness = np.maximum(found.omega, found.kappa_max / 2.0)
    rows = np.flatnonzero((steepness <= SHARPEST) & (found.verdict[:, 0] == 0))
    _decide_clear(found, rows, steepness[rows])
    rows = rows[found.verdict[rows, 0] == 0]
    if not len(rows):
        return
    _judge_with(found, rows, _counts(TRIAL_MODES, steepness[rows]), planes=(0,))
    doubtful = rows[np.abs(found.margins[rows, 0]) < DOUBT * (1.0 + steepness[rows] ** 2)]
    if len(doubtful):
        _judge_with(found, doubtful, np.full(len(doubtful), FINEST), planes=(0,))
    found.verdict[rows, 0] = np.where(found.margins[rows, 0] > NEUTRAL, 1, -1)


def _decide_clear(found: Equilibria, rows: np.ndarray, steepness: Array) -> None:
    """Verdicts in the plane of those `rows` whose margins are farther from zero than rough ones can be wrong."""
    doubt = np.zeros(len(found))
    doubt[rows] = SURE * (1.0 + steepness**2)
    for own, some, space in _alike(found, rows, _counts(VERDICT_MODES, steepness)):
        (forms,), _ = _forms(some, space, *some.tangents(space.s), (0,))
        found.verdict[own, 0] = _signs(forms, doubt[own])


def judge(found: Equilibria) -> None:
    """Find the margins that are missing, and with them both verdicts and whether a turn is free."""
    missing = np.flatnonzero(np.isnan(found.margins[:, 1]))
    if not len(missing):
        return
    steepness = np.maximum(found.omega, found.kappa_max / 2.0)[missing]
    plain = steepness <= SHARPEST
    whole = np.isnan(found.margins[missing, 0])
    both: tuple[Plane, ...] = (0, 1)
    for some, planes in ((plain & whole, both), (plain & ~whole, both[1:])):
        if some.any():
            _judge_with(found, missing[some], _counts(TRIAL_MODES, steepness[some]), planes=planes)
    for row in missing[~plain]:
        _judge_on_panels(found, row)
    doubtful = plain & (np.min(np.abs(found.margins[missing]), axis=1) < DOUBT * (1.0 + steepness**2))
    if doubtful.any():
        _judge_with(found, missing[doubtful], np.full(np.count_nonzero(doubtful), FINEST), planes=both)
    found.verdict[missing] = np.where(found.margins[missing] > NEUTRAL, 1, -1)


def _counts(modes: Sequence[tuple[float, int]], steepness: Array) -> np.ndarray:
    """Trial functions for shapes by their steepness, of `TRIAL_MODES` or `VERDICT_MODES`."""
    limits, counts = zip(*modes, strict=True)
    return np.array(counts)[np.searchsorted(limits, steepness)]


def decide(found: Equilibria, plane: Plane) -> np.ndarray:
    """Verdicts in or out of the plane, 1 or -1, shape (n,); what is not yet known is found.

    One equilibrium that is stable beyond doubt is seen to be so without its margins.
    """
    if not found.verdict[:, plane].all():
        if len(found) == 1 and max(found.omega[0], found.kappa_max[0] / 2.0) <= SHARPEST:
            steady, free = _one_is_steady(found)
            if steady:
                found.verdict[:] = 1
                found.free_turns[:] = free
                return found.verdict[:, plane]
        judge(found)
    return found.verdict[:, plane]


def _judge_with(found: Equilibria, rows: np.ndarray, counts: np.ndarray, *, planes: tuple[Plane, ...]) -> None:
    """Margins of `rows`, each by its number of trial functions."""
    for own, some, space in _alike(found, rows, counts):
        forms, free = _forms(some, space, *some.tangents(space.s), planes)
        found.margins[own[:, None], planes] = np.linalg.eigvalsh(forms)[..., 0].T
        if 1 in planes:
            found.free_turns[own] = free


def _alike(
    found: Equilibria, rows: np.ndarray, counts: np.ndarray
) -> Iterator[tuple[np.ndarray, Equilibria, TrialSpace]]:
    """Rows alike in their ends and in their number of trial functions together: their indices, and these functions."""
    kinds = np.column_stack([found.held[rows], np.isnan(found.torsion_ratio[rows]), counts])
    for kind in np.unique(kinds, axis=0) if len(rows) > 1 else kinds:
        own = rows[(kinds == kind).all(axis=1)]
        some = found.take(own) if len(own) < len(found) else found
        yield own, some, trial_space(bool(kind[0]), bool(kind[1]), (0.0, 1.0), int(kind[3]))


def _judge_on_panels(found: Equilibria, i: int) -> None:
    """Margins of one row by `stability`, which chooses its panels."""
    row = found.take(np.array([i]))
    ratio = float(row.torsion_ratio[0])
    judged = stability(
        lambda s: row.at(np.atleast_1d(s))[0][0],
        lambda s: row.at(np.atleast_1d(s))[1][0],
        row.force[0],
        start_clamped=bool(row.held[0, 0]),
        end_clamped=bool(row.held[0, 1]),
        torsion_ratio=None if math.isnan(ratio) else ratio,
        chord=_chord(row)[0],
    )
    found.margins[i] = float(judged.in_plane), float(judged.out_of_plane)
    found.free_turns[i] = bool(judged.free_turn)


def _one_is_steady(row: Equilibria) -> tuple[bool, bool]:
    """Whether a single row is stable beyond doubt, and whether a turn is free."""
    start_clamped, end_clamped = row.held[0].tolist()
    state = State(*(getattr(row, name).item() for name in State._fields))
    steepness = max(state.omega, row.kappa_max.item() / 2.0)
    count = next(count for limit, count in VERDICT_MODES if steepness <= limit)
    space = trial_space(start_clamped, end_clamped, (0.0, 1.0), count)
    ratio, size, frame = row.torsion_ratio.item(), 1.0 - row.excess.item(), row.frame.item()
    x, y = row.force[0].tolist()
    return is_steady(
        space,
        *Course(state).tangent(space.s - 0.5),
        (x, y),
        (row.theta0.item(), row.theta1.item()),
        (size * math.cos(frame), size * math.sin(frame)),
        start_clamped=start_clamped,
        end_clamped=end_clamped,
        torsion_ratio=None if math.isnan(ratio) else ratio,
        above=SURE * (1.0 + steepness**2),
    )


def _forms(
    some: Equilibria, space: TrialSpace, cosine: Array, sine: Array, kappa: Array, planes: tuple[Plane, ...]
) -> tuple[Array, Any]:
    """`forms_at_nodes` of rows alike in their ends."""
    return forms_at_nodes(
        space,
        cosine,
        sine,
        kappa,
        some.force,
        np.stack([some.theta0, some.theta1], axis=-1),
        start_clamped=bool(some.held[0, 0]),
        end_clamped=bool(some.held[0, 1]),
        torsion_ratio=None if np.isnan(some.torsion_ratio[0]) else some.torsion_ratio,
        chord=_chord(some),
        planes=planes,
    )


@dataclass(frozen=True, slots=True)
class RowStability:
    """The `Stability` of a single row, found as far as it is asked for: a verdict costs less than a margin.

    Attributes:
        trace: Of the equilibrium.
        spin: ``"clamped"`` where the twist's stiffness takes part, else ``"free"``.
    """

    trace: Trace
    spin: str

    @property
    def in_plane(self) -> float:
        """Least eigenvalue in the plane."""
        return float(self.trace.row.margin_in_plane[0])

    @property
    def out_of_plane(self) -> float:
        """Least eigenvalue out of the plane."""
        return float(self.trace.row.margin_out_of_plane[0])

    @property
    def free_turn(self) -> bool:
        """Whether a turn about an axis of the ends was left out of `out_of_plane`."""
        return bool(self.trace.row.free_turn[0])

    @property
    def stable_in_plane(self) -> bool:
        """Whether every small motion in the plane costs energy."""
        return self._verdict(0)

    @property
    def stable_out_of_plane(self) -> bool:
        """Whether every small motion out of the plane costs energy, turns about free axes left out."""
        return self._verdict(1)

    def _verdict(self, plane: Plane) -> bool:
        known = int(self.trace.among.verdict[self.trace.place, plane]) or int(decide(self.trace.row, plane)[0])
        return known > 0


def _chord(some: Equilibria) -> Array:
    """From start to end, shape (n, 2)."""
    chord: Array = (1.0 - some.excess)[:, None] * np.stack([np.cos(some.frame), np.sin(some.frame)], axis=-1)
    return chord


@lru_cache(maxsize=16)
def nodes(start_clamped: bool, end_clamped: bool, modes: int) -> tuple[TrialSpace, Array]:
    """Trial functions for the stability, and the Ritz functions at their nodes."""
    space = trial_space(start_clamped, end_clamped, (0.0, 1.0), modes)
    _, values = legendre(space.s, modes)
    return space, np.column_stack([1.0 - space.s, space.s, values])


def discretise(found: Equilibria) -> Array:
    """Modes of all rows, shape (n, 46); missing ones as c_j = int kappa p_j ds over the exact shape."""
    unknown = np.isnan(found.z[:, 0])
    if unknown.any():
        counts = modes_for(found.omega)
        for modes in np.unique(counts[unknown]).tolist():
            rows = np.flatnonzero(unknown & (counts == modes))
            some = found.take(rows) if len(rows) < len(found) else found
            s, weighted = _projection(modes)
            if len(some) == 1 and not some.taut[0]:
                state = State(*(getattr(some, name).item() for name in State._fields))
                kappa = Course(state).at(s - 0.5).kappa[None]
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
