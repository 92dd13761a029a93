"""What is damaged in a STEP file, looked for when Open Cascade has read its text and before it makes shapes of it.

Its translator trusts what it has read: where an entity is missing that the standard promises, it follows the null
pointer, and the process is gone; where a unit is missing, it takes another. Open Cascade itself tells the entities it
could not read in full (`failures`), but neither references that may be to anything of a wide kind, nor lists that are
too short: those that make shapes are looked at here: curves in surfaces, vertices, placements, units.

About 15 ms for each MB, found by kind in C++ because to look at every entity from Python would take 50.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass
from typing import TypeVar, cast

from OCP.IFSelect import IFSelect_SelectModelEntities, IFSelect_SelectType
from OCP.Interface import Interface_CheckIterator
from OCP.Standard import Standard_Transient
from OCP.StepGeom import (
    StepGeom_Axis2Placement3d,
    StepGeom_CartesianPoint,
    StepGeom_Curve,
    StepGeom_Pcurve,
    StepGeom_Point,
)
from OCP.StepRepr import StepRepr_Representation, StepRepr_RepresentationContext
from OCP.StepShape import StepShape_ShapeRepresentation, StepShape_VertexPoint
from OCP.XSControl import XSControl_WorkSession

from cablecad.brep.units import has_length, settle_units

Entity = TypeVar("Entity", bound=Standard_Transient)

_UNKNOWN = "(representation_item) : Entity has illegal type"
"""What Open Cascade says of a representation with an item of a kind that it does not know."""

_PLACING = (
    "StepRepr_ItemDefinedTransformation",
    "StepRepr_MappedItem",
    "StepRepr_ShapeRepresentationRelationshipWithTransformation",
)
"""Entities that place a shape in an assembly."""

_COLOURING = frozenset(
    f"StepVisual_{kind}"
    for kind in (
        "StyledItem",
        "OverRidingStyledItem",
        "PresentationStyleByContext",
        "SurfaceStyleUsage",
        "SurfaceSideStyle",
        "SurfaceStyleFillArea",
        "FillAreaStyle",
        "FillAreaStyleColour",
        "CurveStyle",
        "ColourRgb",
    )
)
"""Entities Open Cascade follows to a colour without looking whether they are whole: a broken one kills the process."""

_LAYERING = frozenset({"StepVisual_PresentationLayerAssignment"})
"""Likewise to a layer."""


@dataclass(frozen=True, slots=True)
class Failure:
    """An entity that is not as it must be.

    Attributes:
        place: Of the entity in the file, counted from 1.
        entity: As Open Cascade holds it.
        problem: What is wrong with it.
    """

    place: int
    entity: Standard_Transient
    problem: str

    @property
    def kind(self) -> str:
        """As Open Cascade calls it: ``StepGeom_CartesianPoint``."""
        return type(self.entity).__name__

    def __str__(self) -> str:
        return f"{self.kind.partition('_')[2]}: {self.problem}"


@dataclass(frozen=True, slots=True)
class Findings:
    """What was found in a file that Open Cascade has read.

    Attributes:
        damage: The first entity of which Open Cascade must not make shapes; or None.
        colors: Whether it may follow colours.
        layers: Whether it may follow layers.
        lengths: Whether every shape has a unit of length.
    """

    damage: Failure | None
    colors: bool
    layers: bool
    lengths: bool


def failures(checks: Interface_CheckIterator) -> list[Failure]:
    """What Open Cascade itself found, of each entity what weighs most."""
    failed = []
    checks.Start()
    while checks.More():
        check = checks.Value()
        problems = [str(check.Fail(i).ToCString()).strip() for i in range(1, check.NbFails() + 1)]
        if problems:
            problem = next((problem for problem in problems if not problem.endswith(_UNKNOWN)), problems[0])
            failed.append(Failure(checks.Number(), check.Entity(), problem))
        checks.Next()
    return failed


def look_at(session: XSControl_WorkSession) -> Findings:
    """Look at a file that Open Cascade has read and not yet translated; `units` are settled in it."""
    failed = failures(session.ModelCheckList(False))
    kinds = {failure.kind for failure in failed}
    damage = next((failure for failure in failed if _makes_shapes(failure)), None)
    contexts: list[StepRepr_RepresentationContext] = []
    if damage is None and session.ComputeGraph():  # else there is nothing, or to look further may kill the process
        shapes = _of_kind(session, StepShape_ShapeRepresentation)
        contexts = list({id(context): context for context in (shape.ContextOfItems() for shape in shapes)}.values())
        odd = next(_odd(session, shapes, contexts, {failure.entity for failure in failed}), None)
        damage = Failure(_place(session, odd[0]), *odd) if odd else None
    return Findings(
        damage,
        colors=kinds.isdisjoint(_COLOURING),
        layers=kinds.isdisjoint(_LAYERING),
        lengths=damage is not None or all(map(has_length, contexts)),
    )


def _makes_shapes(failure: Failure) -> bool:
    """Whether Open Cascade would make or place a shape by a broken entity, and might well kill the process over it."""
    # A representation may hold annotations of kinds that Open Cascade does not know, and does in many sound files.
    annotated = failure.kind.endswith("Representation") and failure.problem.endswith(_UNKNOWN)
    return failure.kind.startswith(("StepGeom_", "StepShape_", *_PLACING)) and not annotated


def _odd(
    session: XSControl_WorkSession,
    shapes: Iterable[StepShape_ShapeRepresentation],
    contexts: Iterable[StepRepr_RepresentationContext],
    failed: Collection[Standard_Transient],
) -> Iterator[tuple[Standard_Transient, str]]:
    """Entities that are not as they must be and that Open Cascade does not complain of, and why."""
    for context in contexts:
        wrong = settle_units(context, failed)
        if wrong:
            yield wrong
    for shape in shapes:
        for i in range(1, shape.NbItems() + 1):
            item = shape.ItemsValue(i)
            if isinstance(item, StepGeom_Axis2Placement3d) and not _is_in_space(item.Location()):
                yield item, "its location is no point with three coordinates"
    for curve in _of_kind(session, StepGeom_Pcurve):
        flat = curve.ReferenceToCurve()
        is_one = isinstance(flat, StepRepr_Representation) and flat.NbItems() == 1
        if not (is_one and isinstance(flat.ItemsValue(1), StepGeom_Curve)):
            yield flat or curve, "its items are not one curve"
    for vertex in _of_kind(session, StepShape_VertexPoint):
        if not _is_in_space(vertex.VertexGeometry()):
            yield vertex, "its geometry is no point with three coordinates"


def _is_in_space(point: StepGeom_Point) -> bool:
    return isinstance(point, StepGeom_CartesianPoint) and point.NbCoordinates() == 3


def _of_kind(session: XSControl_WorkSession, kind: type[Entity]) -> list[Entity]:
    """Every entity of a kind, or of one that is derived from it."""
    selection = IFSelect_SelectType(kind.get_type_descriptor_s())
    selection.SetInput(IFSelect_SelectModelEntities())
    found = selection.RootResult(session.Graph())
    entities = []
    found.Start()
    while found.More():
        entities.append(cast(Entity, found.Value()))
        found.Next()
    return entities


def _place(session: XSControl_WorkSession, entity: Standard_Transient) -> int:
    """Of an entity in its file, from 1. Open Cascade's own `Number` does not find entities that come from Python."""
    model = session.Model()
    return next((i for i in range(1, model.NbEntities() + 1) if model.Value(i) is entity), 0)
