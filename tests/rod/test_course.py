"""One elastica as a curve: the same as the flow of arrays, in every regime."""

import math

import numpy as np
import pytest
from test_flow import S, states

from cablecad.rod.course import Course
from cablecad.rod.flow import jump
from cablecad.rod.midpoint import State


@pytest.mark.parametrize("tension", [False, True])
@pytest.mark.parametrize(("psi", "kappa", "omega"), list(states()))
def test_every_regime_is_that_of_the_flow(psi, kappa, omega, tension):
    lean = math.remainder(psi - math.pi, 2 * math.pi) if tension else psi
    state = State(float(lean), float(kappa), 0.7, float(omega), tension)
    p, c = state.half
    want = jump(np.array([p]), np.array([c]), np.array([kappa]), np.array([omega]), S)
    scale = 1 + omega + abs(kappa)
    got = Course(state).at(S)
    for name in ("along", "across", "kappa"):
        assert np.max(np.abs(getattr(got, name) - getattr(want, name)[0])) < 3e-14 * scale, name
    assert np.max(np.abs(got.cosine - (want.c**2 - want.p**2)[0])) < 3e-14 * scale
    assert np.max(np.abs(got.sine - (2 * want.c * want.p)[0])) < 3e-14 * scale
    theta = state.direction + state.lean + want.turn[0]
    cosine, sine, bent = Course(state).tangent(S)
    assert np.max(np.abs(cosine - np.cos(theta))) < 3e-14 * scale
    assert np.max(np.abs(sine - np.sin(theta))) < 3e-14 * scale
    assert np.array_equal(bent, got.kappa)
