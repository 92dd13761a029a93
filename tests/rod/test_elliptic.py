"""Elliptic integrals and functions against mpmath, against integrals done here, and against their identities.

The oracle takes the amplitude from theta functions (`mpmath.ellipfun`) and the integrals from Carlson's forms
(`mpmath.ellipe`, `ellipf`): neither is the arithmetic-geometric climb of the code. Where m is near 1 the oracle itself
is checked by quadrature of an integrand without a peak.
"""

import math
import subprocess
import sys
from functools import cache
from typing import NamedTuple

import mpmath as mp
import numpy as np
import pytest
import scipy
import scipy.special
from hypothesis import given
from hypothesis import strategies as st

from cablecad.errors import UsageError
from cablecad.rod.elliptic import (
    argument,
    complete_2e_minus_k,
    complete_d,
    complete_e,
    complete_k,
    incomplete_e,
    incomplete_f,
    jacobi,
)

EPS = float(np.finfo(float).eps)

SMALL_M = (0.0, 1e-300, 1e-20, 1e-8, 0.117, 0.5)
SMALL_M1 = (0.4, 0.1738851717, 0.03, 1e-4, 1e-9, 1e-16, 1e-30, 1e-100, 3e-173)


class Parameter(NamedTuple):
    """m and m1 as floats, and the exact parameter they stand for: the smaller of the two is exact."""

    m: float
    m1: float

    @property
    def exact(self) -> mp.mpf:
        return mp.mpf(self.m) if self.m <= 0.5 else 1 - mp.mpf(self.m1)

    @property
    def dps(self) -> int:
        """Digits that leave 40 of them in m1 after two cancellations."""
        return 40 if self.m <= 0.5 else 40 + 2 * round(-math.log10(self.m1))


PARAMETERS = [Parameter(m, 1.0 - m) for m in SMALL_M] + [Parameter(1.0 - m1, m1) for m1 in SMALL_M1]


def ids(p: Parameter) -> str:
    return f"m={p.m:g}" if p.m <= 0.5 else f"m1={p.m1:g}"


each_parameter = pytest.mark.parametrize("p", PARAMETERS, ids=ids)


def exact_jacobi(u: float, p: Parameter) -> tuple[mp.mpf, ...]:
    """sn, cn, dn, am and epsilon of the float u."""
    with mp.workdps(p.dps):
        m, x = p.exact, mp.mpf(u)
        sn, cn, dn = (mp.ellipfun(name, x, m=m) for name in ("sn", "cn", "dn"))
        angle = mp.atan2(sn, cn)
        am = angle + 2 * mp.pi * mp.nint((x / mp.ellipk(m) * mp.pi / 2 - angle) / (2 * mp.pi))
        return sn, cn, dn, am, mp.ellipe(am, m)


def arguments(p: Parameter, count: int) -> np.ndarray:
    """Small, ordinary and many-turn arguments of both signs, and points at and beside the multiples of K."""
    rng = np.random.default_rng(20240611)
    quarter = complete_k(p.m, p.m1)
    at = quarter * np.arange(-4, 5)
    beside = quarter * np.array([1 - 1e-12, 1 + 1e-9, 2 - 1e-6, 3 + 1e-3])
    spread = [rng.uniform(-reach, reach, count) for reach in (3.0, 2 * quarter, 60 * quarter)]
    return np.concatenate([[0.0, 1e-300, -1e-12, 1e-5], at, beside, *spread])


@cache
def cases(p: Parameter) -> tuple[np.ndarray, list[tuple[mp.mpf, ...]]]:
    u = arguments(p, 12 if p.dps < 100 else 4)
    return u, [exact_jacobi(float(x), p) for x in u]


def gaps(got: np.ndarray, truth: list[mp.mpf]) -> np.ndarray:
    return np.array([abs(float(mp.mpf(float(g)) - t)) for g, t in zip(got, truth, strict=True)])


# --- complete integrals -------------------------------------------------------------------------------------------


@each_parameter
def test_complete_integrals(p: Parameter) -> None:
    with mp.workdps(p.dps + (330 if p.m < 1e-100 else 40)):
        m = p.exact
        K, E = mp.ellipk(m), mp.ellipe(m)
        D = (K - E) / m if m else mp.pi / 4
        assert abs(complete_k(p.m, p.m1) / K - 1) < 4 * EPS
        assert abs(complete_e(p.m, p.m1) / E - 1) < 4 * EPS
        assert abs(complete_d(p.m, p.m1) / D - 1) < 4 * EPS
        assert abs(complete_2e_minus_k(p.m, p.m1) - (2 * E - K)) < 4 * EPS * (1 + K)


