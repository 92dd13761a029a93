"""Any scene in range is solved to its residual or refused with a reason; none crashes or hangs."""

from __future__ import annotations

import math
import time

import numpy as np
import pytest

from cablecad.errors import CablecadError
from cablecad.model import Cable, Clamp, Pin
from cablecad.rod.solve import solve_many, solve_rod

RESIDUAL = 1e-12


def random_cable(rng: np.random.Generator) -> Cable:
    """Ends of all kinds: coincident, parallel, backward, aligned, far away, out of plane, too far apart."""
    scale = 10.0 ** rng.uniform(-6, 6)
    length = scale * 10.0 ** rng.uniform(-0.5, 0.5)
    origin = scale * rng.normal(size=3) * rng.choice([0.0, 1.0, 10.0])
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    kind = rng.integers(8)
    ratio = rng.choice([rng.uniform(0, 1), 0.0, 1.0 - 10.0 ** rng.uniform(-10, -2), 1.0, rng.uniform(1.0, 1.1)])
    directions = [0.0, math.pi, math.pi / 2, -math.pi / 2]
    a, b = (rng.choice([rng.uniform(-math.pi, math.pi), *directions]) for _ in range(2))
    tilt = rng.choice([0.0, 0.0, 0.0, 1e-7, 1e-3])

    def clamp(position, angle, tilted) -> Clamp:
        direction = turn @ [math.cos(angle), math.sin(angle), tilted]
        return Clamp(tuple(position), tuple(direction), straight=float(rng.choice([0.0, 0.0, 0.1])) * length)

    end = origin + turn @ [ratio * length, 0.0, 0.0]
    start_support = Pin(tuple(origin)) if kind == 0 else clamp(origin, a, 0.0)
    end_support = Pin(tuple(end)) if kind in (0, 1) else clamp(end, b, tilt)
    return Cable("c", length * 1e-3, start_support, end_support, length=length)


def judge(cable: Cable, result) -> str:
    """What became of a cable; an assertion where it is not what the contract allows."""
    if isinstance(result, CablecadError):
        assert result.exit_code in (2, 3), (cable, result)
        assert len(str(result)) > 20
        return type(result).__name__
    assert result.residual <= RESIDUAL * 1.0001, (cable, result.residual)
    assert np.isfinite(result.points(9)).all()
    assert result.bend_radius_min is None or result.bend_radius_min > 0
    return "solved"


def run(count: int, seed: int) -> dict[str, int]:
    rng = np.random.default_rng(seed)
    counts: dict[str, int] = {}
    for _ in range(count // 50):
        cables = [random_cable(rng) for _ in range(50)]
        for cable, result in zip(cables, solve_many(cables), strict=True):
            verdict = judge(cable, result)
            counts[verdict] = counts.get(verdict, 0) + 1
    return counts


def test_two_thousand() -> None:
    counts = run(2000, seed=1)
    assert counts["solved"] > 800
    assert counts["InfeasibleError"] > 100
    assert counts["NotPlanarError"] > 50
    assert counts.get("SolveError", 0) <= 2, counts


@pytest.mark.slow
def test_twenty_thousand_one_by_one() -> None:
    """One by one, each within two seconds."""
    rng = np.random.default_rng(2)
    unsolved = 0
    for _ in range(20000):
        cable = random_cable(rng)
        begun = time.perf_counter()
        try:
            result = solve_rod(cable)
        except CablecadError as error:
            result = error
        assert time.perf_counter() - begun < 2.0, cable
        unsolved += judge(cable, result) == "SolveError"
    assert unsolved <= 20


def test_many_equals_one_by_one() -> None:
    rng = np.random.default_rng(3)
    cables = [random_cable(rng) for _ in range(120)]
    for cable, together in zip(cables, solve_many(cables), strict=True):
        if isinstance(together, CablecadError):
            with pytest.raises(type(together)) as caught:
                solve_rod(cable)
            assert str(caught.value) == str(together)
            continue
        alone = solve_rod(cable)
        assert together.equilibrium.energy_per_EI == pytest.approx(alone.equilibrium.energy_per_EI, rel=1e-9, abs=1e-15)
        np.testing.assert_allclose(together.points(11), alone.points(11), atol=1e-7 * cable.length)
