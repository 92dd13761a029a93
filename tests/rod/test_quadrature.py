"""The paper's quadrature against mpmath, against its own theory of convergence, and against the closed forms."""

import math

import mpmath as mp
import numpy as np
import pytest

from cablecad.errors import UsageError
from cablecad.rod.elliptic import complete_2e_minus_k, complete_k, incomplete_e, incomplete_f, jacobi
from cablecad.rod.quadrature import (
    gauss_amplitude,
    gauss_incomplete,
    gauss_legendre,
    integrate_tangent,
    pinned_points,
)

EPS = float(np.finfo(float).eps)


def exact_points(phi: np.ndarray, m: float) -> np.ndarray:
    """(y, z) of the pinned cable for omega = 1, at 30 digits."""
    with mp.workdps(30):
        exact_m = mp.mpf(m)
        return np.array(
            [
                (
                    float(2 * mp.sqrt(exact_m) * mp.cos(p)),
                    float(2 * mp.ellipe(p, exact_m) - mp.ellipf(p, exact_m)),
                )
                for p in map(mp.mpf, phi.tolist())
            ]
        )


# --- the rule -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("nodes", [1, 2, 5, 16, 64])
def test_the_rule_is_exact_to_degree_2n_minus_1_and_not_beyond(nodes: int) -> None:
    x, w = gauss_legendre(nodes)
    assert (np.diff(x) > 0.0).all()
    for degree in range(2 * nodes):
        assert x**degree @ w == pytest.approx(1.0 / (degree + 1), rel=8 * EPS)
    # The error of x^(2n) is (n!)^4/((2n + 1) (2n)!^2): the square of the norm of the monic Legendre polynomial.
    missing = math.factorial(nodes) ** 4 / ((2 * nodes + 1) * math.factorial(2 * nodes) ** 2)
    assert 1.0 / (2 * nodes + 1) - x ** (2 * nodes) @ w == pytest.approx(missing, rel=1e-6, abs=4 * EPS)


def test_the_rule_is_shared_and_cannot_be_changed() -> None:
    x, w = gauss_legendre(7)
    assert gauss_legendre(7)[0] is x
    for array in (x, w):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0.0


@pytest.mark.parametrize("nodes", [0, -3])
def test_a_rule_without_nodes_is_refused(nodes: int) -> None:
    with pytest.raises(UsageError, match=f"nodes = {nodes}"):
        gauss_legendre(nodes)


# --- the paper's evaluation ---------------------------------------------------------------------------------------

ERRORS = {
    0.117: {4: 2e-6, 8: 3e-12, 16: 7e-16, 32: 7e-16},
    0.6: {4: 2e-4, 8: 1e-8, 16: 2e-15, 32: 7e-16},
    0.97: {4: 4e-2, 8: 5e-4, 16: 6e-8, 32: 3e-14},
}
"""Largest error of a point over a quarter wave at omega = 1, by m and number of nodes."""


@pytest.mark.parametrize("m", ERRORS)
def test_error_by_number_of_nodes(m: float) -> None:
    phi = np.linspace(0.0, math.pi / 2, 41)
    exact = exact_points(phi, m)
    for nodes, expected in ERRORS[m].items():
        error = np.abs(pinned_points(phi, m, 1.0 - m, 1.0, nodes=nodes) - exact).max()
        assert expected / 2.5 < error < expected * 2.5, f"{nodes} nodes: {error:.1e}"


@pytest.mark.parametrize("m", [0.3, 0.6, 0.9, 0.97])
def test_the_error_falls_at_the_rate_of_the_nearest_singularity(m: float) -> None:
    """Like rho^(-2 n), with the ellipse of rho through pi/2 + i arcosh(1/k) as [0, pi/2] is mapped on [-1, 1]."""
    pole = 1.0 + 4.0j / math.pi * math.acosh(1.0 / math.sqrt(m))
    rate = -2.0 * math.log(abs(pole + np.sqrt(pole**2 - 1.0)))
    exact = complete_k(m, 1.0 - m)
    orders, logs = [], []
    for nodes in range(2, 30):
        error = abs(gauss_incomplete(math.pi / 2, m, 1.0 - m, nodes=nodes)[0] - exact)
        if 1e-12 < error < 1e-3:
            orders.append(nodes)
            logs.append(math.log(error))
    assert len(orders) >= 4
    # The algebraic factor in front, a power of n near -1/2, is what the tolerance is for.
    assert np.polyfit(orders, logs, 1)[0] == pytest.approx(rate, rel=0.08)


