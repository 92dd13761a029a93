"""Splines of odd degree: the same as SciPy's, polynomials reproduced, and rounding no worse with thousands of spans."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline

from cablecad.brep.bspline import end_orders, interpolate, powers_of


def knots_of(spans: int, seed: int) -> np.ndarray:
    """Neighbouring spans differ by up to a factor of five, as the fit's do."""
    steps = 5.0 ** np.random.default_rng(seed).uniform(-0.5, 0.5, spans)
    return np.concatenate([[0.0], np.cumsum(steps) / steps.sum()])


@pytest.mark.parametrize("degree", [3, 5, 7, 9])
@pytest.mark.parametrize("spans", [1, 2, 3, 5, 17, 58, 59, 60, 119, 200, 3000])
def test_same_as_scipy(spans: int, degree: int) -> None:
    rng = np.random.default_rng(spans)
    knots = np.linspace(0.0, 1.0, spans + 1) if degree == 9 else knots_of(spans, spans)
    orders = end_orders(degree)
    values = np.cumsum(rng.normal(size=(spans + 1, 4)), axis=0) / (1 + spans) ** 0.5
    # Derivatives of the size a curve has whose features are as long as the spans.
    start, end = rng.normal(size=(2, len(orders), 4)) * float(spans) ** np.array(orders)[:, None]
    conditions = tuple([(order, side[i]) for i, order in enumerate(orders)] for side in (start, end))
    theirs = make_interp_spline(knots, values, k=degree, bc_type=conditions)
    ours = interpolate(knots, degree, values, start, end)
    size = np.abs(theirs.c).max()
    assert np.abs(ours.poles - theirs.c).max() < 1e-11 * size
    x = np.sort(rng.uniform(0.0, 1.0, 500))
    x[[0, -1]] = 0.0, 1.0
    found = ours(x, 3)
    for derivative in range(4):
        want = theirs(x, nu=derivative)
        assert np.abs(found[derivative] - want).max() < 1e-9 * np.abs(want).max()


@pytest.mark.parametrize("degree", [5, 7, 9])
@pytest.mark.parametrize("spans", [1, 4, 70])
def test_polynomials_are_reproduced(spans: int, degree: int) -> None:
    knots = knots_of(spans, 3)
    polynomial = np.polynomial.Polynomial(np.random.default_rng(degree).normal(size=degree + 1))
    ends = [np.array([[polynomial.deriv(order)(x)] for order in end_orders(degree)]) for x in (0.0, 1.0)]
    spline = interpolate(knots, degree, polynomial(knots)[:, None], *ends)
    x = np.linspace(0.0, 1.0, 301)
    found = spline(x, 5)[:, :, 0]
    for derivative in range(6):
        want = polynomial.deriv(derivative)(x) if derivative else polynomial(x)
        assert np.abs(found[derivative] - want).max() < 1e-11 * 100.0**derivative * (1 + spans)


@pytest.mark.parametrize("spans", [1, 2, 13, 119, 130])
def test_many_at_once_are_as_each_alone(spans: int) -> None:
    degree, rng = 9, np.random.default_rng(spans)
    knots = np.stack([np.linspace(0.0, 1.0, spans + 1) ** power for power in (1.0, 1.1, 1.2)])
    values, (start, end) = rng.normal(size=(3, spans + 1, 2)), rng.normal(size=(2, 3, 4, 2))
    powers = powers_of(np.linspace(0.0, 1.0, 4), degree, 1)
    many = interpolate(knots, degree, values, start, end)
    sampled = many.sampled(powers)
    some = slice(spans // 2, None)
    for i in range(3):
        alone = interpolate(knots[i], degree, values[i], start[i], end[i])
        size = np.abs(alone.poles).max()
        assert np.abs(many.poles[i] - alone.poles).max() < 1e-12 * size
        for spline in (alone, many.one(i)):
            for order in (0, 1):
                want = spline.sampled(powers)[order]
                assert np.abs(sampled[order, i] - want).max() < 1e-11 * np.abs(want).max()
                want = spline.sampled(powers, some)[order]
                assert np.abs(many.sampled(powers, some)[order, i] - want).max() < 1e-11 * np.abs(want).max()


@pytest.mark.parametrize("degree", [7, 9])
def test_samples_are_values(degree: int) -> None:
    """At the same shares of every span, by the same derivatives, of all spans or of some."""
    knots = knots_of(40, 5)
    orders = np.array(end_orders(degree))
    values = np.stack([np.sin(9.0 * knots), np.cos(9.0 * knots)], axis=1)
    spline = interpolate(knots, degree, values, np.zeros((len(orders), 2)), np.zeros((len(orders), 2)))
    shares = np.array([0.0, 0.3, 0.95])
    x = knots[:-1, None] + np.diff(knots)[:, None] * shares
    for spans in (slice(None), slice(7, 19), slice(30, 99)):
        sampled, called = spline.sampled(powers_of(shares, degree, 2), spans), spline(x[spans].ravel(), 2)
        assert sampled.shape == called.shape
        for derivative in range(3):
            assert np.abs(sampled[derivative] - called[derivative]).max() < 1e-11 * np.abs(called[derivative]).max()


@pytest.mark.parametrize("degree", [5, 7, 9])
def test_values_at_knots_are_met(degree: int) -> None:
    knots = knots_of(500, 9)
    values = np.sin(40.0 * knots)[:, None]
    signs = np.array([(-1.0) ** (order // 2) * 40.0**order for order in end_orders(degree)])
    spline = interpolate(knots, degree, values, signs[:, None], signs[:, None] * np.cos(40.0))
    assert np.abs(spline(knots)[0] - values).max() < (1e-13 if degree == 9 else 1e-14)
    assert np.array_equal(spline.poles[[0, -1]], values[[0, -1]])
