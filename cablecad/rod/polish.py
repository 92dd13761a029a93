"""Newton's method on the state of an elastica at mid-span, against the exact flow: the last digits of a solution.

The unknowns are (theta, kappa, n_x, n_y) at s = 1/2; both halves start there, which halves the exponent in the growth
of errors, and the angle of the middle is kept from the nearer of n and -n, so that under tension, where it is
exp(-omega/2), it keeps its own digits. The derivative comes from the discretised solution: the response of the middle
to a change of the end conditions; after a sketch by few modes it is corrected on the way. It serves for sensitivities
too.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from cablecad.rod.course import Courses, courses
from cablecad.rod.flow import Jump, jump
from cablecad.rod.midpoint import Held, State, refine
from cablecad.rod.ritz import Ritz, blocks, gap, respond, solve
from cablecad.rod.taut import SEED, wrap
from cablecad.rod.trial import Array

_FLAT = 0.5
"""Below this angle from the chord everywhere positions come from quadrature of the angles [rad]: for small angles the
closed form's positions lose what the chord is short of the length."""

_LAYER = 5.5
"""Layers turning further than this come close to a full loop, which moves inwards [rad]."""

EASY_OMEGA = 14.0
"""Below this a state in floats and plain difference quotients do; above, tension may need its layers."""

_GOOD = 1e-13
"""Residual above which a solution polished in floats is tried again by the other way."""

_FEW = 8
"""Up to so many solutions are polished one by one in floats: calls of numpy cost more than the arithmetic."""

_ENDS = np.array([-0.5, 0.5])

PROBES = np.array([-0.5, -0.25, 0.5])
"""Where polished states are carried to: the ends, and the quarter point that tells twins apart."""


@dataclass(frozen=True, slots=True)
class Middle:
    """States at mid-span in the frame of the chord, arrays of shape (n,).

    Attributes:
        lean: Angle of the tangent from `direction`, in [-pi, pi].
        kappa: Curvature.
        direction: Angle of n where `tension`, else of -n.
        omega: sqrt(|n|).
        tension: Whether n.t > 0 at mid-span when the state was first found.
    """

    lean: Array
    kappa: Array
    direction: Array
    omega: Array
    tension: np.ndarray

    @property
    def theta(self) -> Array:
        """Angle of the tangent from the chord, in no particular turn."""
        return self.direction + self.lean

    @property
    def force(self) -> Array:
        """(n_x, n_y), shape (n, 2)."""
        size = np.where(self.tension, 1.0, -1.0) * self.omega**2
        return np.stack([size * np.cos(self.direction), size * np.sin(self.direction)], axis=-1)

    def jump(self, s: Array) -> Jump:
        """The exact flow to arclengths `s` from mid-span, shape (k,) or (n, k)."""
        return jump(*self.half, self.kappa, self.omega, s)

    @property
    def half(self) -> tuple[Array, Array]:
        """sin and cos of half the angle from the compression."""
        sine, cosine = np.sin(self.lean / 2.0), np.cos(self.lean / 2.0)
        return (
            np.where(self.tension, -np.copysign(cosine, self.lean), sine),
            np.where(self.tension, np.abs(sine), cosine),
        )

    @property
    def courses(self) -> Courses:
        """The exact curves."""
        return courses(*self.half, self.kappa, self.omega)

    @property
    def compression(self) -> Array:
        """Angle from the chord of the frame of `jump`: that of -n, in the turn its angles are in."""
        return self.direction + np.where(self.tension, np.copysign(np.pi, self.lean), 0.0)

    def take(self, index: np.ndarray) -> Middle:
        """Some of the states."""
        return Middle(*(getattr(self, f.name)[index] for f in fields(self)))

    def one(self, i: int) -> State:
        """A single one, in floats."""
        return State(*(getattr(self, name)[i].item() for name in State._fields))

    def replaced(self, rows: np.ndarray, new: Middle) -> Middle:
        """A copy with `new` in place of `rows`."""
        values = []
        for f in fields(self):
            value = getattr(self, f.name).copy()
            value[rows] = getattr(new, f.name)
            values.append(value)
        return Middle(*values)


