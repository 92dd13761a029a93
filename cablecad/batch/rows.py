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


@dataclass(frozen=True, slots=True)
class RowInput:
    """What the result of a row depends on.

    Attributes:
        hash: Of the row's id and scene, of the contents of its files, of settings of the batch and of cablecad's
            version.
        files: What is read where the row is worked on: its scene, where that is a path, and its parts.
        state: Of these files, see `files_state`.
    """

    hash: str
    files: tuple[Path, ...]
    state: int


Contents = dict[Path, tuple[bytes, int]]
"""The hashes of what files hold, and the files' states."""


def row_hash(row: Row, *settings: object) -> str:
    """The hash of what the result of a row depends on."""
    return row_input(row, *settings).hash


def row_input(row: Row, *settings: object, contents: Contents | None = None) -> RowInput:
    """What the result of a row depends on.

    Args:
        row: The row.
        settings: What else its result depends on.
        contents: Keeps what is known of the parts' files from row to row; without it each is looked at anew.
    """
    digest = blake2b(_SETTINGS.encode([__version__, row.id, *settings]).encode(), digest_size=HASH_BYTES)
    scene = row.scene
    parts: Sequence[Path] = ()
    files: list[Path] = []
    states: list[int] = []
    if isinstance(scene, RawScene):
        digest.update(_RAW.encode(scene.data).encode())
        parts = raw_parts(scene)
    else:
        if isinstance(scene, Path):
            content, state = _content(scene)
            digest.update(content)
            files.append(scene)
            states.append(state)
            with contextlib.suppress(CablecadError):  # a row that will fail, which is seen when it is worked on
                scene = load_scene(scene) if scene.is_file() else scene  # a pipe would keep us waiting
        if isinstance(scene, Scene):
            digest.update(repr((scene.name, scene.cables, scene.parts, scene.tolerance)).encode())
            parts = [part.step for part in scene.parts]
    contents = {} if contents is None else contents
    for part in parts:
        if part not in contents:
            contents[part] = _content(part)
        digest.update(contents[part][0])
        states.append(contents[part][1])
    return RowInput(digest.hexdigest(), (*files, *parts), hash(tuple(states)) if states else 0)


def files_state(files: Sequence[Path]) -> int:
    """What tells without reading them whether files are as they were: their times, sizes and places on the disk."""
    return hash(tuple(map(file_state, files))) if files else 0


def file_state(path: Path) -> int:
    """The same of one file; 0 for one that is not there."""
    try:
        return _state(path.stat())
    except (OSError, ValueError):
        return 0


def _state(status: os.stat_result) -> int:
    return hash((status.st_dev, status.st_ino, status.st_size, status.st_mtime_ns))


def raw_parts(scene: RawScene) -> list[Path]:
    """The files of the parts, as far as the raw data name them."""
    folder = scene.source.parent if scene.source is not None else Path()
    parts = scene.data.get("parts")
    names = [part.get("step") for part in parts if isinstance(part, dict)] if isinstance(parts, list) else []
    return [folder / name for name in names if isinstance(name, str) and "\0" not in name]


def _content(path: Path) -> tuple[bytes, int]:
    """The hash of what a file holds, and its state; of a file that cannot be read or is none, that of its path."""
    try:
        status = path.stat()
    except (OSError, ValueError):
        return os.fsencode(path), 0
    state = _state(status)
    if not stat.S_ISREG(status.st_mode):  # a pipe would keep us waiting
        return os.fsencode(path), state
    return _hash_of(os.path.realpath(path), state), state


@lru_cache(maxsize=256)
def _hash_of(path: str, _state: int) -> bytes:
    try:
        return blake2b(Path(path).read_bytes(), digest_size=16).digest()
    except OSError:
        return os.fsencode(path)
