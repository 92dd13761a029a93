"""Cables in CadQuery scripts: real solids, with what cablecad knows of them on board.

    import cadquery as cq
    from cablecad.adapters.cadquery import cable, add_to

    plate = cq.Workplane().box(40, 40, 8).faces(">Z").workplane().hole(6)
    start = plate.faces(">Z").edges("%CIRCLE")             # the rim of the hole: its centre, and its axis out of it
    wire = cable(start, cq.Location((0, 120, 4)), diameter=4, length=350, name="W1", color="#2b6cb0")
    wire.report["bend_radius_min"], wire.solution.points(200), wire.moved(end=cq.Location((0, 125, 4)))
    add_to(cq.Assembly(plate, name="plate"), wire).export("loom.step")

An end is a `cq.Location` or `cq.Plane` (its z axis is outward, out of the connector); a `cq.Workplane` with one face or
edge selected, or with a point on it (its plane's normal is outward); a `cq.Face`; a `cq.Vertex`, `cq.Vector` or three
numbers (a pin: free to turn); position and outward, three numbers each; or a `cablecad.Port`, `Clamp`, `Pin` or
`Toward`. Nothing of CadQuery is patched.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence, Set
from os import PathLike, fspath
from typing import Any

from cablecad.errors import MissingDependencyError, UsageError

try:
    import cadquery as cq
except ModuleNotFoundError as error:
    if error.name != "cadquery":
        import cablecad.brep.kernel  # noqa: F401 - says what to install where Open Cascade is what is missing

        raise
    raise MissingDependencyError("CadQuery is not installed: pip install cadquery") from error

from cablecad.adapters.cadquery_ends import end_of, frame_of_end, selected_ends
from cablecad.adapters.ends import asked_cable, held, keep_straight, placed
from cablecad.adapters.results import CableResults, Results
from cablecad.brep.document import Color, Node, frame_of, part_frame
from cablecad.model import SHAPE_TOLERANCE, Scene
from cablecad.pipeline import Built, build, make_scene
from cablecad.scene import load_scene

__all__ = ["CableSolid", "add_to", "as_solid", "cable", "cable_from", "port", "to_assembly"]


class CableSolid(CableResults, cq.Solid):
    """A `cq.Solid` that is a cable.

    `report`, `solution`, `cable`, `built` and `write_step` are those of `cablecad`. Copies and moved ones keep them; a
    solid made of it by an operation, such as a cut, is a plain solid of CadQuery.
    """

    def moved(self, *args: Any, start: Any = None, end: Any = None, length: float | None = None, **kwargs: Any) -> Any:
        """Move the solid as a whole, as `cq.Shape.moved`; or an end of the cable, which is then solved again.

        Args:
            args: As for `cq.Shape.moved`.
            start: Where the cable starts instead, as for `cable`; its straight part stays as it is.
            end: Where it ends instead.
            length: Its length instead [mm].
            kwargs: As for `cq.Shape.moved`.

        Returns:
            A new solid: the same equilibrium, followed to the moved ends; or the same solid elsewhere.

        Raises:
            UsageError: A whole move and a move of an end at once.
            CablecadError: As `cablecad.RodSolution.moved` and `cablecad.build`.
        """
        if start is None and end is None and length is None:
            found = super().moved(*args, **kwargs)
            # By a list of one location or a vertex CadQuery makes a solid of its own class.
            return self._keeping(CableSolid(found.wrapped) if type(found) is cq.Solid else found)
        if args or kwargs:
            raise UsageError("moved() moves the cable as a whole or its ends, not both; call it twice")
        asked = self.cable
        ends = [
            None if new is None else keep_straight(end_of(new, key), old)
            for key, new, old in (("start", start, asked.start), ("end", end, asked.end))
        ]
        placement = self._placement()
        solid = _solid(self.results.solved_again(placement, ends[0], ends[1], length))
        return solid if placement.IsIdentity() else solid.moved(cq.Location(placement))

    def located(self, loc: cq.Location) -> Any:
        """As `cq.Shape.located`."""
        return self._keeping(super().located(loc))

    def copy(self, mesh: bool = False) -> Any:
        """As `cq.Shape.copy`."""
        return self._keeping(super().copy(mesh))

    def clean(self) -> Any:
        """As `cq.Shape.clean`; of a cable nothing is superfluous."""
        return self._keeping(super().clean())

    def translate(self, vector: Any) -> Any:
        """As `cq.Shape.translate`; by its location, so that the results keep their frame."""
        return self.moved(cq.Location(cq.Vector(vector)))

    def rotate(self, startVector: Any, endVector: Any, angleDegrees: float) -> Any:
        """As `cq.Shape.rotate`; by its location, so that the results keep their frame."""
        foot = cq.Vector(startVector)
        turn = cq.Location(cq.Vector(), cq.Vector(endVector) - foot, angleDegrees)
        return self.moved(cq.Location(foot) * turn * cq.Location(foot * -1))

    def __getstate__(self) -> Any:
        return super().__getstate__(), self._results, self.label

    def __setstate__(self, state: Any) -> None:
        shape, self._results, self.label = state
        super().__setstate__(shape)

    def __copy__(self) -> Any:
        return self.copy()

    def __deepcopy__(self, memo: object) -> Any:
        return self.copy()

    def _keeping(self, other: Any) -> Any:
        """Hand the results on to the same solid elsewhere."""
        if isinstance(other, CableSolid):
            other._results, other.label = self._results, self.label
        return other


def cable(
    start: Any,
    end: Any,
    *,
    diameter: float,
    name: str = "cable",
    start_straight: float = 0.0,
    end_straight: float = 0.0,
    tolerance: float = SHAPE_TOLERANCE,
    **data: Any,
) -> CableSolid:
    """Solve a cable and make its solid.

    Args:
        start: Where it starts; see the module for what an end may be.
        end: Where it ends.
        diameter: [mm].
        name: For the report, the solid's label and assemblies.
        start_straight: Length of straight cable the start's connector holds, part of the length [mm].
        end_straight: The same at the end.
        tolerance: Bound on the distance between the solid's side and the exact tube [mm].
        data: The other fields of `cablecad.Cable`: length, slack, color, material, min_bend_radius, bulge, ...

    Raises:
        SceneError: Values that do not fit.
        UsageError: An end that is none, or a field there is not.
        CablecadError: As `cablecad.build`.
    """
    ends = held(end_of(start, "start"), start_straight, "start"), held(end_of(end, "end"), end_straight, "end")
    asked = asked_cable(name, *ends, diameter, data)
    return _solid(Results(build(asked, tolerance=tolerance), tolerance))


def cable_from(end: Any, *, name: str = "cable", **data: Any) -> Callable[[Any], Any]:
    """Make a factory of cables to one end, for `Workplane.invoke` and `Workplane.eachpoint`.

    With `invoke` a cable starts at each face, edge, vertex or point that is selected, points along the plane's normal,
    and the cables become the new selection::

        plate.faces(">Z").edges("%CIRCLE").invoke(cable_from(cq.Location((0, 120, 4)), diameter=4, length=350))

    With `eachpoint` it starts at each point too, but `end` is then seen as the points are: with
    `useLocalCoordinates=True` in the plane's coordinates, which are those of the cables' numbers too; without it
    CadQuery puts points where they belong only on planes parallel to the XY plane.

    Args:
        end: An end as for `cable`, or a function from the start's `cq.Location` to one.
        name: Of the cable; the second and later ones of an `invoke` get a number behind it.
        data: As for `cable`.

    Returns:
        A function from a `cq.Workplane` to one with the cables selected, and from a `cq.Location` to a cable.
    """

    def make(start: Any) -> Any:
        if not isinstance(start, cq.Workplane):
            return cable(start, end(start) if callable(end) else end, name=name, **data)
        solids = []
        for i, begin in enumerate(selected_ends(start), 1):
            finish = end(frame_of_end(begin)) if callable(end) else end
            solids.append(cable(begin, finish, name=name if i == 1 else f"{name} {i}", **data))
        return start.newObject(solids)

    return make


def port(end: Any, location: cq.Location | None = None) -> Any:
    """The end of a cable that a CadQuery object stands for.

    Args:
        end: As for `cable`.
        location: Where the object's own part is placed, for one that was selected in the part's own coordinates.

    Returns:
        A `cablecad.Port`, `Clamp`, `Pin` or `Toward`.

    Raises:
        UsageError: The object stands for no end.
        GeometryError: A face or edge without an axis, or with one that may point either way.
    """
    return placed(end_of(end, "end"), location, cq.Location)


def as_solid(built: Built, *, tolerance: float = SHAPE_TOLERANCE) -> CableSolid:
    """The CadQuery solid of a cable built by `cablecad.build`.

    Args:
        built: The cable.
        tolerance: For when it is solved again [mm].

    Raises:
        UsageError: It was not built by `cablecad.build`.
    """
    if not isinstance(built, Built):
        raise UsageError(f"a {type(built).__name__} is no cable that cablecad.build() returned")
    return _solid(Results(built, tolerance))


def add_to(assembly: cq.Assembly, *cables: CableSolid | Built, loc: cq.Location | None = None) -> cq.Assembly:
    """Add cables to an assembly, each with its name and colour, and its report in `metadata["cablecad"]`.

    Args:
        assembly: To add to.
        cables: Of this module, or as built by `cablecad.build`.
        loc: Where they are in the assembly, as for `cq.Assembly.add`.

    Returns:
        The assembly.

    Raises:
        UsageError: The assembly, or another of the cables, has a cable's name already; nothing is added then.
    """
    if not isinstance(assembly, cq.Assembly):
        raise UsageError(f"a {type(assembly).__name__} is no cq.Assembly to add cables to")
    taken, solids = set(assembly.objects), []
    for one in cables:
        solid = as_solid(one) if isinstance(one, Built) else one
        if not isinstance(solid, CableSolid):
            raise UsageError(f"a {type(one).__name__} is no cable of cablecad: add it with assembly.add()")
        if solid.cable.name in taken:
            raise UsageError(f"the assembly has a {solid.cable.name!r} already; give the cable another name")
        taken.add(solid.cable.name)
        solids.append(solid)
    for solid in solids:
        asked, metadata = solid.cable, {"cablecad": solid.report}
        assembly.add(solid, loc=loc, name=asked.name, color=_color(asked.color), metadata=metadata)
    return assembly


def to_assembly(scene: Scene | str | PathLike[str]) -> cq.Assembly:
    """Solve a scene and make an assembly of it: ``name / parts / ...`` and ``name / cables / ...``, as `build` writes.

    Args:
        scene: A `cablecad.Scene`, or the path of a scene file.

    Returns:
        Names, colours and placements as in the file; colours of single faces too. `metadata["cablecad"]` of the whole
        holds the report.

    Raises:
        CablecadError: The first thing that went wrong; the others are notes on it.
    """
    if not isinstance(scene, Scene | str | PathLike):
        raise UsageError(f"a {type(scene).__name__} is no cablecad.Scene and no path of a scene file")
    if not isinstance(scene, Scene):
        scene = load_scene(fspath(scene))
    run, solids = make_scene(scene)
    run.raise_first()
    name = run.scene.name
    whole = cq.Assembly(name=name, metadata={"cablecad": run.report()})
    if run.scene.parts:
        group = cq.Assembly(name=_name_beside("parts", {name, *(part.name for part in run.scene.parts)}))
        for part in run.scene.parts:
            roots = run.documents[part.name].tree()
            placed = _branch(roots[0], part.name) if len(roots) == 1 else _bundle(roots, part.name)
            group.add(placed, loc=cq.Location(part_frame(part)), name=part.name)
        whole.add(group)
    if solids:
        group = cq.Assembly(name=_name_beside("cables", {name, *(built.name for built in solids)}))
        add_to(group, *solids)
        whole.add(group)
    return whole


# --- solids and assemblies ----------------------------------------------------------------------------------------


def _solid(results: Results) -> CableSolid:
    solid = CableSolid(results.built.solid.wrapped)
    solid._results, solid.label = results, results.built.name
    return solid


def _color(text: str | None) -> cq.Color | None:
    if text is None:
        return None
    return cq.Color(*(value / 255.0 for value in bytes.fromhex(f"{text[1:]:f<8}")))


def _bundle(nodes: Sequence[Node], name: str, color: Color | None = None) -> cq.Assembly:
    """Several products as the children of one assembly, with names of their own among them."""
    whole, taken = cq.Assembly(name=name), {name}
    for node in nodes:
        child = _name_beside(node.occurrence or node.name or "part", taken)
        taken.add(child)
        whole.add(_branch(node, child, color))
    return whole


def _name_beside(wanted: str, taken: Set[str]) -> str:
    """A name that CadQuery takes: in an assembly it must differ from those of all others, and from the assembly's."""
    name, count = wanted, 1
    while name in taken:
        count += 1
        name = f"{wanted} {count}"
    return name


def _branch(node: Node, name: str, color: Color | None = None) -> cq.Assembly:
    """A product and all below it."""
    color = node.occurrence_color or node.color or color
    frame = cq.Location(frame_of(node.placement))
    if node.children:
        branch = _bundle(node.children, name, color)
        branch.loc = frame
        return branch
    shape = cq.Shape.cast(node.shape)
    leaf = cq.Assembly(shape, loc=frame, name=name, color=None if color is None else cq.Color(*color))
    kinds = {"solid": shape.Solids, "shell": shape.Shells, "face": shape.Faces, "edge": shape.Edges}
    for (kind, index), own in node.subshape_colors.items():
        leaf.addSubshape(kinds[kind]()[index], color=cq.Color(*own))
    return leaf
