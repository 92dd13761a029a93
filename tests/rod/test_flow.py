"""The exact flow of a planar elastica, against independent integration and 50-digit arithmetic."""

import math

import mpmath
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from cablecad.rod.flow import jump
from cablecad.rod.taut import Taut

S = np.array([-0.5, 0.3, 0.5])
EPS = np.finfo(float).eps


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


def test_a_nearly_circular_arc_keeps_its_digits():
    """A parameter of 8e-4, over which the integral of a square is held: it must not lose digits by that."""
    psi, kappa, omega = 1.8719738156357186, 0.04472495199403055, 0.000647596032442146
    at = jump(np.array([math.sin(psi / 2)]), np.array([math.cos(psi / 2)]), np.array([kappa]), np.array([omega]), S)
    with mpmath.workdps(30):
        square = mpmath.mpf(omega) ** 2
        path = mpmath.odefun(
            lambda _, y: [y[1], -square * mpmath.sin(y[0]), mpmath.cos(y[0]), mpmath.sin(y[0])],
            0,
            [mpmath.mpf(psi), mpmath.mpf(kappa), 0, 0],
            tol=mpmath.mpf(10) ** -25,
        )
        _, _, along, across = path(0.5)
        assert abs(at.along[0, 2] - along) < 1e-15
        assert abs(at.across[0, 2] - across) < 1e-15


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


def layers(omega, far, s):
    """The flow from the middle of two layers under tension, turned by some two radians and by `far` of that."""
    tail = 1.7 * math.exp(-omega / 2)
    lean, kappa = tail * (1 + far), omega * tail * (far - 1)
    p0, c0 = -math.copysign(math.cos(lean / 2), lean), abs(math.sin(lean / 2))
    return jump(np.array([p0]), np.array([c0]), np.array([kappa]), np.array([omega]), s)


@pytest.mark.parametrize("omega", [16.0, 25.0, 36.0, 48.0, 78.0])
@pytest.mark.parametrize("far", [0.0, 1.0, -0.6])
def test_under_tension_positions_are_the_integral_of_the_tangent(omega, far):
    x, w = np.polynomial.legendre.leggauss(24)
    edges = np.linspace(-0.5, 0.5, 41)
    inner = layers(omega, far, (edges[:-1, None] + (x + 1) / 80).ravel())
    at = layers(omega, far, edges)
    for tangent, position in ((inner.c**2 - inner.p**2, at.along), (2 * inner.p * inner.c, at.across)):
        want = np.concatenate([[0.0], np.cumsum(tangent.reshape(40, 24) @ w / 80)])
        assert np.max(np.abs(position[0] - (want - want[20]))) < 3e-15


@pytest.mark.parametrize("omega", [40.0, 78.0])
@pytest.mark.parametrize("far", [0.0, 1.0, -0.6])
def test_under_tension_the_flow_meets_the_taut_closed_form(omega, far):
    """Two layers by `taut`, exact to exp(-omega): angles and positions from the start."""
    start = 4 * math.atan(1.7 / 4)
    shape = Taut(np.zeros(1, int), np.zeros(1), np.array([omega]), np.array([start]), 4 * np.arctan([far * 1.7 / 4]))
    s = np.linspace(0.0, 1.0, 41)
    at = layers(omega, far, s - 0.5)
    along, across = shape.position(s)
    # The frame of the flow lies along the compression, against the pull.
    assert np.max(np.abs(at.along - at.along[:, :1] + along)) < 3e-15
    assert np.max(np.abs(at.across - at.across[:, :1] + across)) < 3e-15
    # Doubling the argument from 2.5 to omega/2 multiplies the few units of rounding there.
    assert np.max(np.abs(at.turn[0] - shape.psi(s)[0] + shape.psi(s)[0, 20])) < 4 * omega * EPS


def test_phases_count_what_the_curvature_does():
    """Zeros of the curvature between the ends, by the phase and by sign changes of dense samples."""
    rng = np.random.default_rng(8)
    s = np.linspace(-0.5, 0.5, 4001)
    for _ in range(40):
        omega, psi = rng.uniform(0.5, 40), rng.uniform(-3, 3)
        kappa = rng.uniform(-1, 1) * 2 * omega * math.cos(psi / 2)
        at = jump(np.array([math.sin(psi / 2)]), np.array([math.cos(psi / 2)]), np.array([kappa]), np.array([omega]), s)
        low, high = np.sort((at.phase[0, [0, -1]] - math.pi / 2) / math.pi)
        assert math.ceil(high) - math.floor(low) - 1 == np.count_nonzero(np.diff(np.sign(at.kappa[0])))


def test_many_turns_are_counted():
    at = jump(np.array([0.0]), np.array([1.0]), np.array([100.0]), np.array([3.0]), np.array([-0.5, 0.5]))
    want = integrated(0.0, 100.0, 3.0, 0.5)
    assert math.isclose(at.turn[0, 1], want[0], rel_tol=1e-12)
    assert at.turn[0, 0] == -at.turn[0, 1]