@pytest.mark.parametrize("m", [0.0, 0.117, 0.6, 0.9])
def test_agreement_with_the_elliptic_module(m: float) -> None:
    phi = np.linspace(-math.pi / 2, math.pi / 2, 33)
    f_phi, e_phi = gauss_incomplete(phi, m, 1.0 - m, nodes=48)
    np.testing.assert_allclose(f_phi, incomplete_f(phi, m, 1.0 - m), rtol=0.0, atol=1e-14)
    np.testing.assert_allclose(e_phi, incomplete_e(phi, m, 1.0 - m), rtol=0.0, atol=1e-14)
    u = np.linspace(-1.0, 1.0, 41) * complete_k(m, 1.0 - m)
    exact = jacobi(u, m, 1.0 - m)
    angle = gauss_amplitude(u, m, 1.0 - m, nodes=48)
    np.testing.assert_allclose(angle, exact.am, rtol=0.0, atol=1e-14)
    points = pinned_points(angle, m, 1.0 - m, 2.0, nodes=48)
    np.testing.assert_allclose(points[:, 0], math.sqrt(m) * exact.cn, rtol=0.0, atol=1e-14)
    np.testing.assert_allclose(points[:, 1], exact.epsilon - u / 2.0, rtol=0.0, atol=1e-14)


@pytest.mark.parametrize(("m", "nodes"), [(0.117, 4), (0.6, 4), (0.97, 4), (0.999, 3), (0.9999, 2), (1.0 - 1e-6, 1)])
def test_the_amplitude_solves_the_rule_it_was_given(m: float, nodes: int) -> None:
    """Newton's method holds even where the rule is far from the integral; beyond its quarter period it gives pi/2."""
    quarter = float(gauss_incomplete(math.pi / 2, m, 1.0 - m, nodes=nodes)[0])
    u = np.linspace(-quarter, quarter, 101)
    phi = gauss_amplitude(u, m, 1.0 - m, nodes=nodes)
    assert (np.diff(phi) > 0.0).all()
    # A step of one unit in phi moves F by up to dF/dphi < 1/sqrt(m1) units.
    tolerance = 16 * EPS * (quarter + 2.0 / math.sqrt(1.0 - m))
    np.testing.assert_allclose(gauss_incomplete(phi, m, 1.0 - m, nodes=nodes)[0], u, rtol=0.0, atol=tolerance)
    beyond = gauss_amplitude([-2 * quarter, 2 * quarter], m, 1.0 - m, nodes=nodes)
    np.testing.assert_array_equal(beyond, [-math.pi / 2, math.pi / 2])


def test_the_curve_of_equation_21() -> None:
    """With k = 0.342, Omega = 0.724: height 2k/Omega = 0.94475, length 2K/Omega = 4.4752, in the paper's unit."""
    k, omega = 0.342, 0.724
    m = k * k
    length = 2 * float(gauss_incomplete(math.pi / 2, m, 1.0 - m, nodes=16)[0]) / omega
    assert length == pytest.approx(4.4752, abs=5e-5)
    s = np.array([-length / 2, 0.0, length / 2])
    points = pinned_points(gauss_amplitude(omega * s, m, 1.0 - m, nodes=16), m, 1.0 - m, omega, nodes=16)
    assert points[1] == pytest.approx([0.94475, 0.0], abs=1e-5)
    np.testing.assert_allclose(points[[0, 2], 0], 0.0, atol=4 * EPS)
    chord = points[2, 1] - points[0, 1]
    assert chord == pytest.approx(2 * complete_2e_minus_k(m, 1.0 - m) / omega, rel=8 * EPS)


