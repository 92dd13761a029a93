"""The keys of a scene file, format 1: their types, units, examples and ranges, as pydantic models.

The models know types and keys only. What the values of a cable demand of each other, and their ranges, is known to
`cablecad.model`; the JSON Schema made here reads the ranges from the same table, `cablecad.model.RANGES`.

No key is required by the models, so that a file can be read in spite of its mistakes: whether a key was given is told
by ``model_fields_set``, and only given keys may be read (the None of the others is not of the type they declare).
"""

from __future__ import annotations

import copy
from functools import cache
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Discriminator, Field, Tag, ValidationError, WrapValidator
from pydantic.json_schema import GenerateJsonSchema, JsonSchemaValue
from pydantic_core import PydanticCustomError, core_schema

from cablecad.model import COLOR, LEAST_TOLERANCE, RANGES, SHAPE_TOLERANCE

FORMAT = 1
"""The format of scene files this version reads."""

JsonDict = dict[str, Any]


def _keywords(key: str) -> JsonDict:
    """The range of a number as JSON Schema says it."""
    above, least, below, most = RANGES[key]
    bounds = {"exclusiveMinimum": above, "minimum": least, "exclusiveMaximum": below, "maximum": most}
    return {keyword: bound for keyword, bound in bounds.items() if bound is not None}


def _key(description: str, example: object, keywords: JsonDict | None = None, *, default: object = None) -> Any:
    """A key of a table; `keywords` go into the JSON Schema as they are, a default of None means there is none."""
    return Field(default=default, description=description, examples=[example], json_schema_extra=keywords)


def _else_say(problem: str) -> WrapValidator:
    """One mistake in plain words, whatever the types inside a union found."""

    def validate(value: object, inner: Any) -> object:
        try:
            return inner(value)
        except ValidationError:
            raise PydanticCustomError("in_words", problem) from None

    return WrapValidator(validate)


# A text of which something is seen, on one line.
_NAME = {"pattern": r"^[^\x00-\x1f\x7f]*[^\x00-\x1f\x7f\s][^\x00-\x1f\x7f]*$"}
# JSON Schema has no norm: an axis has a component that is not zero.
_AXIS = {"contains": {"not": {"const": 0}}}

Vector = Annotated[list[float], Field(min_length=3, max_length=3)]
Length = Annotated[float | Literal["shortest"], _else_say('must be a finite number of mm, or "shortest"')]


class Table(BaseModel):
    """A table of a scene file: strict types, finite numbers and no keys but its own."""

    model_config = ConfigDict(strict=True, extra="forbid", allow_inf_nan=False, defer_build=True)


class ToleranceTable(Table):
    """What the solids are held to."""

    model_config = ConfigDict(title="Tolerance")

    shape: float = _key(
        "Bound on the distance between a solid's side and the exact tube [mm].",
        0.001,
        {"minimum": LEAST_TOLERANCE},
        default=SHAPE_TOLERANCE,
    )


class MaterialTable(Table):
    """What a cable is made of; only forces, moments, energies and twist need it.

    By its moduli, or by the stiffnesses measured on the cable itself (a stranded cable is far softer than a solid rod).
    """

    model_config = ConfigDict(
        title="Material",
        json_schema_extra={
            "oneOf": [{"required": ["youngs_modulus"]}, {"required": ["bending_stiffness"]}],
            "not": {"required": ["poissons_ratio", "torsional_stiffness"]},
            "dependentRequired": {"poissons_ratio": ["youngs_modulus"]},
        },
    )

    youngs_modulus: float = _key(
        "Young's modulus of the solid circle of the cable's diameter [MPa].", 3890.0, _keywords("youngs_modulus")
    )
    poissons_ratio: float = _key(
        "Poisson's ratio (dimensionless); with youngs_modulus it gives the torsional stiffness.",
        0.25,
        _keywords("poissons_ratio"),
    )
    bending_stiffness: float = _key(
        "Bending stiffness EI as measured [N mm^2]; instead of youngs_modulus.",
        48883.0,
        _keywords("bending_stiffness"),
    )
    torsional_stiffness: float = _key(
        "Torsional stiffness GJ as measured [N mm^2]; instead of poissons_ratio.",
        39106.0,
        _keywords("torsional_stiffness"),
    )
    mass_per_length: float = _key(
        "Mass per length [kg/m]; only to judge whether gravity may be left out.", 0.02, _keywords("mass_per_length")
    )


class RotationTable(Table):
    """A turn about an axis through the part's origin, made before the part is moved."""

    model_config = ConfigDict(title="Rotation", json_schema_extra={"required": ["axis", "angle_deg"]})

    axis: Vector = _key("Axis of the turn, of any length but zero (dimensionless).", [0, 0, 1], _AXIS)
    angle_deg: float = _key("Angle of the turn, right-handed about the axis [degrees].", 90.0)


