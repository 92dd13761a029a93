"""One elastica by its state at mid-span, in floats: what `flow` and `polish` do for arrays, 15 times faster for one.

The two halves of a rod need Jacobi's functions at u and -u, odd or even in u: one descent serves both ends. The
formulas and their regimes are those of `flow`; the two are held together by tests/rod/test_midpoint.py.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from cablecad.rod.jacobian import Jacobian

_TURN = 2.0 * math.pi

_STEP = 1e-7
"""Difference quotients at this step have eight digits, which Newton's method turns into sixteen."""

_SLOW = 0.1
"""Where a step left more than this of the residual the derivative is taken anew."""

CONTRACTION = 0.5
"""Each step of Newton's method is to be at most this of the one before. Where one is not, the start was not near, and
what it led to may be another equilibrium (beyond a fold a small arch snaps through). Deuflhard's monotonicity test."""

_SETTLED = 1e-10
"""Steps shorter than this, relative to the state, are not compared: they are on their way into rounding."""

_ROUNDING = 2e-15
"""Residual below which nothing is gained."""


class State(NamedTuple):
    """The middle of a rod of length one; see `polish.Middle`."""

    lean: float
    kappa: float
    direction: float
    omega: float
    tension: bool

    @property
    def compression(self) -> float:
        """Angle of the frame of `carry`: that of -n, in the turn its angles are in."""
        return self.direction + (math.copysign(math.pi, self.lean) if self.tension else 0.0)

    @property
    def half(self) -> tuple[float, float]:
        """sin and cos of half the angle from the compression."""
        sine, cosine = math.sin(self.lean / 2.0), math.cos(self.lean / 2.0)
        return (-math.copysign(cosine, self.lean), abs(sine)) if self.tension else (sine, cosine)

    @property
    def crest_kappa(self) -> float:
        """|curvature| where the tangent lies along the compression."""
        return 2.0 * math.hypot(self.kappa / 2.0, self.omega * self.half[0])


class Reach(NamedTuple):
    """A point of the rod as seen from its middle; the fields of `flow.Jump`, and the phase.

    Attributes:
        phase: Of a swing (omega p, kappa/2) the polar angle, of a revolution half the angle psi, counted from the
            middle's own without jumps: the curvature vanishes where a swing's cosine does, p where the sine does.
    """

    turn: float
    kappa: float
    p: float
    c: float
    along: float
    across: float
    square: float
    phase: float


class Swing:
    """What all points of one elastica have in common: its constants, and Jacobi's functions of its parameter.

    Attributes:
        p, c: sin and cos of half the angle from the compression at mid-span.
        h: Half the curvature there.
        omega: sqrt(|n|).
        swings: Whether the branch is the inflexional one.
        rate: omega for a swing, else sqrt(h^2 + omega^2 p^2): the elliptic argument is rate s.
        m: Parameter.
        jacobian: Its functions.
    """

    __slots__ = ("c", "h", "jacobian", "m", "omega", "p", "rate", "swings")

    def __init__(self, state: State) -> None:
        self.p, self.c = state.half
        self.omega, self.h = state.omega, state.kappa / 2.0
        o2 = self.omega * self.omega
        w2 = self.h * self.h + o2 * self.p * self.p
        gap = (self.omega * self.c - abs(self.h)) * (self.omega * self.c + abs(self.h))
        self.swings = gap >= 0.0
        # A line has rate 0, and then any scale does.
        r2 = max(o2 if self.swings else w2, 1e-200)
        self.rate = math.sqrt(r2)
        self.m = (w2 if self.swings else o2) / r2
        self.jacobian = Jacobian(self.m, max(abs(gap) / r2, 1e-100) if r2 > 1e-200 else 1.0)

    def base(self, u: Any, swing: Any) -> Any:
        """int p^2 from the argument 0 to u, but for the boundary term of the addition theorem."""
        f = self.jacobian
        return (self.m * (f.mean_sn2 * u - swing) if self.swings else u - (f.mean_cn2 * u + swing)) / self.rate


