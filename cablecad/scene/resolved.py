"""A scene file written again with numbers in place of the ends on parts: the author's own keys, all but those ends."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterator, Mapping
from os import PathLike
from pathlib import Path
from typing import Any, Literal

from cablecad.model import Port, Scene
from cablecad.scene.load import load_raw_scene

_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")

_NUMBERS = re.compile(r"\[\s+([-+.\deE]+(?:,\s+[-+.\deE]+)*)\s+\]")


def resolved_text(
    path: str | PathLike[str],
    scene: Scene,
    *,
    syntax: Literal["toml", "json"] = "toml",
    folder: str | PathLike[str] | None = None,
) -> str:
    """The text of a scene file with numbers for its ends.

    Args:
        path: The scene file.
        scene: What it holds, with its ends resolved.
        syntax: Of the text.
        folder: Where the text is going to lie: the relative paths of parts are made to begin there. None makes them
            absolute, so that it may lie anywhere.

    Returns:
        A text that loads as `scene`, up to the paths of parts.
    """
    path = Path(path)
    data = load_raw_scene(path).data
    for table, cable in zip(data.get("cables", []), scene.cables, strict=True):
        for key, end in (("start", cable.start), ("end", cable.end)):
            if isinstance(end, Port) and "part" in table[key]:
                table[key] = _end(end)
    for table in data.get("parts", []):
        table["step"] = _step(table["step"], path.parent, folder)
    if syntax == "json":
        text = json.dumps(data, indent=2, ensure_ascii=False, allow_nan=False)
        return _NUMBERS.sub(lambda found: "[" + re.sub(r"\s+", " ", found[1]) + "]", text) + "\n"
    return "\n".join(_lines("", data)).lstrip("\n") + "\n"


def _end(port: Port) -> dict[str, Any]:
    end: dict[str, Any] = {"position": list(port.position)}
    if port.outward is not None:
        end["outward"] = list(port.outward)
    if port.straight:
        end["straight"] = port.straight
    return end


def _step(step: str, source: Path, folder: str | PathLike[str] | None) -> str:
    """The path of a part, as it must be written where the text lies; with forward slashes where it is relative."""
    if Path(step).is_absolute():
        return step
    found = os.path.normpath(Path(os.path.realpath(source)) / step)
    if folder is None:
        return found
    try:
        return Path(os.path.relpath(found, os.path.realpath(folder))).as_posix()
    except ValueError:  # on another drive
        return found


# --- TOML ---------------------------------------------------------------------------------------------------------


def _lines(name: str, table: Mapping[str, Any]) -> Iterator[str]:
    """The lines of a table: its values, then the tables in it that have headers of their own.

    An end or a rotation has none: a hand would write it on one line.
    """
    below = {key: value for key, value in table.items() if _has_header(name, value)}
    for key, value in table.items():
        if key not in below:
            yield f"{_key(key)} = {_value(value)}"
    for key, value in below.items():
        path = f"{name}.{_key(key)}" if name else _key(key)
        if isinstance(value, list):
            for entry in value:
                yield f"\n[[{path}]]"
                yield from _lines(path, entry)
        else:
            yield f"\n[{path}]"
            yield from _lines(path, value)


def _has_header(name: str, value: object) -> bool:
    if isinstance(value, list):
        return bool(value) and all(isinstance(entry, dict) for entry in value)
    return isinstance(value, dict) and name in ("", "materials")


def _key(key: str) -> str:
    return key if _BARE_KEY.fullmatch(key) else _value(key)


def _value(value: object) -> str:
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{_key(key)} = {_value(part)}" for key, part in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(_value, value)) + "]"
    # JSON's escapes are TOML's, which wants one more.
    return json.dumps(value, ensure_ascii=False, allow_nan=False).replace("\x7f", "\\u007f")