class PortTable(Table):
    """A place on a part where cables end, in the part's own coordinates: it moves with the part.

    A clamp where it has an axis (outward), else a pin.
    """

    model_config = ConfigDict(title="Port of a part", json_schema_extra={"required": ["name", "position"]})

    name: str = _key("Name, unique within the part.", "J1", _NAME)
    position: Vector = _key("Where the cable ends, in the part's own coordinates [mm].", [0, 0, 12.5])
    outward: Vector = _key(
        "Axis out of the part, towards the free cable, in the part's own coordinates; any length but zero "
        "(dimensionless).",
        [0, 0, 1],
        _AXIS,
    )


class PartTable(Table):
    """A rigid part read from a STEP file; its point x goes to rotation * x + position."""

    model_config = ConfigDict(title="Part", json_schema_extra={"required": ["name", "step"]})

    name: str = _key("Name, unique among cables and parts.", "plate", _NAME)
    step: str = _key("Path of the STEP file, relative to the scene file.", "parts/plate.step", {"minLength": 1})
    position: Vector = _key("Where the part's origin goes [mm].", [0, 0, 0], default=[0.0, 0.0, 0.0])
    rotation: RotationTable = _key(
        "Turn about the part's origin (angle in degrees).", {"axis": [0, 0, 1], "angle_deg": 90.0}
    )
    ports: list[PortTable] = _key(
        "Named places on the part where cables end, in its own coordinates [mm].",
        [{"name": "J1", "position": [0, 0, 12.5], "outward": [0, 0, 1]}],
    )


_POSITION = "Where the cable, with its straight part if it has one, begins or ends [mm]."
_OUTWARD = "Axis out of the connector, towards the free cable; of any length but zero (dimensionless)."
_DIRECTION = "Axis along the way of travel from start to end, instead of outward; any length but zero (dimensionless)."
_STRAIGHT = "Straight cable held by the connector before the free part begins; counts in length [mm]."
_TWO_AXES: JsonDict = {"required": ["outward", "direction"]}
_STRAIGHT_NEEDS_AXIS: JsonDict = {
    "anyOf": [
        {"required": ["outward"]},
        {"required": ["direction"]},
        {"properties": {"straight": {"maximum": 0}}},
    ]
}


_PLACES = ("position", "outward", "direction")
_ON_PART: JsonDict = {
    "required": ["part"],
    "oneOf": [{"required": ["port"]}, {"required": ["near"]}],
    "not": {"anyOf": [{"required": [key]} for key in (*_PLACES, "toward")]},
}
"""An end on a part: at a named port of it, or at the feature of its geometry that is nearest to a point."""


def _at_position(*others: str) -> JsonDict:
    """An end given by numbers."""
    others = ("part", "port", "near", *others)
    forbidden = [_TWO_AXES, *({"required": [key]} for key in others)]
    return {"required": ["position"], "not": {"anyOf": forbidden}, **_STRAIGHT_NEEDS_AXIS}


class StartTable(Table):
    """The start of a cable: a clamp where it has an axis (outward or direction), else a pin; or a port of a part."""

    model_config = ConfigDict(title="Start", json_schema_extra={"oneOf": [_at_position(), _ON_PART]})

    position: Vector = _key(_POSITION, [0, 0, 0])
    outward: Vector = _key(_OUTWARD, [0, 0, 1], _AXIS)
    direction: Vector = _key(_DIRECTION, [0, 0, 1], _AXIS)
    straight: float = _key(_STRAIGHT, 15.0, _keywords("straight"), default=0.0)
    part: str = _key("Name of the part the end is on, instead of position; with port or near.", "plate", _NAME)
    port: str = _key("Name of one of that part's ports.", "J1", _NAME)
    near: Vector = _key(
        "Instead of port: a point in that part's own coordinates. The end is at the circular edge, cylindrical face or "
        "plane face nearest to it: at its centre, with its axis out of the material. The distance to a feature is that "
        "to it or to its centre, whichever is less; an edge comes before the faces it bounds [mm].",
        [0, 0, 12.5],
    )


class EndTable(StartTable):
    """The end of a cable: as its start, or only the line it lies on (toward) where both ends are pinned."""

    model_config = ConfigDict(
        title="End",
        json_schema_extra={
            "oneOf": [_at_position("toward"), _ON_PART, {"required": ["toward"], "maxProperties": 1}],
        },
    )

    toward: Vector = _key(
        "Instead of position, for a cable pinned at both ends: from the start along the chord, whose length follows "
        "from two other data; of any length but zero (dimensionless).",
        [0, 0, 1],
        _AXIS,
    )


class EquilibriumTable(Table):
    """Names an equilibrium in a way that does not jump when the energies of two cross."""

    model_config = ConfigDict(title="Equilibrium")

    winding: int = _key("Full turns of the tangent beyond the least, from start to end (turns).", 0, default=0)
    side: int = _key("1: towards bulge, -1: away from it.", 1, {"enum": [-1, 1]}, default=1)


Equilibrium = Annotated[
    Annotated[
        int,
        _else_say("must be an index such as 0, or a table { winding = 0, side = 1 }"),
        Tag("index"),
    ]
    | Annotated[EquilibriumTable, Tag("table")],
    Discriminator(lambda value: "table" if isinstance(value, dict) else "index"),
]


