"""Solids made together are those of each built alone, and what one cable lacks costs no other its own."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from OCP.BRep import BRep_Builder
from OCP.TopAbs import TopAbs_ShapeEnum
from OCP.TopoDS import TopoDS_Shell, TopoDS_Solid

from cablecad.bench.whole import loom
from cablecad.brep.check import volume_of
from cablecad.brep.kernel import subshapes
from cablecad.errors import CablecadError, GeometryError, InvalidTubeError, SceneError
from cablecad.model import Cable, Clamp, Pin, Port
from cablecad.pipeline import build, solve, solve_many
from cablecad.pipeline import solid as solid_module
from cablecad.pipeline.solid import make_solids
from cablecad.report import CableOutcome

UP = (0.0, 0.0, 1.0)


def outcomes(cables: list[Cable]) -> list[CableOutcome]:
    solved = solve_many(cables, measured=False)
    assert not any(isinstance(one, CablecadError) for one in solved)
    return [CableOutcome(cable, solution) for cable, solution in zip(cables, solved, strict=True)]  # type: ignore[arg-type]


def assorted() -> list[Cable]:
    """Arches with and without lead-outs, straight, pinned, taut, thick and thin."""
    return [
        *loom(5).cables,
        Cable("lead-outs", 3.0, Port((0, 0, 0), UP, 12.0), Port((90, 0, 0), UP, 8.0), length=260.0),
        Cable("straight", 2.0, Port((0, 0, 0), (1, 0, 0)), Port((100, 0, 0), (-1, 0, 0)), length=100.0),
        Cable("pinned", 2.0, Pin((0, 0, 0)), Pin((80, 0, 0)), length=100.0),
        Cable("taut", 0.5, Port((0, 0, 0), UP), Port((100, 0, 0), UP), length=100.5),
        *loom(3).cables,
    ]


def test_made_together_and_alone() -> None:
    cables = assorted()
    some = outcomes(cables)
    for cable, outcome, solid in zip(cables, some, make_solids(some, 1e-3), strict=True):
        assert not isinstance(solid, CablecadError)
        alone = build(cable, tolerance=1e-3)
        assert outcome.fit is not None
        assert alone.outcome.fit is not None
        assert outcome.fit.spans == alone.outcome.fit.spans
        assert outcome.fit.deviation <= 1e-3
        assert outcome.check is not None
        assert outcome.check.valid
        assert volume_of(solid) == pytest.approx(volume_of(alone.solid.wrapped), rel=1e-9)
        assert outcome.check.volume == pytest.approx(volume_of(solid), rel=1e-6)
        assert outcome.seconds["tube"] > 0.0
        s = np.linspace(0.0, outcome.fit.length, 7)
        assert np.abs(outcome.fit.frames(s).position - alone.outcome.fit.frames(s).position).max() < 1e-9


def test_each_failure_is_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    cables = assorted()
    cables.insert(1, Cable("thick", 260.0, Port((0, 0, 0), UP), Port((120, 0, 0), UP), length=300.0))
    cables.insert(3, Cable("hair", 1e-6, Port((0, 0, 0), UP), Port((120, 0, 0), UP), length=300.0))
    cables.insert(6, Cable("spoilt", 4.0, Port((0, 0, 0), UP), Port((121, 0, 0), UP), length=300.0))
    some = outcomes(cables)
    make_solid = solid_module.make_solid

    def fails(outcome: CableOutcome, *prepared: Any) -> object:
        if outcome is some[6]:
            raise GeometryError("Open Cascade failed")
        return make_solid(outcome, *prepared)

    monkeypatch.setattr(solid_module, "make_solid", fails)
    kinds = [type(one) if isinstance(one, CablecadError) else None for one in make_solids(some, 1e-3)]
    wanted: list[type | None] = [None] * len(cables)
    wanted[1], wanted[3], wanted[6] = InvalidTubeError, SceneError, GeometryError
    assert kinds == wanted
    assert some[6].fit is None


def test_a_solid_that_is_not_valid_costs_no_other_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    some = outcomes(assorted())
    make_solid = solid_module.make_solid

    def opened(outcome: CableOutcome, *prepared: Any) -> TopoDS_Solid:
        solid = make_solid(outcome, *prepared)
        if outcome is not some[2]:
            return solid
        builder, shell, broken = BRep_Builder(), TopoDS_Shell(), TopoDS_Solid()
        builder.MakeShell(shell)
        builder.Add(shell, subshapes(solid, TopAbs_ShapeEnum.TopAbs_FACE)[0])
        builder.MakeSolid(broken)
        builder.Add(broken, shell)
        return broken

    monkeypatch.setattr(solid_module, "make_solid", opened)
    made = list(make_solids(some, 1e-3))
    assert [i for i, one in enumerate(made) if isinstance(one, CablecadError)] == [2]
    assert isinstance(made[2], GeometryError)
    assert "BRepCheck not valid" in str(made[2])
    assert [outcome.check is not None and outcome.check.valid for outcome in some] == [i != 2 for i in range(len(some))]
    assert all(outcome.seconds["check"] > 0.0 for outcome in some)


def bent(tolerance: float, margin: float) -> None:
    """Build a cable whose radius is its least bend radius but for a margin."""
    start = Clamp((0, 0, 0), (math.cos(-0.18), math.sin(-0.18), 0))
    end = Clamp((61, 0, 0), (math.cos(0.21), math.sin(0.21), 0))
    cable = Cable("W", 1.0, start, end, length=500.0, allow_contact=True)
    radius = solve(cable).bend_radius_min
    assert radius is not None
    build(replace(cable, diameter=2.0 * radius * (1.0 - margin)), tolerance=tolerance)


def test_a_side_that_would_fold_is_refused() -> None:
    """The exact tube just does not, and neither does its centreline's fit; a finer fit shows it."""
    with pytest.raises(InvalidTubeError, match=r"side would fold at s = 25.*ask for a smaller tolerance"):
        bent(0.1, 1e-7)
    bent(1e-6, 1e-4)
    bent(0.1, 0.02)


def test_a_sweep_is_measured_itself() -> None:
    some = outcomes(list(loom(3).cables))
    for outcome, solid in zip(some, make_solids(some, 1e-3, "pipe_shell"), strict=True):
        assert not isinstance(solid, CablecadError)
        assert outcome.check is not None
        assert outcome.check.volume == pytest.approx(volume_of(solid), rel=1e-6)


def test_the_curves_are_those_of_the_solutions() -> None:
    (outcome,) = outcomes([loom(1).cables[0]])
    (solid,) = make_solids([outcome], 1e-3)
    assert not isinstance(solid, CablecadError)
    curve = solve(loom(1).cables[0]).centreline
    s = np.linspace(0.0, curve.length, 50)
    assert outcome.fit is not None
    assert np.abs(outcome.fit.frames(s).position - curve.position(s)).max() < 1e-3
