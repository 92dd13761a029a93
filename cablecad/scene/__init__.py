"""Scene files: TOML by hand, JSON by machine, the same keys; all mistakes of a file at once.

The only folder that imports pydantic. A scene made in Python, from the objects of `cablecad.model`, needs none of it.
"""

from cablecad.scene.load import load_scene, parse_scene
from cablecad.scene.resolved import resolved_text
from cablecad.scene.schema import scene_schema
from cablecad.scene.starter import starter_scene

__all__ = ["load_scene", "parse_scene", "resolved_text", "scene_schema", "starter_scene"]
