"""A scene: cables and the rigid parts beside them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from os import PathLike, fspath
from pathlib import Path

from cablecad.errors import Mistake, SceneError
from cablecad.model.cable import Cable
from cablecad.model.ends import NamedPort
from cablecad.model.ports import end_mistakes, port_name_mistakes
from cablecad.model.values import (
    POSITIVE,
    Checked,
    Vector,
    as_vector,
    number_mistakes,
    text_mistakes,
    unit,
    vector_mistakes,
)

SHAPE_TOLERANCE = 1e-3
"""Default bound on the distance between a solid's side and the exact tube [mm]."""

LEAST_TOLERANCE = 1e-9
"""No tolerance below this is accepted [mm]; far from the origin `tolerance_floor` is higher."""


def tolerance_floor(reach: float) -> float:
    """The least tolerance double precision can keep [mm], `reach` being |position| + length of the cable [mm]."""
    return max(LEAST_TOLERANCE, 2e-14 * reach)


@dataclass(frozen=True, slots=True)
class Rotation(Checked):
    """A turn about an axis through the origin.

    Attributes:
        axis: Of any length but zero.
        angle_deg: Right-handed about the axis [degrees].
    """

    axis: Vector = (0.0, 0.0, 1.0)
    angle_deg: float = 0.0

    def __post_init__(self) -> None:
        self._set(axis=as_vector(self.axis))
        super(Rotation, self).__post_init__()

    def _mistakes(self) -> Iterator[Mistake]:
        yield from vector_mistakes("axis", self.axis, axis=True)
        yield from number_mistakes("angle_deg", self.angle_deg)

    @property
    def rows(self) -> tuple[Vector, Vector, Vector]:
        """The rows of its matrix, by Rodrigues' formula; exact for quarter turns about an axis of coordinates."""
        x, y, z = axis = unit(self.axis)
        angle = math.remainder(self.angle_deg, 360.0)
        quarters = round(angle / 90.0)
        # cos and sin of what is left beyond whole quarter turns, then turned: cos(pi/2) must be 0, not 6e-17.
        rest = math.radians(angle - 90.0 * quarters)
        cosine, sine = math.cos(rest), math.sin(rest)
        for _ in range(quarters % 4):
            cosine, sine = -sine, cosine
        cross = ((0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0))

        def row(i: int) -> Vector:
            a, b, c = (
                cosine * (1.0 if i == j else 0.0) + sine * cross[i][j] + (1.0 - cosine) * (axis[i] * axis[j])
                for j in range(3)
            )
            return a, b, c

        return row(0), row(1), row(2)

    def turned(self, vector: Vector) -> Vector:
        """`vector` after the turn."""
        a, b, c = vector
        x, y, z = (row[0] * a + row[1] * b + row[2] * c for row in self.rows)
        return x, y, z


@dataclass(frozen=True, slots=True)
class Part(Checked):
    """A rigid part read from a STEP file; its point x goes to rotation * x + position.

    Attributes:
        name: Unique in a scene.
        step: Path of the STEP file.
        position: [mm].
        rotation: Turn about the part's origin, made before the move.
        ports: Where cables may end on it, in its own coordinates.
    """

    name: str
    step: Path
    position: Vector = (0.0, 0.0, 0.0)
    rotation: Rotation = Rotation()
    ports: tuple[NamedPort, ...] = ()

    def __init__(
        self,
        name: str,
        step: str | PathLike[str],
        position: Vector = (0.0, 0.0, 0.0),
        rotation: Rotation | None = None,
        ports: Iterable[NamedPort] = (),
    ) -> None:
        self._set(
            name=name,
            step=Path(fspath(step)),
            position=as_vector(position),
            rotation=rotation if rotation is not None else Rotation(),
            ports=tuple(ports),
        )
        self.__post_init__()

    def _mistakes(self) -> Iterator[Mistake]:
        yield from text_mistakes("name", self.name)
        if self.step == Path() or "\0" in str(self.step):
            yield Mistake("step", "must be the path of a STEP file", str(self.step))
        yield from vector_mistakes("position", self.position)
        yield from port_name_mistakes([port.name for port in self.ports])

    def placed(self, point: Vector) -> Vector:
        """Where a point of the part is in the scene [mm]."""
        x, y, z = (a + b for a, b in zip(self.rotation.turned(point), self.position, strict=True))
        return x, y, z


