"""The vocabulary: what a scene is made of, as frozen dataclasses that know no mechanics and no CAD.

Units: mm, N, MPa, N mm^2; degrees in names ending ``_deg``. Every object checks itself when it is made and raises
`SceneError` with all of its mistakes at once. `cable_mistakes` makes the same checks on a cable of which only some
values could be read, so that one pass over a scene file finds all its mistakes.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass
from os import PathLike, fspath
from pathlib import Path
from typing import Literal, NamedTuple

from cablecad.errors import Mistake, SceneError

Vector = tuple[float, float, float]

SHAPE_TOLERANCE = 1e-3
"""Default bound on the distance between a solid's side and the exact tube [mm]."""

LEAST_TOLERANCE = 1e-9
"""No tolerance below this is accepted [mm]; far from the origin `tolerance_floor` is higher."""

PINNED_DATA = ("chord", "force", "angle_deg", "rise", "bend_radius")
"""What only a cable pinned at both ends may give besides its length or slack."""

LENGTH_DATA = ("length", "slack", *PINNED_DATA)
"""The data of which a cable needs one, two or three, as its ends demand."""

COLOR = re.compile(r"#(?:[0-9a-fA-F]{6}|[0-9a-fA-F]{8})")
"""What a colour looks like."""


class Range(NamedTuple):
    """The finite numbers a value may be; None leaves a side open."""

    above: float | None = None
    least: float | None = None
    below: float | None = None
    most: float | None = None


_ANY = Range()
_POSITIVE = Range(above=0.0)

RANGES = {
    **dict.fromkeys(("diameter", "length", "slack", "force", "rise", "bend_radius", "min_bend_radius"), _POSITIVE),
    "angle_deg": Range(above=0.0, below=180.0),  # of a cable's ends: a rotation's angle may be any
    "straight": Range(least=0.0),
    **dict.fromkeys(("youngs_modulus", "bending_stiffness", "torsional_stiffness", "mass_per_length"), _POSITIVE),
    "poissons_ratio": Range(above=-1.0, most=0.5),  # what elasticity allows an isotropic material
}
"""The range of every number that has one, by its key: for the checks here and for the schema of scene files."""


def tolerance_floor(reach: float) -> float:
    """The least tolerance double precision can keep [mm], `reach` being |position| + length of the cable [mm]."""
    return max(LEAST_TOLERANCE, 2e-14 * reach)


# --- checks of single values, each yielding what is wrong ---------------------------------------------------------


def _is_finite(value: float) -> bool:
    try:
        return math.isfinite(value)
    except OverflowError:  # a whole number beyond the largest double
        return False


def _number(path: str, value: object, allowed: Range = _ANY) -> Iterator[Mistake]:
    """Check that `value` is a finite number in its range."""
    above, least, below, most = allowed
    if isinstance(value, bool) or not isinstance(value, int | float):
        yield Mistake(path, "must be a number", value)
    elif not _is_finite(value):
        yield Mistake(path, "must be a finite number", value)
    elif above is not None and value <= above:
        yield Mistake(path, f"must be greater than {above:g}", value)
    elif least is not None and value < least:
        yield Mistake(path, f"must be {least:g} or more", value)
    elif below is not None and value >= below:
        yield Mistake(path, f"must be less than {below:g}", value)
    elif most is not None and value > most:
        yield Mistake(path, f"must be {most:g} or less", value)


def _vector(path: str, value: object, *, axis: bool = False) -> Iterator[Mistake]:
    """Check that `value` is three finite numbers, and not all zero where it is an axis."""
    if not isinstance(value, Sequence) or isinstance(value, str) or len(value) != 3:
        yield Mistake(path, "must be three numbers [x, y, z]", value)
        return
    mistakes = [m for i, part in enumerate(value) for m in _number(f"{path}[{i}]", part)]
    yield from mistakes
    if axis and not mistakes and math.hypot(*value) == 0.0:
        yield Mistake(path, "an axis must not be zero; write a direction such as [0, 0, 1]", value)


def _name(path: str, value: object) -> Iterator[Mistake]:
    if not isinstance(value, str) or not value.strip():
        yield Mistake(path, "must be a text that is not empty", value)
    elif any(ord(c) < 32 or ord(c) == 127 for c in value):
        yield Mistake(path, "must not contain control characters such as line breaks or tabs", value)


