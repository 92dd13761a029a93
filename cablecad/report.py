"""What a build or a solution says of itself: report format 1, as plain data and as JSON.

Lengths in mm, forces in N, moments in N mm, energy in N mm, EI and GJ in N mm^2; `*_per_EI` in 1/mm^2 (force), 1/mm
(moment and energy). What needs a material is null without one; every number of a cable that was not solved is null.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from cablecad import __version__
from cablecad.errors import (
    CablecadError,
    GeometryError,
    InfeasibleError,
    NotPlanarError,
    SolveError,
)
from cablecad.model import Cable, Scene

if TYPE_CHECKING:
    from cablecad.brep.check import SolidCheck
    from cablecad.brep.spline import FittedCentreline
    from cablecad.rod.solution import EndState, Equilibrium, RodSolution

FORMAT = 1

_RESULTS: tuple[tuple[type[CablecadError], str], ...] = (
    (NotPlanarError, "not_planar"),
    (InfeasibleError, "infeasible"),
    (SolveError, "unsolved"),
    (GeometryError, "invalid_tube"),
    (CablecadError, "unsolved"),
)
"""The result each error stands for; the first that fits."""

_PLAIN = frozenset({float, str, int, bool, type(None)})
"""Kinds of values that are plain Python data as they are."""

_VECTOR = re.compile(r"\[\n\s+([-+.\deE]+(?:,\n\s+[-+.\deE]+)*)\n\s+\]")
"""A list of numbers as `json` indents it; a line break inside a string is escaped, so nothing else looks like it."""


@dataclass
class CableOutcome:
    """What became of one cable of a scene.

    Attributes:
        cable: What was asked.
        solution: Its solution, or None where there is none.
        error: Why it has no solution or no solid.
        fit: The fitted centreline, once made.
        check: The solid's certificate, once made.
        notes: What making the solid adds to the warnings.
        origins: Of each end taken from a part's geometry, what it was found to be.
        seconds: Time by stage: solve, tube, check.
    """

    cable: Cable
    solution: RodSolution | None = None
    error: CablecadError | None = None
    fit: FittedCentreline | None = None
    check: SolidCheck | None = None
    notes: list[str] = field(default_factory=list)
    origins: list[str] = field(default_factory=list)
    seconds: dict[str, float] = field(default_factory=dict)

    @property
    def result(self) -> str:
        """solved, infeasible, unsolved, not_planar or invalid_tube."""
        if self.error is None:
            return "solved"
        return next(result for kind, result in _RESULTS if isinstance(self.error, kind))

    @property
    def violations(self) -> list[str]:
        """The rules its shape breaks."""
        return [] if self.solution is None else [violation.message for violation in self.solution.violations]

    @property
    def broken_rules(self) -> list[str]:
        """Those of them that are the user's own: the solid can be made in spite of them."""
        found = () if self.solution is None else self.solution.violations
        return [violation.message for violation in found if not violation.spoils_tube]

    @property
    def warnings(self) -> list[str]:
        """What a user should know of it besides."""
        return [] if self.solution is None else [*self.solution.warnings, *self.notes]


def cable_report(outcome: CableOutcome, *, points: int | None = None) -> dict[str, Any]:
    """The report of one cable.

    Args:
        outcome: What became of it.
        points: How many points at equal arclengths to list; None for none.
    """
    solution = outcome.solution if outcome.error is None else None
    return {
        "name": outcome.cable.name,
        "result": outcome.result,
        "message": "" if outcome.error is None else str(outcome.error),
        **_solution_numbers(solution),
        **({"reason": "; ".join([solution.reason, *outcome.origins])} if solution is not None else {}),
        "equilibria": [] if solution is None else _equilibria(solution),
        "points": [] if solution is None or points is None else solution.points(points).tolist(),
        "solid": _solid(outcome) if solution is not None else None,
        "violations": outcome.violations,
        "warnings": outcome.warnings,
        "seconds": {stage: outcome.seconds.get(stage) for stage in ("solve", "tube", "check")},
    }


