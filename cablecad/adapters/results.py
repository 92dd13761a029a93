"""What travels with a cable through a script: its solution, its report, its exact STEP file."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.TopAbs import TopAbs_ShapeEnum
from OCP.TopExp import TopExp_Explorer
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS, TopoDS_Shape, TopoDS_Solid

from cablecad.adapters.ends import End, seen_from
from cablecad.brep.kernel import subshapes
from cablecad.brep.rounds import xyz
from cablecad.centreline import Array
from cablecad.errors import UsageError
from cablecad.model import Part, Toward
from cablecad.pipeline import Built, Solid, build_solution, write_step

if TYPE_CHECKING:
    from cablecad.rod.solution import RodSolution


@dataclass(frozen=True, eq=False)
class Results:
    """A built cable and what it was built to; copies of a shape share it.

    Attributes:
        built: In the frame in which the cable was solved.
        tolerance: Of its solid [mm].
    """

    built: Built
    tolerance: float

    def __deepcopy__(self, memo: object) -> Results:
        return self

    def solved_again(
        self, placement: TopLoc_Location, start: End | None, end: End | None, length: float | None
    ) -> Results:
        """The same equilibrium, followed to moved ends.

        Args:
            placement: Where the frame of the solution is now.
            start: The new start, in the script's coordinates; None leaves it.
            end: The new end.
            length: The new length [mm].

        Raises:
            UsageError: An end of which only the line is known.
            CablecadError: There is no such shape, or the equilibrium could not be followed.
        """
        back = placement.Transformation().Inverted()
        moved: dict[str, Any] = {"length": length}
        for key, new in (("start", start), ("end", end)):
            if isinstance(new, Toward):
                raise UsageError(f"the {key} moves to a place: give it a position")
            moved[key] = None if new is None else seen_from(new, back)
        solution = self.built.solution.moved(**moved)
        return Results(build_solution(solution, tolerance=self.tolerance), self.tolerance)


class CableResults:
    """Adds to a shape of the host what cablecad knows of the cable it is.

    The numbers of `solution` and `report` are in the frame in which the cable was solved. Moving the shape as a whole
    moves that frame with it, as the shape's location tells; `built` and `write_step` have the solid where it is now.
    """

    wrapped: Any
    _results: Results | None = None

    @property
    def results(self) -> Results:
        """The built cable and its tolerance.

        Raises:
            UsageError: The shape was changed since the cable was made, so that nothing is known of it.
        """
        found = self._results
        if found is None or not all(_is_same(solid, found.built.solid.wrapped) for solid in _solids(self.wrapped)):
            raise UsageError(
                "this shape is no longer the cable that was solved (it was cut, filleted, scaled, mirrored or read "
                "from a file); ask the cable it was made from"
            )
        return found

    @property
    def cable(self) -> Any:
        """The `cablecad.Cable` that was asked for."""
        return self.results.built.cable

    @property
    def solution(self) -> RodSolution:
        """The solved rod: points, curvature, forces, equilibria."""
        return self.results.built.solution

    @property
    def report(self) -> dict[str, Any]:
        """As `cablecad build --report` writes it for a cable."""
        return self.results.built.report

    @property
    def built(self) -> Built:
        """The cable as `cablecad.build` returns it, its solid where it is now.

        Raises:
            UsageError: The shape holds the cable more than once.
        """
        return replace(self.results.built, solid=Solid(self._one_solid()))

    def write_step(self, path: str | PathLike[str], *parts: Part) -> None:
        """Write the cable, and rigid parts read from STEP files, as `cablecad.write_step` does: exact and byte-stable.

        Raises:
            ExchangeError: The file cannot be written.
        """
        write_step([self.built, *parts], path)

    def _one_solid(self) -> TopoDS_Solid:
        solids = list(_solids(self.wrapped))
        if len(solids) != 1:
            raise UsageError(f"the shape holds {len(solids)} solids; ask one of them")
        return TopoDS.Solid(solids[0])

    def _placement(self) -> TopLoc_Location:
        """Where the frame of the solution is now."""
        self.results  # noqa: B018 - says so where nothing is known
        return self._one_solid().Location()


def _is_same(solid: TopoDS_Shape, built: TopoDS_Shape) -> bool:
    """Whether a solid is a copy of the one that was built, wherever it is placed: by its vertices."""
    one, other = _corners(solid), _corners(built)
    return one.shape == other.shape and bool(np.allclose(one, other, rtol=0.0, atol=1e-9 * (1.0 + np.abs(other).max())))


def _corners(solid: TopoDS_Shape) -> Array:
    """The vertices in the solid's own frame, shape (n, 3) [mm]."""
    vertices = subshapes(solid.Located(TopLoc_Location()), TopAbs_ShapeEnum.TopAbs_VERTEX)
    return np.array([xyz(BRep_Tool.Pnt_s(TopoDS.Vertex(vertex))) for vertex in vertices])


def _solids(shape: TopoDS_Shape) -> Iterator[TopoDS_Shape]:
    explorer = TopExp_Explorer(shape, TopAbs_ShapeEnum.TopAbs_SOLID)
    while explorer.More():
        yield explorer.Current()
        explorer.Next()
