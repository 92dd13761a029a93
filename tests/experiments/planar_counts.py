"""What chose the counts of the planar solver: ``python planar_counts.py [seed]``, about four minutes.

1. Modes of the final Newton's method, `equilibria._MODES` and `SHARP_MODES`: too few, and the polish from there does
   not end below the residual (an equilibrium is lost); too many cost time.
2. Those of the sketch that goes before, `equilibria._SKETCH_MODES`: too few, and much is done over again.
3. Starts: how many of the bends are needed for no least energy to lie above the best known.
4. `CHUNK`: scenes that go through together; time of a scene, and the greatest memory numpy held.

Each line prints what was tried, then what it lost or took; the product's own choice is marked with *.
"""

import sys
import time
import tracemalloc

import numpy as np

from cablecad.bench.scenes import random_scenes
from cablecad.bench.search import search_45
from cablecad.rod import equilibria, planar, starts

COUNT = 500


def say(line):
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


def solve(scenes, **how):
    begun = time.perf_counter()
    found = planar.solve_planar(scenes.a, scenes.b, scenes.end, **how)
    taken = (time.perf_counter() - begun) / len(scenes.a) * 1e3
    energy = np.full(len(scenes.a), np.inf)
    stable = found.equilibria.stable_in_plane
    np.minimum.at(energy, found.equilibria.scene[stable], found.equilibria.energy[stable])
    return energy, int(np.count_nonzero(stable)), taken


def give(name, value):
    """Another value for a constant, in every module that has taken it over."""
    for module in [module for key, module in sys.modules.items() if key.startswith("cablecad.rod.")]:
        if name in vars(module):
            setattr(module, name, value)


def mark(chosen):
    return "*" if chosen else " "


def modes(scenes, best):
    say(f"modes of the final method, {COUNT} scenes: unsolved, above the best known, stable met, ms a scene")
    by_omega, sharp = equilibria._MODES, equilibria.SHARP_MODES
    tables = (
        *[(((7.0, count),), 44) for count in (12, 16, 20, 24, 32)],
        *[(((7.0, 24),), count) for count in (28, 36, 52, 60)],
        *[(((7.0, 24), (11.0, count)), 44) for count in (24, 28, 32, 36)],
        (((5.0, 16), (7.0, 24), (11.0, 32)), 44),
        (((7.0, 24), (8.0, 28), (11.0, 32)), 44),
        (((7.0, 24), (14.0, 32)), 44),
    )
    for table in tables:
        give("_MODES", table[0])
        give("SHARP_MODES", table[1])
        energy, met, taken = min((solve(scenes) for _ in range(3)), key=lambda one: one[2])
        above = np.count_nonzero(energy > best * (1.0 + 1e-9))
        lost = np.count_nonzero(~np.isfinite(energy))
        named = ", ".join(f"{count} to {omega:g}" for omega, count in table[0])
        say(f" {mark(table == (by_omega, sharp))} {named}, then {table[1]}: {lost}, {above}, {met}, {taken:.2f}")
    give("_MODES", by_omega)
    give("SHARP_MODES", sharp)


def sketches(scenes, best):
    say("modes of the sketch: unsolved, above the best known, stable met, ms a scene")
    chosen = equilibria._SKETCH_MODES
    for table in (
        equilibria._MODES,
        *[((7.0, count), (11.0, count + 2)) for count in (8, 10, 12, 14, 16, 18)],
        ((7.0, 14), (11.0, 16), (14.0, 20)),
        ((7.0, 14), (11.0, 16), (18.0, 25)),
        ((7.0, 14), (11.0, 18), (14.0, 22), (20.0, 28)),
    ):
        give("_SKETCH_MODES", table)
        energy, met, taken = min((solve(scenes) for _ in range(3)), key=lambda one: one[2])
        above, lost = np.count_nonzero(energy > best * (1.0 + 1e-9)), np.count_nonzero(~np.isfinite(energy))
        named = ", ".join(f"{count} to {omega:g}" for omega, count in table)
        say(f" {mark(table == chosen)} {named}: {lost}, {above}, {met}, {taken:.2f}")
    give("_SKETCH_MODES", chosen)


def bends(scenes, best):
    say("starts: bends a winding: above the best known, stable met, ms a scene")
    chosen = starts._BENDS
    for some in (chosen[:1], chosen[:3], chosen[1:3], chosen[3:], chosen, starts._MORE_BENDS):
        starts._BENDS = some
        energy, met, taken = solve(scenes)
        above = np.count_nonzero(energy > best * (1.0 + 1e-9))
        say(f" {mark(some is chosen)} {len(some)} from {some[0]}: {above}, {met}, {taken:.2f}")
    starts._BENDS = chosen


def chunks(scenes):
    say("scenes together: ms a scene, MB")
    chosen = planar.CHUNK
    for size in (1, 8, 32, 128, 256, 512, 1024, 2048):
        planar.CHUNK = size
        some = scenes.take(slice(0, max(40, min(size, len(scenes.a)))))
        taken = min(solve(some)[2] for _ in range(2))
        tracemalloc.start()
        solve(some)
        held = tracemalloc.get_traced_memory()[1] / 1e6
        tracemalloc.stop()
        say(f" {mark(size == chosen)} {size}: {taken:.2f}, {held:.0f}")
    planar.CHUNK = chosen


if __name__ == "__main__":
    seed = int(sys.argv[1]) if len(sys.argv) > 1 else 1
    some = random_scenes(COUNT, seed)
    solve(some.take(slice(0, 2)))  # trial functions are made once in a process
    least = np.fmin(solve(some, search="wide")[0], search_45(some))
    modes(some, least)
    sketches(some, least)
    bends(some, least)
    chunks(random_scenes(2048, seed + 1))
