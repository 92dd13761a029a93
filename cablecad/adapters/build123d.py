"""Cables in build123d: part objects like any other, with what cablecad knows of them on board.

    from build123d import *
    from cablecad.adapters.build123d import Cable

    plate = Box(40, 40, 8) - Cylinder(3, 8)
    start = plate.edges().filter_by(GeomType.CIRCLE).sort_by(Axis.Z)[-1]   # the rim of the hole
    wire = Cable(start, Location((0, 120, 4)), diameter=4, length=350, name="W1", color="#2b6cb0")
    wire.report["bend_radius_min"], wire.solution.points(200), wire.joints["end"].location
    wire.moved(end=Location((0, 125, 4)))                                  # solved again
    export_step(Compound(children=[plate, wire]), "loom.step")

An end is a `Location` or `Plane` (its z axis is outward, out of the connector); a `Joint` (the same of its location);
a `Face` or circular `Edge` that was selected from a part (its centre, and its axis out of the part); a `Vertex`,
`Vector` or three numbers (a pin: free to turn); position and outward, three numbers each; or a `cablecad.Port`,
`Clamp`, `Pin` or `Toward`. Nothing of build123d is patched.
"""

from __future__ import annotations

import copy
from typing import Any

from cablecad.errors import MissingDependencyError, UsageError

try:
    import build123d as b3d
except ModuleNotFoundError as error:
    if error.name != "build123d":
        import cablecad.brep.kernel  # noqa: F401 - says what to install where Open Cascade is what is missing

        raise
    raise MissingDependencyError("build123d is not installed: pip install build123d") from error

from cablecad.adapters.ends import End, asked_cable, held, keep_straight, known_end, placed
from cablecad.adapters.results import CableResults, Results
from cablecad.brep.ports import edge_port, face_port
from cablecad.model import SHAPE_TOLERANCE, Pin, Port, port_of_frame
from cablecad.pipeline import Built, build

__all__ = ["Cable", "port"]


class Cable(CableResults, b3d.BasePartObject):
    """Part Object: Cable, a flexible cable between two ends, in the shape elasticity gives it.

    `report`, `solution`, `cable`, `built` and `write_step` are those of `cablecad`; copies and moved ones keep them.

    Args:
        start (Location | Plane | Joint | Face | Edge | Vertex | VectorLike): where it starts; z axes are outward. A
            cable built by `cablecad.build`, without `end`, is taken as it is.
        end: where it ends
        diameter (float): outer diameter
        name (str, optional): for the report and the label. Defaults to "cable"
        start_straight (float, optional): length of straight cable the start's connector holds, part of the length.
            Defaults to 0
        end_straight (float, optional): the same at the end. Defaults to 0
        tolerance (float, optional): bound on the distance between the solid's side and the exact tube. Defaults to
            0.001
        rotation (RotationLike, optional): angles to rotate about axes. Defaults to (0, 0, 0)
        align (Align | tuple[Align, Align, Align] | None, optional): align MIN, CENTER, or MAX of object. Defaults to
            None: the cable is where its ends are
        mode (Mode, optional): combine mode. Defaults to Mode.ADD
        data: the other fields of `cablecad.Cable`: length, slack, color, material, min_bend_radius, bulge, ...

    Joints:
        "start" (Rigid): where the cable starts; its z axis is outward, out of the connector and along the cable
        "end" (Rigid): where it ends; its z axis is outward too, so it points into the cable

    Raises:
        CablecadError: As `cablecad.build`.
    """

    _applies_to = b3d.BasePartObject._applies_to

    def __init__(
        self,
        start: Any,
        end: Any = None,
        diameter: float | None = None,
        *,
        name: str = "cable",
        start_straight: float = 0.0,
        end_straight: float = 0.0,
        tolerance: float = SHAPE_TOLERANCE,
        rotation: Any = (0, 0, 0),
        align: Any = None,
        mode: Any = b3d.Mode.ADD,
        **data: Any,
    ) -> None:
        frames: list[b3d.Location | None] = [None, None]
        if isinstance(start, Built):
            built = start
        else:
            if diameter is None:
                raise UsageError("a cable needs its diameter: Cable(start, end, diameter=..., length=...)")
            frames = [_own_frame(start), _own_frame(end)]
            ends = held(_end(start, "start"), start_straight, "start"), held(_end(end, "end"), end_straight, "end")
            built = build(asked_cable(name, *ends, diameter, data), tolerance=tolerance)
        solid = b3d.Solid(built.solid.wrapped)
        solid.label = built.name
        super().__init__(part=solid, rotation=rotation, align=align, mode=mode)
        self._results = Results(built, tolerance)
        self.label = built.name
        if built.cable.color is not None:
            self.color = b3d.Color(built.cable.color)
        placement = b3d.Location(self._placement())  # by rotation and align
        self._set_joints(*(None if frame is None else placement * frame for frame in frames))

    def moved(self, loc: Any = None, *, start: Any = None, end: Any = None, length: float | None = None) -> Any:
        """Move a copy as a whole, as `Shape.moved`; or an end of the cable, which is then solved again.

        Args:
            loc (Location | Plane): new location relative to the current one.
            start: Where the cable starts instead, as for `Cable`; its straight part stays as it is.
            end: Where it ends instead.
            length: Its length instead [mm].

        Returns:
            A new object: the same equilibrium, followed to the moved ends; or the same solid elsewhere.

        Raises:
            UsageError: A whole move and a move of an end at once.
            CablecadError: As `cablecad.RodSolution.moved` and `cablecad.build`.
        """
        if start is None and end is None and length is None:
            return super().moved(loc)
        if loc is not None:
            raise UsageError("moved() moves the cable as a whole or its ends, not both; call it twice")
        asked = self.cable
        ends = [
            None if new is None else keep_straight(_end(new, key), old)
            for key, new, old in (("start", start, asked.start), ("end", end, asked.end))
        ]
        placement = self._placement()
        results = self.results.solved_again(placement, ends[0], ends[1], length)
        # Not a call of the class: within a builder that would publish the object a second time.
        again = copy.deepcopy(self)
        again._results = results
        solid = b3d.Solid(results.built.solid.wrapped.Moved(placement))
        solid.label = self.label
        again.wrapped = b3d.Compound([solid]).wrapped
        again.joints.clear()
        again._set_joints(
            *(
                self.joints[key].location if new is None else _own_frame(new)
                for key, new in (("start", start), ("end", end))
            )
        )
        return again

    def _set_joints(self, start: Any, end: Any) -> None:
        """Rigid joints at both ends; a frame that is known is taken as it is, x axis too."""
        placement = b3d.Location(self._placement())
        states = self.solution.equilibrium.start, self.solution.equilibrium.end
        for label, state, way, frame in (("start", states[0], 1.0, start), ("end", states[1], -1.0, end)):
            origin, axis = b3d.Vector(*state.position.tolist()), b3d.Vector(*(way * state.direction).tolist())
            own = placement * b3d.Plane(origin, z_dir=axis).location
            b3d.RigidJoint(label, self, own if frame is None else frame)