def _as_vector(value: object) -> object:
    """The numbers of any sequence (a numpy array too) as a tuple of floats; anything else unchanged."""
    if not isinstance(value, Iterable) or isinstance(value, str | bytes):
        return value
    parts = tuple(value)
    if any(isinstance(part, str | bytes | bool) for part in parts):  # float() would read "4" and True
        return value
    try:
        return tuple(float(part) for part in parts)
    except (TypeError, ValueError, OverflowError):
        return value


def unit(vector: Vector) -> Vector:
    """`vector` scaled to length one, safe for components near the limits of a double."""
    largest = max(abs(part) for part in vector)
    scaled = [part / largest for part in vector]
    norm = math.hypot(*scaled)
    x, y, z = (part / norm for part in scaled)
    return x, y, z


class _Checked:
    """Base of the dataclasses that refuse to be made with mistakes in them."""

    __slots__ = ()

    def __post_init__(self) -> None:
        mistakes = list(self._mistakes())
        if mistakes:
            raise SceneError(mistakes)

    def _mistakes(self) -> Iterator[Mistake]:
        raise NotImplementedError  # pragma: no cover - every subclass defines it

    def _set(self, **values: object) -> None:
        for key, value in values.items():
            object.__setattr__(self, key, value)


# --- section and material -----------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Section(_Checked):
    """A solid circular cross-section.

    Attributes:
        diameter: Outer diameter [mm].
    """

    diameter: float

    def _mistakes(self) -> Iterator[Mistake]:
        yield from _number("diameter", self.diameter, RANGES["diameter"])

    @property
    def radius(self) -> float:
        """Outer radius [mm]."""
        return self.diameter / 2.0

    @property
    def area(self) -> float:
        """Area [mm^2]."""
        return math.pi * self.radius**2

    @property
    def second_moment(self) -> float:
        """Second moment of area about a diameter [mm^4]."""
        return math.pi * self.diameter**4 / 64.0


@dataclass(frozen=True, slots=True)
class Material(_Checked):
    """What the cable is made of: by its moduli, or by the stiffnesses measured on the cable itself.

    A stranded cable is far softer than a solid rod of its diameter: measured stiffnesses are the better input.

    Attributes:
        youngs_modulus: Young's modulus of the solid circle of the cable's diameter [MPa].
        poissons_ratio: Poisson's ratio; with `youngs_modulus` it gives the torsional stiffness.
        bending_stiffness: EI as measured [N mm^2]; instead of `youngs_modulus`.
        torsional_stiffness: GJ as measured [N mm^2].
        mass_per_length: [kg/m], only to judge whether gravity may be left out.
    """

    youngs_modulus: float | None = None
    poissons_ratio: float | None = None
    bending_stiffness: float | None = None
    torsional_stiffness: float | None = None
    mass_per_length: float | None = None

    def _mistakes(self) -> Iterator[Mistake]:
        yield from material_mistakes({key: getattr(self, key) for key in self.__slots__})

    def EI(self, section: Section) -> float:
        """Bending stiffness [N mm^2]."""
        if self.bending_stiffness is not None:
            return self.bending_stiffness
        assert self.youngs_modulus is not None  # one of the two was checked to be there
        return self.youngs_modulus * section.second_moment

    def GJ(self, section: Section) -> float | None:
        """Torsional stiffness [N mm^2], or None where nothing tells it."""
        if self.torsional_stiffness is not None:
            return self.torsional_stiffness
        if self.poissons_ratio is None:
            return None
        return self.EI(section) / (1.0 + self.poissons_ratio)


def material_mistakes(given: Mapping[str, object], unreadable: Collection[str] = ()) -> Iterator[Mistake]:
    """What is wrong with a material of which `given` are the readable values by field name.

    A check that needs a value of a field of `unreadable` is left out: its mistake was reported where it was read.
    """
    known = {key: value for key, value in given.items() if value is not None and key not in unreadable}
    present = {*known, *unreadable}
    for key, value in known.items():
        yield from _number(key, value, RANGES[key])
    if len({"youngs_modulus", "bending_stiffness"} & present) != 1:
        yield Mistake("", "give either youngs_modulus or bending_stiffness, and not both")
    if "poissons_ratio" in known:
        if "torsional_stiffness" in present:
            problem = "give either poissons_ratio or torsional_stiffness, and not both"
            yield Mistake("poissons_ratio", problem, known["poissons_ratio"])
        elif "youngs_modulus" not in present:
            yield Mistake(
                "poissons_ratio", "needs youngs_modulus; or give torsional_stiffness", known["poissons_ratio"]
            )


