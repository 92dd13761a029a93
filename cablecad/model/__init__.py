"""The vocabulary: what a scene is made of, as frozen dataclasses that know no mechanics and no CAD.

Units: mm, N, MPa, N mm^2; degrees in names ending ``_deg``. Every object checks itself when it is made and raises
`SceneError` with all of its mistakes at once.
"""

from cablecad.model.cable import LENGTH_DATA, PINNED_DATA, Cable, EquilibriumKey, cable_mistakes
from cablecad.model.ends import Clamp, NamedPort, PartPort, Pin, Port, Toward, as_end, as_moved_end, port_of_frame
from cablecad.model.ports import end_mistakes, find_port, placed_port, port_name_mistakes
from cablecad.model.scene import (
    LEAST_TOLERANCE,
    SHAPE_TOLERANCE,
    Part,
    Rotation,
    Scene,
    checked_tolerance,
    name_mistakes,
    scene_mistakes,
    tolerance_floor,
    tolerance_mistakes,
)
from cablecad.model.section import Material, Section, material_mistakes
from cablecad.model.values import COLOR, LARGEST, RANGES, SMALLEST, Range, Vector, unit

__all__ = [
    "COLOR",
    "LARGEST",
    "LEAST_TOLERANCE",
    "LENGTH_DATA",
    "PINNED_DATA",
    "RANGES",
    "SHAPE_TOLERANCE",
    "SMALLEST",
    "Cable",
    "Clamp",
    "EquilibriumKey",
    "Material",
    "NamedPort",
    "Part",
    "PartPort",
    "Pin",
    "Port",
    "Range",
    "Rotation",
    "Scene",
    "Section",
    "Toward",
    "Vector",
    "as_end",
    "as_moved_end",
    "cable_mistakes",
    "checked_tolerance",
    "end_mistakes",
    "find_port",
    "material_mistakes",
    "name_mistakes",
    "placed_port",
    "port_name_mistakes",
    "port_of_frame",
    "scene_mistakes",
    "tolerance_floor",
    "tolerance_mistakes",
    "unit",
]