@dataclass(frozen=True, slots=True)
class Scene(Checked):
    """Cables and the rigid parts beside them.

    Attributes:
        name: Of the assembly that is written.
        cables: In the order of the file.
        parts: In the order of the file.
        tolerance: Bound on the distance between a solid's side and the exact tube [mm].
        source: The file it came from, or None.
    """

    name: str = "scene"
    cables: tuple[Cable, ...] = ()
    parts: tuple[Part, ...] = ()
    tolerance: float = SHAPE_TOLERANCE
    source: Path | None = None

    def __post_init__(self) -> None:
        self._set(cables=tuple(self.cables), parts=tuple(self.parts))
        super(Scene, self).__post_init__()

    def _mistakes(self) -> Iterator[Mistake]:
        cables, parts = ([thing.name for thing in things] for things in (self.cables, self.parts))
        yield from scene_mistakes(self.name, self.tolerance, cables, parts)
        ports = {part.name: [port.name for port in part.ports] for part in self.parts}
        for cable in self.cables:
            for key, end in (("start", cable.start), ("end", cable.end)):
                yield from (mistake.under(f"cables.{cable.name}.{key}") for mistake in end_mistakes(end, ports))

    def with_cables(self, cables: Iterable[Cable]) -> Scene:
        """The same scene with other cables of the same names, and with the same ends where those are on parts.

        Cables are checked when they are made, so that nothing is new to the scene.
        """
        values = {key: getattr(self, key) for key in self.__slots__}
        return self._trusted(**{**values, "cables": tuple(cables)})

    @property
    def inputs(self) -> tuple[Path, ...]:
        """Every file the scene reads."""
        own = () if self.source is None else (self.source,)
        return own + tuple(part.step for part in self.parts)


def scene_mistakes(
    name: object, tolerance: object, cables: Sequence[str | None], parts: Sequence[str | None]
) -> Iterator[Mistake]:
    """What is wrong with a scene beside what is wrong inside its cables and parts, of which only the names are asked.

    A name that could not be read is None.
    """
    yield from text_mistakes("name", name)
    yield from tolerance_mistakes(tolerance)
    yield from name_mistakes(cables, parts)
    if not cables and not parts:
        yield Mistake("cables", "is empty: a scene needs at least one cable or part")


def tolerance_mistakes(tolerance: object) -> Iterator[Mistake]:
    """What is wrong with a shape tolerance, before the cable's size is known."""
    found = list(number_mistakes("tolerance.shape", tolerance, POSITIVE))
    yield from found
    if not found and float(tolerance) < LEAST_TOLERANCE:  # type: ignore[arg-type]
        yield Mistake("tolerance.shape", f"is below the floor of {LEAST_TOLERANCE:g} mm", tolerance)


def checked_tolerance(tolerance: float) -> float:
    """A shape tolerance [mm] that was given by itself.

    Raises:
        SceneError: It is no number above 1e-9.
    """
    mistakes = list(tolerance_mistakes(tolerance))
    if mistakes:
        raise SceneError(mistakes)
    return float(tolerance)


def name_mistakes(cables: Sequence[str | None], parts: Sequence[str | None]) -> Iterator[Mistake]:
    """Names that more than one cable or part has; None is a name that could not be read."""
    first: dict[str, str] = {}
    for kind, names in (("parts", parts), ("cables", cables)):
        for i, name in enumerate(names):
            place = f"{kind}[{i}]"
            if name is None:
                continue
            if name in first:
                yield Mistake(f"{place}.name", f"is also the name of {first[name]}; names must be unique", name)
            else:
                first[name] = place
