"""Minimise the bending energy of a rod between two points over a few Legendre modes: a batched SQP.

It goes downhill from starts that are far off, a dozen modes deep; what it reaches is for Newton's method (`ritz`) to
bring to rest over more of them.
"""

from __future__ import annotations

import numpy as np

from cablecad.rod.ritz import CAP, SIGNS, Ritz, gap, hessian
from cablecad.rod.trial import Array

_FLOOR = 0.05
"""Least curvature of the model along a direction; negative curvature is taken as positive so that steps descend."""

_MANY = 24
"""From so many systems on elimination in numpy beats calls of LAPACK, one after the other."""

_BACK = 4.0
"""Longest step towards the constraints; near a straight shape their rows are almost dependent and ask for more."""

_COARSE = 0.1
"""Relative change of the angles at which the descent ends: Newton's method on the fine modes takes over. 0.01 found
the same equilibria, later."""

_NEAR = 0.6
"""The same for what is left after the last iteration: good enough to be tried."""

ITERATIONS = 12
"""10, 12, 16 and 30 gave the same least energies on 1500 random scenes (8: 8 of them higher): late ones are on their
way to a known minimum. tests/experiments/planar_search.py."""

_NO_ROW = 1e-100
"""Size of a row of sines that is none."""


def descend(space: Ritz, z: Array, excess: Array, *, iterations: int = ITERATIONS) -> tuple[Array, Array, np.ndarray]:
    """Sequential quadratic programming towards local minima.

    Args:
        space: Coarse: a dozen modes.
        z: Starts, shape (n, m + 2); a0 and a1 of clamps stay as they are.
        excess: 1 - chord, shape (n,).
        iterations: At most so many.

    Returns:
        z; multipliers as the force (n_x, n_y), shape (n, 2); whether a minimum was reached or is near, shape (n,).
        Of a row that did not come so far, where it stands.
    """
    out, force, reached = z.copy(), np.zeros((len(z), 2)), np.zeros(len(z), dtype=bool)
    index = np.arange(len(z))
    functions = space.functions[:, space.free]
    slopes = np.ascontiguousarray(space.stiffness[:, space.free])
    rows, turned = functions * space.weights[:, None], functions.T.copy()
    lam, weight = np.zeros((len(z), 2)), np.ones(len(z))
    trig, miss = _trial(space, z, excess)
    energy = _energy(z)
    for step_count in range(iterations):
        normal = trig @ rows
        unit, triangle = _orthonormal(normal)
        slope = z @ slopes
        if step_count == 0:
            lam = _multipliers(triangle, _along(unit, slope))
        form = hessian(space, _across(lam * SIGNS, trig[:, ::-1]))
        back = _solve_lower(triangle, -miss)
        back *= np.minimum(1.0, _BACK / np.sqrt(np.einsum("ni,ni->n", back, back) + 1e-300))[:, None]
        across = _across(back, unit)
        image = _along(form, across) + slope
        tangential, least = _newton(form, unit, image)
        step = across + tangential
        new = _multipliers(triangle, _along(unit, image + _along(form, tangential)))
        bend = np.abs(step @ turned).max(axis=1)
        shrink = np.minimum(1.0, CAP / np.maximum(bend, 1e-300))
        weight = np.maximum(weight, 1.5 * np.abs(new).max(axis=1))
        move = np.zeros_like(z)
        move[:, space.free] = step * shrink[:, None]
        z, trig, miss, energy = _search(space, z, move, excess, energy + weight * np.abs(miss).sum(axis=1), weight)
        lam = lam + (new - lam) * shrink[:, None]
        size = np.minimum(1.0, np.abs(trig[:, 0]).max(axis=1) + np.sqrt(excess))
        last = step_count == iterations - 1
        enough = (_NEAR if last else _COARSE) * size
        done = (bend < enough) & (np.abs(miss).max(axis=1) < enough * size)
        if last:
            out[index], force[index] = z, new * SIGNS
            reached[index] = done & (least > 0.0)
        elif done.any():
            at = index[done]
            out[at], reached[at] = z[done], least[done] > 0.0
            force[at] = new[done] * SIGNS
            keep = ~done
            if not keep.any():
                break
            index, z, lam, excess, weight, energy = (v[keep] for v in (index, z, lam, excess, weight, energy))
            trig, miss = trig[keep], miss[keep]
    return out, force, reached


def first_force(space: Ritz, z: Array) -> Array:
    """The force (n_x, n_y) that comes closest to holding shapes that are no equilibria, shape (n, 2)."""
    trig, _ = _trial(space, z, np.zeros(len(z)))
    unit, triangle = _orthonormal(trig @ (space.functions[:, space.free] * space.weights[:, None]))
    force: Array = _multipliers(triangle, _along(unit, (z @ space.stiffness)[:, space.free])) * SIGNS
    return force


def _trial(space: Ritz, z: Array, excess: Array) -> tuple[Array, Array]:
    """`gap` with sin(theta) and cos(theta) in one array, shape (n, 2, q): the descent multiplies both by the same."""
    trig = np.empty((len(z), 2, len(space.weights)))
    trig[:, 0], trig[:, 1], miss = gap(space, z, excess)
    return trig, miss


def _along(rows: Array, vectors: Array) -> Array:
    """rows[n] @ vectors[n]."""
    product: Array = (rows @ vectors[:, :, None])[:, :, 0]
    return product


def _across(vectors: Array, rows: Array) -> Array:
    """vectors[n] @ rows[n]."""
    product: Array = (vectors[:, None, :] @ rows)[:, 0]
    return product


