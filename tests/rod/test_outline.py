"""What is found of many shapes together: the same as of each drawn alone."""

from __future__ import annotations

import math

import numpy as np
import pytest
from test_room import cables

from cablecad.model import Cable, Clamp, Pin
from cablecad.rod.outline import measure_outlines
from cablecad.rod.solution import RodSolution
from cablecad.rod.solve import solve_many

TOLD = {"residual", "rise", "end_angle_deg"}


def special() -> list[Cable]:
    """Circles, closed loops, a hair of slack, twins, other planes, lead-outs of both ends."""
    far = (-120.0, 40.0, 900.0)
    return [
        Cable("circle", 1.0, Clamp((0, 0, 0), (1, 0, 0)), Clamp((0, 20, 0), (-1, 0, 0)), length=10.0 * math.pi),
        Cable("loop", 1.0, Clamp(far, (1, 0, 0)), Clamp(far, (1, 0, 0)), length=100.0),
        Cable("drop", 1.0, Clamp(far, (0, 1, 0)), Pin(far), length=100.0),
        Cable("hair", 1.0, Clamp((0, 0, 0), (1, 0, 0)), Clamp((100, 0, 0), (1, 0, 0)), slack=1e-9),
        Cable("arch", 1.0, Clamp((0, 0, 0), (0, 0, 1), 7.0), Clamp((0, 60, 0), (0, 0, -1), 7.0), length=150.0),
        Cable("tilted", 1.0, Clamp((1, 2, 3), (1, 1, 1), 5.0), Clamp((41, 52, 23), (3, 6, -1)), length=150.0),
        Cable("steep", 1.0, Clamp((0, 0, 0), (-1, 0.2, 0), 3.0), Clamp((90, 0, 0), (0, 1, 0), 2.0), length=100.0),
    ]


def solved(bulged: list[Cable]) -> list[RodSolution]:
    return [one for one in solve_many(bulged) if isinstance(one, RodSolution)]


@pytest.mark.parametrize("seed", [3, 4, 5])
def test_outlines_are_those_of_each_alone(seed: int) -> None:
    together, alone = (solved([*cables(60, seed), *special()]) for _ in range(2))
    measure_outlines(together)
    measured = 0
    for one, other in zip(together, alone, strict=True):
        if not one.__dict__.keys() >= TOLD:
            continue
        measured += 1
        assert "shape" not in one.equilibrium.__dict__
        size = one.length
        assert one.rise == pytest.approx(other.rise, rel=1e-12, abs=1e-14 * size)
        assert abs(one.residual - other.residual) < 3e-13
        if other.end_angle_deg is None:
            assert one.end_angle_deg is None
        else:
            assert one.end_angle_deg == pytest.approx(other.end_angle_deg, rel=1e-12, abs=1e-12)
        assert one.bend_radius_min_at == pytest.approx(other.bend_radius_min_at, abs=1e-6 * size), one.cable.name
        assert one.equilibrium.greatest_curvature[0] == pytest.approx(
            other.equilibrium.greatest_curvature[0], rel=1e-11, abs=1e-14 / size
        )
        reach = size + np.abs(other.equilibrium.start.position).max()
        for got, want in zip(one.equilibrium.ends, other.equilibrium.ends, strict=True):
            assert np.abs(got.position - want.position).max() < 1e-14 * reach
            assert np.abs(got.direction - want.direction).max() < 1e-13
            scale = np.abs(want.force_per_EI).max()
            assert np.abs(got.force_per_EI - want.force_per_EI).max() <= 1e-12 * scale
            scale = max(np.abs(want.moment_per_EI).max(), scale * size)
            assert np.abs(got.moment_per_EI - want.moment_per_EI).max() <= 1e-12 * scale
    assert measured > 30


def test_mirrored_ends_bend_most_at_the_first() -> None:
    """Two crests alike but for rounding: which one is told of must not hang on it."""
    arches = [
        Cable(f"W{i}", 1.0, Clamp((0, 0, 0), (0, 0, 1)), Clamp((0, 60 + i, 0), (0, 0, -1)), length=100.0)
        for i in range(20)
    ]
    together, alone = solved(arches), solved(arches)
    measure_outlines(together)
    for one, other in zip(together, alone, strict=True):
        assert one.bend_radius_min_at is not None
        assert one.bend_radius_min_at <= one.length / 2.0 * (1.0 + 1e-9)
        assert one.bend_radius_min_at == pytest.approx(other.bend_radius_min_at, abs=1e-6)


@pytest.mark.parametrize("off", [0.0, 1e-7, 3e-6, 1e-5, 1e-4, 1e-3])
def test_of_two_tops_nearly_alike_the_higher_counts(off: float) -> None:
    """An S whose halves differ by less than samples tell; the oracle looks from so near that it need not refine."""
    shapes = []
    for i in range(8):
        first, last = (math.radians(40.0 + 7.0 * i + more) for more in (0.0, off))
        start = Clamp((0, 0, 0), (math.cos(first), math.sin(first), 0))
        end = Clamp((75, 0, 0), (math.cos(last), math.sin(last), 0))
        shapes.append(Cable(f"W{i}", 1.0, start, end, length=100.0))
    together, alone = solved(shapes), solved(shapes)
    measure_outlines(together)
    assert len(together) == len(shapes)
    for one, other in zip(together, alone, strict=True):
        height = np.abs(other.centreline.points(400_001)[:, 1])
        missed = other.centreline.greatest_curvature()[0] * (100.0 / 400_000) ** 2 / 8.0
        for rise in (one.rise, other.rise):
            assert height.max() - 1e-13 <= rise <= height.max() + missed + 1e-13


def test_few_and_drawn_ones_are_left_to_themselves() -> None:
    few = solved(cables(3, 9))[:2]
    measure_outlines(few)
    assert not any("rise" in one.__dict__ for one in few)
    drawn = solved(cables(20, 9))
    for one in drawn:
        _ = one.centreline
    measure_outlines(drawn)
    assert not any("rise" in one.__dict__ for one in drawn)
