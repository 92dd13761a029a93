"""The certificate of a solid: what it measures is right, and what is wrong with a solid shows in it."""

from __future__ import annotations

import math
import os
import signal
import warnings

import pytest
from curves import Helix, arch, chain
from OCP.BRep import BRep_Builder
from OCP.BRepBuilderAPI import BRepBuilderAPI_Transform
from OCP.BRepPrimAPI import BRepPrimAPI_MakeCylinder, BRepPrimAPI_MakeTorus
from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt, gp_Trsf, gp_Vec
from OCP.TopAbs import TopAbs_ShapeEnum
from OCP.TopoDS import TopoDS_Shape, TopoDS_Shell, TopoDS_Solid

from cablecad.brep.check import ONE_THREAD, all_valid, check_solid
from cablecad.brep.fit import fit_centreline
from cablecad.brep.kernel import subshapes
from cablecad.brep.tube import build_tube
from cablecad.centreline import Centreline
from cablecad.errors import GeometryError

CURVES = {
    "k=.342": arch(0.342, 350.0),
    "k=.8": arch(0.8, 350.0),
    "k=.999": arch(0.999, 350.0),
    "S": arch(0.6, 350.0, mode=2),
    "line-arc-line": chain((20.0, 0.0), (30.0, 1 / 15.0), (10.0, 0.0)),
    "helix": Centreline([Helix.of_turns(30.0, 100.0, 3.0)]),
}


def solid_of(curve: Centreline, radius: float, tolerance: float) -> TopoDS_Solid:
    return build_tube(fit_centreline(curve, radius, tolerance=tolerance), radius)


def test_cylinder_of_open_cascade() -> None:
    """A solid that is none of ours: the closed form to rounding."""
    check = check_solid(BRepPrimAPI_MakeCylinder(3.0, 40.0).Solid(), radius=3.0, length=40.0)
    assert check.valid
    assert check.faces == 3
    assert check.volume == pytest.approx(math.pi * 9.0 * 40.0, rel=1e-13)
    assert check.area == pytest.approx(2.0 * math.pi * 3.0 * 43.0, rel=1e-13)
    assert abs(check.volume_error) < 1e-13
    assert abs(check.area_error) < 1e-13


def test_torus_obeys_pappus() -> None:
    """Volume pi r^2 L and side 2 pi r L for any curve; a ring has no caps, and is short of them by 2 pi r^2."""
    radius, bend = 3.0, 20.0
    length = 2.0 * math.pi * bend
    check = check_solid(BRepPrimAPI_MakeTorus(bend, radius).Solid(), radius=radius, length=length)
    assert abs(check.volume_error) < 1e-9
    assert check.area_error == pytest.approx(-radius / (length + radius), rel=1e-6)


@pytest.mark.parametrize(("radius", "length"), [(3.0 * 1.001, 40.0), (3.0, 40.0 * 1.001), (2.9, 40.0), (3.0, 41.0)])
def test_errors_are_relative_to_what_was_asked(radius: float, length: float) -> None:
    check = check_solid(BRepPrimAPI_MakeCylinder(3.0, 40.0).Solid(), radius=radius, length=length)
    assert check.volume_error == pytest.approx(9.0 * 40.0 / (radius**2 * length) - 1.0, rel=1e-9)
    assert check.area_error == pytest.approx(3.0 * 43.0 / (radius * (length + radius)) - 1.0, rel=1e-9)


@pytest.mark.parametrize("tolerance", [1e-1, 1e-2, 1e-3, 1e-5, 1e-7, 1e-9])
@pytest.mark.parametrize("name", CURVES)
def test_volume_and_area_follow_the_tolerance(name: str, tolerance: float) -> None:
    """A side off by e at most is off by 2 e / r in volume; and Open Cascade integrates to 1e-6 of it."""
    curve, radius = CURVES[name], 2.0
    check = check_solid(solid_of(curve, radius, tolerance), radius=radius, length=curve.length)
    assert check.valid
    assert abs(check.volume_error) <= 1e-6 + 2.0 * tolerance / radius
    # Of the area the waviness of a side takes part too: its slope is about e over a span, which is 2 r or more here.
    assert abs(check.area_error) <= 1e-6 + 4.0 * tolerance / radius


@pytest.mark.parametrize("name", CURVES)
def test_measures_do_not_depend_on_the_place(name: str) -> None:
    """A kilometre from the origin, where moments about the origin would have lost their digits."""
    curve = CURVES[name]
    solid = solid_of(curve, 2.0, 1e-4)
    move = gp_Trsf()
    move.SetTranslation(gp_Vec(1e6, -1e6, 1e6))
    here = check_solid(solid, radius=2.0, length=curve.length)
    there = check_solid(BRepBuilderAPI_Transform(solid, move, True).Shape(), radius=2.0, length=curve.length)
    assert there.valid
    assert there.volume == pytest.approx(here.volume, rel=1e-6)
    assert there.area == pytest.approx(here.area, rel=1e-6)
    assert there.faces == here.faces


