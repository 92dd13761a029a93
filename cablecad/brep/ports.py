"""The port nearest to a point, among the features of a shape; and the ports of an edge or a face that was selected.

The distance to a feature is that to it or to its centre, whichever is less: a hole is meant by a point on its rim and
by one in its middle. As in a CAD package's own picking, an edge comes before the faces it bounds, here within a
twentieth of its radius. Nothing is guessed: where a second port is as near, or less than a tenth farther, or where
both ways along the axis are free, the error lists what there is.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from cablecad.brep.features import Feature, bounding_box, find_features
from cablecad.brep.kernel import occ_errors, silence

# isort: split
from OCP.Bnd import Bnd_Box
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeVertex
from OCP.BRepExtrema import BRepExtrema_DistShapeShape
from OCP.gp import gp_Pnt
from OCP.TopAbs import TopAbs_ShapeEnum
from OCP.TopoDS import TopoDS_Shape

from cablecad.brep.rounds import circle_of
from cablecad.centreline import Array
from cablecad.errors import GeometryError, Mistake, SceneError
from cablecad.model import Vector

_EDGE_FIRST = 0.05
"""Within this share of its radius an edge comes before a face that is nearer."""

_CLEARLY = 0.9
"""The nearest port is meant if its distance is below this share of the next one's."""

_EQUAL = 1e-6
"""Distances, places [mm] and directions closer than this are one."""

_MIDDLE = 0.01
"""Within this share of its length from its middle a point does not tell the ends of a cylinder apart."""

_LISTED = 6
"""So many candidates an error names."""


@dataclass(frozen=True)
class FoundPort:
    """A port of a feature.

    Attributes:
        position: [mm].
        outward: Unit vector out of the material.
        distance: Of the feature or its centre from the point asked for [mm].
        feature: What it is the port of.
    """

    position: Vector
    outward: Vector
    distance: float
    feature: Feature

    def __str__(self) -> str:
        radius = "" if self.feature.radius is None else f" of radius {self.feature.radius:.6g} mm"
        return (
            f"{self.feature.kind}{radius} at {_shown(self.position)}, outward {_shown(self.outward)}, "
            f"{self.distance:.4g} mm away"
        )


def nearest_port(shape: TopoDS_Shape, near: Vector, features: Sequence[Feature] | None = None) -> FoundPort:
    """The port of the feature nearest to a point.

    Args:
        shape: A part, all its bodies placed.
        near: Point in the shape's own coordinates [mm].
        features: Of the shape, where they were found before.

    Raises:
        SceneError: At the path ``near``: there is no feature, or more than one is meant; lists the candidates.
        GeometryError: Open Cascade failed.
    """
    ports = _ports_by_distance(find_features(shape) if features is None else features, near)
    if not ports:
        problem = "the part has no circular edge, cylindrical or plane face; write position and outward instead"
        raise _no_port(near, problem)
    size = float(bounding_box(shape).SquareExtent()) ** 0.5
    if ports[0].distance > size:
        problem = (
            f"is {ports[0].distance:.6g} mm away from every feature, farther than the part is large ({size:.6g} mm): "
            f"write it in the part's own coordinates; the nearest are: {_listed(ports)}"
        )
        raise _no_port(near, problem)
    chosen = min((port for port in ports if _comes_before(port, ports[0])), key=_distance_of, default=ports[0])
    rivals = [
        port
        for port in ports
        if port is chosen
        or (port.distance * _CLEARLY <= chosen.distance + _EQUAL and not _is_bound(port.feature, chosen.feature))
    ]
    if len(rivals) > 1:
        problem = (
            f"{len(rivals)} ports are as near, in the part's own coordinates: {_listed(rivals)}; move the point "
            "clearly to the one that is meant, or name it under the part's ports by its position and outward"
        )
        raise _no_port(near, problem)
    return chosen


def _comes_before(port: FoundPort, nearest: FoundPort) -> bool:
    """Whether an edge is meant though a face it bounds is nearer."""
    slack = _EDGE_FIRST * (port.feature.radius or 0.0)
    return port.distance <= nearest.distance + slack and _is_bound(nearest.feature, port.feature)


def _is_bound(face: Feature, edge: Feature) -> bool:
    return any(shape.IsSame(bound) for shape in face.shapes for bound in edge.bounds)


def _distance_of(port: FoundPort) -> float:
    return port.distance


def _no_port(near: Vector, problem: str) -> SceneError:
    return SceneError([Mistake("near", problem, list(near))])


def _listed(ports: Sequence[FoundPort]) -> str:
    return "; ".join(map(str, ports[:_LISTED]))


def _shown(vector: Vector) -> str:
    # + 0.0: no minus zero
    return "[" + ", ".join(f"{round(part, 9) + 0.0:.6g}" for part in vector) + "]"


def _ports_by_distance(features: Sequence[Feature], near: Vector) -> list[FoundPort]:
    """The ports that may be among the nearest, the nearest first; of those at one place with one axis, the first."""
    with silence(), occ_errors(GeometryError, "measuring the features of a part", "give position and outward"):
        measured = list(_measured(features, np.array(near)))
    # Of equal distances but for rounding the edge comes first, as in `features`: its centre is the truer one.
    order = {id(feature): i for i, feature in enumerate(features)}
    measured.sort(key=lambda pair: (round(pair[0] / _EQUAL), order[id(pair[1])]))
    ports: list[FoundPort] = []
    for distance, feature in measured:
        for way in _ways(feature, near):
            outward = _vector(way * feature.axis)
            if not any(_same(port, feature.position, outward) for port in ports):
                ports.append(FoundPort(_vector(feature.position), outward, distance, feature))
    return ports