def test_complete_integrals_at_the_limit() -> None:
    assert complete_k(1.0, 0.0) == complete_d(1.0, 0.0) == math.inf
    assert complete_2e_minus_k(1.0, 0.0) == -math.inf
    assert complete_e(1.0, 0.0) == 1.0


def test_quarter_period_of_the_least_subnormal() -> None:
    m1 = 5e-324
    assert complete_k(1.0, m1) == pytest.approx(float(mp.log(4) - mp.log(mp.mpf(m1)) / 2), rel=4 * EPS)


def test_arrays_with_limits_among_them_equal_their_scalars() -> None:
    m1 = np.array([[1.0, 0.5, 0.0], [1e-30, 5e-324, 0.25]])
    m = 1.0 - m1
    for function in (complete_k, complete_e, complete_d, complete_2e_minus_k):
        scalars = np.reshape([function(float(1.0 - x), float(x)) for x in m1.flat], m1.shape)
        np.testing.assert_allclose(function(m, m1), scalars, rtol=4 * EPS)


# --- functions of the argument ------------------------------------------------------------------------------------


@each_parameter
def test_jacobi_absolute_error(p: Parameter) -> None:
    u, truth = cases(p)
    got = jacobi(u, p.m, p.m1)
    allowed = 4 * EPS * (1 + abs(u))
    for name, values, exact in zip(got._fields, got, zip(*truth, strict=True), strict=True):
        excess = gaps(values, list(exact)) / allowed
        assert excess.max() < 1.0, f"{name}({u[excess.argmax()]!r}) is off by {4 * excess.max():.1f} eps (1 + |u|)"


@each_parameter
def test_jacobi_relative_error(p: Parameter) -> None:
    """Of dn relative to itself down to sqrt(m1); of sn and cn relative to the larger of themselves and their slope."""
    u, truth = cases(p)
    got = jacobi(u, p.m, p.m1)
    sn, cn, dn = (np.array([float(row[i]) for row in truth]) for i in range(3))
    allowed = 6 * EPS * (1 + abs(u))
    assert (gaps(got.dn, [row[2] for row in truth]) < allowed * dn).all()
    assert (gaps(got.cn, [row[1] for row in truth]) < allowed * np.maximum(abs(cn), abs(sn) * dn)).all()
    assert (gaps(got.sn, [row[0] for row in truth]) < allowed * np.maximum(abs(sn), abs(cn) * dn)).all()


@each_parameter
def test_jacobi_near_zero_keeps_relative_digits(p: Parameter) -> None:
    u = np.array([1e-300, 1e-150, 1e-9, 1e-3])
    got = jacobi(u, p.m, p.m1)
    exact = [exact_jacobi(float(x), p) for x in u]
    for i in (0, 3, 4):
        truth = [row[i] for row in exact]
        assert (gaps(got[i], truth) <= 4 * EPS * np.array([float(t) for t in truth])).all()


@pytest.mark.parametrize("u", [1.0, 30.0, 36.0, 50.0])
def test_oracle_near_one_by_integration(u: float) -> None:
    """With tan(phi) = sinh(t): F = int dt/sqrt(1 + m1 sinh^2 t), E = int sech^2 t sqrt(1 + m1 sinh^2 t) dt.

    Beyond K = 35.9 by reflection: am(u) = pi - am(2 K - u).
    """
    p = Parameter(1.0, 1e-30)
    sn, cn, _, am, epsilon = exact_jacobi(u, p)
    with mp.workdps(p.dps):
        stops = [*mp.linspace(0, mp.asinh(abs(sn / cn)), 24)]
        F = mp.quad(lambda t: 1 / mp.sqrt(1 + mp.mpf(p.m1) * mp.sinh(t) ** 2), stops)
        E = mp.quad(lambda t: mp.sqrt(1 + mp.mpf(p.m1) * mp.sinh(t) ** 2) / mp.cosh(t) ** 2, stops)
        beyond = am > mp.pi / 2
        if beyond:
            F, E = 2 * mp.ellipk(p.exact) - F, 2 * mp.ellipe(p.exact) - E
        assert abs(F - u) < 1e-35
        assert abs(E - epsilon) < 1e-35
        assert beyond == (u > mp.ellipk(p.exact))


