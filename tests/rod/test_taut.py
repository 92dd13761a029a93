"""The taut closed form: it solves the equation of the elastica, and its positions are quadratures of its tangent."""

import math

import numpy as np
import pytest

from cablecad.rod.taut import EXACT, taut
from cablecad.rod.trial import gauss_legendre


@pytest.mark.parametrize("excess", [0.03, 1e-3, 1e-6, 1e-10])
@pytest.mark.parametrize(("a", "b"), [(1.0, 0.7), (-2.0, 2.5), (math.pi, math.pi), (3.0, -3.0), (0.4, 0.0)])
def test_shape_meets_the_ends_and_the_equation(a, b, excess):
    found = taut(np.array([a]), np.array([b]), True, True, np.array([excess]))
    found = found.take(np.flatnonzero(found.omega >= EXACT))
    along, across = found.position(np.array([1.0]))
    cosine, sine = np.cos(found.direction), np.sin(found.direction)
    x, y = cosine * along[:, 0] - sine * across[:, 0], sine * along[:, 0] + cosine * across[:, 0]
    assert np.max(np.abs(x - (1 - excess)), initial=0.0) < 1e-15
    assert np.max(np.abs(y), initial=0.0) < 1e-15
    # Layer coordinates: a few widths next to the start, where all happens.
    node, weight = gauss_legendre(60)
    for one in range(len(found.omega)):
        rod = found.take(np.array([one]))
        s = node * min(0.5, 8.0 / rod.omega[0])
        psi, kappa = rod.psi(s)[0], rod.curvature(s)[0]
        invariant = kappa**2 / 2 + rod.omega[0] ** 2 * np.cos(psi)
        assert np.ptp(invariant) < 1e-12 * rod.omega[0] ** 2
        width = min(0.5, 8.0 / rod.omega[0])
        step = rod.position(np.array([width]))
        assert math.isclose(step[1][0, 0] / width, weight @ np.sin(psi), abs_tol=1e-12)


def test_more_slack_than_the_layers_need_is_not_taut():
    assert not len(taut(np.array([0.3]), np.array([-0.2]), True, True, np.array([0.3])).scene)
