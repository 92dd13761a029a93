"""Scene files: TOML by hand, JSON by machine, the same keys; all mistakes of a file at once.

The only folder that imports pydantic. A scene made in Python, from the objects of `cablecad.model`, needs none of it.
"""

from cablecad.scene.load import load_data, load_scene, parse_scene
from cablecad.scene.resolve import resolve_scene
from cablecad.scene.resolved import resolved_text
from cablecad.scene.schema import scene_schema
from cablecad.scene.starter import starter_scene
from cablecad.scene.sweep import Sweep, parse_sweep, place_steps, with_value

__all__ = [
    "Sweep",
    "load_data",
    "load_scene",
    "parse_scene",
    "parse_sweep",
    "place_steps",
    "resolve_scene",
    "resolved_text",
    "scene_schema",
    "starter_scene",
    "with_value",
]