def _measured(features: Sequence[Feature], near: Array) -> Iterator[tuple[float, Feature]]:
    """Features with their distances, all of them that may be among the nearest."""
    point = Bnd_Box()
    point.Set(gp_Pnt(*near.tolist()))
    bounds = []
    for feature in features:
        to_centre = float(np.linalg.norm(feature.position - near))
        to_boxes = min(float(bounding_box(shape).Distance(point)) for shape in feature.shapes)
        bounds.append((min(to_centre, to_boxes), to_centre, feature))
    bounds.sort(key=lambda bound: bound[0])
    vertex = BRepBuilderAPI_MakeVertex(gp_Pnt(*near.tolist())).Vertex()
    best, count = float("inf"), 0
    for least, to_centre, feature in bounds:
        edge_first = _EDGE_FIRST * feature.radius if feature.kind == "circular edge" and feature.radius else 0.0
        if count >= _LISTED and least * _CLEARLY > best + _EQUAL and least > best + edge_first:
            continue
        distance = min(to_centre, *(_distance(vertex, shape) for shape in feature.shapes))
        best, count = min(best, distance), count + 1
        yield distance, feature


def _distance(vertex: TopoDS_Shape, shape: TopoDS_Shape) -> float:
    measure = BRepExtrema_DistShapeShape(vertex, shape)
    return float(measure.Value()) if measure.IsDone() else float("inf")


def _ways(feature: Feature, near: Vector) -> tuple[int, ...]:
    """Out of the material; of a cylinder that is open at both ends towards the end that is nearer to the point.

    Of one that is closed at both ends neither is better, and both are candidates.
    """
    if feature.kind == "cylindrical face" and len(feature.ways) > 1:
        along = float((np.array(near) - feature.position) @ feature.axis)
        if abs(along) > _MIDDLE * feature.extent:
            return (1,) if along > 0.0 else (-1,)
    return feature.ways or (1, -1)


def _same(port: FoundPort, position: Array, outward: Vector) -> bool:
    slack = _EQUAL * (1.0 + float(np.abs(position).max()) * 1e-3)
    apart = float(np.linalg.norm(np.subtract(port.position, position)))
    return apart < slack and float(np.linalg.norm(np.subtract(port.outward, outward))) < _EQUAL


def _vector(array: Array) -> Vector:
    x, y, z = (array + 0.0).tolist()  # + 0.0: no minus zero
    return x, y, z


# --- features that were selected in a script ----------------------------------------------------------------------


def edge_port(
    edge: TopoDS_Shape, body: TopoDS_Shape | None = None, features: Sequence[Feature] | None = None
) -> tuple[Vector, Vector]:
    """Centre and axis of a circular edge, the axis out of the material.

    Args:
        edge: On a circle.
        body: What it is an edge of, whole; without it the circle's own axis is taken.
        features: Of the body, where they were found before.

    Raises:
        GeometryError: The edge is on no circle, or both ways along its axis are free.
    """
    if edge.ShapeType() != TopAbs_ShapeEnum.TopAbs_EDGE:
        raise GeometryError("an end of a cable is at an edge or a face; this is neither")
    own = circle_of(edge)
    if own is None:
        raise GeometryError(
            "the edge is no circle, so it has no centre and axis; select a circular edge or a plane face"
        )
    if body is None:
        return _vector(own.centre), _vector(own.axis)
    for feature in find_features(body, ["circular edge"]) if features is None else features:
        if feature.kind == "circular edge" and any(shape.IsSame(edge) for shape in feature.shapes):
            return _only_port(feature)
    raise GeometryError(
        "the edge is no feature of its body: less than half a circle, or on no face; give the end by position and axis"
    )


def face_port(
    face: TopoDS_Shape, body: TopoDS_Shape | None = None, features: Sequence[Feature] | None = None
) -> tuple[Vector, Vector]:
    """Middle and normal of a plane face, or middle and axis of a cylindrical one, out of the material.

    Args:
        face: Plane or cylindrical.
        body: What it is a face of, whole; the open end of a cylinder can be told only with it.
        features: Of the body, where they were found before.

    Raises:
        GeometryError: The face is of another kind, or a cylinder that is open at both ends.
    """
    whole = face if body is None else body
    for feature in find_features(whole, ["cylindrical face", "plane face"]) if features is None else features:
        if feature.kind != "circular edge" and any(shape.IsSame(face) for shape in feature.shapes):
            return _only_port(feature)
    raise GeometryError(
        "the face is neither plane nor at least half a cylinder, so it has no axis; select a plane face or a circular "
        "edge, or give the end by position and axis"
    )


def _only_port(feature: Feature) -> tuple[Vector, Vector]:
    if len(feature.ways) != 1:
        state = "open" if feature.ways else "closed"
        raise GeometryError(
            f"the {feature.kind} at {_shown(_vector(feature.position))} is {state} on both sides, so its axis may "
            "point either way; select the circular edge of the mouth that is meant, or give the end by position and "
            "axis"
        )
    return _vector(feature.position), _vector(feature.ways[0] * feature.axis)
