"""A literal multi-start search, to compare the planar solver with: 5 windings x 9 shapes, each by Newton's method.

It shares no code with the solver: an augmented Lagrangian over trial functions of its own.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cablecad.bench.scenes import TURN, Array, Scenes

_SHAPES = np.array([(0, 0), (3, 0), (-3, 0), (0, 3), (0, -3), (3, 3), (-3, -3), (3, -3), (-3, 3)], dtype=float)
_WINDINGS = np.arange(-2, 3)
_PENALTY = 300.0
_COARSE, _FINE = 12, 36


class _Basis(NamedTuple):
    """theta = a + (b - a) s + sum c_j f_j, int f_i' f_j' = delta_ij; f_j made of s (1 - s) times Chebyshev's T_j."""

    s: Array
    weights: Array
    values: Array


def _basis(modes: int) -> _Basis:
    x, w = np.polynomial.legendre.leggauss(2 * modes + 8)
    s, weights = (x + 1.0) / 2.0, w / 2.0
    chebyshev = np.polynomial.chebyshev.chebvander(x, modes - 1)
    slope = np.stack(
        [np.polynomial.chebyshev.chebval(x, np.polynomial.chebyshev.chebder(row)) * 2.0 for row in np.eye(modes)], -1
    )
    values = (s * (1.0 - s))[:, None] * chebyshev
    slopes = (1.0 - 2.0 * s)[:, None] * chebyshev + (s * (1.0 - s))[:, None] * slope
    triangle = np.linalg.qr(np.sqrt(weights)[:, None] * slopes)[1]
    return _Basis(s, weights, np.linalg.solve(triangle.T, values.T).T)


def search_45(scenes: Scenes) -> Array:
    """The least energy of a search from 45 starts, inf where none converged, shape (n,).

    Energies are of the fine discretisation: above the truth by its error, which is below 1e-9 where it is taken.
    """
    best = np.full(len(scenes.a), np.inf)
    coarse, fine = _basis(_COARSE), _basis(_FINE)
    for low in range(0, len(scenes.a), 200):  # 9000 problems at a time
        rows = slice(low, min(low + 200, len(scenes.a)))
        some = scenes.take(rows)
        count, each = len(some.a), len(_WINDINGS) * len(_SHAPES)
        turn = (some.b - some.a + np.pi) % TURN - np.pi
        finish = some.a[:, None] + turn[:, None] + TURN * _WINDINGS
        finish = np.repeat(finish, len(_SHAPES), axis=1).ravel()
        many = Scenes(np.repeat(some.a, each), finish, np.repeat(some.end, each, axis=0))
        c = np.zeros((len(finish), _COARSE))
        c[:, :2] = np.tile(_SHAPES, (count * len(_WINDINGS), 1))
        c, lam = _augmented(coarse, many, c)
        energy = ((many.b - many.a) ** 2 + np.sum(c * c, axis=1)) / 2.0
        # The five lowest of each scene, over all windings, on the fine modes.
        order = np.argsort(energy.reshape(count, each), axis=1)[:, :5] + each * np.arange(count)[:, None]
        chosen = order.ravel()
        refined = _refined(coarse, fine, many.take(chosen), c[chosen], lam[chosen])
        best[rows] = refined.reshape(order.shape).min(axis=1)
    return best


def _parts(basis: _Basis, scenes: Scenes, c: Array) -> tuple[Array, Array, Array]:
    """cos and sin of theta, and the end missed by, shape (n, 2)."""
    theta = scenes.a[:, None] + (scenes.b - scenes.a)[:, None] * basis.s + c @ basis.values.T
    cosine, sine = np.cos(theta), np.sin(theta)
    return cosine, sine, np.stack([cosine @ basis.weights, sine @ basis.weights], axis=-1) - scenes.end


def _system(basis: _Basis, cosine: Array, sine: Array, lam: Array) -> tuple[Array, Array]:
    """Jacobian of the end, shape (n, 2, m), and Hessian of the Lagrangian, shape (n, m, m)."""
    jacobian = np.stack([-(sine * basis.weights) @ basis.values, (cosine * basis.weights) @ basis.values], axis=1)
    pull = -(lam[:, :1] * cosine + lam[:, 1:] * sine) * basis.weights
    hessian = (basis.values.T * pull[:, None, :]) @ basis.values + np.eye(basis.values.shape[1])
    return jacobian, hessian


