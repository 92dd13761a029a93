"""The keys of a scene file, format 1: their types, units, examples and ranges.

The tables know types and keys only. What the values of a cable demand of each other, and their ranges, is known to
`cablecad.model`; the JSON Schema reads the ranges from the same table, `cablecad.model.RANGES`.

No key is required, so that a file can be read in spite of its mistakes.
"""

from __future__ import annotations

from cablecad.model import COLOR, LARGEST, LEAST_TOLERANCE, RANGES, SHAPE_TOLERANCE, SMALLEST
from cablecad.scene.keys import (
    FLAG,
    NUMBER,
    TEXT,
    VECTOR,
    WHOLE,
    JsonDict,
    Key,
    Table,
    a_table,
    index_or_table,
    list_of,
    named,
    number_or_word,
)

FORMAT = 1
"""The format of scene files this version reads."""


def _range(key: str) -> JsonDict:
    """The range of a number as JSON Schema says it."""
    above, least, below, most = RANGES[key]
    if above == 0.0:
        above = SMALLEST
    if below is None and most is None:
        below = LARGEST
    bounds = {"exclusiveMinimum": above, "minimum": least, "exclusiveMaximum": below, "maximum": most}
    return {keyword: bound for keyword, bound in bounds.items() if bound is not None}


# A text on one line, without blanks around it.
_NAME = {"pattern": r"^[^\x00-\x1f\x7f\s]([^\x00-\x1f\x7f]*[^\x00-\x1f\x7f\s])?$"}
# JSON Schema has no norm: an axis has a component that is not zero.
_AXIS = {"contains": {"not": {"const": 0}}}

TOLERANCE = Table(
    "ToleranceTable",
    "Tolerance",
    "What the solids are held to.",
    {
        "shape": Key(
            NUMBER,
            "Bound on the distance between a solid's side and the exact tube [mm].",
            0.001,
            {"minimum": LEAST_TOLERANCE},
            default=SHAPE_TOLERANCE,
        ),
    },
)

MATERIAL = Table(
    "MaterialTable",
    "Material",
    (
        "What a cable is made of; only forces, moments, energies and twist need it.\n\n"
        "By its moduli, or by the stiffnesses measured on the cable itself (a stranded cable is far softer than a "
        "solid rod)."
    ),
    {
        "youngs_modulus": Key(
            NUMBER,
            "Young's modulus of the solid circle of the cable's diameter [MPa].",
            3890.0,
            _range("youngs_modulus"),
        ),
        "poissons_ratio": Key(
            NUMBER,
            "Poisson's ratio (dimensionless); with youngs_modulus it gives the torsional stiffness.",
            0.25,
            _range("poissons_ratio"),
        ),
        "bending_stiffness": Key(
            NUMBER,
            "Bending stiffness EI as measured [N mm^2]; instead of youngs_modulus.",
            48883.0,
            _range("bending_stiffness"),
        ),
        "torsional_stiffness": Key(
            NUMBER,
            "Torsional stiffness GJ as measured [N mm^2]; instead of poissons_ratio.",
            39106.0,
            _range("torsional_stiffness"),
        ),
        "mass_per_length": Key(
            NUMBER,
            "Mass per length [kg/m]; only to judge whether gravity may be left out.",
            0.02,
            _range("mass_per_length"),
        ),
    },
    {
        "oneOf": [{"required": ["youngs_modulus"]}, {"required": ["bending_stiffness"]}],
        "not": {"required": ["poissons_ratio", "torsional_stiffness"]},
        "dependentRequired": {"poissons_ratio": ["youngs_modulus"]},
    },
)

ROTATION = Table(
    "RotationTable",
    "Rotation",
    "A turn about an axis through the part's origin, made before the part is moved.",
    {
        "axis": Key(VECTOR, "Axis of the turn, of any length but zero (dimensionless).", [0, 0, 1], _AXIS),
        "angle_deg": Key(NUMBER, "Angle of the turn, right-handed about the axis [degrees].", 90.0),
    },
    {"required": ["axis", "angle_deg"]},
)