def test_scalars_and_shapes() -> None:
    assert gauss_incomplete(0.5, 0.6, 0.4, nodes=8)[0].shape == ()
    assert gauss_amplitude(0.5, 0.6, 0.4, nodes=8).shape == ()
    assert pinned_points(np.zeros((2, 3)), 0.6, 0.4, 1.0, nodes=8).shape == (2, 3, 2)
    np.testing.assert_array_equal(gauss_amplitude([-0.0, 0.0], 0.6, 0.4, nodes=8), [0.0, 0.0])


# --- any curve from its angle -------------------------------------------------------------------------------------


def elastica_angle(s: np.ndarray) -> np.ndarray:
    """An inflexional elastica of m = 0.9, omega = 1 over more than one wave: 2 asin(k sn)."""
    at = jacobi(s, 0.9, 0.1)
    return 2.0 * np.arctan2(math.sqrt(0.9) * at.sn, at.dn)


def elastica_points(s: np.ndarray) -> np.ndarray:
    at = jacobi(s, 0.9, 0.1)
    points = np.stack([2.0 * at.epsilon - s, -2.0 * math.sqrt(0.9) * at.cn], axis=-1)
    return points - points[0]


def test_a_closed_form_elastica_from_its_angle() -> None:
    s = np.sort(np.random.default_rng(3).uniform(-4.0, 12.0, 60))
    got = integrate_tangent(elastica_angle, s)
    np.testing.assert_allclose(got, elastica_points(s), rtol=0.0, atol=4e-15)
    backwards = integrate_tangent(elastica_angle, s[::-1])
    np.testing.assert_allclose(backwards, elastica_points(s[::-1]), rtol=0.0, atol=4e-15)


@pytest.mark.parametrize(("nodes", "coarsest"), [(1, 32), (2, 16), (3, 16), (4, 12)])
def test_orders_of_the_panels(nodes: int, coarsest: int) -> None:
    """The error falls with order 2 n in the panel's length, between the coarse end and the rounding of the sum."""
    s = np.array([0.0, 3.0])
    exact = elastica_points(s)[-1]
    counts = coarsest * np.array([1.0, 1.5, 2.0])
    errors = [
        np.linalg.norm(integrate_tangent(elastica_angle, s, nodes=nodes, panels=int(n))[-1] - exact) for n in counts
    ]
    order = -np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert order == pytest.approx(2 * nodes, abs=0.15)


def test_a_circle_and_a_clothoid() -> None:
    s = np.linspace(0.0, 2.0 * math.pi, 9)
    circle = integrate_tangent(lambda at: at, s)
    np.testing.assert_allclose(circle, np.stack([np.sin(s), 1.0 - np.cos(s)], axis=-1), rtol=0.0, atol=1e-15)
    clothoid = integrate_tangent(lambda at: math.pi / 2 * at**2, np.linspace(0.0, 2.0, 5))
    fresnel = [[float(mp.fresnelc(x)), float(mp.fresnels(x))] for x in (0, 0.5, 1, 1.5, 2)]
    np.testing.assert_allclose(clothoid, fresnel, rtol=0.0, atol=1e-15)


def test_one_arclength_is_one_point() -> None:
    np.testing.assert_array_equal(integrate_tangent(np.sin, [3.0]), [[0.0, 0.0]])


def test_what_cannot_be_integrated_is_refused() -> None:
    with pytest.raises(UsageError, match=r"shape \(0,\)"):
        integrate_tangent(np.sin, [])
    with pytest.raises(UsageError, match=r"shape \(1, 2\)"):
        integrate_tangent(np.sin, [[0.0, 1.0]])
    with pytest.raises(UsageError, match="panels = 0"):
        integrate_tangent(np.sin, [0.0, 1.0], panels=0)
    with pytest.raises(UsageError, match="nodes = 0"):
        integrate_tangent(np.sin, [0.0, 1.0], nodes=0)
