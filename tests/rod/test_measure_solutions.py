"""`solve_many` gives its answers with all that is told of them at hand, the same as each finds when asked alone."""

from __future__ import annotations

import pytest
from test_room import cables

from cablecad.errors import CablecadError
from cablecad.pipeline import solve_many
from cablecad.rod.solution import RodSolution
from cablecad.rod.stability import Stability


def solved(**how: bool) -> list[RodSolution]:
    return [one for one in solve_many(cables(30, 6), **how) if isinstance(one, RodSolution)]


def test_what_is_told_is_at_hand_and_the_same() -> None:
    measured, asked = solved(), solved(measured=False)
    assert len(measured) == len(asked) > 25
    told = 0
    for one, other in zip(measured, asked, strict=True):
        assert not {"residual", "rise", "end_angle_deg"} & other.__dict__.keys()
        assert not any("self_gap" in found.__dict__ for found in other.equilibria)
        for found in one.equilibria:
            assert found.trace is not None
            if not found.trace.is_taut:
                assert "self_gap" in found.__dict__
                assert isinstance(found.__dict__["stability"], Stability)
        if {"residual", "rise", "end_angle_deg"} <= one.__dict__.keys():
            told += 1
        assert abs(one.residual - other.residual) < 3e-13
        assert one.rise == pytest.approx(other.rise, rel=1e-12, abs=1e-12)
        assert one.stability.stable_out_of_plane == other.stability.stable_out_of_plane
        assert (one.self_gap is None) == (other.self_gap is None)
    assert told > 20


def test_failures_and_closed_forms_among_them() -> None:
    some = cables(6, 6)
    some.insert(2, type(some[0])("short", 1.0, some[0].start, some[1].end, length=1e-3))
    results = solve_many(some)
    assert [isinstance(one, CablecadError) for one in results].count(True) >= 1
    assert isinstance(results[2], CablecadError)
