"""Scene files: TOML by hand, JSON by machine, the same keys; all mistakes of a file at once.

The only folder that imports pydantic. A scene made in Python, from the objects of `cablecad.model`, needs none of it.
"""

from cablecad.scene.load import clean_value, load_data, load_raw_scene, load_scene, parse_json, parse_scene
from cablecad.scene.override import Target, find_target, overlaps
from cablecad.scene.raw import RawScene
from cablecad.scene.resolve import resolve_scene
from cablecad.scene.resolved import resolved_text
from cablecad.scene.schema import scene_schema
from cablecad.scene.starter import starter_scene
from cablecad.scene.sweep import Sweep, parse_sweep, place_steps, with_value

__all__ = [
    "RawScene",
    "Sweep",
    "Target",
    "clean_value",
    "find_target",
    "load_data",
    "load_raw_scene",
    "load_scene",
    "overlaps",
    "parse_json",
    "parse_scene",
    "parse_sweep",
    "place_steps",
    "resolve_scene",
    "resolved_text",
    "scene_schema",
    "starter_scene",
    "with_value",
]