def test_at_m1_zero_the_functions_are_hyperbolic() -> None:
    u = np.array([-800.0, -40.0, -0.3, 0.0, 1e-9, 2.0, 19.0, 800.0])
    got = jacobi(u, 1.0, 0.0)
    with mp.workdps(400):
        truth = [(mp.tanh(x), mp.sech(x), mp.sech(x), mp.atan(mp.sinh(x)), mp.tanh(x)) for x in map(mp.mpf, u.tolist())]
    for values, exact in zip(got, zip(*truth, strict=True), strict=True):
        np.testing.assert_allclose(values, [float(x) for x in exact], rtol=4 * EPS, atol=0.0)


def test_the_least_subnormal_m1_is_hyperbolic_about_zero_and_about_the_quarter_period() -> None:
    """About K, with v = u - K: sn = 1, cn = -sqrt(m1) sinh v, dn = sqrt(m1) cosh v, up to m1 e^(2 K + 2 |v|)."""
    m1 = 5e-324
    quarter = complete_k(1.0, m1)
    u = np.array([-30.0, 0.5, 5.0, 100.0])
    np.testing.assert_allclose(jacobi(u, 1.0, m1).dn, 1 / np.cosh(u), rtol=4 * EPS * 101)
    v = np.array([-60.0, -3.0, 2.0, 70.0])
    at = jacobi(quarter + v, 1.0, m1)
    np.testing.assert_allclose(at.cn, -math.sqrt(m1) * np.sinh(v), rtol=4 * EPS * (1 + quarter + 70))
    np.testing.assert_allclose(at.dn, math.sqrt(m1) * np.cosh(v), rtol=4 * EPS * (1 + quarter + 70))


def test_a_small_m1_is_not_replaced_by_zero_beyond_the_quarter_period() -> None:
    quarter = complete_k(1.0, 1e-30)
    assert jacobi(2 * quarter, 1.0, 1e-30).cn == pytest.approx(-1.0, abs=EPS)
    assert jacobi(4 * quarter, 1.0, 1e-30).cn == pytest.approx(1.0, abs=EPS)


@st.composite
def parameters(draw: st.DrawFn) -> Parameter:
    small = 10.0 ** draw(st.floats(-200.0, -0.31))
    return Parameter(small, 1.0 - small) if draw(st.booleans()) else Parameter(1.0 - small, small)


@given(p=parameters(), turns=st.floats(-20.0, 20.0))
def test_identities(p: Parameter, turns: float) -> None:
    quarter = complete_k(p.m, p.m1)
    u = turns * quarter
    here, minus, quarter_on = jacobi(u, p.m, p.m1), jacobi(-u, p.m, p.m1), jacobi(u + quarter, p.m, p.m1)
    allowed = 8 * EPS * (1 + abs(u) + quarter)
    assert (minus.sn, minus.cn, minus.dn) == (-here.sn, here.cn, here.dn)
    assert (minus.am, minus.epsilon) == (-here.am, -here.epsilon)
    assert here.sn**2 + here.cn**2 == pytest.approx(1.0, abs=4 * EPS)
    assert here.dn**2 == pytest.approx(p.m1 + p.m * here.cn**2, rel=2 * allowed)
    assert here.dn * quarter_on.dn == pytest.approx(math.sqrt(p.m1), rel=2 * allowed)
    half_on = jacobi(u + 2 * quarter, p.m, p.m1)
    assert half_on.am == pytest.approx(here.am + math.pi, abs=2 * allowed)
    assert half_on.epsilon == pytest.approx(here.epsilon + 2 * complete_e(p.m, p.m1), abs=2 * allowed)


def test_broadcasting_equals_scalars() -> None:
    u = np.linspace(-9.0, 9.0, 7)
    m1 = np.array([[1.0], [0.3], [1e-20], [0.0]])
    table = jacobi(u, 1.0 - m1, m1)
    for i, row in enumerate(m1[:, 0].tolist()):
        for j, x in enumerate(u.tolist()):
            one = jacobi(x, 1.0 - row, row)
            assert all(isinstance(value, float) for value in one)
            np.testing.assert_allclose([f[i, j] for f in table], one, rtol=0.0, atol=4 * EPS * (1 + abs(x)))
    assert jacobi(u, 0.7, 0.3).sn.shape == (7,)
    assert jacobi(2.0, 1.0 - m1, m1).sn.shape == (4, 1)
    assert jacobi(np.zeros((0,)), 0.7, 0.3).am.shape == (0,)


