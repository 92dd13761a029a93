"""Ends of a cable as scripts have them, for both hosts: frames of the kernel, numbers, and cablecad's own ends.

A frame's z axis is outward: out of the connector, towards the free cable.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from OCP.gp import gp_Dir, gp_Pnt, gp_Trsf

from cablecad.errors import SceneError, UsageError
from cablecad.model import Cable, Clamp, PartPort, Pin, Port, Toward, Vector
from cablecad.model.values import RANGES, as_vector, number_mistakes

End = Clamp | Pin | Port | Toward


def known_end(value: object) -> End | None:
    """An end of cablecad's own, or one written in numbers; None for anything else.

    Args:
        value: A `Port`, `Clamp`, `Pin` or `Toward`; three numbers, a pin; two times three, position and outward.

    Raises:
        UsageError: A `PartPort`: a script has no scene to look the part up in.
        SceneError: Numbers that are no place or no axis.
    """
    if isinstance(value, Clamp | Pin | Port | Toward):
        return value
    if isinstance(value, PartPort):
        raise UsageError(
            f"an end on part {value.part!r} needs a scene; in a script select the part's face or edge instead"
        )
    numbers = _numbers(value)
    if numbers is not None:
        return Pin(numbers)
    if isinstance(value, tuple | list) and len(value) == 2:
        position, outward = map(_numbers, value)
        if position is not None and outward is not None:
            return Port(position, outward)
    return None


def _numbers(value: object) -> Any:
    """Three numbers as a tuple, or None."""
    numbers = as_vector(value)
    fits = isinstance(numbers, tuple) and len(numbers) == 3 and all(isinstance(part, float) for part in numbers)
    return numbers if fits else None


def held(end: End, straight: float, key: str) -> End:
    """The end with a length of straight cable [mm] held by its connector, where one was asked for apart from it.

    Raises:
        SceneError: The length is no number of 0 or more.
        UsageError: The end has no axis, or a straight length of its own.
    """
    mistakes = list(number_mistakes(f"{key}_straight", straight, RANGES["straight"]))
    if mistakes:
        raise SceneError(mistakes)
    if not straight:
        return end
    if not isinstance(end, Clamp | Port) or not _has_axis(end):
        raise UsageError(f"{key}_straight = {straight:g} needs an end with an axis; give the {key} an axis")
    if end.straight:
        raise UsageError(f"{key}_straight = {straight:g} is given twice: the {key} has straight = {end.straight:g}")
    return replace(end, straight=straight)


def keep_straight(new: End, old: object) -> End:
    """An end that moved, with the straight part its connector held before."""
    straight = old.straight if isinstance(old, Clamp | Port) else 0.0
    if not straight or not isinstance(new, Clamp | Port) or new.straight or not _has_axis(new):
        return new
    return replace(new, straight=straight)


def _has_axis(end: End) -> bool:
    return isinstance(end, Clamp) or (isinstance(end, Port) and end.outward is not None)


def placed(end: End, location: Any, kind: type[Any]) -> End:
    """An end that was selected in a part's own coordinates, where a location of the host's `kind` has the part.

    Raises:
        UsageError: It is placed by something else; None leaves the part where it is.
    """
    if location is None:
        return end
    if not isinstance(location, kind):
        raise UsageError(f"a part is placed by a {kind.__name__}, not by a {type(location).__name__}")
    return seen_from(end, location.wrapped.Transformation())


def seen_from(end: End, frame: gp_Trsf) -> End:
    """The end after a rigid move."""
    if isinstance(end, Pin):
        return Pin(_moved_point(end.position, frame))
    if isinstance(end, Clamp):
        return Clamp(_moved_point(end.position, frame), _moved_axis(end.direction, frame), end.straight)
    if isinstance(end, Toward):
        return Toward(_moved_axis(end.direction, frame))
    outward = None if end.outward is None else _moved_axis(end.outward, frame)
    return Port(_moved_point(end.position, frame), outward, end.straight)


def _moved_point(point: Vector, frame: gp_Trsf) -> Vector:
    moved = gp_Pnt(*point).Transformed(frame)
    return moved.X(), moved.Y(), moved.Z()


def _moved_axis(axis: Vector, frame: gp_Trsf) -> Vector:
    moved = gp_Dir(*axis).Transformed(frame)
    return moved.X(), moved.Y(), moved.Z()


def asked_cable(name: str, start: End, end: End, diameter: float, data: dict[str, Any]) -> Cable:
    """The cable a script asked for.

    Args:
        name: Of the cable.
        start: Its start.
        end: Its end.
        diameter: [mm].
        data: The other fields of `cablecad.Cable`; vectors of the host are taken as three numbers.

    Raises:
        UsageError: There is no such field; names those there are.
        SceneError: Values that do not fit.
    """
    known = [key for key in Cable.__dataclass_fields__ if key not in ("name", "diameter", "start", "end")]
    unknown = [key for key in data if key not in known]
    if unknown:
        raise UsageError(
            f"a cable has no {', '.join(unknown)}; besides its ends and diameter it has {', '.join(known)}"
        )
    if data.get("bulge") is not None and not isinstance(data["bulge"], tuple | list):
        data["bulge"] = host_vector(data["bulge"])
    if isinstance(start, Toward):
        raise UsageError("`Toward` is for the end of a cable: its start needs a place")
    return Cable(name, diameter, start, end, **data)


def host_vector(value: Any) -> Any:
    """Three numbers of a vector of the host (with x, y, z or X, Y, Z); anything else as it is."""
    for keys in (("x", "y", "z"), ("X", "Y", "Z")):
        if all(hasattr(value, key) for key in keys):
            return tuple(float(getattr(value, key)) for key in keys)
    return value
