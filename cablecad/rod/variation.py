"""The first variation of an elastica: what its angle does when its ends are moved, over panels as fine as it needs.

With t = (cos theta, sin theta), v = (-sin theta, cos theta) and the force n an elastica has theta'' = -n.v. A neighbour
of it is off by d, at the force n + f, with

    d'' = (n.t) d - f.v,    int d v ds = the move of the end,    d given at a clamp, d' = 0 at a pin,

which is solved in its weak form: int d' w' + (n.t) d w - (f.v) w ds = [d' w] for all w. At a clamp that form gives the
change of the curvature too, as accurately as an energy: twice the digits of d itself.

Nothing here is discretised but d: theta comes from the exact curve.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cablecad.errors import UsageError
from cablecad.rod.quadrature import gauss_legendre
from cablecad.rod.trial import PANEL_MODES, Array, legendre, refine

_POINTS = 22
"""Gauss points a panel: they integrate products of three smooth factors to rounding."""

_MOST_PANELS = 1500
"""As many unknowns; a fifth of a second."""

Curve = Callable[[Array], Array]


@dataclass(frozen=True)
class Variation:
    """The change of a rod of length one by unit moves: of its end along x and y, of its angles at start and end.

    The last axis of each array runs over these four.

    Attributes:
        force: Of n, shape (2, 4).
        kappa0: Of the curvature at the start, shape (4,); 0 at a pin.
        kappa1: The same at the end.
        theta0: Of the angle at the start, shape (4,).
        theta: The rod's angle.
        breaks: Where panels begin and end, shape (panels + 1,).
        angles: Of the angle, by the functions of each panel, shape (panels, functions, 4).
        moves: Of the end of each panel, as seen from its start, shape (panels, 2, 4).
    """

    force: Array
    kappa0: Array
    kappa1: Array
    theta0: Array
    theta: Curve
    breaks: Array
    angles: Array
    moves: Array

    def moved(self, s: Array) -> Array:
        """The change of the points at some shares of the length, shape (k, 2, 4): int_0^s v d ds."""
        panel = np.clip(np.searchsorted(self.breaks, s, side="right") - 1, 0, len(self.breaks) - 2)
        before = np.concatenate([np.zeros((1, 2, 4)), np.cumsum(self.moves, axis=0)])
        moved: Array = before[panel] + self._integrals(panel, s - self.breaks[panel])
        return moved

    def _integrals(self, panels: np.ndarray, lengths: Array) -> Array:
        """int v d ds over the first `lengths` of some panels, shape (k, 2, 4)."""
        if not len(panels):
            return np.zeros((0, 2, 4))
        node, weight = gauss_legendre(_POINTS)
        width = np.diff(self.breaks)[panels]
        inside = node * (lengths / width)[:, None]
        theta = self.theta((self.breaks[panels, None] + width[:, None] * inside).ravel()).reshape(inside.shape)
        values = _functions(inside.ravel())[0].reshape(*inside.shape, -1)
        angle = (values @ self.angles[panels]) * (lengths[:, None] * weight)[..., None]
        across = np.stack([-np.sin(theta), np.cos(theta)], axis=1)
        integrals: Array = across @ angle
        return integrals


def vary(theta: Curve, kappa: Curve, force: Array, *, start_clamped: bool, end_clamped: bool) -> Variation:
    """Find how an elastica of length one answers moves of its ends.

    Args:
        theta: Its angle at an array of shares of the length.
        kappa: Its curvature there.
        force: n, shape (2,).
        start_clamped: Whether the angle is held at the start; else it is a pin, whose angle is no input.
        end_clamped: Whether it is at the end.

    Raises:
        UsageError: The shape is too sharp, straight, or exactly at a fold.
    """
    omega = float(np.hypot(*force)) ** 0.5
    breaks = np.array(refine(lambda s: np.maximum(np.abs(kappa(s)), omega), omega=omega))
    panels = len(breaks) - 1
    if panels > _MOST_PANELS:
        raise UsageError(
            f"the shape is too sharp for derivatives: it would take {panels} panels to resolve its bends, "
            f"{_MOST_PANELS} are the most"
        )
    local, pull = _forms(theta, force, breaks)
    system, answers = _condensed(local, pull)
    hats = panels + 1  # the unknowns: the angles where panels meet, then the force
    free = np.ones(hats + 2, bool)
    free[[0, hats - 1]] = not start_clamped, not end_clamped
    field, right = np.zeros((hats + 2, 4)), np.zeros((hats + 2, 4))
    right[hats:, :2] = np.eye(2)
    field[0, 2], field[hats - 1, 3] = start_clamped, end_clamped
    try:
        field[free] = np.linalg.solve(system[np.ix_(free, free)], (right - system @ field)[free])
    except np.linalg.LinAlgError:
        raise UsageError("the shape is straight or at a fold, where a change of the ends has no derivative") from None
    moments = system[[0, hats - 1]] @ field
    kappa0, kappa1 = np.zeros((2, 4))
    if start_clamped:
        kappa0 = -moments[0]
    if end_clamped:
        kappa1 = moments[1]
    change, pair = field[hats:], np.stack([field[: hats - 1], field[1:hats]], axis=1)
    angles = np.concatenate([answers[..., :2] @ pair + answers[..., 2:] @ change, pair], axis=1)
    return Variation(change, kappa0, kappa1, field[0], theta, breaks, angles, np.swapaxes(pull, 1, 2) @ angles)


def _forms(theta: Curve, force: Array, breaks: Array) -> tuple[Array, Array]:
    """Of each panel's functions int w' w' + (n.t) w w ds and int v w ds, shapes (panels, m, m) and (panels, m, 2)."""
    node, weight = gauss_legendre(_POINTS)
    values, slopes = _functions(node)
    width = np.diff(breaks)
    angle = theta((breaks[:-1, None] + width[:, None] * node).ravel()).reshape(len(width), -1)
    cosine, sine = np.cos(angle), np.sin(angle)
    weights = width[:, None] * weight
    local = (slopes.T * weight) @ slopes / width[:, None, None]
    local += values.T @ ((weights * (force[0] * cosine + force[1] * sine))[..., None] * values)
    return local, np.stack([-(weights * sine) @ values, (weights * cosine) @ values], axis=-1)