def test_inputs_are_left_alone() -> None:
    u = np.linspace(0.0, 5.0, 5)
    m1 = np.array([0.5, 0.1, 1.0, 0.0, 1e-12])
    m = 1.0 - m1
    before = u.copy(), m.copy(), m1.copy()
    jacobi(u, m, m1)
    argument(np.sin(u), np.cos(u), m, m1)
    incomplete_e(u, m, m1)
    for array, copy in zip((u, m, m1), before, strict=True):
        np.testing.assert_array_equal(array, copy)


# --- functions of the amplitude -----------------------------------------------------------------------------------


def promised(p: Parameter) -> float:
    """The bound on the error over 1 + |result|: a tiny m1 takes up to eleven steps, each with its rounding."""
    return (4 if p.m1 >= 1e-7 else 8) * EPS


@each_parameter
def test_incomplete_integrals(p: Parameter) -> None:
    rng = np.random.default_rng(7)
    beside = np.array([1e-300, 1e-9, math.pi / 2, math.pi / 2 - 1e-7, math.pi, 3 * math.pi / 2, 10 * math.pi])
    phi = np.concatenate([beside, rng.uniform(-1.6, 1.6, 8), rng.uniform(-200.0, 200.0, 8)])
    with mp.workdps(p.dps + 20):
        F = [mp.ellipf(x, p.exact) for x in map(mp.mpf, phi.tolist())]
        E = [mp.ellipe(x, p.exact) for x in map(mp.mpf, phi.tolist())]
    got_f, got_e = incomplete_f(phi, p.m, p.m1), incomplete_e(phi, p.m, p.m1)
    assert (gaps(got_f, F) <= promised(p) * (1 + np.array([abs(float(x)) for x in F]))).all()
    assert (gaps(got_e, E) <= promised(p) * (1 + abs(phi))).all()
    np.testing.assert_allclose(got_f[:2], phi[:2], rtol=4 * EPS, atol=0.0)
    np.testing.assert_allclose(got_e[:2], phi[:2], rtol=4 * EPS, atol=0.0)
    np.testing.assert_allclose([incomplete_f(x, p.m, p.m1) for x in phi.tolist()], got_f, rtol=4 * EPS)


def test_incomplete_integrals_at_the_limit() -> None:
    """At m1 = 0: E is the integral of |cos|, and F is gd^-1 up to a quarter turn."""
    phi = np.array([-20.0, -2.0, -1.5, -1e-9, 0.0, 0.7, 1.5, 1.6, 6.0, 20.0])
    with mp.workdps(50):
        E = [float(mp.ellipe(mp.mpf(x), 1)) for x in phi.tolist()]
        F = [float(mp.asinh(mp.tan(mp.mpf(x)))) if abs(x) < 1.57 else math.copysign(math.inf, x) for x in phi.tolist()]
    np.testing.assert_allclose(incomplete_e(phi, 1.0, 0.0), E, rtol=4 * EPS)
    np.testing.assert_allclose(incomplete_f(phi, 1.0, 0.0), F, rtol=4 * EPS)
    assert incomplete_f(1.6, 1.0, 0.0) == math.inf
    assert incomplete_e(0.7, 1.0, 0.0) == pytest.approx(math.sin(0.7), rel=EPS)


@each_parameter
def test_argument_there_and_back(p: Parameter) -> None:
    """From angles over the whole turn, those a hair from pi/2 included, where u is all in the digits of cn."""
    half = np.concatenate([np.linspace(0.01, 1.55, 9), [1e-200, 1e-12]])
    sn0 = np.concatenate([np.sin(half), np.cos(half), np.sin(half), -np.cos(half)])
    cn0 = np.concatenate([np.cos(half), np.sin(half), -np.cos(half), -np.sin(half)])
    u0 = argument(sn0, cn0, p.m, p.m1)
    quarter = complete_k(p.m, p.m1)
    assert (abs(u0) <= 2 * quarter * (1 + EPS)).all()
    with mp.workdps(p.dps + 20):
        m, K = p.exact, mp.ellipk(p.exact)
        truth = []
        for s, c in zip(map(mp.mpf, sn0.tolist()), map(mp.mpf, cn0.tolist()), strict=True):
            first = mp.ellipf(mp.atan2(abs(s), abs(c)), m)
            truth.append(mp.sign(s) * (first if c > 0 else 2 * K - first))
    assert (gaps(u0, truth) <= promised(p) * (1 + abs(u0))).all()
    there = jacobi(u0, p.m, p.m1)
    allowed = 8 * EPS * (1 + abs(u0))
    assert (abs(there.sn - sn0) <= allowed * np.maximum(abs(sn0), abs(cn0) * there.dn)).all()
    assert (abs(there.cn - cn0) <= allowed * np.maximum(abs(cn0), abs(sn0) * there.dn)).all()