def _solution_numbers(solution: RodSolution | None) -> dict[str, Any]:
    """Everything the mechanics say, or the same keys with null."""
    get = _reader(solution)
    equilibrium = None if solution is None else solution.equilibrium
    stability = None if solution is None else solution.stability
    chosen, judged = _reader(equilibrium), _reader(stability)
    EI = None if solution is None else solution.EI
    return {
        "model": get("model"),
        "reason": get("reason"),
        "branch": chosen("branch"),
        "length": get("length"),
        "chord": get("chord"),
        "slack": get("slack"),
        "out_of_plane_deg": get("out_of_plane_deg"),
        "residual": get("residual"),
        "rise": get("rise"),
        "end_angle_deg": get("end_angle_deg"),
        "bend_radius_min": get("bend_radius_min"),
        "bend_radius_min_at": get("bend_radius_min_at"),
        "self_gap": get("self_gap"),
        "energy_per_EI": chosen("energy_per_EI"),
        "EI": EI,
        "GJ": get("GJ"),
        "energy": get("energy"),
        "weight_ratio": get("weight_ratio"),
        "start": _end(chosen("start"), EI),
        "end": _end(chosen("end"), EI),
        "stable_in_plane": judged("stable_in_plane"),
        "margin_in_plane": judged("in_plane"),
        "stable_out_of_plane": judged("stable_out_of_plane"),
        "margin_out_of_plane": judged("out_of_plane"),
        "spin": judged("spin"),
    }


def _reader(source: object | None) -> Any:
    """A function that reads an attribute, as plain Python data, or gives None where there is nothing to read."""

    def read(name: str) -> Any:
        value: Any = None if source is None else getattr(source, name)
        return value if value.__class__ in _PLAIN or not hasattr(value, "item") else value.item()

    return read


def _end(state: EndState | None, EI: float | None) -> dict[str, Any]:
    if state is None:
        keys = ("position", "direction", "force", "moment", "force_per_EI", "moment_per_EI")
        return dict.fromkeys(keys)
    force, moment = state.force_per_EI.tolist(), state.moment_per_EI.tolist()
    return {
        "position": state.position.tolist(),
        "direction": state.direction.tolist(),
        "force": None if EI is None else [EI * part for part in force],
        "moment": None if EI is None else [EI * part for part in moment],
        "force_per_EI": force,
        "moment_per_EI": moment,
    }


def _equilibria(solution: RodSolution) -> list[dict[str, Any]]:
    return [_equilibrium(index, equilibrium) for index, equilibrium in enumerate(solution.equilibria)]


def _equilibrium(index: int, equilibrium: Equilibrium) -> dict[str, Any]:
    judged = _reader(equilibrium.stability)
    return {
        "index": index,
        "winding": equilibrium.winding,
        "side": equilibrium.side,
        "inflections": equilibrium.inflections,
        "energy_per_EI": equilibrium.energy_per_EI,
        "bend_radius_min": equilibrium.bend_radius_min,
        "self_gap": equilibrium.self_gap,
        "stable_in_plane": judged("stable_in_plane"),
        "margin_in_plane": judged("in_plane"),
        "stable_out_of_plane": judged("stable_out_of_plane"),
        "margin_out_of_plane": judged("out_of_plane"),
    }


def _solid(outcome: CableOutcome) -> dict[str, Any] | None:
    """The certificate of the solid, or None where none was made."""
    fit, check = outcome.fit, outcome.check
    if fit is None or check is None:
        return None
    kappa = fit.greatest_curvature()[0]
    return {
        "deviation": fit.deviation,
        "tolerance": fit.tolerance,
        "volume": check.volume,
        "volume_error": check.volume_error,
        "area": check.area,
        "area_error": check.area_error,
        "bend_radius_min": 1.0 / kappa if kappa > 0.0 else None,
        "valid": check.valid,
        "knot_spans": fit.spans,
        "faces": check.faces,
    }


def scene_report(
    scene: Scene,
    outcomes: Sequence[CableOutcome],
    *,
    solids: Mapping[str, int | None],
    seconds: Mapping[str, float],
    points: int | None = None,
) -> dict[str, Any]:
    """The report of a scene.

    Args:
        scene: What was asked.
        outcomes: What became of each cable.
        solids: Number of solids of each part by name; None where the part was not read.
        seconds: Time by stage: import, read, cables, write, total.
        points: As for `cable_report`.
    """
    return {
        "format": FORMAT,
        "cablecad": __version__,
        "scene": scene.name,
        "cables": [cable_report(outcome, points=points) for outcome in outcomes],
        "parts": [{"name": part.name, "solids": solids.get(part.name)} for part in scene.parts],
        "seconds": {stage: seconds.get(stage) for stage in ("import", "read", "cables", "write", "total")},
    }


def to_json(report: Mapping[str, Any]) -> str:
    """A report as JSON text with a final line break; it holds no NaN, and a vector stands on one line."""
    text = json.dumps(report, indent=2, ensure_ascii=False, allow_nan=False)
    return _VECTOR.sub(lambda found: "[" + re.sub(r"\s+", " ", found[1]) + "]", text) + "\n"