@pytest.mark.parametrize("scale", [1e-4, 1e4])
def test_measures_do_not_depend_on_the_size(scale: float) -> None:
    base = check_solid(solid_of(arch(0.8, 350.0), 2.0, 1e-3), radius=2.0, length=350.0)
    curve = arch(0.8, 350.0 * scale)
    check = check_solid(solid_of(curve, 2.0 * scale, 1e-3 * scale), radius=2.0 * scale, length=curve.length)
    assert check.valid
    assert check.volume == pytest.approx(base.volume * scale**3, rel=1e-6)
    assert check.area == pytest.approx(base.area * scale**2, rel=1e-6)


# --- solids that are wrong --------------------------------------------------------------------------------------------


def open_solid() -> TopoDS_Solid:
    """A tube without one of its caps."""
    builder, shell, solid = BRep_Builder(), TopoDS_Shell(), TopoDS_Solid()
    builder.MakeShell(shell)
    for face in subshapes(solid_of(CURVES["k=.8"], 2.0, 1e-3), TopAbs_ShapeEnum.TopAbs_FACE)[:-1]:
        builder.Add(shell, face)
    builder.MakeSolid(solid)
    builder.Add(solid, shell)
    return solid


def test_open_solid_is_not_valid() -> None:
    check = check_solid(open_solid(), radius=2.0, length=350.0)
    assert not check.valid
    assert check.faces == 2


@pytest.mark.parametrize("threads", ["one", "all"])
def test_one_of_many_that_is_not_valid_is_found(threads: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(ONE_THREAD, "1" if threads == "one" else "")
    solids: list[TopoDS_Shape] = [solid_of(CURVES[name], 2.0, 1e-3) for name in CURVES]
    assert all_valid(solids)
    assert all_valid(solids[:1])
    for place in (0, 3, len(solids)):
        assert not all_valid([*solids[:place], open_solid(), *solids[place:]])
        assert not all_valid([*solids[:place], TopoDS_Shape(), *solids[place:]])  # Open Cascade fails


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system does not fork")
def test_a_forked_process_checks_too() -> None:
    """It has none of the threads its parent has started."""
    solids = [solid_of(CURVES[name], 2.0, 1e-3) for name in CURVES]
    assert all_valid(solids)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # forks beside threads: that is what is tried
        child = os.fork()
    if not child:
        signal.alarm(20)
        try:
            os._exit(0 if all_valid(solids) else 1)
        finally:
            os._exit(2)
    assert os.waitpid(child, 0)[1] == 0


def test_solid_inside_out_has_negative_volume() -> None:
    """BRepCheck calls it valid: the volume tells."""
    check = check_solid(solid_of(CURVES["k=.8"], 2.0, 1e-3).Reversed(), radius=2.0, length=350.0)
    assert check.volume_error == pytest.approx(-2.0, abs=1e-5)


def test_missing_stretch_shows_in_the_volume() -> None:
    """What Open Cascade's sweeps do at an inflection and call valid: two per cent gone."""
    check = check_solid(solid_of(arch(0.6, 343.0, mode=2), 2.0, 1e-3), radius=2.0, length=350.0)
    assert check.valid
    assert check.volume_error == pytest.approx(-0.02, abs=1e-5)


def test_self_crossing_tube_does_not_show() -> None:
    """Why the self-gap is judged on the centreline: by Pappus nothing is missing where a tube crosses itself."""
    check = check_solid(solid_of(arch(0.95, 350.0), 2.0, 1e-3), radius=2.0, length=350.0)
    assert check.valid
    assert abs(check.volume_error) < 1e-5


def test_nothing_cannot_be_measured() -> None:
    with pytest.raises(GeometryError, match="Open Cascade failed while measuring the solid"):
        check_solid(TopoDS_Shape(), radius=2.0, length=350.0)


def test_two_cylinders_count_all_faces() -> None:
    """Faces are counted once each, wherever they are in the shape."""
    axis = gp_Ax2(gp_Pnt(100.0, 0.0, 0.0), gp_Dir(0.0, 0.0, 1.0))
    builder, shell, solid = BRep_Builder(), TopoDS_Shell(), TopoDS_Solid()
    builder.MakeShell(shell)
    for one in (BRepPrimAPI_MakeCylinder(1.0, 5.0).Solid(), BRepPrimAPI_MakeCylinder(axis, 1.0, 5.0).Solid()):
        for face in subshapes(one, TopAbs_ShapeEnum.TopAbs_FACE):
            builder.Add(shell, face)
    builder.MakeSolid(solid)
    builder.Add(solid, shell)
    assert check_solid(solid, radius=1.0, length=10.0).faces == 6
