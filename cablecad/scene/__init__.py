"""Scene files: TOML by hand, JSON by machine, the same keys; all mistakes of a file at once.

The only folder that imports pydantic, and of it only the core. A scene made in Python, from the objects of
`cablecad.model`, needs none of it. Names are loaded when they are first used: a scene that is only read needs few.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cablecad.scene.draft import scene_schema
    from cablecad.scene.load import clean_value, load_raw_scene, load_scene, parse_json, parse_scene
    from cablecad.scene.override import Target, find_target, overlaps
    from cablecad.scene.raw import RawScene
    from cablecad.scene.resolved import resolved_text
    from cablecad.scene.starter import starter_scene

_HOMES = {
    "draft": ("scene_schema",),
    "load": ("clean_value", "load_raw_scene", "load_scene", "parse_json", "parse_scene"),
    "override": ("Target", "find_target", "overlaps"),
    "raw": ("RawScene",),
    "resolved": ("resolved_text",),
    "starter": ("starter_scene",),
}
_HOME = {name: module for module, names in _HOMES.items() for name in names}

__all__ = [
    "RawScene",
    "Target",
    "clean_value",
    "find_target",
    "load_raw_scene",
    "load_scene",
    "overlaps",
    "parse_json",
    "parse_scene",
    "resolved_text",
    "scene_schema",
    "starter_scene",
]


def __getattr__(name: str) -> object:
    if name in _HOME:
        value = getattr(import_module(f"cablecad.scene.{_HOME[name]}"), name)
        globals()[name] = value
        return value
    raise AttributeError(f"module 'cablecad.scene' has no attribute {name!r}")
