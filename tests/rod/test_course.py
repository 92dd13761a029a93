"""One elastica as a curve: the same as the flow of arrays, in every regime."""

import math

import numpy as np
import pytest
from test_flow import S, states

from cablecad.rod.course import Course, courses
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


def test_many_are_those_of_each_alone():
    """Every regime at once, along rows and one point a rod."""
    found = list(states())
    psi, kappa, omega = map(np.array, zip(*found, strict=True))
    many = courses(np.sin(psi / 2), np.cos(psi / 2), kappa, omega)
    s = np.tile(S, (len(found), 1))
    rows = many.take(np.s_[:, None]).at(s)
    rod = np.repeat(np.arange(len(found)), len(S))
    points = many.take(rod).at(s.ravel())
    for name, got, flat in zip(rows._fields, rows, points, strict=True):
        assert np.array_equal(got.ravel(), flat), name
    bent = many.take(np.s_[:, None]).kappa(s)
    for name, got in zip(("cosine", "sine", "kappa"), many.take(np.s_[:, None]).tangent(s), strict=True):
        assert np.max(np.abs(got - getattr(rows, name)) / (1.0 + np.abs(got))) < 1e-14, name
    for i in range(len(found)):
        want = jump(*(np.array([x]) for x in (math.sin(psi[i] / 2), math.cos(psi[i] / 2), kappa[i], omega[i])), S)
        size = 1.0 + omega[i] + abs(kappa[i])
        assert np.max(np.abs(rows.along[i] - want.along[0])) < 3e-14 * size
        assert np.max(np.abs(rows.across[i] - want.across[0])) < 3e-14 * size
        assert np.max(np.abs(rows.kappa[i] - want.kappa[0])) < 3e-14 * size
        assert np.max(np.abs(bent[i] - want.kappa[0])) < 3e-14 * size
        assert np.max(np.abs(rows.sine[i] - 2.0 * want.p[0] * want.c[0])) < 3e-14 * size


@pytest.mark.parametrize("seed", range(40))
def test_the_crest_is_where_the_curvature_is_greatest(seed):
    """Against a fine sampling of |kappa|: over the whole way, and nowhere before it as great."""
    rng = np.random.default_rng(seed)
    state = State(*rng.uniform(-3.0, 3.0, 2), 0.0, float(rng.choice([0.0, 0.3, 3.0, 9.0])), bool(seed % 2))
    curve = Course(state)
    s, kappa = curve.crest(), curve.state.crest_kappa
    at = np.linspace(-0.5, 0.5, 4001)
    sampled = np.abs(curve.at(at).kappa)
    if s > 0.5:
        assert sampled.max() == pytest.approx(max(sampled[0], sampled[-1]), rel=1e-12)
    else:
        assert np.abs(curve.at(np.array([s])).kappa)[0] == pytest.approx(kappa, rel=1e-13)
        assert kappa >= sampled.max() * (1.0 - 1e-13)
        assert np.all(sampled[at < s - 1e-3] <= kappa)
        assert s >= -0.5 - 1e-12


def test_crests_of_many_are_those_of_each():
    rng = np.random.default_rng(5)
    states = [
        State(*rng.uniform(-3.0, 3.0, 2), 0.0, float(rng.choice([0.0, 0.3, 3.0, 9.0])), bool(i % 2)) for i in range(200)
    ]
    states.append(State(0.0, 0.0, 0.0, 0.0, False))  # a line
    half = np.array([state.half for state in states])
    many = courses(
        half[:, 0], half[:, 1], *(np.array([getattr(x, name) for x in states]) for name in ("kappa", "omega"))
    )
    places, points, has_crest, kappa, tightest, known = many.marks()
    for i, state in enumerate(states):
        want = Course(state).crest()
        assert many.crest()[i] == (want if math.isinf(want) else pytest.approx(want, abs=1e-12 * (1.0 + abs(want))))
        assert many.crest_kappa[i] == pytest.approx(state.crest_kappa, rel=1e-14)
        assert has_crest[i] == (want <= 0.5)
        assert places[i].tolist() == pytest.approx([-0.5, min(want, 0.5), 0.5], abs=1e-12)
        alone = Course(state).at(places[i])
        for got, one in zip(points, alone, strict=True):
            assert np.abs(got[i] - one).max() < 1e-13 * (1.0 + np.abs(one).max())
        assert known[i]
        sampled = np.abs(Course(state).at(np.linspace(-0.5, 0.5, 501)).kappa)
        assert sampled.max() <= kappa[i] * (1.0 + 1e-12)
        assert kappa[i] == pytest.approx(np.abs(Course(state).at(tightest[i : i + 1] - 0.5).kappa)[0], rel=1e-12)