def middle_of(theta: Array, kappa: Array, force: Array) -> Middle:
    """States from angle, curvature and force."""
    size = np.hypot(force[:, 0], force[:, 1])
    tension = force[:, 0] * np.cos(theta) + force[:, 1] * np.sin(theta) > 0.0
    sign = np.where(tension, 1.0, -1.0)
    direction = np.arctan2(sign * force[:, 1], sign * force[:, 0])
    return Middle(wrap(theta - direction), kappa, direction, np.sqrt(size), tension)


def response(space: Ritz, z: Array, force: Array) -> Array:
    """How the middle answers the end conditions, shape (n, 4, 4).

    Columns: a unit of int 2 sin^2(theta/2), of int sin(theta), of the condition at s = 0 and at s = 1: of the angle at
    a clamp, of the curvature at a pin. Rows: theta, kappa, n_x, n_y at mid-span.
    """
    return np.concatenate([_response_of(space, z[own], force[own]) for own in blocks(len(z))])


def _response_of(space: Ritz, z: Array, force: Array) -> Array:
    """`response` for one block."""
    sine, cosine, _ = gap(space, z, np.zeros(len(z)))
    system, tension = respond(space, force, sine, cosine)
    d = len(space.free)
    right = np.zeros((len(z), d + 2, 4))
    right[:, d, 0] = right[:, d + 1, 1] = 1.0
    extra = np.zeros((2, space.functions.shape[1]))
    for end in (0, 1):
        if end in space.free:
            right[:, list(space.free).index(end), 2 + end] = 2.0 * end - 1.0
            continue
        own = space.functions[:, end]
        weighted = tension * (space.weights * own)
        right[:, :d, 2 + end] = -(weighted @ space.functions[:, space.free]) - space.stiffness[space.free, end]
        right[:, d, 2 + end] = -(sine * own) @ space.weights
        right[:, d + 1, 2 + end] = -(cosine * own) @ space.weights
        extra[end, end] = 1.0
    answer = solve(system, right)
    matrix = np.empty((len(z), 4, 4))
    matrix[:, :2] = space.middle[:, space.free] @ answer[:, :d]
    matrix[:, :2, 2:] += space.middle @ extra.T
    matrix[:, 2], matrix[:, 3] = answer[:, d], -answer[:, d + 1]
    return matrix


def unmet(space: Ritz, middle: Middle, targets: Array, excess: Array, flat: np.ndarray) -> Array:
    """End conditions not met by the exact elastica, shape (n, 4), ordered as the columns of `response`.

    Args:
        space: The discretisation; its free ends are the pins.
        middle: States at mid-span.
        targets: Angle at a clamp, curvature (0) at a pin, shape (n, 2); full turns of the angles do not count.
        excess: 1 - chord, shape (n,).
        flat: Which have small angles throughout, shape (n,).
    """
    ends = middle.jump(_ENDS)
    x, y = ends.along[:, 1] - ends.along[:, 0], ends.across[:, 1] - ends.across[:, 0]
    frame = middle.compression
    cosine, sine = np.cos(frame), np.sin(frame)
    missing = np.empty((len(excess), 4))
    missing[:, 0] = 1.0 - (cosine * x - sine * y) - excess
    missing[:, 1] = sine * x + cosine * y
    if flat.any():
        some = middle.take(np.flatnonzero(flat))
        # Angles near zero, however the frame's turns were counted.
        half = wrap(some.theta[:, None] + some.jump(space.s - 0.5).turn) / 2.0
        missing[flat, 0] = (2.0 * np.sin(half) ** 2) @ space.weights - excess[flat]
        missing[flat, 1] = np.sin(2.0 * half) @ space.weights
    for end in (0, 1):
        if end in space.free:
            missing[:, 2 + end] = ends.kappa[:, end]
        else:
            missing[:, 2 + end] = wrap(middle.theta + ends.turn[:, end] - targets[:, end])
    return missing