# --- ends ---------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Pin(_Checked):
    """An end held at a point and free to turn.

    Attributes:
        position: [mm].
    """

    position: Vector

    def __post_init__(self) -> None:
        self._set(position=_as_vector(self.position))
        super(Pin, self).__post_init__()

    def _mistakes(self) -> Iterator[Mistake]:
        yield from _vector("position", self.position)


@dataclass(frozen=True, slots=True)
class Clamp(_Checked):
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
        self._set(position=_as_vector(self.position), direction=_as_vector(self.direction))
        super(Clamp, self).__post_init__()

    def _mistakes(self) -> Iterator[Mistake]:
        yield from _vector("position", self.position)
        yield from _vector("direction", self.direction, axis=True)
        yield from _number("straight", self.straight, RANGES["straight"])


@dataclass(frozen=True, slots=True)
class Port(_Checked):
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
        self._set(position=_as_vector(self.position), outward=_as_vector(self.outward))
        super(Port, self).__post_init__()

    def _mistakes(self) -> Iterator[Mistake]:
        yield from _vector("position", self.position)
        if self.outward is not None:
            yield from _vector("outward", self.outward, axis=True)
        yield from _number("straight", self.straight, RANGES["straight"])
        if self.outward is None and self.straight:
            yield Mistake("straight", "needs an axis to run along: give outward or direction", self.straight)

    def support(self, *, at_end: bool) -> Clamp | Pin:
        """The support this port gives to a cable's start, or to its end, where the cable travels inward."""
        if self.outward is None:
            return Pin(self.position)
        x, y, z = self.outward
        return Clamp(self.position, (-x, -y, -z) if at_end else (x, y, z), self.straight)


@dataclass(frozen=True, slots=True)
class Toward(_Checked):
    """The end of a cable pinned at both ends of which only the line is known, not the distance.

    Attributes:
        direction: From the start along the chord; of any length but zero. The chord is signed along it.
    """

    direction: Vector

    def __post_init__(self) -> None:
        self._set(direction=_as_vector(self.direction))
        super(Toward, self).__post_init__()

    def _mistakes(self) -> Iterator[Mistake]:
        yield from _vector("toward", self.direction, axis=True)


# --- cable, part, scene -------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class EquilibriumKey(_Checked):
    """Names an equilibrium in a way that does not jump when the energies of two cross.

    Attributes:
        winding: Full turns of the tangent beyond the least, from start to end.
        side: +1 or -1: towards `bulge`, or away from it.
    """

    winding: int = 0
    side: int = 1

    def _mistakes(self) -> Iterator[Mistake]:
        if isinstance(self.winding, bool) or not isinstance(self.winding, int):
            yield Mistake("winding", "must be a whole number", self.winding)
        if isinstance(self.side, bool) or not isinstance(self.side, int) or self.side not in (-1, 1):
            yield Mistake("side", "must be 1 or -1", self.side)


@dataclass(frozen=True, slots=True)
class Cable(_Checked):
    """A cable between two ends.

    A cable pinned at both ends is given by any two independent data of `length` (or `slack`), `chord`, `force`,
    `angle_deg`, `rise` and `bend_radius`; the distance of its ends is one of them unless the end is a `Toward`.

    Attributes:
        name: Unique in a scene.
        diameter: [mm].
        start: Clamp, Pin or Port at arclength 0.
        end: Clamp, Pin, Port or Toward at arclength `length`.
        length: [mm], or "shortest" for the least length that keeps `min_bend_radius`.
        slack: (length - chord) / chord, instead of `length`.
        chord: Distance of the ends [mm], signed along `Toward`.
        force: Compressive force along the chord [N]; needs a material.
        angle_deg: Angle between tangent and chord at the ends [degrees].
        rise: Greatest distance from the chord [mm].
        bend_radius: The least bend radius, exactly [mm].
        material: Only forces, moments, energies and twist need it.
        color: ``#rrggbb`` or ``#rrggbbaa``.
        min_bend_radius: A rule to check, never an input of the shape [mm].
        bulge: The side to bend to where the ends leave it open.
        equilibrium: Which of the equilibria found: an index, or a key that does not jump.
        allow_contact: Lets a cable through that touches itself, with a warning.
    """

    name: str
    diameter: float
    start: Clamp | Pin | Port
    end: Clamp | Pin | Port | Toward
    length: float | Literal["shortest"] | None = None
    slack: float | None = None
    chord: float | None = None
    force: float | None = None
    angle_deg: float | None = None
    rise: float | None = None
    bend_radius: float | None = None
    material: Material | None = None
    color: str | None = None
    min_bend_radius: float | None = None
    bulge: Vector | None = None
    equilibrium: int | EquilibriumKey = 0
    allow_contact: bool = False

    def __post_init__(self) -> None:
        self._set(bulge=_as_vector(self.bulge))
        super(Cable, self).__post_init__()

    def _mistakes(self) -> Iterator[Mistake]:
        yield from cable_mistakes({key: getattr(self, key) for key in self.__slots__})

    @property
    def section(self) -> Section:
        """The cross-section."""
        return Section(self.diameter)

    @property
    def start_support(self) -> Clamp | Pin:
        """What holds the start, with its axis as the way of travel."""
        return self.start.support(at_end=False) if isinstance(self.start, Port) else self.start

    @property
    def end_support(self) -> Clamp | Pin | Toward:
        """What holds the end, with its axis as the way of travel."""
        return self.end.support(at_end=True) if isinstance(self.end, Port) else self.end

    @property
    def is_pinned(self) -> bool:
        """Whether both ends are free to turn: the cable of the paper."""
        return isinstance(self.start_support, Pin) and isinstance(self.end_support, Pin | Toward)