@each_parameter
def test_argument_backwards_is_two_quarter_periods(p: Parameter) -> None:
    half_period = 2 * complete_k(p.m, p.m1)
    for zero in (0.0, -0.0):
        assert argument(zero, -1.0, p.m, p.m1) == pytest.approx(half_period, rel=4 * EPS)
        assert argument(np.array([zero]), np.array([-1.0]), p.m, p.m1)[0] == pytest.approx(half_period, rel=4 * EPS)
        assert argument(zero, 1.0, p.m, p.m1) == 0.0


def test_argument_on_the_separatrix() -> None:
    u = np.array([-300.0, -2.0, 0.0, 1e-9, 5.0])
    at = jacobi(u, 1.0, 0.0)
    np.testing.assert_allclose(argument(at.sn, at.cn, 1.0, 0.0), u, rtol=8 * EPS)
    assert argument(1.0, 0.0, 1.0, 0.0) == math.inf
    assert argument(-0.6, -0.8, 1.0, 0.0) == -math.inf


# --- refusals, and what the common alternative does ----------------------------------------------------------------


@pytest.mark.parametrize(("m", "m1"), [(-0.1, 1.1), (1.5, -0.5), (0.9, 0.9)])
def test_parameters_that_cannot_be(m: float, m1: float) -> None:
    with pytest.raises(UsageError, match="reciprocal parameter"):
        jacobi(0.3, m, m1)


def test_one_bad_parameter_in_an_array_is_named() -> None:
    with pytest.raises(UsageError, match=r"m = 0\.81 with m1 = 0\.1:"):
        complete_k(np.array([0.5, 0.81]), np.array([0.5, 0.1]))


def test_a_nan_argument_stays_where_it_is_and_a_nan_parameter_is_refused() -> None:
    for values in jacobi(np.array([0.3, math.nan]), 0.5, 0.5):
        np.testing.assert_array_equal(np.isnan(values), [False, True])
    assert all(math.isnan(value) for value in jacobi(math.nan, 0.5, 0.5))
    for m, m1 in ((math.nan, 0.5), (0.5, math.nan)):
        with pytest.raises(UsageError, match="nan"):
            jacobi(0.3, m, m1)
        with pytest.raises(UsageError, match="nan"):
            complete_k(np.array([0.5, m]), np.array([0.5, m1]))


def test_scipy_is_not_loaded() -> None:
    """Its import takes longer than solving a scene."""
    code = "import sys, cablecad.rod.elliptic, cablecad.rod.quadrature; sys.exit('scipy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


SCIPY_MEASURED = scipy.__version__ == "1.17.1"


def test_where_scipy_ellipj_fails() -> None:
    """m1 = 2^-40, u = 2.5 K: ellipj takes a series about tanh that does not hold beyond K: its cn is -4096."""
    m1 = 2.0**-40
    p = Parameter(1.0 - m1, m1)
    u = 2.5 * complete_k(p.m, p.m1)
    exact = [float(x) for x in exact_jacobi(u, p)[:3]]
    np.testing.assert_allclose(jacobi(u, p.m, p.m1)[:3], exact, rtol=0.0, atol=4 * EPS * (1 + u))
    at_limit = jacobi(400.0, 1.0, 0.0)
    assert at_limit[:2] == (1.0, pytest.approx(2 * math.exp(-400.0), rel=4 * EPS))
    if SCIPY_MEASURED:
        assert scipy.special.ellipj(u, p.m)[1] == pytest.approx(-4096.0, rel=1e-6)
        assert np.isnan(scipy.special.ellipj(400.0, 1.0)[1])


def test_where_scipy_ellipeinc_fails() -> None:
    """An ordinary point at which ellipeinc is 7 % off; the phi is an amplitude of a uniform grid of arclengths."""
    phi, m = 0.5152081237009323, 0.81
    exact = float(mp.ellipe(mp.mpf(phi), mp.mpf(m)))
    assert exact == pytest.approx(0.49714, abs=5e-6)
    assert incomplete_e(phi, m, 1.0 - m) == pytest.approx(exact, rel=4 * EPS)
    if SCIPY_MEASURED:
        assert scipy.special.ellipeinc(phi, m) == pytest.approx(0.53375, abs=5e-6)
