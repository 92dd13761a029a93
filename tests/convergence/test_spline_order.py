"""The fit's error falls with the sixth power of the span, with the constant by which the knots are counted."""

from __future__ import annotations

import math

import numpy as np
import pytest
from curves import Helix, arch, chain
from scipy.interpolate import make_interp_spline

from cablecad.brep.quintic import DEGREE
from cablecad.brep.spline import QUINTIC_ERROR, fit_centreline
from cablecad.centreline import Centreline


def bernoulli_6(t: np.ndarray) -> np.ndarray:
    return t**6 - 3 * t**5 + 2.5 * t**4 - 0.5 * t**2 + 1 / 42


def test_constant_is_the_bernoulli_polynomial() -> None:
    exact = abs(bernoulli_6(np.array(0.5)) - bernoulli_6(np.array(0.0))) / math.factorial(6)
    assert abs(QUINTIC_ERROR - exact) < 1e-15 * exact


@pytest.mark.parametrize("spans", [5, 8, 20])
def test_error_for_a_constant_sixth_derivative(spans: int) -> None:
    """x^6 / 6! with first and third derivatives at the ends: the same error curve in every span, end spans too."""
    knots = np.linspace(0.0, 1.0, spans + 1)
    conditions = tuple(
        [(order, end ** (6 - order) / math.factorial(6 - order)) for order in (1, 3)] for end in (0.0, 1.0)
    )
    spline = make_interp_spline(knots, knots**6 / math.factorial(6), k=DEGREE, bc_type=conditions)
    t = np.linspace(0.0, 1.0, 33)
    x = (np.arange(spans)[:, None] + t) / spans
    error = x**6 / math.factorial(6) - spline(x)
    expected = (bernoulli_6(t) - bernoulli_6(np.zeros(1))) / math.factorial(6) / spans**6
    # The spline is solved to a few eps of its values, which reach 1/720.
    assert np.abs(error - expected).max() < 1e-17
    assert np.abs(error).max() == pytest.approx(QUINTIC_ERROR / spans**6, rel=1e-6)


@pytest.mark.parametrize("tolerance", [1e-6, 1e-7, 1e-8, 1e-9])
@pytest.mark.parametrize("radius", [0.1, 2.0, 14.0])
def test_constant_of_a_circular_arc(tolerance: float, radius: float) -> None:
    """An arc's spans are even and |f^(6)| is kappa^5 (1 + kappa r): the deviation is the formula's but for the next
    term, of the relative size (kappa h)^2."""
    kappa, length = 1 / 15.0, 60.0
    fit = fit_centreline(chain((length, kappa)), radius, tolerance=tolerance)
    h = length / fit.spans
    formula = QUINTIC_ERROR * h**6 * kappa**5 * (1.0 + kappa * radius)
    assert fit.deviation == pytest.approx(formula, rel=1.5 * (kappa * h) ** 2)


CURVES = {
    "k = .2": arch(0.2, 350.0),
    "k = .342": arch(0.342, 350.0),
    "k = .8": arch(0.8, 350.0),
    "k = .999": arch(0.999, 350.0),
    "loop": arch(1.0, 350.0, m1=1e-17),
    "third mode": arch(0.8, 350.0, mode=3),
    "arc": chain((100.0, 0.05)),
    "helix": Centreline([Helix.of_turns(30.0, 100.0, 3.0)]),
}


@pytest.mark.parametrize("name", CURVES)
def test_order_six(name: str) -> None:
    fits = [fit_centreline(CURVES[name], 2.0, tolerance=10.0**-n) for n in (6, 7, 8, 9)]
    spans = np.log([fit.spans for fit in fits])
    deviations = np.log([fit.deviation for fit in fits])
    order = -np.polyfit(spans, deviations, 1)[0]
    assert 5.8 < order < 6.4