def polish(
    space: Ritz, z: Array, force: Array, targets: Array, excess: Array, *, sketched: bool = False, iterations: int = 10
) -> tuple[Middle, Jump, Array]:
    """Bring discretised solutions to rounding.

    Args:
        space: The discretisation.
        z: Solutions in it, shape (n, m + 2).
        force: Their forces, shape (n, 2).
        targets: Of the ends, as for `unmet`.
        excess: 1 - chord, shape (n,).
        sketched: Whether the modes are few: the derivative they give is then corrected by what each step brings. That
            of enough modes is better left as it is: beyond an omega of 14 or so corrected ones led astray.
        iterations: At most so many.

    Returns:
        States at mid-span; their flow to `PROBES`; residual, shape (n,): the largest unmet end condition (curvature
        at a pin over 1 + omega).
    """
    if len(z) > _FEW:
        middle, residual = _polish_together(space, z, force, targets, excess, iterations, sketched)
        return middle, middle.jump(PROBES), residual
    state = z @ space.middle.T
    middle = middle_of(state[:, 0], state[:, 1], force)
    easy = (np.max(np.abs(z @ space.functions.T), axis=1) > _FLAT) & (middle.omega < EASY_OMEGA)
    residual = np.full(len(z), np.inf)
    held = 0 not in space.free, 1 not in space.free
    for i in np.flatnonzero(easy).tolist():
        given = Held(*held, float(targets[i, 0]), float(targets[i, 1]), float(excess[i]))
        refined, residual[i] = refine(middle.one(i), given)
        for name, value in zip(State._fields, refined, strict=True):
            getattr(middle, name)[i] = value
    rest = np.flatnonzero(residual > _GOOD)
    if len(rest):
        some, residual[rest] = _polish_together(
            space, z[rest], force[rest], targets[rest], excess[rest], iterations, sketched
        )
        middle = middle.replaced(rest, some)
    return middle, middle.jump(PROBES), residual


def _polish_together(
    space: Ritz, z: Array, force: Array, targets: Array, excess: Array, iterations: int, sketched: bool
) -> tuple[Middle, Array]:
    """`polish` for any number at once, without the flow."""
    state = z @ space.middle.T
    middle = middle_of(state[:, 0], state[:, 1], force)
    matrix = response(space, z, force)
    # Angles from n at the ends, in the turns they have when followed from the middle.
    layers = z[:, :2] - (state[:, 0] - middle.lean)[:, None]
    pulled = middle.tension & (middle.omega > SEED) & (np.abs(middle.lean) < 0.01)
    pulled &= np.max(np.abs(layers), axis=1) < _LAYER
    if pulled.any():
        rows = np.flatnonzero(pulled)
        middle = middle.replaced(rows, _from_layers(middle.take(rows), layers[rows]))
    flat = np.max(np.abs(z @ space.functions.T), axis=1) < _FLAT
    best = np.full(len(z), np.inf)
    kept = current = middle
    active = np.arange(len(z))
    stalled = np.zeros(len(z), dtype=bool)
    before = step = None
    for _ in range(iterations):
        missing = unmet(space, current, targets[active], excess[active], flat[active])
        scale = np.ones((len(active), 4))
        for end in (0, 1):
            if end in space.free:
                scale[:, 2 + end] = 1.0 + current.omega
        size = np.max(np.abs(missing) / scale, axis=1)
        size[~np.isfinite(size)] = np.inf
        # What rounding of small angles allows is less than rounding of angles of one radian.
        better = size < best[active]
        kept = kept.replaced(active[better], current.take(better))
        halved = size < 0.5 * best[active]
        best[active] = np.minimum(best[active], size)
        floor = np.where(flat[active], 1e-18, 2e-15)
        # The modes' derivative may bring little in one step and much in the next: what is not done gets another one.
        patient = ~halved & ~stalled[active] & better & (size > _GOOD)
        stalled[active] = ~halved
        go = (halved | patient) & (size > floor)
        if not go.any():
            break
        current, missing, active = current.take(np.flatnonzero(go)), missing[go], active[go]
        if sketched and before is not None and step is not None:
            matrix[active] = _corrected(matrix[active], step[go], missing - before[go], ~pulled[active])
        before, step = missing, -(matrix[active] @ missing[:, :, None])[:, :, 0]
        moved = _advance(current, step)
        rows = np.flatnonzero(pulled[active])
        if len(rows):
            own = _advance_layers(space, current.take(rows), layers[active[rows]], -missing[rows])
            moved = moved.replaced(rows, own)
        current = moved
    return kept, best


