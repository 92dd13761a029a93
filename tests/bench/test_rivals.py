"""The rivals of the benchmark find what is known: a benchmark whose rival is broken proves nothing."""

import math

import numpy as np
import pytest

from cablecad.bench.collocation import boundary_value, naive_guess
from cablecad.bench.discrete_rod import search_rod
from cablecad.bench.scenes import Scenes
from cablecad.bench.search import search_45
from cablecad.bench.truth import planar_truths

# L = EI = 1, start at the origin: angles, place, least energy (closed forms, and 26-digit minimisation).
KNOWN = [
    (0.0, math.pi / 2, (2 / math.pi, 2 / math.pi), math.pi**2 / 8),
    (0.0, math.pi, (0.0, 2 / math.pi), math.pi**2 / 2),
    (0.0, 0.0, (0.5, 0.0), 22.8023670460620),
    (0.0, 0.0, (0.1, 0.0), 20.1369837863150),
    (math.pi / 2, -math.pi / 2, (0.3, 0.0), 9.136720278),
    (0.0, 0.0, (0.6, 0.3), 14.219524301),
]


def reference(name):
    return next(truth for truth in planar_truths() if truth.name == name)


def test_the_search_from_45_starts_finds_known_energies():
    scenes = Scenes(np.array([k[0] for k in KNOWN]), np.array([k[1] for k in KNOWN]), np.array([k[2] for k in KNOWN]))
    assert np.max(np.abs(search_45(scenes) / [k[3] for k in KNOWN] - 1)) < 1e-9


@pytest.mark.parametrize("case", [2, 4, 5])
def test_the_discrete_rod_converges_to_known_energies_with_the_square_of_its_segments(case):
    a, b, place, energy = KNOWN[case]
    off = [
        search_rod(a, b, np.array(place), segments=n, starts=10, rng=np.random.default_rng(2)).energy / energy - 1.0
        for n in (50, 100)
    ]
    assert abs(off[1]) < 2e-3
    assert off[0] / off[1] == pytest.approx(4.0, abs=0.8)


@pytest.mark.parametrize("name", ["random04", "random05"])
def test_the_discrete_rod_gives_the_points_of_a_reference(name):
    truth = reference(name)
    found = search_rod(truth.a, truth.b, truth.end, segments=200, starts=10, rng=np.random.default_rng(0))
    assert found.energy == pytest.approx(truth.energy, rel=1e-3)
    assert np.abs(found.points - truth.points).max() < 1e-3


def test_collocation_gives_the_points_of_a_reference():
    truth = reference("random04")
    found = boundary_value(truth.a, truth.end, naive_guess(truth.a, truth.b, truth.end))()
    assert found.energy == pytest.approx(truth.energy, rel=1e-6)
    assert np.abs(found.points - truth.points).max() < 1e-6


def test_collocation_keeps_its_tolerance_where_it_finds_the_shape():
    a, b, place, energy = KNOWN[4]
    for tolerance, allowed in ((1e-3, 1e-3), (1e-6, 1e-7), (1e-9, 1e-10)):
        found = boundary_value(a, np.array(place), naive_guess(a, b, np.array(place)), tolerance=tolerance)()
        assert found.energy == pytest.approx(energy, rel=allowed + 1e-9)


def test_collocation_that_meets_no_ends_is_no_success():
    found = boundary_value(0.0, np.array([2.0, 0.0]), naive_guess(0.0, 0.0, np.array([2.0, 0.0])))()
    assert not math.isfinite(found.energy)