def _condensed(local: Array, pull: Array) -> tuple[Array, Array]:
    """The equations of the hats and the force, once what is within a panel is eliminated, which answers these alone.

    Returns:
        The matrix, shape (panels + 3, panels + 3): rows of the hats, then the move of the end; and how the inner
        functions of each panel answer its two hats and the force, shape (panels, m - 2, 4).
    """
    panels, own, hats = len(local), slice(0, PANEL_MODES), slice(PANEL_MODES, None)
    answers = -np.linalg.solve(local[:, own, own], np.concatenate([local[:, own, hats], -pull[:, own]], axis=2))
    rows = np.concatenate([local[:, hats, hats], -pull[:, hats]], axis=2)
    rows += np.swapaxes(local[:, own, hats], 1, 2) @ answers
    whole = np.concatenate([answers, np.broadcast_to(np.eye(2, 4), (panels, 2, 4))], axis=1)
    moves = np.swapaxes(pull, 1, 2) @ whole
    system, first = np.zeros((panels + 3, panels + 3)), np.arange(panels)
    for a in (0, 1):
        for b in (0, 1):
            system[first + a, first + b] += rows[:, a, b]
        system[first + a, -2:] += rows[:, a, 2:]
        system[-2:, first + a] += moves[:, :, a].T
    system[-2:, -2:] = moves[:, :, 2:].sum(axis=0)
    return system, answers


def _functions(share: Array) -> tuple[Array, Array]:
    """A panel's functions at shares of it, and their slopes by the share: polynomials that vanish at its ends, hats."""
    polynomial, integral = legendre(share, PANEL_MODES)
    one = np.ones_like(share)
    return np.column_stack([integral, 1.0 - share, share]), np.column_stack([polynomial, -one, one])
