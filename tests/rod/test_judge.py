"""Verdicts found without margins are the signs of the margins."""

from __future__ import annotations

import numpy as np
import pytest

from cablecad.rod.judge import SHARPEST, judge_in_plane
from cablecad.rod.planar import solve_planar
from cablecad.rod.stability import stability


@pytest.mark.parametrize("held", [(True, True), (True, False), (False, True)])
def test_verdicts_of_many_are_the_signs_of_their_margins(held: tuple[bool, bool]) -> None:
    """Against each equilibrium judged alone, on panels chosen for it."""
    rng = np.random.default_rng(26)
    count = 60
    a, b = rng.uniform(-np.pi, np.pi, (2, count))
    chord, turn = rng.uniform(0.05, 0.98, count), rng.uniform(-np.pi, np.pi, count)
    end = chord[:, None] * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    found = solve_planar(a + turn, b + turn, end, start_clamped=held[0], end_clamped=held[1], search="wide").equilibria
    found = found.take(np.flatnonzero(np.maximum(found.omega, found.kappa_max / 2.0) <= SHARPEST))
    found.verdict[:], found.margins[:] = 0, np.nan
    judge_in_plane(found)
    verdicts = found.verdict[:, 0]
    assert set(verdicts.tolist()) == {-1, 1}
    assert np.isnan(found.margins[:, 0]).mean() > 0.9  # most were decided without one
    for i in range(0, len(found), 3):
        row = found.take(np.array([i]))
        margin = stability(
            lambda s, row=row: row.at(np.atleast_1d(s))[0][0],  # type: ignore[misc]
            lambda s, row=row: row.at(np.atleast_1d(s))[1][0],  # type: ignore[misc]
            row.force[0],
            start_clamped=held[0],
            end_clamped=held[1],
        ).in_plane
        if abs(margin) > 1e-6:
            assert verdicts[i] == np.sign(margin)