def _search(
    space: Ritz, z: Array, move: Array, excess: Array, merit: Array, weight: Array
) -> tuple[Array, Array, Array, Array]:
    """Halve steps that do not lower `merit`, energy + weight |miss|, at most three times."""
    trial = z + move
    trig, miss = _trial(space, trial, excess)
    energy = _energy(trial)
    merit = merit * (1.0 + 1e-12)
    worse = np.flatnonzero(~(energy + weight * np.abs(miss).sum(axis=1) <= merit))
    scale = 1.0
    for _ in range(3):
        if not len(worse):
            break
        scale /= 2.0
        some = z[worse] + scale * move[worse]
        trial[worse] = some
        trig[worse], miss[worse] = _trial(space, some, excess[worse])
        energy[worse] = _energy(some)
        after = energy[worse] + weight[worse] * np.abs(miss[worse]).sum(axis=1)
        worse = worse[~(after <= merit[worse])]
    return trial, trig, miss, energy


def _energy(z: Array) -> Array:
    difference, bends = z[:, 1] - z[:, 0], z[:, 2:]
    energy: Array = (difference * difference + np.einsum("ij,ij->i", bends, bends)) / 2.0
    return energy


def _orthonormal(rows: Array) -> tuple[Array, Array]:
    """Orthonormal rows and the triangle T with rows = T unit; a row that vanishes gets a unit of zero and T = 1."""
    first, second = rows[:, 0], rows[:, 1]
    unit, triangle = np.empty_like(rows), np.empty((len(rows), 3))
    # The cosine row never vanishes together with the sine row; starting from it serves straight cables best.
    n2 = np.sqrt(np.einsum("ij,ij->i", second, second))
    unit[:, 1] = u2 = second / np.maximum(n2, 1e-300)[:, None]
    triangle[:, 1] = t = np.einsum("ij,ij->i", first, u2)
    rest = first - t[:, None] * u2
    n1 = np.sqrt(np.einsum("ij,ij->i", rest, rest))
    # A hair of slack makes for a short row: what counts is how much of it is left.
    own = np.sqrt(np.einsum("ij,ij->i", first, first))
    dead = (n1 <= 1e-12 * own) | (own <= _NO_ROW)
    if dead.any():
        rest[dead], n1[dead] = 0.0, 1.0
    unit[:, 0] = rest / n1[:, None]
    triangle[:, 0], triangle[:, 2] = n1, n2
    return unit, triangle


def _solve_lower(triangle: Array, right: Array) -> Array:
    """y with n1 y1 + t y2 = right1 and n2 y2 = right2."""
    y2 = right[:, 1] / np.maximum(triangle[:, 2], 1e-12)
    return np.stack([(right[:, 0] - triangle[:, 1] * y2) / triangle[:, 0], y2], axis=1)


def _multipliers(triangle: Array, along: Array) -> Array:
    """Least-squares multipliers of gradient + rows^T lam = 0, from the gradient's components along the unit rows."""
    l1 = -along[:, 0] / triangle[:, 0]
    return np.stack([l1, (-along[:, 1] - triangle[:, 1] * l1) / np.maximum(triangle[:, 2], 1e-12)], axis=1)


def _newton(form: Array, unit: Array, gradient: Array) -> tuple[Array, Array]:
    """Step in the null space of `unit` with negative curvature made positive, and the least curvature there."""
    across = np.swapaxes(unit, 1, 2)
    image = form @ across
    # P form P + unit^T unit = form - (image - unit^T (unit image + 1)/2) unit - transposed.
    half = (image - across @ ((unit @ image + np.eye(2)) / 2.0)) @ unit
    projected = form - half - np.swapaxes(half, 1, 2)
    flat = gradient - _across(_along(unit, gradient), unit)
    if len(form) > _MANY:
        step, least = _eliminate(projected, -flat)
        bent = np.flatnonzero(least < _FLOOR)
        step[bent], least[bent] = _descent(projected[bent], flat[bent])
    else:
        step, least = _descent(projected, flat)
    return step - _across(_along(unit, step), unit), least


def _descent(form: Array, gradient: Array) -> tuple[Array, Array]:
    """Newton's step with negative curvature made positive, and the least eigenvalue."""
    values, vectors = np.linalg.eigh(form)
    return _along(vectors, _across(gradient, vectors) / -np.maximum(np.abs(values), _FLOOR)), values[:, 0]


def _eliminate(form: Array, right: Array) -> tuple[Array, Array]:
    """Solve symmetric positive systems by elimination, all at once; a tenth of the time of their eigenvalues.

    Returns:
        Solutions, and the least pivot of each, no less than its least eigenvalue but of its sign: where it is not
        positive the system is not either, and the solution means nothing.
    """
    count = form.shape[1]
    work = np.empty((count, count + 1, len(form)))  # scenes last: each step then runs along memory
    work[:, :count], work[:, count] = form.transpose(1, 2, 0), right.T
    inverse = np.empty((count, len(form)))
    least = np.full(len(form), np.inf)
    for k in range(count):
        pivot = work[k, k]
        np.minimum(least, pivot, out=least)
        inverse[k] = np.where(pivot > _FLOOR, 1.0 / np.maximum(pivot, _FLOOR), 0.0)
        factor = work[k, k + 1 :] * inverse[k]
        work[k + 1 :, k + 1 :] -= work[k, k + 1 : count, None] * factor
    answer = np.empty((count, len(form)))
    for k in reversed(range(count)):
        known = np.einsum("jn,jn->n", work[k, k + 1 : count], answer[k + 1 :])
        answer[k] = (work[k, count] - known) * inverse[k]
    return answer.T, least
