"""A row of a batch: a scene with an id, and the hash of all that its result depends on."""

from __future__ import annotations

import contextlib
import json
import os
import stat
import unicodedata
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from hashlib import blake2b
from os import PathLike
from pathlib import Path
from typing import Any

from cablecad import __version__
from cablecad.errors import CablecadError, Mistake, SceneError
from cablecad.model import Scene
from cablecad.scene import RawScene, load_scene

_LONGEST_ID = 200
"""Bytes of an id in UTF-8: with a suffix, and what is put around a file name while it is written, 255 are allowed."""


_SETTINGS = json.JSONEncoder()
_RAW = json.JSONEncoder(sort_keys=True, default=repr)

HASH_BYTES = 12
"""Of the hash of a row's input: two of a million rows share one with a chance of 1e-17."""


@dataclass(frozen=True, slots=True)
class Row:
    """One scene of a batch.

    Attributes:
        id: Names its output and its line of the results.
        scene: A scene; or its raw data, or the path of its file, which are resolved where the row is worked on.
        overrides: What was overridden, by dotted name, as the results are to show it; no more than a remark.
    """

    id: str
    scene: Scene | RawScene | Path
    overrides: Mapping[str, Any] = field(default_factory=dict)

    def resolve(self) -> Scene:
        """The scene.

        Raises:
            SceneError: Mistakes in it.
            ExchangeError: Its file cannot be read.
        """
        if isinstance(self.scene, Path):
            return load_scene(self.scene)
        return self.scene.resolve() if isinstance(self.scene, RawScene) else self.scene


def scene_rows(paths: Iterable[str | PathLike[str]]) -> list[Row]:
    """A row for each scene file, called as the file is without its suffix."""
    return [Row(path.stem, path) for path in map(Path, paths)]


def id_mistakes(row_id: object) -> list[str]:
    """What is wrong with an id, which must be able to name a file on any system."""
    if not isinstance(row_id, str) or not row_id.strip():
        return ["must be a text that is not empty"]
    if row_id != row_id.strip() or row_id.startswith("."):
        return ["must not begin or end with a blank, nor begin with a dot: it names a file"]
    if any(c in '/\\:*?"<>|' or unicodedata.category(c) in ("Cc", "Cs") for c in row_id):
        return ['must not hold any of / \\ : * ? " < > | or control characters: it names a file']
    if len(row_id.encode()) > _LONGEST_ID:
        return [f"is longer than {_LONGEST_ID} bytes: it names a file"]
    return []


def same_id(row_id: str) -> str:
    """What two ids have in common that would name one file on some file systems."""
    return unicodedata.normalize("NFC", row_id).casefold()


def check_id(row: Row) -> None:
    """Refuse an id that cannot name a file.

    Raises:
        SceneError: What is wrong with it.
    """
    wrong = id_mistakes(row.id)
    if wrong:
        raise SceneError([Mistake("id", problem, row.id) for problem in wrong])


def row_hash(row: Row, *settings: object, contents: dict[Path, bytes] | None = None) -> str:
    """The hash of a row's scene, of the contents of its parts, of settings of the batch and of cablecad's version.

    Args:
        row: The row.
        settings: What else its result depends on.
        contents: Keeps the hashes of the parts' files from row to row; without it each is looked at anew.
    """
    digest = blake2b(_SETTINGS.encode([__version__, *settings]).encode(), digest_size=HASH_BYTES)
    scene = row.scene
    parts: Sequence[Path] = ()
    if isinstance(scene, RawScene):
        digest.update(_RAW.encode(scene.data).encode())
        parts = _raw_parts(scene)
    else:
        if isinstance(scene, Path):
            digest.update(_content_hash(scene))
            with contextlib.suppress(CablecadError):  # a row that will fail, which is seen when it is worked on
                scene = load_scene(scene) if scene.is_file() else scene  # a pipe would keep us waiting
        if isinstance(scene, Scene):
            digest.update(repr((scene.name, scene.cables, scene.parts, scene.tolerance)).encode())
            parts = [part.step for part in scene.parts]
    contents = {} if contents is None else contents
    for part in parts:
        if part not in contents:
            contents[part] = _content_hash(part)
        digest.update(contents[part])
    return digest.hexdigest()


def _raw_parts(scene: RawScene) -> list[Path]:
    """The files of the parts, as far as the raw data name them."""
    folder = scene.source.parent if scene.source is not None else Path()
    parts = scene.data.get("parts")
    names = [part.get("step") for part in parts if isinstance(part, dict)] if isinstance(parts, list) else []
    return [folder / name for name in names if isinstance(name, str) and "\0" not in name]


def _content_hash(path: Path) -> bytes:
    """The hash of what a file holds; of a file that cannot be read or is none, that of its path."""
    try:
        status = path.stat()
    except (OSError, ValueError):
        return os.fsencode(path)
    if not stat.S_ISREG(status.st_mode):  # a pipe would keep us waiting
        return os.fsencode(path)
    return _hash_of(os.path.realpath(path), status.st_mtime_ns, status.st_size)


@lru_cache(maxsize=256)
def _hash_of(path: str, _mtime: int, _size: int) -> bytes:
    try:
        return blake2b(Path(path).read_bytes(), digest_size=16).digest()
    except OSError:
        return os.fsencode(path)
