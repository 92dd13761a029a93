"""What holds the ends of a cable."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

from cablecad.errors import Mistake
from cablecad.model.values import RANGES, Checked, Vector, as_vector, number_mistakes, text_mistakes, vector_mistakes


@dataclass(frozen=True, slots=True)
class Pin(Checked):
    """An end held at a point and free to turn.

    Attributes:
        position: [mm].
    """

    position: Vector

    def __post_init__(self) -> None:
        self._set(position=as_vector(self.position))
        super(Pin, self).__post_init__()

    def _mistakes(self) -> Iterator[Mistake]:
        yield from vector_mistakes("position", self.position)


@dataclass(frozen=True, slots=True)
class Clamp(Checked):
    """An end held at a point and in its direction.

    Attributes:
        position: [mm].
        direction: The way of travel along the cable from its start to its end; of any length but zero.
        straight: Length of straight cable held by the connector before the free part begins [mm].
    """

    position: Vector
    direction: Vector
    straight: float = 0.0

    def __post_init__(self) -> None:
        self._set(position=as_vector(self.position), direction=as_vector(self.direction))
        super(Clamp, self).__post_init__()

    def _mistakes(self) -> Iterator[Mistake]:
        yield from vector_mistakes("position", self.position)
        yield from vector_mistakes("direction", self.direction, axis=True)
        yield from number_mistakes("straight", self.straight, RANGES["straight"])


@dataclass(frozen=True, slots=True)
class Port(Checked):
    """An end as a connector has it: a point and the axis that points out of the connector.

    Attributes:
        position: [mm].
        outward: Out of the connector, towards the free cable; of any length but zero. None makes it a pin.
        straight: Length of straight cable held by the connector before the free part begins [mm].
    """

    position: Vector
    outward: Vector | None = None
    straight: float = 0.0

    def __post_init__(self) -> None:
        self._set(position=as_vector(self.position), outward=as_vector(self.outward))
        super(Port, self).__post_init__()

    def _mistakes(self) -> Iterator[Mistake]:
        yield from vector_mistakes("position", self.position)
        if self.outward is not None:
            yield from vector_mistakes("outward", self.outward, axis=True)
        yield from number_mistakes("straight", self.straight, RANGES["straight"])
        if self.outward is None and self.straight:
            yield Mistake("straight", "needs an axis to run along: give outward or direction", self.straight)

    def support(self, *, at_end: bool) -> Clamp | Pin:
        """The support this port gives to a cable's start, or to its end, where the cable travels inward."""
        if self.outward is None:
            return Pin._trusted(position=self.position)
        x, y, z = self.outward
        direction = (-x, -y, -z) if at_end else (x, y, z)
        return Clamp._trusted(position=self.position, direction=direction, straight=self.straight)


@dataclass(frozen=True, slots=True)
class Toward(Checked):
    """The end of a cable pinned at both ends of which only the line is known, not the distance.

    Attributes:
        direction: From the start along the chord; of any length but zero. The chord is signed along it.
    """

    direction: Vector

    def __post_init__(self) -> None:
        self._set(direction=as_vector(self.direction))
        super(Toward, self).__post_init__()

    def _mistakes(self) -> Iterator[Mistake]:
        yield from vector_mistakes("toward", self.direction, axis=True)


@dataclass(frozen=True, slots=True)
class NamedPort(Checked):
    """A port of a part, by name, in the part's own coordinates; it moves with the part.

    Attributes:
        name: Unique within the part.
        position: [mm].
        outward: Out of the connector, towards the free cable; of any length but zero. None makes it a pin.
    """

    name: str
    position: Vector
    outward: Vector | None = None

    def __post_init__(self) -> None:
        self._set(position=as_vector(self.position), outward=as_vector(self.outward))
        super(NamedPort, self).__post_init__()

    def _mistakes(self) -> Iterator[Mistake]:
        yield from text_mistakes("name", self.name)
        yield from vector_mistakes("position", self.position)
        if self.outward is not None:
            yield from vector_mistakes("outward", self.outward, axis=True)


@dataclass(frozen=True, slots=True)
class PartPort(Checked):
    """An end on a part of the scene: at one of the part's named ports, or at the feature nearest to a point.

    A feature is a circular edge, a cylindrical face or a plane face; its centre and its axis out of the material are
    the port. Only a scene knows its parts, so `cablecad.solve` refuses such an end and `build_scene` takes it.

    Attributes:
        part: Name of the part.
        port: Name of one of the part's ports.
        near: Point in the part's own coordinates [mm], instead of `port`.
        straight: Length of straight cable held by the connector before the free part begins [mm].
    """

    part: str
    port: str | None = None
    near: Vector | None = None
    straight: float = 0.0

    def __post_init__(self) -> None:
        self._set(near=as_vector(self.near))
        super(PartPort, self).__post_init__()

    def _mistakes(self) -> Iterator[Mistake]:
        yield from text_mistakes("part", self.part)
        if self.port is not None and self.near is not None:
            yield Mistake("near", "give either port or near, and not both", self.near)
        elif self.port is not None:
            yield from text_mistakes("port", self.port)
        elif self.near is not None:
            yield from vector_mistakes("near", self.near)
        else:
            yield Mistake("part", "says nothing of the place on it: give port or near", self.part)
        yield from number_mistakes("straight", self.straight, RANGES["straight"])


_HOSTS, _FRAMES = ("cadquery", "build123d"), ("Location", "Plane")


def as_end(value: Any) -> Any:
    """A frame of CadQuery's or build123d's as a port, its z axis outward; anything else as it is."""
    kinds = {kind.__name__ for kind in type(value).__mro__ if kind.__module__.partition(".")[0] in _HOSTS}
    if kinds.isdisjoint(_FRAMES):
        return value
    return port_of_frame(value.wrapped if "Location" in kinds else value.location.wrapped)


def as_moved_end(value: Any, old: object) -> Any:
    """`as_end` of an end that moved: of a frame, which has none, the straight part is the one that was there."""
    port = as_end(value)
    straight = old.straight if isinstance(old, Clamp | Port | PartPort) else 0.0
    return replace(port, straight=straight) if port is not value and straight else port


def port_of_frame(location: Any) -> Port:
    """The port at a location of Open Cascade's, by the matrix it hands out: its origin, and its z axis as outward."""
    frame = location.Transformation()
    (x, px), (y, py), (z, pz) = ([float(frame.Value(row, column)) for column in (3, 4)] for row in (1, 2, 3))
    return Port((px, py, pz), (x, y, z))