def _augmented(basis: _Basis, scenes: Scenes, c: Array) -> tuple[Array, Array]:
    """Minimise |c|^2/2 + lam.r + penalty |r|^2/2, lam updated as it goes."""
    lam = np.zeros((len(c), 2))
    active = np.arange(len(c))
    c = c.copy()
    for step_count in range(48):
        here = scenes.take(active)
        x, multiplier = c[active], lam[active]
        cosine, sine, missing = _parts(basis, here, x)
        jacobian, hessian = _system(basis, cosine, sine, multiplier + _PENALTY * missing)
        gradient = x + np.einsum("ni,nij->nj", multiplier + _PENALTY * missing, jacobian)
        values, vectors = np.linalg.eigh(hessian + _PENALTY * np.swapaxes(jacobian, 1, 2) @ jacobian)
        step = -np.einsum(
            "nj,nij->ni", np.einsum("ni,nij->nj", gradient, vectors) / np.maximum(np.abs(values), 0.1), vectors
        )
        turned = np.abs(step @ basis.values.T).max(axis=1)
        step *= np.minimum(1.0, 1.0 / np.maximum(turned, 1e-300))[:, None]
        merit = _merit(x, multiplier, missing)
        scale = np.ones(len(x))
        for _ in range(4):
            _, _, there = _parts(basis, here, x + scale[:, None] * step)
            worse = _merit(x + scale[:, None] * step, multiplier, there) > merit + 1e-12 * np.abs(merit)
            scale[worse] /= 3.0
        c[active] = x + scale[:, None] * step
        settled = turned * scale < 0.1
        _, _, missing = _parts(basis, here, c[active])
        lam[active[settled]] += _PENALTY * missing[settled]
        if step_count >= 8:
            done = (turned < 1e-3) & (np.abs(missing).max(axis=1) < 1e-4)
            active = active[~done]
        if not len(active):
            break
    return c, lam


def _merit(c: Array, lam: Array, missing: Array) -> Array:
    value: Array = (c * c).sum(axis=1) / 2.0 + (lam * missing).sum(axis=1) + _PENALTY / 2.0 * (missing**2).sum(axis=1)
    return value


def _refined(coarse: _Basis, fine: _Basis, scenes: Scenes, c: Array, lam: Array) -> Array:
    """Energies of minima by Newton's method with both bases; inf where it fails or lands on no minimum."""
    size = fine.values.shape[1]
    # The same shape in the fine functions: f_j of the coarse are linear combinations of them.
    change = np.linalg.lstsq(fine.values, _resampled(coarse, fine), rcond=None)[0]
    x = c @ change.T
    moved = np.full(len(x), np.inf)
    for _ in range(9):
        cosine, sine, missing = _parts(fine, scenes, x)
        jacobian, hessian = _system(fine, cosine, sine, lam)
        system = np.zeros((len(x), size + 2, size + 2))
        system[:, :size, :size], system[:, size:, :size] = hessian, jacobian
        system[:, :size, size:] = np.swapaxes(jacobian, 1, 2)
        system[:, size:, size:] = -1e-13 * np.eye(2)  # never singular; steps that vanish do not feel it
        right = -np.concatenate([x + np.einsum("ni,nij->nj", lam, jacobian), missing], axis=1)
        step = np.linalg.solve(system, right[:, :, None])[:, :, 0]
        moved = np.abs(step[:, :size] @ fine.values.T).max(axis=1)
        shrink = np.minimum(1.0, 1.0 / np.maximum(moved, 1e-300))[:, None]
        x, lam = x + shrink * step[:, :size], lam + shrink * step[:, size:]
    cosine, sine, missing = _parts(fine, scenes, x)
    jacobian, hessian = _system(fine, cosine, sine, lam)
    # Positive on the null space of the end's Jacobian, and the last modes faded out.
    lifted = hessian + 1e6 * np.swapaxes(jacobian, 1, 2) @ jacobian
    good = (moved < 1e-8) & (np.abs(missing).max(axis=1) < 1e-11)
    good &= np.linalg.eigvalsh(np.where(np.isfinite(lifted), lifted, 0.0))[:, 0] > 0.0
    good &= np.abs(x[:, -4:]).max(axis=1) < 1e-6
    energy = ((scenes.b - scenes.a) ** 2 + np.sum(x * x, axis=1)) / 2.0
    return np.where(good, energy, np.inf)


def _resampled(coarse: _Basis, fine: _Basis) -> Array:
    """The coarse functions at the fine nodes, exactly: over s (1 - s) they are polynomials."""
    bubble = coarse.s * (1.0 - coarse.s)
    modes = coarse.values.shape[1]
    fit = np.polynomial.chebyshev.chebfit(2.0 * coarse.s - 1.0, coarse.values / bubble[:, None], modes - 1)
    value: Array = (fine.s * (1.0 - fine.s))[:, None] * np.polynomial.chebyshev.chebval(2.0 * fine.s - 1.0, fit).T
    return value
