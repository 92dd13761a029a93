"""The exact flow of a planar elastica, against independent integration and 50-digit arithmetic."""

import math

import mpmath
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from cablecad.rod.flow import jump

S = np.array([-0.5, 0.3, 0.5])


def integrated(psi, kappa, omega, s):
    """psi, kappa, along, across, int cos^2(psi/2) by DOP853 at its tightest."""
    path = solve_ivp(
        lambda _, y: [y[1], -omega * omega * math.sin(y[0]), math.cos(y[0]), math.sin(y[0]), math.cos(y[0] / 2) ** 2],
        (0.0, s),
        [psi, kappa, 0.0, 0.0, 0.0],
        method="DOP853",
        rtol=3e-14,
        atol=1e-14,
    )
    return path.y[:, -1]


def states():
    rng = np.random.default_rng(5)
    for i in range(60):
        omega = 10 ** rng.uniform(-6, 1.2)
        psi = rng.uniform(-math.pi, math.pi)
        kappa = rng.normal() * 10 ** rng.uniform(-4, 1.1)
        if i % 5 == 0:
            omega = 0.0  # a circle
        if i % 7 == 0:
            kappa = 2 * omega * math.cos(psi / 2) * (1 + rng.choice([0, 1e-12, -1e-9]))  # the separatrix and near it
        if i % 11 == 0:
            kappa = 0.0  # a line too, where omega is 0
        yield psi, kappa, omega


@pytest.mark.parametrize(("psi", "kappa", "omega"), list(states()))
def test_every_regime_against_integration(psi, kappa, omega):
    at = jump(np.array([math.sin(psi / 2)]), np.array([math.cos(psi / 2)]), np.array([kappa]), np.array([omega]), S)
    for i, s in enumerate(S):
        want = integrated(psi, kappa, omega, s)
        got = [psi + at.turn[0, i], at.kappa[0, i], at.along[0, i], at.across[0, i], at.square[0, i]]
        # The separatrix multiplies the integrator's own errors by exp(omega/2) at most 3e3 here.
        assert np.max(np.abs(got - want) / np.array([1, 1 + omega, 1, 1, 1])) < 5e-13


def test_under_tension_the_ends_keep_their_digits():
    """Middle angle 1e-11 from n: ends by mpmath's Jacobi functions at 60 digits, omega = 48."""
    with mpmath.workdps(60):
        omega, lean, kappa = mpmath.mpf(48), mpmath.mpf("1.3e-11"), mpmath.mpf("2.0e-10")
        # psi from the compression is lean - pi; psi'' = -omega^2 sin(psi).
        h0 = kappa / 2
        p0 = -mpmath.cos(lean / 2)
        m = (h0 / omega) ** 2 + p0**2
        u = mpmath.ellipf(mpmath.asin(p0 / mpmath.sqrt(m)), m) + omega / 2
        want = mpmath.ellipfun("cn", u, m=m) * mpmath.sqrt(m) * omega * 2
    lean, kappa = 1.3e-11, 2.0e-10
    at = jump(
        np.array([-math.cos(lean / 2)]),
        np.array([math.sin(lean / 2)]),
        np.array([kappa]),
        np.array([48.0]),
        np.array([0.5]),
    )
    assert math.isclose(at.kappa[0, 0], float(want), rel_tol=1e-13)


def test_many_turns_are_counted():
    at = jump(np.array([0.0]), np.array([1.0]), np.array([100.0]), np.array([3.0]), np.array([-0.5, 0.5]))
    want = integrated(0.0, 100.0, 3.0, 0.5)
    assert math.isclose(at.turn[0, 1], want[0], rel_tol=1e-12)
    assert at.turn[0, 0] == -at.turn[0, 1]