def _corrected(matrix: Array, step: Array, gained: Array, plain: np.ndarray) -> Array:
    """Inverse derivatives that answer the last change of the end conditions by the last step: Broyden's good method.

    Args:
        matrix: Inverse derivatives, shape (n, 4, 4).
        step: Last steps of the middle, shape (n, 4).
        gained: By how much the end conditions changed, shape (n, 4).
        plain: Which went that step, shape (n,): layers under tension go by another.
    """
    answer = (matrix @ gained[:, :, None])[:, :, 0]
    along = np.einsum("ni,ni->n", step, answer)
    wrong = (step - answer) / np.where(plain & (along != 0.0), along, np.inf)[:, None]
    corrected: Array = matrix + wrong[:, :, None] * (step[:, None, :] @ matrix)
    return corrected


def _from_layers(middle: Middle, layers: Array) -> Middle:
    """The middle of two boundary layers under tension: leaning by the sum of their tails."""
    tails = 4.0 * np.tan(layers / 4.0) * np.exp(-middle.omega / 2.0)[:, None]
    return Middle(
        tails[:, 0] + tails[:, 1],
        middle.omega * (tails[:, 1] - tails[:, 0]),
        middle.direction,
        middle.omega,
        middle.tension,
    )


def _advance_layers(space: Ritz, middle: Middle, layers: Array, wanted: Array) -> Middle:
    """Newton's step for two boundary layers under tension, by the derivative of the taut closed form.

    The middle then leans by A + B and has kappa = omega (B - A), A and B the layers' tails, which answer an end's angle
    by exp(-omega/2): far below what a discretisation resolves. The derivative is good to exp(-omega) < 1e-6.
    """
    w, direction = middle.omega, middle.direction
    cosine, sine = np.cos(direction), np.sin(direction)
    jacobian = np.zeros((len(w), 4, 4))  # rows as `wanted`, columns a, b, direction, omega
    angles = []
    for end in (0, 1):
        free = end in space.free
        angle = layers[:, end] * (not free)
        angles.append(angle)
        s, c = np.sin(angle / 2.0) / w, np.cos(angle / 2.0) / w
        jacobian[:, 0, end] = cosine * s + sine * c
        jacobian[:, 1, end] = cosine * c - sine * s
        if free:
            jacobian[:, 2 + end, end] = (2 * end - 1) * w
        else:
            jacobian[:, 2 + end, end] = jacobian[:, 2 + end, 2] = 1.0
    short = 4.0 / w * (np.sin(angles[0] / 4.0) ** 2 + np.sin(angles[1] / 4.0) ** 2)
    lift = 2.0 / w * (np.sin(angles[0] / 2.0) + np.sin(angles[1] / 2.0))
    jacobian[:, 0, 2] = sine * (1.0 - short) + cosine * lift
    jacobian[:, 1, 2] = cosine * (1.0 - short) - sine * lift
    jacobian[:, 0, 3] = -(cosine * short + sine * lift) / w
    jacobian[:, 1, 3] = (sine * short - cosine * lift) / w
    step = solve(jacobian, wanted[:, :, None])[:, :, 0]
    tails = []
    for end in (0, 1):
        tail = (middle.lean + (2 * end - 1) * middle.kappa / w) / 2.0
        grown = np.exp(-w / 2.0) / np.cos(angles[end] / 4.0) ** 2 * step[:, end]
        tails.append(tail + grown - tail * step[:, 3] / 2.0)
    omega = w + step[:, 3]
    return Middle(tails[0] + tails[1], omega * (tails[1] - tails[0]), direction + step[:, 2], omega, middle.tension)


def _advance(middle: Middle, change: Array) -> Middle:
    """The state after (theta, kappa, n_x, n_y) changed; the lean changes by its own small amount, not by difference."""
    sign = np.where(middle.tension, 1.0, -1.0)
    cosine, sine = np.cos(middle.direction), np.sin(middle.direction)
    along = sign * (cosine * change[:, 2] + sine * change[:, 3])
    across = sign * (cosine * change[:, 3] - sine * change[:, 2])
    size = middle.omega**2
    turn = np.arctan2(across, size + along)
    return Middle(
        wrap(middle.lean + (change[:, 0] - turn)),
        middle.kappa + change[:, 1],
        middle.direction + turn,
        np.sqrt(np.hypot(size + along, across)),
        middle.tension,
    )