def carry(state: State, s: float) -> tuple[Reach, Reach]:
    """What lies at the arclengths -s and s from the middle, s > 0."""
    own = Swing(state)
    p0, c0, h0, omega, swings = own.p, own.c, own.h, own.omega, own.swings
    o2 = omega * omega
    u = own.rate * s
    sn, cn, dn, zeta = own.jacobian(u)
    big_s = sn / own.rate
    big_c, big_d = (cn, dn) if swings else (dn, cn)
    base = own.base(u, zeta)
    below = big_c * big_c + c0 * c0 * o2 * big_s * big_s
    lift = big_s * big_s / (1.0 + big_c) if big_c >= 0.0 else (1.0 - big_c) / o2
    weight = c0 * c0 + p0 * p0 * big_c
    mean = own.jacobian.rate * u
    first = math.atan2(omega * p0, h0) if swings else 0.0
    reached = []
    for sign in (-1.0, 1.0):
        at = sign * big_s
        p = (p0 * big_c * big_d + h0 * c0 * at) / below
        c = (c0 * big_d - p0 * h0 * at * big_c) / below
        h = (h0 * big_c - o2 * p0 * c0 * at * big_d) / below
        half = math.atan2(
            h0 * at * weight - p0 * c0 * big_d * o2 * lift, big_d * weight + p0 * c0 * h0 * at * (o2 * lift)
        )
        if swings:
            phase = math.atan2(omega * p, h) - first
            phase = first + phase + _TURN * round((sign * mean - phase) / _TURN)
        else:
            half += _TURN * round((sign * math.copysign(mean, h0) - half) / _TURN)
            phase = math.atan2(p0, c0) + half
        square = sign * s - sign * base - p0 * p * at
        along = sign * s - 2.0 * sign * base - 2.0 * p0 * p * at
        across = 2.0 / below * (p0 * c0 * at * big_d + h0 * lift * (c0 * c0 - p0 * p0 * big_c))
        reached.append(Reach(2.0 * half, 2.0 * h, p, c, along, across, square, phase))
    return reached[0], reached[1]


def wrap(angle: float) -> float:
    """The angle in [-pi, pi]."""
    return math.remainder(angle, _TURN)


class Held(NamedTuple):
    """The two-point problem of one rod in the frame of its chord: clamps, their angles, 1 - chord."""

    start: bool
    end: bool
    a: float
    b: float
    excess: float


def unmet(state: State, given: Held) -> list[float]:
    """End conditions not met, in the order of `polish.unmet`: `carry` to both ends, what cancels between them left out.

    What is even in the arclength drops out of the chord, in which each half has as much as the other.
    """
    own = Swing(state)
    p0, c0, h0, omega = own.p, own.c, own.h, own.omega
    o2 = omega * omega
    u = 0.5 * own.rate
    sn, cn, dn, zeta = own.jacobian(u)
    at = sn / own.rate
    big_c, big_d = (cn, dn) if own.swings else (dn, cn)
    base = own.base(u, zeta)
    below = big_c * big_c + c0 * c0 * o2 * at * at
    lift = at * at / (1.0 + big_c) if big_c >= 0.0 else (1.0 - big_c) / o2
    weight = c0 * c0 + p0 * p0 * big_c
    along = 1.0 - 4.0 * base - 4.0 * p0 * p0 * at * big_c * big_d / below
    across = 4.0 * p0 * c0 * at * big_d / below
    frame = state.compression
    cosine, sine = math.cos(frame), math.sin(frame)
    missing = [1.0 - (cosine * along - sine * across) - given.excess, sine * along + cosine * across]
    theta = state.direction + state.lean
    odd, even = h0 * at * weight, p0 * c0 * big_d * o2 * lift
    level, slant = big_d * weight, p0 * c0 * h0 * at * (o2 * lift)
    for sign, clamped, angle in ((-1.0, given.start, given.a), (1.0, given.end, given.b)):
        if clamped:  # full turns do not count
            half = math.atan2(sign * odd - even, level + sign * slant)
            missing.append(wrap(theta + 2.0 * half - angle))
        else:
            missing.append(2.0 * (h0 * big_c - sign * o2 * p0 * c0 * at * big_d) / below)
    return missing


