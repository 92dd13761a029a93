"""What holds the ends of a cable."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from cablecad.errors import Mistake
from cablecad.model.values import RANGES, Checked, Vector, as_vector, number_mistakes, vector_mistakes


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
