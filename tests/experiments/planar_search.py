"""What chose the numbers of the planar search: ``python planar_search.py [seed]``, about five minutes.

1. Modes and iterations of the descent: on random scenes, how many least energies lie above the best known, and how
   many stable equilibria are met at all. The best known is the wide search's, or whatever was lower.
2. `planar.ROOM`: scenes of small excess that have an exactly taut shape are not searched further. Here they are, with
   the wide search's starts, and lower ones are counted.
"""

import sys
import time

import numpy as np

from cablecad.rod import planar
from cablecad.rod.descent import ITERATIONS

COUNT = 1000


def say(line):
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


def scenes(count, rng, *, excess=None):
    d = rng.uniform(0.0, 0.999, count) if excess is None else 1.0 - excess
    toward, a, b = (rng.uniform(-np.pi, np.pi, count) for _ in range(3))
    return a, b, d[:, None] * np.stack([np.cos(toward), np.sin(toward)], axis=-1)


def least(found, count):
    energy = np.full(count, np.inf)
    stable = found.equilibria.stable_in_plane
    np.minimum.at(energy, found.equilibria.scene[stable], found.equilibria.energy[stable])
    return energy, np.count_nonzero(stable)


def descent(rng):
    a, b, end = scenes(COUNT, rng)
    best, _ = least(planar.solve_planar(a, b, end, search="wide"), COUNT)
    answers, descend, modes = [], planar.descend, planar.COARSE_MODES
    for planar.COARSE_MODES in (6, 8, 10, 12):
        for iterations in (8, 10, 12, 16):
            planar.descend = lambda space, z, excess, n=iterations: descend(space, z, excess, iterations=n)
            begun = time.perf_counter()
            energy, met = least(planar.solve_planar(a, b, end), COUNT)
            answers.append((planar.COARSE_MODES, iterations, met, time.perf_counter() - begun, energy))
            best = np.minimum(best, energy)
    planar.descend, planar.COARSE_MODES = descend, modes
    say(f"descent, {COUNT} scenes (now {modes} modes, {ITERATIONS} iterations)")
    for coarse, iterations, met, taken, energy in answers:
        above = np.count_nonzero(energy > best * (1.0 + 1e-9))
        say(f"  {coarse:2d} modes, {iterations:2d} iterations: {above} above, {met} stable met, {taken:.1f} s")


def room(rng):
    say(f"excess below ROOM = {planar.ROOM}, where an exactly taut shape exists: lower ones when searched on")
    limit = planar.ROOM
    for clamps in ({}, {"end_clamped": False}):
        for low, high in (
            (1e-6, 1e-4),
            (1e-4, 1e-3),
            (1e-3, 1e-2),
            (1e-2, 2e-2),
            (2e-2, 5e-2),
            (5e-2, 1e-1),
            (0.1, 0.3),
        ):
            excess = np.exp(rng.uniform(np.log(low), np.log(high), COUNT // 2))
            a, b, end = scenes(COUNT // 2, rng, excess=excess)
            planar.ROOM = 1.0  # nothing is searched
            taut, _ = least(planar.solve_planar(a, b, end, excess=excess, **clamps), COUNT // 2)
            is_taut = planar.solve_planar(a, b, end, excess=excess, **clamps).equilibria
            exact = np.zeros(COUNT // 2, dtype=bool)
            exact[is_taut.scene[is_taut.taut]] = True
            planar.ROOM = 0.0  # everything is
            full, _ = least(planar.solve_planar(a, b, end, excess=excess, search="wide", **clamps), COUNT // 2)
            lower = np.flatnonzero(exact & (full < taut * (1.0 - 1e-9)))
            said = f", by up to {np.max(1.0 - full[lower] / taut[lower]):.2g}" if len(lower) else ""
            say(f"  {clamps or 'clamps'} {low:g}..{high:g}: {len(lower)} of {np.count_nonzero(exact)} lower{said}")
    planar.ROOM = limit


if __name__ == "__main__":
    generator = np.random.default_rng(int(sys.argv[1]) if len(sys.argv) > 1 else 1)
    room(generator)
    descent(generator)
