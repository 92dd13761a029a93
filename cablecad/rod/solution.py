"""What solving a cable gives: its equilibria, the one chosen, and what that one is worth."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Literal

from numpy.typing import ArrayLike

from cablecad.centreline import Array, Centreline, Side
from cablecad.errors import Mistake, SceneError
from cablecad.model import Cable, Clamp, EquilibriumKey, Pin, Port
from cablecad.rod.stability import Judged
from cablecad.rod.verdict import Violation, find_violations, find_warnings

if TYPE_CHECKING:
    from cablecad.rod.response import Response
    from cablecad.rod.trace import Trace

STANDARD_GRAVITY = 9.80665
"""[m/s^2]"""

ModelName = Literal["straight", "planar"]


@dataclass(frozen=True)
class EndState:
    """One end of a solved cable.

    Attributes:
        position: [mm], shape (3,).
        direction: Unit tangent in the way of travel, shape (3,).
        force_per_EI: What the support applies to the cable, per unit bending stiffness [1/mm^2], shape (3,).
        moment_per_EI: The same for the moment about the end's own point [1/mm], shape (3,).
    """

    position: Array
    direction: Array
    force_per_EI: Array
    moment_per_EI: Array


@dataclass(frozen=True)
class Shape:
    """The curve of an equilibrium, and what its supports apply to it."""

    centreline: Centreline
    start: EndState
    end: EndState


@dataclass(frozen=True)
class Equilibrium:
    """One equilibrium of a cable.

    Attributes:
        winding: Full turns of the tangent beyond the least.
        side: +1 towards the bulge, -1 away from it, 0 where there is no side.
        inflections: Points between the ends at which the curvature changes sign.
        branch: "inflexional", "non-inflexional", "circle" or "line".
        energy_per_EI: Strain energy per unit bending stiffness [1/mm].
        draw: Makes the shape; called once, and only if someone asks.
        judge: Finds the stability; called once, and only if someone asks.
        diameter: Of the cable [mm], for the self-gap.
        trace: What a moved cable and derivatives start from; None for closed forms of their own.
        kappa_max: The greatest |curvature| [1/mm], where it is known without drawing the shape.
    """

    winding: int
    side: int
    inflections: int
    branch: str
    energy_per_EI: float
    draw: Callable[[], Shape] = field(repr=False)
    judge: Callable[[], Judged] = field(repr=False)
    diameter: float
    trace: Trace | None = field(default=None, repr=False)
    kappa_max: float | None = None

    @cached_property
    def shape(self) -> Shape:
        """The centreline and the states of its ends."""
        return self.draw()

    @property
    def centreline(self) -> Centreline:
        """The curve."""
        return self.shape.centreline

    @cached_property
    def ends(self) -> tuple[EndState, EndState]:
        """States of the start and the end."""
        return self.shape.start, self.shape.end

    @property
    def start(self) -> EndState:
        """State of the start."""
        return self.ends[0]

    @property
    def end(self) -> EndState:
        """State of the end."""
        return self.ends[1]

    @cached_property
    def stability(self) -> Judged:
        """Margins in and out of the plane."""
        return self.judge()

    @cached_property
    def greatest_curvature(self) -> tuple[float, float]:
        """The greatest |curvature| [1/mm] and the arclength where it stands [mm]."""
        return self.centreline.greatest_curvature()

    @property
    def bend_radius_min(self) -> float | None:
        """The least bend radius [mm], or None where the cable is straight."""
        kappa = self.greatest_curvature[0] if self.kappa_max is None else self.kappa_max
        return 1.0 / kappa if kappa > 0.0 else None

    @cached_property
    def self_gap(self) -> float | None:
        """Room between parts of the cable's side that face each other [mm]; None where none do."""
        from cablecad.rod.room import gap_of  # which knows equilibria

        return gap_of(self)


