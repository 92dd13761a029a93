"""The truth of the benchmark is right, and errors against it are what they are said to be."""

import math

import mpmath as mp
import numpy as np
import pytest

from cablecad.bench.points import METHODS, OURS, SCIPY, errors_of
from cablecad.bench.truth import arch_truths, function_truths, planar_truths, wave_truths
from cablecad.rod.quadrature import integrate_tangent

mp.mp.dps = 40


@pytest.mark.parametrize("m1", [0.9, 0.19, 1e-4])
def test_waves_obey_their_differential_equation(m1):
    """x' = cos(psi), y' = -sin(psi), psi'' = -sin(psi): Taylor series of mpmath, which know no elliptic functions."""
    truth = next(truth for truth in wave_truths() if truth.m1 == m1)
    i = len(truth.u) // 4 + 10
    start = 2 * mp.sqrt(1 - mp.mpf(m1))
    with mp.workdps(20):
        right = mp.odefun(lambda _, z: [z[1], -mp.sin(z[0]), mp.cos(z[0]), -mp.sin(z[0])], 0, [0, start, 0, start])
        _, _, x, y = right(mp.mpf(float(truth.u[i])))
    assert abs(float(x) - truth.place[i, 0]) < 1e-15
    assert abs(float(y) - truth.place[i, 1]) < 1e-15


@pytest.mark.parametrize("truth", wave_truths(), ids=lambda truth: f"{truth.m1:g}")
def test_waves_are_one_curve_upside_down_after_an_inflection(truth):
    quarter = (len(truth.u) - 1) // 4
    assert truth.u[0] == pytest.approx(-truth.quarter, rel=1e-14)
    assert truth.u[-1] == pytest.approx(3 * truth.quarter, rel=1e-14)
    assert np.all(np.diff(truth.u) > 0.0)
    m = 1 - mp.mpf(truth.m1)
    for i in (3 * quarter - 7, 4 * quarter - 40):
        u = mp.mpf(float(truth.u[i]))
        assert float(2 * mp.sqrt(m) * mp.ellipfun("cn", u, m=m)) == pytest.approx(
            truth.place[i, 1], abs=4e-16 * float(u)
        )


@pytest.mark.parametrize("truth", arch_truths(1000.0), ids=lambda truth: f"{truth.k:g}")
def test_arches_are_the_integral_of_their_tangent(truth):
    def tangent_angle(s):
        """A cubic through angles and curvatures."""
        h = truth.s[1]
        i = np.minimum((s / h).astype(int), len(truth.s) - 2)
        t = s / h - i
        a, b = truth.angle[i], truth.angle[i + 1]
        p, q = h * truth.kappa[i], h * truth.kappa[i + 1]
        return a + t * (p + t * (3 * (b - a) - 2 * p - q + t * (2 * (a - b) + p + q)))

    off = integrate_tangent(tangent_angle, truth.s, nodes=8, panels=1) - truth.place
    assert np.abs(off).max() < 1e-6  # of 1000 mm; the cubic's own error
    assert truth.angle[0] == pytest.approx(-2.0 * math.asin(truth.k), rel=1e-14)


def test_planar_references_have_their_ends():
    truths = planar_truths()
    assert len(truths) >= 25
    for truth in truths:
        assert np.abs(truth.points[0]).max() == 0.0
        assert np.abs(truth.points[-1] - truth.end).max() < 1e-15
        assert math.hypot(*truth.end) < 1.0
        assert np.all(np.hypot(*np.diff(truth.points, axis=0).T) <= 0.125 + 1e-12)


@pytest.mark.parametrize("truth", function_truths(), ids=lambda truth: f"{truth.name} {truth.u:g}")
def test_single_values(truth):
    m = 1 - mp.mpf(truth.m1)
    u = mp.mpf(truth.u)
    if truth.name == "K - E":
        assert float(mp.ellipk(u) - mp.ellipe(u)) == truth.value
    elif truth.name == "cn":
        value = mp.sech(u) if m == 1 else mp.ellipfun("cn", u, m=m)
        assert float(value) == pytest.approx(truth.value, rel=1e-12)
    elif truth.name == "E(phi)":
        assert float(mp.quad(lambda t: mp.sqrt(1 - m * mp.sin(t) ** 2), [0, u])) == pytest.approx(
            truth.value, rel=1e-15
        )
    else:
        # Jacobi's epsilon is the integral of dn^2, whose bumps are 2 K apart.
        quarter = mp.ellipk(m)
        ends = [*[i * quarter for i in range(int(u / quarter) + 1)], u]
        value = mp.quad(lambda t: mp.ellipfun("dn", t, m=m) ** 2, ends)
        assert float(value) == pytest.approx(truth.value, rel=1e-12)


def test_errors_of_points_are_taken_over_the_length_and_see_what_is_not_a_number():
    truth = wave_truths()[1]
    off = truth.place.copy()
    off[3, 1] += 1e-3
    off[5, 0] = np.nan
    errors = errors_of(off, truth)
    assert errors[3] == pytest.approx(1e-3 / (4.0 * truth.quarter))
    assert errors[5] == math.inf
    assert np.count_nonzero(errors) == 2


@pytest.mark.parametrize("name", METHODS)
def test_every_method_of_points_is_right_on_an_easy_curve(name):
    truth = wave_truths()[0]
    errors = errors_of(METHODS[name](truth.u, truth.m1), truth)
    assert np.median(errors) < 1e-4
    if name == OURS:
        assert errors.max() < 1e-14
    if name == SCIPY:
        assert np.median(errors) < 1e-14