def port(end: Any, location: b3d.Location | None = None) -> Any:
    """The end of a cable that a build123d object stands for.

    Args:
        end: As for `Cable`.
        location: Where the object's own part is placed, for one that was selected in the part's own coordinates.

    Returns:
        A `cablecad.Port`, `Clamp`, `Pin` or `Toward`.

    Raises:
        UsageError: The object stands for no end.
        GeometryError: A face or edge without an axis, or with one that may point either way.
    """
    return placed(_end(end, "end"), location, b3d.Location)


def _own_frame(value: Any) -> b3d.Location | None:
    """The frame an object has of its own, x axis and all; None where only a place and an axis are known."""
    if isinstance(value, b3d.Location):
        return value
    return value.location if isinstance(value, b3d.Plane | b3d.Joint) else None


def _end(value: Any, key: str) -> End:
    """What an object of build123d, or of cablecad, or numbers stand for."""
    if isinstance(value, b3d.ShapeList):
        if len(value) != 1:
            raise UsageError(f"the {key} is a list of {len(value)} shapes; take one of them, such as [-1]")
        value = value[0]
    frame = _own_frame(value)
    if frame is not None:
        return port_of_frame(frame.wrapped)
    if isinstance(value, b3d.Vertex | b3d.Vector):
        return Pin((value.X, value.Y, value.Z))
    if isinstance(value, b3d.Face | b3d.Edge):
        whole = value.topo_parent
        find = face_port if isinstance(value, b3d.Face) else edge_port
        return Port(*find(value.wrapped, None if whole is None else whole.wrapped))
    if isinstance(value, b3d.Shape):
        raise UsageError(f"the {key} is a {type(value).__name__}; select one of its faces, circular edges or vertices")
    end = known_end(value)
    if end is None:
        raise UsageError(
            f"the {key} is a {type(value).__name__}, which is no end of a cable: give a Location, Plane, Joint, Face, "
            "circular Edge, a point, or (position, outward)"
        )
    return end
