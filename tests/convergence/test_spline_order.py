"""The fit's error falls with the power of the span its degree allows, with the constant the knots are counted by."""

from __future__ import annotations

import math

import numpy as np
import pytest
from curves import Helix, arch, chain
from scipy.special import bernoulli

from cablecad.brep.bspline import end_orders, interpolate
from cablecad.brep.fit import fit_centreline
from cablecad.brep.knots import DEGREE, ORDER, SPAN_ERROR, knot_density
from cablecad.brep.spline import FittedPiece
from cablecad.centreline import Centreline

BERNOULLI_10 = np.polynomial.Polynomial([5 / 66, 0, -3 / 2, 0, 5, 0, -7, 0, 15 / 2, -5, 1])


def test_constant_is_the_bernoulli_polynomial() -> None:
    assert BERNOULLI_10(0.0) == pytest.approx(bernoulli(ORDER)[ORDER], rel=1e-15)
    exact = abs(BERNOULLI_10(0.5) - BERNOULLI_10(0.0)) / math.factorial(ORDER)
    assert pytest.approx(exact, rel=1e-14) == SPAN_ERROR


@pytest.mark.parametrize("spans", [5, 8, 20])
def test_error_for_a_constant_derivative(spans: int) -> None:
    """x^10 / 10! with its odd derivatives at the ends: the same error curve in every span, end spans too."""
    knots = np.linspace(0.0, 1.0, spans + 1)
    ends = [
        np.array([[end ** (ORDER - i) / math.factorial(ORDER - i)] for i in end_orders(DEGREE)]) for end in (0.0, 1.0)
    ]
    spline = interpolate(knots, DEGREE, knots[:, None] ** ORDER / math.factorial(ORDER), *ends)
    t = np.linspace(0.0, 1.0, 33)
    x = (np.arange(spans)[:, None] + t) / spans
    error = x**ORDER / math.factorial(ORDER) - spline(x.ravel())[0].reshape(x.shape)
    expected = (BERNOULLI_10(t) - BERNOULLI_10(0.0)) / math.factorial(ORDER) / spans**ORDER
    # The spline is solved to a few eps of its values, which reach 1 / 10!.
    rounding = 1e-14 / math.factorial(ORDER)
    assert np.abs(error - expected).max() < rounding
    assert np.abs(error).max() == pytest.approx(SPAN_ERROR / spans**ORDER, rel=1e-6, abs=rounding)


@pytest.mark.parametrize("waves", [0.05, 0.1, 0.2, 0.3])
def test_error_of_waves(waves: float) -> None:
    """cos(w s) with so many waves a span: the greatest error is that of the formula, far from the ends."""
    spans = 60
    w = 2.0 * math.pi * waves
    s = np.arange(spans + 1.0)
    ends = [
        np.array([[w**i * math.cos(w * end + i * math.pi / 2.0)] for i in end_orders(DEGREE)])
        for end in (0.0, float(spans))
    ]
    spline = interpolate(s, DEGREE, np.cos(w * s)[:, None], *ends)
    # Over some spans in the middle, so that a crest of the wave meets the middle of a span.
    x = np.linspace(spans / 2.0 - 5.0, spans / 2.0 + 5.0, 4001)
    error = float(np.abs(spline(x)[0, :, 0] - np.cos(w * x)).max())
    # The density that is wanted for this error is the one there is.
    density = knot_density(np.array([w**ORDER]), np.array([w ** (ORDER + 2)]), error)
    assert density[0] == pytest.approx(1.0, rel=0.04)


@pytest.mark.parametrize("tolerance", [1e-4, 1e-5, 1e-6, 1e-7])
@pytest.mark.parametrize("radius", [0.1, 2.0, 14.0])
def test_constant_of_a_circular_arc(tolerance: float, radius: float) -> None:
    """An arc's spans are even and |f^(10)| is kappa^9 (1 + kappa r): far from its ends the error is a wave's."""
    kappa, length = 1 / 15.0, 600.0
    curve = chain((length, kappa))
    fit = fit_centreline(curve, radius, tolerance=tolerance)
    (piece,) = fit.pieces
    assert isinstance(piece, FittedPiece)
    h = length / fit.spans
    x = kappa * h / (2.0 * math.pi)
    wave = ((1.0 - x) ** -ORDER + (1.0 + x) ** -ORDER) / 2.0
    formula = SPAN_ERROR * h**ORDER * kappa ** (ORDER - 1) * (1.0 + kappa * radius) * wave
    s = np.array([(fit.spans // 2 + 0.5) * h])
    exact, found = curve.frames(s), piece.evaluate(s)[0]
    along, across = found[0, :3] - exact.position[0], radius * (found[0, 3:6] - exact.normal[0])
    assert max(np.linalg.norm(along + across), np.linalg.norm(along - across)) == pytest.approx(formula, rel=0.01)
    assert fit.deviation < 3.0 * formula  # beside the ends


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
def test_order_ten(name: str) -> None:
    fits = [fit_centreline(CURVES[name], 2.0, tolerance=10.0**-n) for n in (6, 7, 8, 9)]
    # The shortest, where the bend is tightest: away from a loop spans grow, whatever the tolerance.
    shortest = np.log([np.diff(piece.knots).min() for fit in fits for piece in fit.pieces])
    deviations = np.log([fit.deviation for fit in fits])
    order = np.polyfit(shortest, deviations, 1)[0]
    # Long spans, of which a wave takes few, err by more than their order says.
    assert 9.5 < order < 13.5