PORT = Table(
    "PortTable",
    "Port of a part",
    (
        "A place on a part where cables end, in the part's own coordinates: it moves with the part.\n\n"
        "A clamp where it has an axis (outward), else a pin."
    ),
    {
        "name": Key(TEXT, "Name, unique within the part.", "J1", _NAME),
        "position": Key(VECTOR, "Where the cable ends, in the part's own coordinates [mm].", [0, 0, 12.5]),
        "outward": Key(
            VECTOR,
            "Axis out of the part, towards the free cable, in the part's own coordinates; any length but zero "
            "(dimensionless).",
            [0, 0, 1],
            _AXIS,
        ),
    },
    {"required": ["name", "position"]},
)

PART = Table(
    "PartTable",
    "Part",
    "A rigid part read from a STEP file; its point x goes to rotation * x + position.",
    {
        "name": Key(TEXT, "Name, unique among cables and parts.", "plate", _NAME),
        "step": Key(TEXT, "Path of the STEP file, relative to the scene file.", "parts/plate.step", {"minLength": 1}),
        "position": Key(VECTOR, "Where the part's origin goes [mm].", [0, 0, 0], default=[0.0, 0.0, 0.0]),
        "rotation": Key(
            a_table(ROTATION),
            "Turn about the part's origin (angle in degrees).",
            {"axis": [0, 0, 1], "angle_deg": 90.0},
        ),
        "ports": Key(
            list_of(PORT),
            "Named places on the part where cables end, in its own coordinates [mm].",
            [{"name": "J1", "position": [0, 0, 12.5], "outward": [0, 0, 1]}],
        ),
    },
    {"required": ["name", "step"]},
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


START = Table(
    "StartTable",
    "Start",
    "The start of a cable: a clamp where it has an axis (outward or direction), else a pin; or a port of a part.",
    {
        "position": Key(VECTOR, _POSITION, [0, 0, 0]),
        "outward": Key(VECTOR, _OUTWARD, [0, 0, 1], _AXIS),
        "direction": Key(VECTOR, _DIRECTION, [0, 0, 1], _AXIS),
        "straight": Key(NUMBER, _STRAIGHT, 15.0, _range("straight"), default=0.0),
        "part": Key(TEXT, "Name of the part the end is on, instead of position; with port or near.", "plate", _NAME),
        "port": Key(TEXT, "Name of one of that part's ports.", "J1", _NAME),
        "near": Key(
            VECTOR,
            "Instead of port: a point in that part's own coordinates. The end is at the circular edge, cylindrical "
            "face or plane face nearest to it: at its centre, with its axis out of the material. The distance to a "
            "feature is that to it or to its centre, whichever is less; an edge comes before the faces it bounds [mm].",
            [0, 0, 12.5],
        ),
    },
    {"oneOf": [_at_position(), _ON_PART]},
)

END = Table(
    "EndTable",
    "End",
    "The end of a cable: as its start, or only the line it lies on (toward) where both ends are pinned.",
    {
        **START.keys,
        "toward": Key(
            VECTOR,
            "Instead of position, for a cable pinned at both ends: from the start along the chord, whose length "
            "follows from two other data; of any length but zero (dimensionless).",
            [0, 0, 1],
            _AXIS,
        ),
    },
    {
        "oneOf": [_at_position("toward"), _ON_PART, {"required": ["toward"], "maxProperties": 1}],
    },
)

EQUILIBRIUM = Table(
    "EquilibriumTable",
    "Equilibrium",
    "Names an equilibrium in a way that does not jump when the energies of two cross.",
    {
        "winding": Key(WHOLE, "Full turns of the tangent beyond the least, from start to end (turns).", 0, default=0),
        "side": Key(WHOLE, "1: towards bulge, -1: away from it.", 1, {"enum": [-1, 1]}, default=1),
    },
)

CABLE = Table(
    "CableTable",
    "Cable",
    (
        "A cable between two ends.\n\n"
        "With an axis at an end it needs length or slack. Pinned at both ends it is given by two independent data of "
        "length (or slack), chord, force, angle_deg, rise and bend_radius, where the distance of the ends is one of "
        "them."
    ),
    {
        "name": Key(TEXT, "Name, unique among cables and parts.", "W1", _NAME),
        "diameter": Key(NUMBER, "Outer diameter [mm].", 4.0, _range("diameter")),
        "length": Key(
            number_or_word("shortest", 'must be a finite number of mm, or "shortest"'),
            'Length [mm], or "shortest": the least that keeps min_bend_radius.',
            350.0,
            _range("length"),
        ),
        "slack": Key(NUMBER, "(length - chord) / chord, instead of length (dimensionless).", 0.1, _range("slack")),
        "chord": Key(NUMBER, "Distance of the pinned ends [mm], signed along toward.", 300.0),
        "force": Key(NUMBER, "Compressive force along the chord of the pinned ends [N].", 4.2, _range("force")),
        "angle_deg": Key(
            NUMBER, "Angle between cable and chord at the pinned ends [degrees].", 40.0, _range("angle_deg")
        ),
        "rise": Key(NUMBER, "Greatest distance of the pinned cable from its chord [mm].", 73.9, _range("rise")),
        "bend_radius": Key(
            NUMBER, "The least bend radius of the pinned cable, exactly [mm].", 157.9, _range("bend_radius")
        ),
        "material": Key(TEXT, "Name of one of the materials; force needs it.", "pvc"),
        "color": Key(TEXT, "Colour, #rrggbb or #rrggbbaa.", "#2b6cb0", {"pattern": f"^{COLOR.pattern}$"}),
        "start": Key(
            a_table(START),
            "Where the cable starts: position [mm] and axis.",
            {"position": [0, 0, 0], "outward": [0, 0, 1]},
        ),
        "end": Key(
            a_table(END),
            "Where the cable ends: position [mm] and axis.",
            {"position": [0, 120, 0], "outward": [0, 0, 1]},
        ),
        "min_bend_radius": Key(
            NUMBER,
            "Least bend radius allowed [mm]: a rule to check, never an input of the shape.",
            20.0,
            _range("min_bend_radius"),
        ),
        "bulge": Key(VECTOR, "The side to bend to where the ends leave it open (dimensionless).", [1, 0, 0], _AXIS),
        "equilibrium": Key(
            index_or_table(EQUILIBRIUM, "must be an index such as 0, or a table { winding = 0, side = 1 }"),
            "Which of the equilibria found, by energy: an index, or a table { winding, side }.",
            0,
            {"minimum": 0},
            default=0,
        ),
        "allow_contact": Key(FLAG, "Lets a cable through that touches itself, with a warning.", False, default=False),
    },
    {
        "required": ["name", "diameter", "start", "end"],
        "anyOf": [{"required": [key]} for key in ("length", "slack", "force", "angle_deg", "rise", "bend_radius")],
        "dependentRequired": {"force": ["material"]},
        "if": {"required": ["length"], "properties": {"length": {"const": "shortest"}}},
        "then": {
            "required": ["min_bend_radius"],
            "not": {"anyOf": [{"required": [key]} for key in ("slack", "force", "angle_deg", "rise", "bend_radius")]},
        },
    },
)

SCENE = Table(
    "SceneTable",
    "cablecad scene",
    "A scene of cablecad, format 1: cables, and the rigid parts beside them. Lengths are in mm.",
    {
        "format": Key(WHOLE, "Version of this file format.", FORMAT, {"const": FORMAT}),
        "name": Key(TEXT, "Name of the assembly that is written.", "gearbox loom", _NAME, default="scene"),
        "tolerance": Key(a_table(TOLERANCE), "What the solids are held to [mm].", {"shape": 0.001}),
        "materials": Key(
            named(MATERIAL),
            "The materials of the cables, by name.",
            {"pvc": {"youngs_modulus": 3890.0, "poissons_ratio": 0.25}},
        ),
        "parts": Key(list_of(PART), "Rigid parts, in order.", [{"name": "plate", "step": "parts/plate.step"}]),
        "cables": Key(
            list_of(CABLE),
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
        ),
    },
    {
        "required": ["format"],
        "anyOf": [{"required": [kind], "properties": {kind: {"minItems": 1}}} for kind in ("cables", "parts")],
    },
)
