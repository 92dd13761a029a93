"""From solutions to equilibria: energy, inflections, side, greatest curvature, stability."""

from __future__ import annotations

from functools import partial

import numpy as np

from cablecad.rod.equilibria import SHARP_MODES, Equilibria, modes_for, sides
from cablecad.rod.flow import Jump
from cablecad.rod.judge import clear_verdict, nodes
from cablecad.rod.polish import Middle
from cablecad.rod.problem import Problem
from cablecad.rod.ritz import Ritz
from cablecad.rod.stability import NEUTRAL, form_in_plane, stability
from cablecad.rod.taut import Taut, wrap
from cablecad.rod.trial import Array

_TURN = 2.0 * np.pi

_TAUT_NOISE = 1e-7
"""Share of omega^2 below which a margin of a taut cable is rounding and counts as none: 6e-9 was seen, of a clamp that
is turned exactly backwards, whose layer turns about the pull freely."""


def classify(
    problem: Problem, space: Ritz, scene: np.ndarray, z: Array, middle: Middle, probe: Jump, residual: Array
) -> Equilibria:
    """Everything worth knowing of polished solutions, in the frames of their chords.

    Args:
        problem: The scenes.
        space: The discretisation of `z`.
        scene: Scene of each solution, shape (n,).
        z: Discretised solutions, shape (n, m + 2).
        middle: Polished states.
        probe: Their flow to `polish.PROBES`.
        residual: Largest unmet end condition of each.
    """
    force = middle.force
    # The discretised solution counts the turns, the polished state has the digits.
    theta_middle = middle.theta + _TURN * np.rint((z @ space.middle[0] - middle.theta) / _TURN)
    kappa_ends = probe.kappa[:, [0, 2]]
    along, across = probe.along - probe.along[:, :1], probe.across - probe.across[:, :1]
    frame = middle.compression
    # Distances from the chord of the middle (minus the start, which lies at -s) and of the quarter point.
    lift = -(np.sin(frame) * probe.along[:, 0] + np.cos(frame) * probe.across[:, 0])
    quarter = np.sin(frame) * along[:, 1] + np.cos(frame) * across[:, 1]
    heights = np.stack([lift, quarter], axis=-1)
    ends = probe.phase[:, 0], probe.phase[:, 2]
    # A revolution never changes the sign of its curvature.
    swings = middle.omega * np.abs(_cosine_half(middle)) >= np.abs(middle.kappa) / 2.0
    inflections = np.where(swings, _zeros(*ends, np.pi / 2.0), 0)
    # Between its ends the curvature is greatest where the tangent meets the compression, and is 2 W there.
    peak = np.sqrt(middle.kappa**2 + (2.0 * middle.omega * _sine_half(middle)) ** 2)
    kappa_max = np.where(_zeros(*ends, 0.0) > 0, peak, np.max(np.abs(kappa_ends), axis=1))
    energy = _bending(middle, z, probe.square[:, 2] - probe.square[:, 0])
    turned = theta_middle[:, None] + probe.turn[:, [0, 2]]
    zero = np.zeros(len(scene))
    found = Equilibria(
        scene=scene,
        theta=theta_middle,
        kappa=middle.kappa,
        lean=middle.lean,
        direction=middle.direction,
        omega=middle.omega,
        tension=middle.tension,
        force=force,
        theta0=z[:, 0] if problem.start_clamped else turned[:, 0],
        theta1=z[:, 1] if problem.end_clamped else turned[:, 1],
        kappa0=kappa_ends[:, 0],
        kappa1=kappa_ends[:, 1],
        energy=energy,
        kappa_max=kappa_max,
        winding=np.zeros(len(scene), dtype=int),
        inflections=inflections,
        heights=heights,
        side=sides(heights),
        residual=residual,
        verdict=np.zeros((len(z), 2), dtype=int),
        margins=np.full((len(z), 2), np.nan),
        free_turns=np.zeros(len(scene), dtype=bool),
        torsion_ratio=_torsion_ratio(problem, len(scene)),
        taut=np.zeros(len(scene), dtype=bool),
        a=zero,
        b=zero,
        z=_as_fine(z, middle.omega),
        held=np.broadcast_to(problem.judged, (len(scene), 2)),
        frame=zero,
        excess=problem.excess[scene],
    )
    found.verdict[:, 0] = _rough_verdict(problem, found, z)
    return found


def _rough_verdict(problem: Problem, found: Equilibria, z: Array) -> np.ndarray:
    """Verdicts in the plane by the search's own modes, 0 where they are not beyond doubt."""
    trial, values = nodes(*problem.judged, z.shape[1] - 2)
    theta = z @ values.T
    forms = form_in_plane(
        trial,
        np.cos(theta),
        np.sin(theta),
        found.force,
        start_clamped=problem.judged[0],
        end_clamped=problem.judged[1],
        chord=_chord(found.excess),
    )
    return clear_verdict(forms, np.maximum(found.omega, found.kappa_max / 2.0))


def _bending(middle: Middle, z: Array, square: Array) -> Array:
    """Bending energy, int kappa^2/2 = 2 int h^2 with h^2 = omega^2 c^2 + W^2 - omega^2; `square` is int c^2.

    Small angles keep their digits only in the discretised form, which resolves them to rounding.
    """
    c, h = middle.omega * _cosine_half(middle), middle.kappa / 2.0
    exact = 2.0 * (middle.omega**2 * square - (c - h) * (c + h))
    small = ((z[:, 1] - z[:, 0]) ** 2 + np.sum(z[:, 2:] ** 2, axis=1)) / 2.0
    return np.where(np.max(np.abs(z), axis=1) < 0.05, small, exact)