def cable_mistakes(given: Mapping[str, object], unreadable: Collection[str] = ()) -> Iterator[Mistake]:
    """What is wrong with a cable of which `given` are the readable values by field name.

    A field of `unreadable` counts as given, and a check that needs its value is left out: its mistake was reported
    where it was read. Of an end that could not be read whole, any end of the same kind may stand in `given`.
    """
    known = {key: value for key, value in given.items() if value is not None and key not in unreadable}
    present = {*known, *unreadable}
    for key in ("name", "diameter", "start", "end"):
        if key not in present:
            yield Mistake(key, "is missing; a cable needs a name, a diameter, a start and an end")
    for key, value in known.items():
        yield from _cable_value(key, value)
    yield from _need_mistakes(known, present)
    yield from _end_mistakes(known, present)


_CABLE_VALUES: Mapping[str, tuple[Callable[[object], bool], str]] = {
    "start": (lambda value: isinstance(value, Clamp | Pin | Port), "must be a Clamp, a Pin or a Port"),
    "end": (lambda value: isinstance(value, Clamp | Pin | Port | Toward), "must be a Clamp, Pin, Port or Toward"),
    "material": (lambda value: isinstance(value, Material), "must be a Material"),
    "color": (
        lambda value: isinstance(value, str) and COLOR.fullmatch(value) is not None,
        "must be #rrggbb or #rrggbbaa, such as #2b6cb0",
    ),
    "equilibrium": (
        lambda value: (
            isinstance(value, EquilibriumKey) or (isinstance(value, int) and not isinstance(value, bool) and value >= 0)
        ),
        "must be an index of 0 or more, or a table { winding, side }",
    ),
    "allow_contact": (lambda value: isinstance(value, bool), "must be true or false"),
}
"""The values of a cable that are no numbers: what they must be."""


def _cable_value(key: str, value: object) -> Iterator[Mistake]:
    """Check one value of a cable by itself."""
    if key in _CABLE_VALUES:
        fits, problem = _CABLE_VALUES[key]
        if not fits(value):
            yield Mistake(key, problem, value)
    elif key == "name":
        yield from _name(key, value)
    elif key == "bulge":
        yield from _vector(key, value, axis=True)
    elif key == "length" and isinstance(value, str):
        if value != "shortest":
            yield Mistake(key, 'must be a number of mm or "shortest"', value)
    else:
        yield from _number(key, value, RANGES.get(key, _ANY))


def _need_mistakes(known: Mapping[str, object], present: Set[str]) -> Iterator[Mistake]:
    """What one datum of a cable needs of the others, whatever its ends."""
    if known.get("length") == "shortest":
        if "min_bend_radius" not in present:
            yield Mistake("length", 'needs min_bend_radius, the rule "shortest" keeps', "shortest")
        if "slack" in present:
            yield Mistake("slack", 'goes against length = "shortest": give one of them', known.get("slack", ...))
    if "force" in known and "material" not in present and not _is_held(known):
        yield Mistake("force", "needs a material with a bending stiffness", known["force"])


