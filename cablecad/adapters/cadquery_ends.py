"""What objects of CadQuery stand for as ends of a cable; `cadquery` lists them."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from typing import Any, get_args

import cadquery as cq

from cablecad.adapters.ends import End, known_end
from cablecad.brep.features import Feature, Kind, find_features
from cablecad.brep.kernel import subshapes
from cablecad.brep.ports import edge_port, face_port
from cablecad.errors import UsageError
from cablecad.model import Pin, Port, port_of_frame


def end_of(value: Any, key: str) -> End:
    """What an object of CadQuery, or of cablecad, or numbers stand for."""
    if isinstance(value, cq.Location):
        return port_of_frame(value.wrapped)
    if isinstance(value, cq.Plane):
        return Port(value.origin.toTuple(), value.zDir.toTuple())
    if isinstance(value, cq.Workplane):
        count = len(value.objects)
        if count > 1:
            raise UsageError(f"the {key} is a Workplane with {count} objects selected; select one face or edge")
        return selected_ends(value)[0]
    if isinstance(value, cq.Vector):
        return Pin(value.toTuple())
    if isinstance(value, cq.Shape):
        return _shape_end(value, None, key)
    if isinstance(value, tuple | list) and len(value) == 2 and isinstance(value[0], cq.Shape):
        return _shape_end(value[0], _whole(value[1], key), key)
    end = known_end(value)
    if end is None:
        raise UsageError(
            f"the {key} is a {type(value).__name__}, which is no end of a cable: give a cq.Location, cq.Plane, "
            "cq.Workplane with a face or edge selected, cq.Face, (edge, solid), a point, or (position, outward)"
        )
    return end


def _whole(value: Any, key: str) -> cq.Shape:
    """What a shape was given as a part of."""
    whole = value
    if isinstance(value, cq.Workplane):
        with suppress(ValueError):  # there is none
            whole = value.findSolid()
    if not isinstance(whole, cq.Shape):
        raise UsageError(
            f"the {key} is a shape with a {type(value).__name__}, in which there is no solid: give an edge as (edge, "
            "solid), and a position with its axis as two times three numbers"
        )
    return whole


def _shape_end(shape: Any, body: cq.Shape | None, key: str, features: Sequence[Feature] | None = None) -> End:
    """The end at a shape that was selected, of `body` where that is known."""
    whole = None if body is None else body.wrapped
    if isinstance(shape, cq.Vertex):
        return Pin(shape.toTuple())
    if isinstance(shape, cq.Face):
        return Port(*face_port(shape.wrapped, whole, features))
    if isinstance(shape, cq.Edge):
        if whole is None:
            raise UsageError(
                f"the {key} is an edge by itself, which does not tell on which side the material is: give it with its "
                "solid as (edge, solid), or give the Workplane in which it was selected"
            )
        return Port(*edge_port(shape.wrapped, whole, features))
    raise UsageError(f"the {key} is a {type(shape).__name__}; select one of its faces, circular edges or vertices")


def selected_ends(workplane: cq.Workplane) -> list[End]:
    """The end at each object on the stack; with an empty stack the one at the plane's origin."""
    plane = workplane.plane
    ends: list[End] = []
    # Of each body that was selected from, however many of its edges and faces were: looking takes time.
    features: dict[int, Sequence[Feature] | None] = {id(None): None}
    has_faces = any(isinstance(one, cq.Face) for one in workplane.objects)
    for one in workplane.objects or [plane.origin]:
        if isinstance(one, cq.Vector):
            ends.append(Port(one.toTuple(), plane.zDir.toTuple()))
        elif isinstance(one, cq.Location):  # on the plane, as CadQuery reads those of polarArray and pushPoints
            ends.append(port_of_frame((plane.location * one).wrapped))
        else:
            body = _body_of(one, workplane) if isinstance(one, cq.Face | cq.Edge) else None
            if body is not None and id(body) not in features:
                kinds: Sequence[Kind] = get_args(Kind) if has_faces else ["circular edge"]
                features[id(body)] = find_features(body.wrapped, kinds)
            ends.append(_shape_end(one, body, "end", features[id(body)]))
    return ends


def _body_of(shape: Any, workplane: cq.Workplane) -> cq.Shape | None:
    """What a shape was selected from, up the chain of operations."""
    node = workplane
    while node is not None:
        for whole in node.objects:
            if isinstance(whole, cq.Solid | cq.Compound | cq.Shell) and any(
                shape.wrapped.IsSame(one) for one in subshapes(whole.wrapped, shape.wrapped.ShapeType())
            ):
                return whole
        node = node.parent
    return None


def frame_of_end(end: End) -> cq.Location:
    """An end as a frame, its z axis outward where it has an axis."""
    if isinstance(end, Port) and end.outward is not None:
        return cq.Plane(cq.Vector(*end.position), normal=cq.Vector(*end.outward)).location
    return cq.Location(cq.Vector(*getattr(end, "position", (0.0, 0.0, 0.0))))