def _sine_half(middle: Middle) -> Array:
    """sin of half the angle from the compression."""
    value: Array = np.where(middle.tension, np.cos(middle.lean / 2.0), np.sin(middle.lean / 2.0))
    return value


def _cosine_half(middle: Middle) -> Array:
    """cos of half the angle from the compression."""
    value: Array = np.where(middle.tension, np.sin(middle.lean / 2.0), np.cos(middle.lean / 2.0))
    return value


def _zeros(one: Array, other: Array, first: float) -> np.ndarray:
    """Points first + j pi strictly between two phases; a phase within 1e-9 of one, as at a pin, is on it."""
    low, high = np.minimum(one, other), np.maximum(one, other)
    inside = np.ceil((high - first) / np.pi - 1e-9) - np.floor((low - first) / np.pi + 1e-9) - 1.0
    count: np.ndarray = np.maximum(inside, 0.0).astype(int)
    return count


def classify_taut(pulled: Taut, problem: Problem) -> Equilibria:
    """The same for taut cables in closed form."""
    inside, outside, free = _taut_margins(pulled, problem)
    w = pulled.omega
    ends = pulled.curvature(np.array([0.0, 1.0]))
    cosine, sine = np.cos(pulled.direction), np.sin(pulled.direction)
    along, across = pulled.position(np.array([0.25, 0.5, 1.0]))
    height = sine[:, None] * along + cosine[:, None] * across
    reach = cosine * along[:, 2] - sine * across[:, 2]
    held = np.array(problem.kind)
    theta0, theta1 = pulled.direction + pulled.a, pulled.direction + pulled.b
    missing = [np.abs(reach - (1.0 - problem.excess[pulled.scene])), np.abs(height[:, 2])]
    for end, angle in ((0, theta0), (1, theta1)):
        if held[end]:
            missing.append(np.abs(wrap(angle - problem.targets[pulled.scene, end])))
    zero = np.zeros(len(w))
    beyond = np.maximum(np.abs(pulled.a), np.abs(pulled.b)) > np.pi
    middle = pulled.psi(np.array([0.5]))[:, 0]
    return Equilibria(
        scene=pulled.scene,
        theta=pulled.direction + middle,
        kappa=pulled.curvature(np.array([0.5]))[:, 0],
        lean=middle,
        direction=pulled.direction,
        omega=w,
        tension=np.ones(len(w), dtype=bool),
        force=(w * w)[:, None] * np.stack([cosine, sine], axis=-1),
        theta0=theta0,
        theta1=theta1,
        kappa0=ends[:, 0],
        kappa1=ends[:, 1],
        energy=pulled.energy,
        kappa_max=np.where(beyond, 2.0 * w, np.max(np.abs(ends), axis=1)),
        winding=np.zeros(len(w), dtype=int),
        inflections=(pulled.a * pulled.b > 0.0).astype(int),
        heights=height[:, [1, 0]],
        side=sides(height[:, [1, 0]]),
        residual=np.max(missing, axis=0),
        verdict=np.where(np.stack([inside, outside], axis=-1) > NEUTRAL, 1, -1),
        margins=np.stack([inside, outside], axis=-1),
        free_turns=free,
        torsion_ratio=_torsion_ratio(problem, len(w)),
        taut=np.ones(len(w), dtype=bool),
        a=pulled.a,
        b=pulled.b,
        z=np.zeros((len(w), SHARP_MODES + 2)),
        held=np.broadcast_to(problem.judged, (len(w), 2)),
        frame=zero,
        excess=problem.excess[pulled.scene],
    )


def _taut_margins(pulled: Taut, problem: Problem) -> tuple[Array, Array, np.ndarray]:
    """Margins in closed form; where their relative error 1/omega could hide the sign, by trial functions."""
    inside, outside = pulled.margins()
    free = np.zeros(len(inside), dtype=bool)
    w = pulled.omega
    for i in np.flatnonzero(np.minimum(np.abs(inside), np.abs(outside)) < 10.0 * w):
        one = pulled.take(np.array([i]))
        judged = stability(
            partial(_angle, one),
            partial(_bend, one),
            w[i] ** 2 * np.array([np.cos(one.direction[0]), np.sin(one.direction[0])]),
            start_clamped=problem.start_clamped,
            end_clamped=problem.end_clamped,
            torsion_ratio=problem.torsion_ratio,
            chord=_chord(problem.excess[one.scene])[0],
        )
        inside[i], outside[i], free[i] = judged.in_plane, judged.out_of_plane, judged.free_turn
    for margins in (inside, outside):
        margins[np.abs(margins) < _TAUT_NOISE * w**2] = 0.0
    return inside, outside, free


def _torsion_ratio(problem: Problem, count: int) -> Array:
    held = problem.torsion_ratio is not None and all(problem.judged)
    return np.full(count, problem.torsion_ratio if held else np.nan)


def _angle(one: Taut, s: Array) -> Array:
    value: Array = one.direction[0] + one.psi(s)[0]
    return value


def _bend(one: Taut, s: Array) -> Array:
    value: Array = one.curvature(s)[0]
    return value


def _chord(excess: Array) -> Array:
    """From start to end in the frame of the chord, shape (n, 2)."""
    return np.stack([1.0 - excess, np.zeros_like(excess)], axis=-1)


def _as_fine(z: Array, omega: Array) -> Array:
    """Modes as `Equilibria` keeps them, NaN where there are not enough of them."""
    out = padded(z, SHARP_MODES)
    out[z.shape[1] - 2 < modes_for(omega)] = np.nan
    return out


def padded(z: Array, modes: int) -> Array:
    """The same functions with more modes."""
    out = np.zeros((len(z), modes + 2))
    out[:, : z.shape[1]] = z
    return out
