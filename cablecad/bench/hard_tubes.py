"""Hard cases of the tube, beside Open Cascade's sweeps, which run in a process they may kill."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge, BRepBuilderAPI_MakeWire
from OCP.BRepOffsetAPI import BRepOffsetAPI_MakePipeShell
from OCP.gp import gp_Ax2, gp_Circ, gp_Dir, gp_Pnt
from OCP.TopoDS import TopoDS, TopoDS_Shape

from cablecad.bench.hard_row import HardRow, shortened
from cablecad.bench.sandbox import SandboxError, in_sandbox
from cablecad.bench.sweeps import fitted_spine, interpolated_spine, sweep_pipe, sweep_pipe_shell
from cablecad.brep.check import check_solid
from cablecad.brep.fit import fit_centreline
from cablecad.brep.spline import FittedCentreline
from cablecad.centreline import Centreline
from cablecad.errors import CablecadError, GeometryError, InvalidTubeError, SceneError
from cablecad.model import Cable, Clamp, Pin, Port, Toward
from cablecad.pipeline import build, solve

VOLUME_ERROR = 1e-4
"""Relative error of a volume that counts as right: pi r^2 L, of any tube that does not cut into itself."""


@dataclass(frozen=True)
class TubeCase:
    """One case.

    Attributes:
        name: What is hard about it.
        regime: In a word.
        cable: What is built.
        tolerance: To what [mm].
        refusal: The error expected instead of a solid.
        sweep: "shell" (corrected Frenet, 1e-6 of the length), "frenet" (plain), or "pipe" (through 64 points).
    """

    name: str
    regime: str
    cable: Cable
    tolerance: float = 1e-3
    refusal: type[CablecadError] | None = None
    sweep: str = "shell"


def _half_circle(diameter: float, scale: float = 1.0) -> Cable:
    """A U-turn that is half a circle of radius 10 mm, without force: its curvature is the same everywhere."""
    start, end = ((x, 0.0, 0.0) for x in (0.0, 20.0 * scale))
    up = (0.0, 0.0, 1.0)
    return Cable("U", diameter, Port(start, up), Port(end, up), length=math.pi * 10.0 * scale)


def _offset(diameter: float) -> Cable:
    """An S: its curvature changes sign in the middle."""
    ahead = (1.0, 0.0, 0.0)
    end = Clamp((60.0, 30.0, 0.0), ahead)
    return Cable("S", diameter, Clamp((0.0, 0.0, 0.0), ahead), end, length=100.0, bulge=(1e-3, 1.0, 0.0))


def _crossed(diameter: float) -> Cable:
    """The paper's cable beyond the figure eight: it runs through itself."""
    return Cable("X", diameter, Pin((0.0, 0.0, 0.0)), Toward((1.0, 0.0, 0.0)), length=350.0, angle_deg=150.0)


CASES = (
    TubeCase("kappa r = 0.999", "kappa r below 1", _half_circle(2.0 * 9.99)),
    TubeCase("kappa r = 1.001", "kappa r above 1", _half_circle(2.0 * 10.01), refusal=InvalidTubeError),
    TubeCase("a loop that runs through itself", "self-touching", _crossed(4.0), refusal=InvalidTubeError),
    TubeCase("an inflection", "kappa through 0", _offset(4.0)),
    TubeCase("an inflection, swept by plain Frenet frames", "kappa through 0", _offset(4.0), sweep="frenet"),
    TubeCase("1e-6 mm of deviation", "tight", _offset(4.0), 1e-6),
    TubeCase("1e-9 mm of deviation", "tight", _offset(4.0), 1e-9),
    TubeCase("length 3e-3 mm", "tiny", _half_circle(2e-4, 1e-4), 1e-9, sweep="pipe"),
    TubeCase("length 30 km", "huge", _half_circle(1e5, 1e6), 1.0),
    TubeCase("below what numbers can keep", "tight", _half_circle(2.0), 1e-15, refusal=SceneError),
)


def tube_rows(tell: Callable[[str], None]) -> list[HardRow]:
    """A row a case."""
    rows = []
    for case in CASES:
        tell(f"tube: {case.name}")
        rows.append(_row(case))
    return rows


def _row(case: TubeCase) -> HardRow:
    rival = {"shell": "MakePipeShell", "frenet": "MakePipeShell, Frenet", "pipe": "MakePipe, 64 points"}[case.sweep]
    try:
        theirs = in_sandbox(lambda: _swept(case))
    except SandboxError as error:
        theirs = shortened(error)
    begun = time.perf_counter()
    try:
        built = build(case.cable, tolerance=case.tolerance)
    except CablecadError as error:
        taken = time.perf_counter() - begun
        right = case.refusal is not None and type(error) is case.refusal
        told = f"refused: {shortened(error)}"
        return HardRow(case.name, case.regime, "tube", told, None, right, taken * 1e3, rival, theirs)
    taken = time.perf_counter() - begun
    solid = built.report["solid"]
    error_of_it = abs(float(solid["volume_error"]))
    right = case.refusal is None and solid["valid"] and error_of_it <= VOLUME_ERROR
    told = f"deviation {solid['deviation']:.1e} mm, volume off by {error_of_it:.0e}"
    return HardRow(case.name, case.regime, "tube", told, error_of_it, right, taken * 1e3, rival, theirs)


def _swept(case: TubeCase) -> str:
    """What Open Cascade makes of it, and what its own check says of that."""
    centreline, radius = solve(case.cable).centreline, case.cable.section.radius
    tolerance = max(case.tolerance, 1e-12 * centreline.length)
    solid = _sweep(case.sweep, centreline, radius, tolerance)
    check = check_solid(solid, radius=radius, length=centreline.length)
    said = "valid" if check.valid else "not valid"
    verdict = f"called {said}, volume off by {abs(check.volume_error):.0e}"
    return verdict if case.refusal is None or not check.valid else f"{verdict}; sees nothing"


def _sweep(kind: str, centreline: Centreline, radius: float, tolerance: float) -> TopoDS_Shape:
    at = centreline.frames(np.linspace(0.0, centreline.length, 64))
    if kind == "pipe":
        return sweep_pipe(interpolated_spine(at.position), at.position[0], at.tangent[0], radius)
    fit = fit_centreline(centreline, radius, tolerance=tolerance)
    if kind == "frenet":
        return _sweep_by_frenet(fit, radius)
    return sweep_pipe_shell(fitted_spine(fit), at.position[0], at.tangent[0], radius, tolerance=tolerance)


def _sweep_by_frenet(fit: FittedCentreline, radius: float) -> TopoDS_Shape:
    start = fit.frames([0.0])
    axes = gp_Ax2(gp_Pnt(*start.position[0].tolist()), gp_Dir(*start.tangent[0].tolist()))
    sweep = BRepOffsetAPI_MakePipeShell(fitted_spine(fit))
    sweep.SetMode(True)
    sweep.SetTolerance(1e-6)
    sweep.Add(BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(gp_Circ(axes, radius)).Edge()).Wire())
    sweep.Build()
    if not sweep.IsDone() or not sweep.MakeSolid():
        raise GeometryError("the sweep failed, and said so")
    return TopoDS.Solid(sweep.Shape())
