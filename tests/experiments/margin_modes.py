"""How many trial functions the margins of stability of one equilibrium need: the steps of `judge.TRIAL_MODES`.

Every equilibrium of random scenes is judged with few functions and with 128; printed is the greatest difference over
1 + steepness^2, by number of functions and by the upper end of a band of steepness, max(omega, curvature/2). Run it by
`python tests/experiments/margin_modes.py`; it takes a minute.
"""

from __future__ import annotations

import sys

import numpy as np

from cablecad.rod.planar import solve_planar
from cablecad.rod.stability import stability_at_nodes
from cablecad.rod.trial import trial_space

COUNTS = (12, 16, 20, 24, 28, 32, 36, 44, 52, 60, 72, 84)
BANDS = (3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0, 14.0, 16.0, 18.0, 24.0, 36.0, 100.0)


def differences(held: tuple[bool, bool], scenes: int, seed: int) -> np.ndarray:
    """Greatest differences, shape (bands, counts)."""
    rng = np.random.default_rng(seed)
    d, toward = rng.uniform(0.0, 0.999, scenes), rng.uniform(-np.pi, np.pi, scenes)
    d[::4] = 1.0 - 10.0 ** rng.uniform(-3.0, -1.0, len(d[::4]))
    a, b = rng.uniform(-np.pi, np.pi, (2, scenes))
    end = d[:, None] * np.stack([np.cos(toward), np.sin(toward)], axis=-1)
    ratio = 0.8 if all(held) else None
    found = solve_planar(
        a, b, end, start_clamped=held[0], end_clamped=held[1], torsion_ratio=ratio, search="wide"
    ).equilibria
    found = found.take(np.flatnonzero(~found.taut))

    def margins(count: int) -> np.ndarray:
        space = trial_space(*held, (0.0, 1.0), count)
        theta, kappa, _ = found.at(space.s)
        ends = np.stack([found.theta0, found.theta1], axis=-1)
        judged = stability_at_nodes(
            space, theta, kappa, found.force, ends, start_clamped=held[0], end_clamped=held[1], torsion_ratio=ratio
        )
        return np.stack([judged.in_plane, judged.out_of_plane], axis=-1)

    best = margins(128)
    worst = np.zeros((len(BANDS), len(COUNTS)))
    steepness = np.maximum(found.omega, found.kappa_max / 2.0)
    band = np.searchsorted(BANDS, steepness)
    for j, count in enumerate(COUNTS):
        off = np.max(np.abs(margins(count) - best), axis=1) / (
            1.0 + np.maximum(found.omega, found.kappa_max / 2.0) ** 2
        )
        for i in range(len(BANDS)):
            worst[i, j] = off[band == i].max(initial=0.0)
    return worst


if __name__ == "__main__":
    worst = np.max([differences(held, 1000, 7) for held in ((True, True), (True, False), (False, False))], axis=0)
    sys.stdout.write("   up to" + "".join(f"{count:9d}" for count in COUNTS) + "\n")
    for band, row in zip(BANDS, worst, strict=True):
        sys.stdout.write(f"{band:8g}" + "".join(f"{value:9.0e}" for value in row) + "\n")