class CableTable(Table):
    """A cable between two ends.

    With an axis at an end it needs length or slack. Pinned at both ends it is given by two independent data of length
    (or slack), chord, force, angle_deg, rise and bend_radius, where the distance of the ends is one of them.
    """

    model_config = ConfigDict(
        title="Cable",
        json_schema_extra={
            "required": ["name", "diameter", "start", "end"],
            "anyOf": [{"required": [key]} for key in ("length", "slack", "force", "angle_deg", "rise", "bend_radius")],
            "dependentRequired": {"force": ["material"]},
            "if": {"required": ["length"], "properties": {"length": {"const": "shortest"}}},
            "then": {"required": ["min_bend_radius"], "not": {"required": ["slack"]}},
        },
    )

    name: str = _key("Name, unique among cables and parts.", "W1", _NAME)
    diameter: float = _key("Outer diameter [mm].", 4.0, _keywords("diameter"))
    length: Length = _key(
        'Length [mm], or "shortest": the least that keeps min_bend_radius.', 350.0, _keywords("length")
    )
    slack: float = _key("(length - chord) / chord, instead of length (dimensionless).", 0.1, _keywords("slack"))
    chord: float = _key("Distance of the pinned ends [mm], signed along toward.", 300.0)
    force: float = _key("Compressive force along the chord of the pinned ends [N].", 4.2, _keywords("force"))
    angle_deg: float = _key("Angle between cable and chord at the pinned ends [degrees].", 40.0, _keywords("angle_deg"))
    rise: float = _key("Greatest distance of the pinned cable from its chord [mm].", 73.9, _keywords("rise"))
    bend_radius: float = _key(
        "The least bend radius of the pinned cable, exactly [mm].", 157.9, _keywords("bend_radius")
    )
    material: str = _key("Name of one of the materials; force needs it.", "pvc")
    color: str = _key("Colour, #rrggbb or #rrggbbaa.", "#2b6cb0", {"pattern": f"^{COLOR.pattern}$"})
    start: StartTable = _key(
        "Where the cable starts: position [mm] and axis.", {"position": [0, 0, 0], "outward": [0, 0, 1]}
    )
    end: EndTable = _key(
        "Where the cable ends: position [mm] and axis.", {"position": [0, 120, 0], "outward": [0, 0, 1]}
    )
    min_bend_radius: float = _key(
        "Least bend radius allowed [mm]: a rule to check, never an input of the shape.",
        20.0,
        _keywords("min_bend_radius"),
    )
    bulge: Vector = _key("The side to bend to where the ends leave it open (dimensionless).", [1, 0, 0], _AXIS)
    equilibrium: Equilibrium = _key(
        "Which of the equilibria found, by energy: an index, or a table { winding, side }.",
        0,
        {"minimum": 0},
        default=0,
    )
    allow_contact: bool = _key("Lets a cable through that touches itself, with a warning.", False, default=False)


class SceneTable(Table):
    """A scene of cablecad, format 1: cables, and the rigid parts beside them. Lengths are in mm."""

    model_config = ConfigDict(
        title="cablecad scene",
        json_schema_extra={
            "required": ["format"],
            "anyOf": [{"required": [kind], "properties": {kind: {"minItems": 1}}} for kind in ("cables", "parts")],
        },
    )

    format: int = _key("Version of this file format.", FORMAT, {"const": FORMAT})
    name: str = _key("Name of the assembly that is written.", "gearbox loom", _NAME, default="scene")
    tolerance: ToleranceTable = _key("What the solids are held to [mm].", {"shape": 0.001})
    materials: dict[str, MaterialTable] = _key(
        "The materials of the cables, by name.", {"pvc": {"youngs_modulus": 3890.0, "poissons_ratio": 0.25}}
    )
    parts: list[PartTable] = _key("Rigid parts, in order.", [{"name": "plate", "step": "parts/plate.step"}])
    cables: list[CableTable] = _key(
        "Cables, in order.",
        [
            {
                "name": "W1",
                "diameter": 4.0,
                "length": 350.0,
                "start": {"position": [0, 0, 0], "outward": [0, 0, 1]},
                "end": {"position": [0, 120, 0], "outward": [0, 0, 1]},
            }
        ],
    )


class _Draft(GenerateJsonSchema):
    """JSON Schema of a file in which a key is given or not: no nulls, and no titles that repeat the keys."""

    def default_schema(self, schema: core_schema.WithDefaultSchema) -> JsonSchemaValue:
        if schema.get("default") is None:
            return self.generate_inner(schema["schema"])
        return super().default_schema(schema)

    def field_title_should_be_set(self, schema: object) -> bool:  # noqa: ARG002 - the base's signature
        return False


@cache
def _schema() -> JsonDict:
    return {"$schema": _Draft.schema_dialect, **SceneTable.model_json_schema(schema_generator=_Draft)}


def scene_schema() -> JsonDict:
    """The JSON Schema (draft 2020-12) of a scene file, for editors and for checks outside of cablecad.

    It accepts every scene `load_scene` accepts. It cannot say all: that names are unique, that a material exists, and
    how many data a cable needs by its ends, is checked by `load_scene` alone.

    Returns:
        A new dict of JSON values.
    """
    return copy.deepcopy(_schema())
