"""A discrete elastic rod, as the planar solver's rival: rigid segments and springs, by scipy's L-BFGS.

Units: L = EI = 1, the start is the origin. The starts are random, the constraints in an augmented Lagrangian.
"""

from __future__ import annotations

import numpy as np

from cablecad.bench.collocation import Found
from cablecad.bench.scenes import TURN, Array


def discrete_rod(a: float, b: float, end: Array, *, segments: int, start: Array, winding: int) -> tuple[float, Array]:
    """Minimise the energy of a chain of rigid segments from one start.

    The springs sit between segments and, of half the length, at the clamps. Unknowns are the turns at the springs
    times sqrt(N), in which the energy is nearly |x|^2/2: L-BFGS needs no other scaling. The turns' sum (the end's
    angle) and the end's place are constraints.

    Args:
        a: Angle at the start.
        b: Angle at the end.
        end: Its place, shape (2,).
        segments: N.
        start: Turns over sqrt(segments) of the springs, shape (N + 1,).
        winding: Full turns added to b - a from where it lies within half a turn.

    Returns:
        The energy (inf where the constraints were not met) and the turns.
    """
    from scipy.optimize import minimize

    h = 1.0 / segments
    stiff = np.full(segments + 1, 1.0)
    stiff[[0, -1]] = 2.0  # half a segment between clamp and centre: twice the stiffness
    total = (b - a + np.pi) % TURN - np.pi + TURN * winding
    lam, penalty = np.zeros(3), 100.0
    root = np.sqrt(h)

    def missing_of(x: Array) -> tuple[Array, Array, Array]:
        turn = np.cumsum(x) * root
        theta = a + turn[:-1]
        cosine, sine = np.cos(theta), np.sin(theta)
        return cosine, sine, np.array([h * cosine.sum() - end[0], h * sine.sum() - end[1], turn[-1] - total])

    def merit(x: Array) -> tuple[float, Array]:
        cosine, sine, missing = missing_of(x)
        pull = lam + penalty * missing
        # int kappa^2/2: turn^2/(2 h) with turn = sqrt(h) x.
        value = 0.5 * float(stiff @ (x * x)) + float(lam @ missing) + 0.5 * penalty * float(missing @ missing)
        swing = np.append(h * (pull[1] * cosine - pull[0] * sine), pull[2])
        return value, stiff * x + root * np.cumsum(swing[::-1])[::-1]

    x, size = start, np.inf
    for _ in range(20):
        found = minimize(merit, x, jac=True, method="L-BFGS-B", options={"maxiter": 400, "maxcor": 20, "ftol": 1e-13})
        x = found.x
        missing = missing_of(x)[2]
        lam = lam + penalty * missing
        old, size = size, float(np.abs(missing).max())
        if size < 1e-6:
            # To first order what is missing costs lam.missing.
            return 0.5 * float(stiff @ (x * x)) + float(lam @ missing), x
        if size > 0.25 * old and penalty < 1e5:
            penalty *= 4.0
    return np.inf, x


def search_rod(a: float, b: float, end: Array, *, segments: int, starts: int, rng: np.random.Generator) -> Found:
    """The least energy from random starts: three waves of random size and phase, a winding of -1, 0 or 1.

    Its discretisation error goes with 1/segments^2. The first start has winding 0.
    """
    best, shape = np.inf, np.zeros(segments + 1)
    for i in range(starts):
        winding = int(rng.integers(-1, 2)) if i else 0
        energy, x = discrete_rod(a, b, end, segments=segments, start=_waves(segments, rng), winding=winding)
        if energy < best:
            best, shape = energy, x
    theta = a + np.cumsum(shape)[:-1] / np.sqrt(segments)
    joints = np.zeros((segments + 1, 2))
    joints[1:] = np.cumsum(np.stack([np.cos(theta), np.sin(theta)], axis=1), axis=0) / segments
    nine, s = np.linspace(0.0, 1.0, 9), np.linspace(0.0, 1.0, segments + 1)
    return Found(float(best), np.stack([np.interp(nine, s, joints[:, i]) for i in range(2)], axis=1))


def rod_energy(a: float, b: float, end: Array, *, starts: int, rng: np.random.Generator) -> tuple[float, float]:
    """The least energy of a rod of 200 segments from random starts, and its discretisation error.

    The error goes with 1/segments^2: a third of the difference to 100 segments, started from the same shape. Infinite
    where no start met the end conditions.
    """
    best, shape, turns = np.inf, np.zeros(201), 0
    for i in range(starts):
        winding = int(rng.integers(-1, 2)) if i else 0
        energy, x = discrete_rod(a, b, end, segments=200, start=_waves(200, rng), winding=winding)
        if energy < best:
            best, shape, turns = energy, x, winding
    if not np.isfinite(best):
        return best, np.inf
    # Two springs of the fine rod are one of the coarse; end springs keep theirs.
    fine = np.cumsum(shape) / np.sqrt(200.0)
    middles = (fine[:-1:2] + fine[1:-1:2]) / 2.0
    coarse = np.diff(np.concatenate([[0.0], middles, fine[-1:]])) * np.sqrt(100.0)
    rough, _ = discrete_rod(a, b, end, segments=100, start=coarse, winding=turns)
    return best, abs(best - rough) / 3.0


def _waves(segments: int, rng: np.random.Generator) -> Array:
    """A start of three waves of random size and phase."""
    s = np.linspace(0.0, 1.0, segments + 1)
    waves = sum(rng.normal() * 6.0 / k * np.cos(k * np.pi * s + rng.uniform(0, TURN)) for k in range(1, 4))
    start: Array = np.asarray(waves, dtype=float) / np.sqrt(segments)
    return start