@dataclass(frozen=True)
class RodSolution:
    """A cable solved as an elastic rod.

    Attributes:
        cable: What was asked.
        model: The mechanical model that was taken.
        reason: Why this one.
        equilibria: Those found: the in-plane stable by energy, then the unstable.
        index: Which of them is the answer.
        length: [mm].
        chord: Distance of the ends [mm]; negative where a `toward` end lies behind the start.
        slack: (length - chord) / chord, or None where the chord is not positive.
        measure_rise: Finds the greatest distance from the chord [mm]; called once, and only if someone asks.
        measure_end_angle: Finds the angle between the start's tangent and the chord; likewise.
        measure_residual: Finds the residual; called once, and only if someone asks.
        out_of_plane_deg: Angle by which the ends were turned into one plane [degrees].
        notes: What the data themselves give to say: other answers, redundant data, ends that have crossed.
        find_notes: Finds further notes that take time; called only if someone asks for the warnings.
    """

    cable: Cable
    model: ModelName
    reason: str
    equilibria: tuple[Equilibrium, ...]
    index: int
    length: float
    chord: float
    slack: float | None
    measure_rise: Callable[[], float] = field(repr=False)
    measure_end_angle: Callable[[], float | None] = field(repr=False)
    measure_residual: Callable[[], float] = field(repr=False)
    out_of_plane_deg: float = 0.0
    notes: tuple[str, ...] = ()
    find_notes: Callable[[], tuple[str, ...]] | None = field(default=None, repr=False)

    def __str__(self) -> str:
        """What the user wants to know of it: the line that `cablecad solve` prints, violations and warnings below."""
        violations = [violation.message for violation in self.violations]
        return "\n".join([self.summary, *(f"  warning: {said}" for said in [*violations, *self.warnings])])

    @property
    def summary(self) -> str:
        """The shape on one line, as `cablecad solve` prints it."""
        radius = self.bend_radius_min
        shortest = " (the shortest that keeps its rule)" if self.cable.length == "shortest" else ""
        parts = [
            f"{self.cable.name}: solved",
            f"{self.model} ({self.equilibrium.branch})",
            f"length {self.length:.7g} mm{shortest}",
            f"chord {self.chord:.7g} mm",
            "no bend"
            if radius is None
            else f"least bend radius {radius:.7g} mm at s = {self.bend_radius_min_at:.7g} mm",
        ]
        if self.EI is not None:
            force = self.EI * float((self.equilibrium.end.force_per_EI**2).sum() ** 0.5)
            parts.append(f"end force {force:.7g} N")
        if not self.stability.stable_in_plane:
            parts.append("unstable")
        elif not self.stability.stable_out_of_plane:
            parts.append("stable only in its plane")
        else:
            parts.append("stable")
        return ", ".join(parts)

    @property
    def equilibrium(self) -> Equilibrium:
        """The chosen equilibrium."""
        return self.equilibria[self.index]

    @property
    def centreline(self) -> Centreline:
        """The chosen equilibrium's shape."""
        return self.equilibrium.centreline

    @property
    def stability(self) -> Judged:
        """The chosen equilibrium's stability."""
        return self.equilibrium.stability

    @property
    def bend_radius_min(self) -> float | None:
        """The least bend radius [mm], or None where the cable is straight."""
        return self.equilibrium.bend_radius_min

    @cached_property
    def residual(self) -> float:
        """Largest unmet end condition of the delivered centreline: position over length, direction as an angle."""
        return self.measure_residual()

    @cached_property
    def end_angle_deg(self) -> float | None:
        """Angle between the start's tangent and the chord [degrees]; None where the ends coincide."""
        return self.measure_end_angle()

    @cached_property
    def rise(self) -> float:
        """Greatest distance from the chord [mm]."""
        return self.measure_rise()

    @property
    def bend_radius_min_at(self) -> float | None:
        """The arclength where the bend radius is least [mm], or None where the cable is straight."""
        return self.equilibrium.greatest_curvature[1] if self.bend_radius_min is not None else None

    @property
    def self_gap(self) -> float | None:
        """Room between parts of the cable's side that face each other [mm]; None where none do."""
        return self.equilibrium.self_gap

    @cached_property
    def EI(self) -> float | None:
        """Bending stiffness [N mm^2], or None without a material."""
        return None if self.cable.material is None else self.cable.material.EI(self.cable.section)

    @cached_property
    def GJ(self) -> float | None:
        """Torsional stiffness [N mm^2], or None where nothing tells it."""
        return None if self.cable.material is None else self.cable.material.GJ(self.cable.section)

    @property
    def energy(self) -> float | None:
        """Strain energy [N mm], or None without a material."""
        return None if self.EI is None else self.EI * self.equilibrium.energy_per_EI

    @property
    def weight_ratio(self) -> float | None:
        """Weight times length squared per EI: above 1 gravity matters. None without a mass and a stiffness."""
        if self.EI is None or self.cable.material is None or self.cable.material.mass_per_length is None:
            return None
        weight = self.cable.material.mass_per_length * STANDARD_GRAVITY / 1000.0  # kg/m times m/s^2 is N/m
        return min(weight * self.length**3 / self.EI, sys.float_info.max)

    @property
    def warnings(self) -> tuple[str, ...]:
        """What the user should know of a shape that breaks no rule."""
        late = () if self.find_notes is None else self.find_notes()
        return self.notes + late + find_warnings(self.cable, self.stability, self.self_gap, self.weight_ratio)

    @cached_property
    def violations(self) -> tuple[Violation, ...]:
        """Rules the shape breaks: a tube that cuts into itself, a bend tighter than the user allows."""
        return find_violations(self.cable, self.bend_radius_min, self.bend_radius_min_at, self.self_gap)

    def moved(
        self,
        *,
        start: Clamp | Pin | Port | None = None,
        end: Clamp | Pin | Port | None = None,
        length: float | None = None,
    ) -> RodSolution:
        """Follow this equilibrium to a moved end or another length, without a search; see `cablecad.rod.move`."""
        from cablecad.rod.move import move_solution

        return move_solution(self, start=start, end=end, length=length)

    def sensitivity(self, s: ArrayLike = ()) -> Response:
        """Derivatives of wrenches, least bend radius and points at `s` [mm]; see `cablecad.rod.response`."""
        from cablecad.rod.response import respond_to_ends

        return respond_to_ends(self, s)

    def points(self, count: int) -> Array:
        """`count` >= 2 positions at equal arclengths, both ends included, shape (count, 3) [mm]."""
        return self.centreline.points(count)

    def position(self, s: ArrayLike) -> Array:
        """Positions at arclengths [mm], shape (n, 3) [mm]."""
        return self.centreline.position(s)

    def tangent(self, s: ArrayLike, side: Side = "right") -> Array:
        """Unit tangents at arclengths [mm], shape (n, 3)."""
        return self.centreline.tangent(s, side)

    def curvature(self, s: ArrayLike, derivative: int = 0, side: Side = "right") -> Array:
        """Curvature about the plane's normal at arclengths [mm], signed, shape (n,) [1/mm^(1 + derivative)]."""
        return self.centreline.curvature(s, derivative, side)


def choose(cable: Cable, found: Sequence[Equilibrium]) -> int:
    """The index of the equilibrium the cable asks for.

    Raises:
        SceneError: It was not found; the message lists what was.
    """
    wanted = cable.equilibrium
    if isinstance(wanted, EquilibriumKey):
        for i, equilibrium in enumerate(found):
            if (equilibrium.winding, equilibrium.side) == (wanted.winding, wanted.side):
                return i
        listed = ", ".join(dict.fromkeys(f"({e.winding}, {e.side})" for e in found))
        problem = f"no such equilibrium was found; the (winding, side) found are {listed}"
        raise SceneError([Mistake("equilibrium", problem, {"winding": wanted.winding, "side": wanted.side})])
    if wanted >= len(found):
        listed = "only one equilibrium was" if len(found) == 1 else f"only {len(found)} equilibria were"
        raise SceneError([Mistake("equilibrium", f"{listed} found, counted from 0", wanted)])
    return wanted