def _end_mistakes(known: Mapping[str, object], present: Set[str]) -> Iterator[Mistake]:
    """How the ends and the data of a cable go together; an end that is not `known` may be of any kind."""
    end = known.get("end")
    data = [key for key in LENGTH_DATA if key in present]
    shortest = known.get("length") == "shortest"
    if _is_held(known):
        for key in PINNED_DATA:
            if key in known:
                yield Mistake(key, "is for a cable pinned at both ends; here an end has an axis", known[key])
        if isinstance(end, Toward):
            yield Mistake("end.toward", "needs a start that is pinned: leave out the start's axis")
        if not {"length", "slack"} & present:
            yield Mistake("length", 'is missing; give length, slack or length = "shortest"')
        if {"length", "slack"} <= present and not shortest:
            yield Mistake("slack", "give either length or slack, and not both", known.get("slack", ...))
    elif isinstance(end, Toward):
        if shortest:
            yield Mistake("length", '"shortest" needs an end with a position', "shortest")
        elif len(data) < 2 or not set(data) - {"slack", "angle_deg"}:
            listed = ", ".join(data) or "none"
            yield Mistake(
                "length",
                "an end with `toward` needs two data of length (or slack), chord, force, angle_deg, rise and "
                f"bend_radius, one of them not slack or angle_deg; given: {listed}",
                known.get("length", ...),
            )
    elif not set(data) - {"chord"}:
        if not {"start", "end"} <= known.keys():
            yield Mistake("length", "is missing; give length or slack")
        else:
            yield Mistake("length", "is missing; give length, slack, force, angle_deg, rise or bend_radius")


def _is_held(known: Mapping[str, object]) -> bool:
    """Whether an end of a cable has an axis, so that the cable is not pinned at both ends."""
    ends = (known.get("start"), known.get("end"))
    return any(isinstance(end, Clamp) or (isinstance(end, Port) and end.outward is not None) for end in ends)


@dataclass(frozen=True, slots=True)
class Rotation(_Checked):
    """A turn about an axis through the origin.

    Attributes:
        axis: Of any length but zero.
        angle_deg: Right-handed about the axis [degrees].
    """

    axis: Vector = (0.0, 0.0, 1.0)
    angle_deg: float = 0.0

    def __post_init__(self) -> None:
        self._set(axis=_as_vector(self.axis))
        super(Rotation, self).__post_init__()

    def _mistakes(self) -> Iterator[Mistake]:
        yield from _vector("axis", self.axis, axis=True)
        yield from _number("angle_deg", self.angle_deg)


@dataclass(frozen=True, slots=True)
class Part(_Checked):
    """A rigid part read from a STEP file; its point x goes to rotation * x + position.

    Attributes:
        name: Unique in a scene.
        step: Path of the STEP file.
        position: [mm].
        rotation: Turn about the part's origin, made before the move.
    """

    name: str
    step: Path
    position: Vector = (0.0, 0.0, 0.0)
    rotation: Rotation = Rotation()

    def __init__(
        self,
        name: str,
        step: str | PathLike[str],
        position: Vector = (0.0, 0.0, 0.0),
        rotation: Rotation | None = None,
    ) -> None:
        self._set(
            name=name,
            step=Path(fspath(step)),
            position=_as_vector(position),
            rotation=rotation if rotation is not None else Rotation(),
        )
        self.__post_init__()

    def _mistakes(self) -> Iterator[Mistake]:
        yield from _name("name", self.name)
        if self.step == Path() or "\0" in str(self.step):
            yield Mistake("step", "must be the path of a STEP file", self.step)
        yield from _vector("position", self.position)


@dataclass(frozen=True, slots=True)
class Scene(_Checked):
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
    yield from _name("name", name)
    yield from tolerance_mistakes(tolerance)
    yield from name_mistakes(cables, parts)
    if not cables and not parts:
        yield Mistake("cables", "is empty: a scene needs at least one cable or part")


def tolerance_mistakes(tolerance: object) -> Iterator[Mistake]:
    """What is wrong with a shape tolerance, before the cable's size is known."""
    found = list(_number("tolerance.shape", tolerance, _POSITIVE))
    yield from found
    if not found and float(tolerance) < LEAST_TOLERANCE:  # type: ignore[arg-type]
        yield Mistake("tolerance.shape", f"is below the floor of {LEAST_TOLERANCE:g} mm", tolerance)


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
