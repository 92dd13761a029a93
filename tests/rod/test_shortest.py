"""Length as the question: the least length that keeps a bend radius, and keeps it for another 5 %."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cablecad.errors import InfeasibleError
from cablecad.model import Cable, Clamp, Pin, Port
from cablecad.rod.solve import solve_rod

ENDS = {
    "U": (Port((0, 0, 0), (0, 0, 1)), Port((0, 120, 0), (0, 0, 1))),
    "lead-out": (Port((0, 0, 0), (0, 0, 1), straight=10.0), Port((50, 20, 0), (0, 0, 1))),
    "clamp-pin": (Clamp((0, 0, 0), (0, 0, 1)), Pin((0, 120, 0))),
    "coaxial": (Clamp((0, 0, 0), (0, 1, 0)), Clamp((0, 120, 0), (0, 1, 0))),
    "pinned": (Pin((0, 0, 0)), Pin((0, 120, 0))),
}


@pytest.mark.parametrize("rule", [20.0, 80.0])
@pytest.mark.parametrize("name", ENDS)
def test_keeps_the_rule_and_is_the_least(name: str, rule: float) -> None:
    cable = Cable("c", 1.0, *ENDS[name], length="shortest", min_bend_radius=rule, bulge=(1.0, 0.1, 0.2))
    solution = solve_rod(cable)
    found = solution.length
    radius = lambda length: solve_rod(replace(cable, length=float(length))).bend_radius_min
    assert not any(violation.rule == "min_bend_radius" for violation in solution.violations)
    for length in np.linspace(found, 1.05 * found, 6)[1:]:
        assert radius(length) >= rule * (1 - 1e-12)
    if solution.model == "straight":
        assert found == pytest.approx(solution.chord, rel=1e-15)
    else:
        assert radius(found) >= rule
        assert radius(found * (1 - 1e-9)) < rule
        # No shorter length keeps it for 5 %.
        least = solution.chord + 1e-6
        for length in np.linspace(least, found, 9)[:-1]:
            try:
                assert min(radius(x) for x in (length, 1.03 * length, 1.05 * length)) < rule
            except InfeasibleError:
                continue
    assert "is the shortest that keeps min_bend_radius" in solution.reason


def test_the_report_names_the_range_and_the_next() -> None:
    start, end = ENDS["pinned"]
    solution = solve_rod(Cable("c", 1.0, start, end, length="shortest", min_bend_radius=80.0))
    assert "kept up to" in solution.reason
    assert "again from" in solution.reason


def test_a_wide_rule_takes_a_long_cable() -> None:
    """Opposed clamps a millimetre apart: a loop, whose bend radius grows with its length."""
    ends = Clamp((0, 0, 0), (1, 0, 0)), Clamp((0, 1, 0), (-1, 0, 0))
    short, long = (
        solve_rod(Cable("c", 1e-3, *ends, length="shortest", min_bend_radius=rule)).length for rule in (1e3, 1e6)
    )
    assert long == pytest.approx(1000 * short, rel=2e-3)


@pytest.mark.parametrize(
    ("ends", "length"),
    [
        ((Clamp((5, 5, 5), (1, 0, 0)), Clamp((5, 5, 5), (-1, 0, 0))), None),
        ((Clamp((5, 5, 5), (1, 0, 0)), Clamp((5, 5, 5), (0, 1, 0))), None),
        ((Clamp((5, 5, 5), (1, 0, 0)), Pin((5, 5, 5))), None),
        ((Pin((5, 5, 5)), Pin((5, 5, 5))), 84.38488),
        ((Clamp((5, 5, 5), (1, 0, 0)), Clamp((5, 5, 5), (1, 0, 0))), 20.0 * np.pi),
    ],
)
def test_ends_at_one_point(ends: tuple[Clamp | Pin, Clamp | Pin], length: float | None) -> None:
    cable = Cable("c", 1.0, *ends, length="shortest", min_bend_radius=10.0, allow_contact=True)
    solution = solve_rod(cable)
    if length is not None:
        assert solution.length == pytest.approx(length, rel=1e-6)
    radius = solution.bend_radius_min
    assert radius is not None
    assert 10.0 <= radius < 10.0 * (1.0 + 1e-6)
    assert solve_rod(replace(cable, length=solution.length * 0.999)).bend_radius_min < 10.0


def test_another_equilibrium_is_not_the_line() -> None:
    pins = Pin((0, 0, 0)), Pin((0, 120, 0))
    solution = solve_rod(Cable("c", 1.0, *pins, length="shortest", min_bend_radius=20.0, equilibrium=1))
    assert solution.model == "planar"
    assert solution.index == 1


def test_axes_of_any_length() -> None:
    tiny, plain = (
        Cable(
            "c",
            1.0,
            Clamp((0, 0, 0), (0, 0, size), straight=10.0),
            Clamp((50, 20, 0), (0, 0, -size)),
            length="shortest",
            min_bend_radius=20.0,
        )
        for size in (1e-170, 1.0)
    )
    assert solve_rod(tiny).length == solve_rod(plain).length