def size_of(missing: Sequence[float], state: State, given: Held) -> float:
    """The largest unmet condition; curvature at a pin over 1 + omega."""
    scale = 1.0 + state.omega
    start, end = missing[2] if given.start else missing[2] / scale, missing[3] if given.end else missing[3] / scale
    size = max(abs(missing[0]), abs(missing[1]), abs(start), abs(end))
    return size if math.isfinite(size) else math.inf


def advance(state: State, change: Sequence[float]) -> State:
    """The state after theta, kappa and the force, along `direction` and across it, changed; see `polish._advance`."""
    theta, kappa, along, across = change
    if not state.tension:
        along, across = -along, -across
    size = state.omega * state.omega + along
    turn = math.atan2(across, size)
    return State(
        wrap(state.lean + (theta - turn)),
        state.kappa + kappa,
        state.direction + turn,
        math.sqrt(math.hypot(size, across)),
        state.tension,
    )


def refine(state: State, given: Held, *, iterations: int = 10) -> tuple[State, float]:
    """Newton's method with difference quotients, mended by Broyden's update and taken anew only where that is slow.

    Returns:
        The best state met and its residual. It stays far from zero where the steps do not contract.
    """
    missing = unmet(state, given)
    size = size_of(missing, state, given)
    best = state, size
    inverse = None
    last = math.inf
    force = (1.0 + state.omega**2) ** -2
    weights = np.array((1.0, (1.0 + state.omega) ** -2, force, force))
    for _ in range(iterations):
        if size <= _ROUNDING:
            break
        if inverse is None:
            try:
                inverse = np.linalg.inv(_derivative(state, given, missing))
            except np.linalg.LinAlgError:
                break
        move = inverse @ missing
        step = (-move).tolist()
        length = max(abs(step[0]), abs(step[1]) / (1.0 + state.omega), math.hypot(*step[2:]) / (1.0 + state.omega**2))
        if not length <= CONTRACTION * last and length > _SETTLED:
            break
        last = length
        state = advance(state, step)
        missing = unmet(state, given)
        old, size = size, size_of(missing, state, given)
        if size < best[1]:
            best = state, size
        elif length <= _SETTLED:
            break
        if size > _SLOW * old:
            inverse = None
            continue
        # Broyden: what the step left over is what the derivative got wrong along it.
        along = move * weights
        rest = inverse @ missing
        inverse = inverse + np.multiply.outer(rest, (along @ inverse) / (along @ (move - rest)))
    return best


def _derivative(state: State, given: Held, missing: list[float]) -> list[list[float]]:
    """Rows of the derivative of `unmet` by theta, kappa and the force along and across `direction`."""
    steps = (_STEP * (1.0 + abs(state.kappa)), _STEP * (1.0 + state.omega**2), _STEP * (1.0 + state.omega**2))
    columns = []
    for i, step in enumerate(steps):
        change = [0.0, 0.0, 0.0, 0.0]
        # Away from zero force: its size cannot shrink below it.
        change[i + 1] = step if i != 1 or state.tension else -step
        there = unmet(advance(state, change), given)
        columns.append([_difference(new - old) / change[i + 1] for new, old in zip(there, missing, strict=True)])
    # Turning the whole rod with its force is known; what it does beyond the force's turn is theta's.
    turned = [missing[1], 1.0 - given.excess - missing[0], float(given.start), float(given.end)]
    pull = state.omega**2 if state.tension else -(state.omega**2)
    first = [whole - pull * across for whole, across in zip(turned, columns[2], strict=True)]
    return [list(row) for row in zip(first, *columns, strict=True)]


def _difference(value: float) -> float:
    """A small change of a number that may be an angle."""
    return wrap(value) if abs(value) > 3.0 else value
