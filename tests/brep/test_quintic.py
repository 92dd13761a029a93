"""Quintic splines: the same as SciPy's, polynomials reproduced, and rounding no worse with thousands of spans."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline

from cablecad.brep.quintic import QuinticSpline, interpolate


def knots_of(spans: int, seed: int) -> np.ndarray:
    """Neighbouring spans differ by up to a factor of five, as the fit's do."""
    steps = 5.0 ** np.random.default_rng(seed).uniform(-0.5, 0.5, spans)
    return np.concatenate([[0.0], np.cumsum(steps) / steps.sum()])


@pytest.mark.parametrize("orders", [(1, 3), (1, 2)])
@pytest.mark.parametrize("spans", [1, 2, 3, 5, 17, 58, 59, 60, 200, 3000])
def test_same_as_scipy(spans: int, orders: tuple[int, int]) -> None:
    rng = np.random.default_rng(spans)
    knots = knots_of(spans, spans)
    values = np.cumsum(rng.normal(size=(spans + 1, 4)), axis=0) / (1 + spans) ** 0.5
    start, end = rng.normal(size=(2, 2, 4))
    conditions = tuple([(order, side[i]) for i, order in enumerate(orders)] for side in (start, end))
    theirs = make_interp_spline(knots, values, k=5, bc_type=conditions)
    ours = interpolate(knots, values, orders, start, end)
    size = np.abs(theirs.c).max()
    assert np.abs(ours.poles - theirs.c).max() < 1e-11 * size
    x = np.sort(rng.uniform(0.0, 1.0, 500))
    x[[0, -1]] = 0.0, 1.0
    for derivative in range(4):
        want = theirs(x, nu=derivative)
        assert np.abs(ours(x, derivative) - want).max() < 1e-9 * np.abs(want).max()


@pytest.mark.parametrize("spans", [1, 4, 70])
def test_quintics_are_reproduced(spans: int) -> None:
    knots = knots_of(spans, 3)
    polynomial = np.polynomial.Polynomial([0.3, -1.0, 2.0, 0.5, -3.0, 1.7])
    ends = [[np.array([polynomial.deriv(order)(x)]) for order in (1, 3)] for x in (0.0, 1.0)]
    spline = interpolate(knots, polynomial(knots)[:, None], (1, 3), *ends)
    x = np.linspace(0.0, 1.0, 301)
    for derivative in range(6):
        want = polynomial.deriv(derivative)(x) if derivative else polynomial(x)
        assert np.abs(spline(x, derivative)[:, 0] - want).max() < 1e-11 * 100.0**derivative * (1 + spans)


def test_values_at_knots_are_met() -> None:
    knots = knots_of(500, 9)
    values = np.sin(40.0 * knots)[:, None]
    ends = [[np.array([40.0 * np.cos(40.0 * x)]), np.array([-64000.0 * np.cos(40.0 * x)])] for x in (0.0, 1.0)]
    spline = interpolate(knots, values, (1, 3), *ends)
    assert isinstance(spline, QuinticSpline)
    assert np.abs(spline(knots) - values).max() < 1e-14
    assert np.array_equal(spline.poles[[0, -1]], values[[0, -1]])
