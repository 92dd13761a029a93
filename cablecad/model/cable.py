"""A cable: its ends, and the data that say how long it is.

`cable_mistakes` makes the checks of a cable on one of which only some values could be read, so that one pass over a
scene file finds all its mistakes.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Set
from dataclasses import dataclass
from typing import Literal

from cablecad.errors import Mistake, SceneError
from cablecad.model.ends import Clamp, PartPort, Pin, Port, Toward, as_end
from cablecad.model.section import Material, Section, stiffness_mistakes
from cablecad.model.values import (
    ANY_NUMBER,
    COLOR,
    RANGES,
    Checked,
    Vector,
    as_vector,
    number_mistakes,
    text_mistakes,
    vector_mistakes,
)

PINNED_DATA = ("chord", "force", "angle_deg", "rise", "bend_radius")
"""What only a cable pinned at both ends may give besides its length or slack."""

LENGTH_DATA = ("length", "slack", *PINNED_DATA)
"""The data of which a cable needs one, two or three, as its ends demand."""


@dataclass(frozen=True, slots=True)
class EquilibriumKey(Checked):
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
class Cable(Checked):
    """A cable between two ends.

    A cable pinned at both ends is given by any two independent data of `length` (or `slack`), `chord`, `force`,
    `angle_deg`, `rise` and `bend_radius`; the distance of its ends is one of them unless the end is a `Toward`.

    Attributes:
        name: Unique in a scene.
        diameter: [mm].
        start: Clamp, Pin, Port or PartPort at arclength 0; a `Location` or `Plane` of CadQuery or build123d is a Port.
        end: Clamp, Pin, Port, PartPort or Toward at arclength `length`; or such a frame.
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
    start: Clamp | Pin | Port | PartPort
    end: Clamp | Pin | Port | PartPort | Toward
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
        self._set(bulge=as_vector(self.bulge), start=as_end(self.start), end=as_end(self.end))
        super(Cable, self).__post_init__()

    def _mistakes(self) -> Iterator[Mistake]:
        yield from cable_mistakes({key: getattr(self, key) for key in self.__slots__})
        for key in ("equilibrium", "allow_contact"):  # which always have a value
            if getattr(self, key) is None:
                yield from _cable_value(key, None)

    def between(self, start: Clamp | Pin | Port | PartPort, end: Clamp | Pin | Port | PartPort, length: float) -> Cable:
        """The same cable of a given length [mm] between other ends, its other data of length left out.

        Only what is new is checked: the rest was when this cable was made.

        Raises:
            SceneError: An end that is none, or a length that is no positive number.
        """
        given = {"start": start, "end": end, "length": length}
        mistakes = [mistake for key, value in given.items() for mistake in _cable_value(key, value)]
        if mistakes:
            raise SceneError(mistakes)
        values = {key: getattr(self, key) for key in self.__slots__}
        return self._trusted(**{**values, **dict.fromkeys(LENGTH_DATA), **given})

    @property
    def section(self) -> Section:
        """The cross-section."""
        return Section._trusted(diameter=self.diameter)

    @property
    def start_support(self) -> Clamp | Pin:
        """What holds the start, with its axis as the way of travel."""
        return _support(self.start, at_end=False) if isinstance(self.start, Port | PartPort) else self.start

    @property
    def end_support(self) -> Clamp | Pin | Toward:
        """What holds the end, with its axis as the way of travel."""
        return _support(self.end, at_end=True) if isinstance(self.end, Port | PartPort) else self.end

    @property
    def is_pinned(self) -> bool:
        """Whether both ends are free to turn: the cable of the paper."""
        return not _is_held(self.start, self.end)


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
    # Whether a port of a part has an axis is known to the scene, which checks the cable again when it has looked.
    known = {key: value for key, value in known.items() if not (isinstance(value, PartPort) and value.near is None)}
    yield from _need_mistakes(known, present)
    yield from _end_mistakes(known, present)


_CABLE_VALUES: Mapping[str, tuple[Callable[[object], bool], str]] = {
    "start": (lambda value: isinstance(value, Clamp | Pin | Port | PartPort), "must be a Clamp, Pin, Port or PartPort"),
    "end": (
        lambda value: isinstance(value, Clamp | Pin | Port | PartPort | Toward),
        "must be a Clamp, Pin, Port, PartPort or Toward",
    ),
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
        yield from text_mistakes(key, value)
    elif key == "bulge":
        yield from vector_mistakes(key, value, axis=True)
    elif key == "length" and isinstance(value, str):
        if value != "shortest":
            yield Mistake(key, 'must be a number of mm or "shortest"', value)
    else:
        yield from number_mistakes(key, value, RANGES.get(key, ANY_NUMBER), sized=True)


def _need_mistakes(known: Mapping[str, object], present: Set[str]) -> Iterator[Mistake]:
    """What one datum of a cable needs of the others, whatever its ends."""
    if _is_shortest(known):
        if "min_bend_radius" not in present:
            yield Mistake("length", 'needs min_bend_radius, the rule "shortest" keeps', "shortest")
        pinned = not _is_held(known.get("start"), known.get("end"))
        for key in ("slack", *(PINNED_DATA[1:] if pinned else ())):  # a chord goes with the ends
            if key in present:
                yield Mistake(key, 'goes against length = "shortest": give one of them', known.get(key, ...))
    diameter, material = known.get("diameter"), known.get("material")
    if isinstance(material, Material) and isinstance(diameter, int | float):
        yield from stiffness_mistakes(material, diameter)
    if "force" in known and "material" not in present and not _is_held(known.get("start"), known.get("end")):
        yield Mistake("force", "needs a material with a bending stiffness", known["force"])


def _end_mistakes(known: Mapping[str, object], present: Set[str]) -> Iterator[Mistake]:
    """How the ends and the data of a cable go together; an end that is not `known` may be of any kind."""
    end = known.get("end")
    data = [key for key in LENGTH_DATA if key in present]
    shortest = _is_shortest(known)
    if _is_held(known.get("start"), known.get("end")):
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


def _is_shortest(known: Mapping[str, object]) -> bool:
    length = known.get("length")
    return isinstance(length, str) and length == "shortest"


def _is_held(*ends: object) -> bool:
    """Whether one of a cable's ends has an axis, as any port of a part may: then it is not pinned at both ends."""
    return any(isinstance(end, Clamp | PartPort) or (isinstance(end, Port) and end.outward is not None) for end in ends)


def _support(end: Port | PartPort, *, at_end: bool) -> Clamp | Pin:
    """What a port gives to an end of a cable."""
    if isinstance(end, Port):
        return end.support(at_end=at_end)
    problem = f"is a port of part {end.part!r}, which only a scene knows: build or solve the cable in a Scene with it"
    raise SceneError([Mistake("end" if at_end else "start", problem)])
