"""The rivals of the benchmark find what is known: a benchmark whose rival is broken proves nothing."""

import math

import numpy as np
import pytest

from cablecad.bench.rivals import Scenes, rival_energy, search_45

# L = EI = 1, start at the origin: angles, place, least energy (closed forms, and 26-digit minimisation).
KNOWN = [
    (0.0, math.pi / 2, (2 / math.pi, 2 / math.pi), math.pi**2 / 8),
    (0.0, math.pi, (0.0, 2 / math.pi), math.pi**2 / 2),
    (0.0, 0.0, (0.5, 0.0), 22.8023670460620),
    (0.0, 0.0, (0.1, 0.0), 20.1369837863150),
    (math.pi / 2, -math.pi / 2, (0.3, 0.0), 9.136720278),
    (0.0, 0.0, (0.6, 0.3), 14.219524301),
]


def test_the_search_from_45_starts_finds_known_energies():
    scenes = Scenes(np.array([k[0] for k in KNOWN]), np.array([k[1] for k in KNOWN]), np.array([k[2] for k in KNOWN]))
    assert np.max(np.abs(search_45(scenes) / [k[3] for k in KNOWN] - 1)) < 1e-9


@pytest.mark.parametrize("case", [0, 2, 4])
def test_the_discrete_rod_converges_to_known_energies_within_its_estimated_error(case):
    a, b, place, energy = KNOWN[case]
    found, error = rival_energy(a, b, np.array(place), np.random.default_rng(2), 10)
    assert error < 1e-3 * energy
    assert abs(found - energy) < 1.2 * error + 1e-6 * energy
