"""Scene files to raw data: the bytes, the syntax, and what TOML and JSON let through that no scene may hold.

TOML and JSON hold the same keys. A file's suffix tells which it is; without one of theirs the text does: JSON begins
with a brace, and TOML cannot.
"""

from __future__ import annotations

import json
import logging
import math
import re
import tomllib
from collections import Counter
from os import PathLike
from pathlib import Path
from typing import Any, Literal

from cablecad.errors import ExchangeError, Mistake, SceneError, UsageError
from cablecad.model import Scene
from cablecad.scene.raw import RawScene
from cablecad.scene.resolve import resolve_scene, type_mistakes
from cablecad.scene.tables import Place

Syntax = Literal["toml", "json"]

_DEPTH = 16
"""No deeper are values nested that are looked at; a scene needs 5 levels, more protects every recursion after this."""

_SURROGATE = re.compile("[\ud800-\udfff]")

_TOML_PLACE = re.compile(
    r"(?P<reason>.*) \(at (?:line (?P<line>\d+), column (?P<column>\d+)|end of document)\)", re.DOTALL
)

_logger = logging.getLogger(__name__)


def load_scene(path: str | PathLike[str]) -> Scene:
    """Read a scene file.

    Args:
        path: Of a file in TOML or JSON; the paths of parts in it begin in its folder.

    Returns:
        The scene. Whether the files of its parts exist is not looked at.

    Raises:
        ExchangeError: The file cannot be read.
        SceneError: All mistakes in it at once, each with its path, value and fix.
    """
    path = Path(path)
    return parse_scene(_content(path), source=path)


def load_data(path: str | PathLike[str]) -> dict[str, Any]:
    """Read the raw data of a scene file, which may be changed before `resolve_scene` makes a scene of them.

    Args:
        path: Of a file in TOML or JSON.

    Returns:
        The top table; whether it is a scene is not looked at.

    Raises:
        ExchangeError: The file cannot be read.
        SceneError: It is not TOML or JSON, or holds what no scene may hold.
    """
    path = Path(path)
    data, found = _raw_data(_content(path), None, path)
    if found:
        resolve_scene(data, source=path, found=found)  # which tells them with their places
    return data


def load_raw_scene(path: str | PathLike[str]) -> RawScene:
    """Read a scene file whose values are to be changed before it is resolved.

    Raises:
        ExchangeError: The file cannot be read.
        SceneError: Its syntax, unknown keys and values of a wrong type, all at once; not what its values demand of
            each other, for they may change.
    """
    path = Path(path)
    data, found = _raw_data(_content(path), None, path)
    mistakes = type_mistakes(data, found)
    if mistakes:
        raise SceneError(mistakes, source=str(path))
    return RawScene(data, path)


def clean_value(value: object) -> tuple[Any, list[Mistake]]:
    """A value of JSON or Python as a scene file may hold it, and what it held that none may."""
    found: list[tuple[Place, Mistake]] = []
    cleaned = _cleaned(value, (), found)
    return cleaned, [mistake for _, mistake in found]


def parse_json(text: str) -> Any:
    """A value of JSON as scene files take it: keys that repeat are noted for `clean_value`, no number is too long.

    Raises:
        ValueError: The text is not valid JSON, or is nested too deep.
    """
    try:
        return _parse_json(text)
    except RecursionError as error:
        raise ValueError("is nested too deep to be read") from error


def _content(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except (OSError, ValueError) as error:  # ValueError: a null character in the path
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        raise ExchangeError(f"cannot read the scene file {str(path)!r}: {reason}; check the path") from error


def parse_scene(text: str | bytes, *, syntax: Syntax | None = None, source: str | PathLike[str] | None = None) -> Scene:
    """Read the text of a scene.

    Args:
        text: TOML or JSON; bytes are UTF-8.
        syntax: Which of the two; None takes it from the suffix of `source`, else from the text.
        source: The file it is from: named in messages, and the paths of parts begin in its folder.

    Raises:
        SceneError: All mistakes at once, each with its path, value and fix; of the syntax only the first.
    """
    if syntax not in (None, "toml", "json"):
        raise UsageError(f"the syntax of a scene is 'toml' or 'json', not {syntax!r}")
    source = None if source is None else Path(source)
    data, found = _raw_data(text, syntax, source)
    return resolve_scene(data, source=source, found=found)


def _raw_data(
    text: str | bytes, syntax: Syntax | None, source: Path | None
) -> tuple[dict[str, Any], list[tuple[Place, Mistake]]]:
    """The data of a text, safe to look at, and what no scene may hold of it."""
    try:
        data = _parse(_decoded(text), syntax, source)
    except _SyntaxMistakeError as error:
        raise SceneError([Mistake("", str(error))], source=str(source or "")) from error
    found: list[tuple[Place, Mistake]] = []
    cleaned: dict[str, Any] = _cleaned(data, (), found)
    return cleaned, found


class _SyntaxMistakeError(ValueError):
    """The text is no table of TOML or JSON."""


def _decoded(content: str | bytes) -> str:
    try:
        text = content if isinstance(content, str) else content.decode()
    except UnicodeDecodeError as error:
        byte, line = error.object[error.start], error.object.count(b"\n", 0, error.start) + 1
        problem = f"is not UTF-8 text: byte 0x{byte:02x} in line {line}; save the file with the encoding UTF-8"
        raise _SyntaxMistakeError(problem) from error
    text = text.removeprefix("\ufeff")  # the byte order mark some editors write
    if not text.strip():
        raise _SyntaxMistakeError("is empty; `cablecad new FILE` writes a scene to begin with")
    return text


def _parse(text: str, syntax: Syntax | None, source: Path | None) -> dict[str, Any]:
    """The top table of a text."""
    suffix = "" if source is None else source.suffix.lower()
    guess = ""
    if syntax is None and suffix in (".toml", ".json"):
        syntax = "json" if suffix == ".json" else "toml"
    elif syntax is None:
        syntax = "json" if text.lstrip().startswith("{") else "toml"
        sign = "begins" if syntax == "json" else "does not begin"
        guess = f"; read as {syntax.upper()}, as it {sign} with a brace: the suffix .toml or .json would tell"
        _logger.info("%s%s", source or "scene", guess)
    try:
        data = tomllib.loads(text) if syntax == "toml" else _parse_json(text)
    except RecursionError as error:
        raise _SyntaxMistakeError(f"is nested too deep to be read: a scene needs 5 levels{guess}") from error
    except ValueError as error:
        raise _SyntaxMistakeError(f"is not valid {syntax.upper()}{_where(error, text)}{guess}") from error
    if not isinstance(data, dict):
        raise _SyntaxMistakeError('must be a table of keys at the top: { "format": 1, ... }')
    return data


def _where(error: ValueError, text: str) -> str:
    """Line, column, reason and the words around the place, as far as a parser tells."""
    if isinstance(error, json.JSONDecodeError):
        line, column, reason = error.lineno, error.colno, error.msg
    elif found := _TOML_PLACE.fullmatch(str(error)):
        lines = text.split("\n")
        reason = found["reason"]
        line = int(found["line"] or len(lines))
        column = int(found["column"] or len(lines[-1]) + 1)
    else:  # a whole number of more digits than Python reads
        return f": {str(error).partition(';')[0]}"
    words = text.split("\n")[line - 1][max(column - 31, 0) : column + 29].strip()
    return f" at line {line}, column {column}: {reason}" + (f", in {words!r}" if words else "")


class _Repeating(dict[str, Any]):
    """A JSON object in which keys stand more than once."""

    repeated: tuple[str, ...] = ()


def _parse_json(text: str) -> Any:
    return json.loads(text, object_pairs_hook=_object, parse_int=_whole)


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    table = dict(pairs)
    if len(table) == len(pairs):
        return table
    repeating = _Repeating(table)
    repeating.repeated = tuple(key for key, count in Counter(key for key, _ in pairs).items() if count > 1)
    return repeating


def _whole(digits: str) -> int | float:
    return int(digits) if len(digits) < 400 else float(digits)  # beyond the largest double, and soon beyond int()


def _cleaned(value: Any, place: Place, found: list[tuple[Place, Mistake]]) -> Any:
    """A copy of raw data that is safe to look at: not deep, no endless numbers, no text that cannot be written."""
    if isinstance(value, dict | list) and len(place) == _DEPTH:
        return "..."
    if isinstance(value, dict):
        for key in getattr(value, "repeated", ()):
            found.append(((*place, key), Mistake("", "stands more than once in its table; keep one", value[key])))
        return {_SURROGATE.sub("\ufffd", key): _cleaned(part, (*place, key), found) for key, part in value.items()}
    if isinstance(value, list):
        return [_cleaned(part, (*place, i), found) for i, part in enumerate(value)]
    if isinstance(value, str) and _SURROGATE.search(value):
        value = _SURROGATE.sub("\ufffd", value)
        found.append((place, Mistake("", "holds half a character, an unpaired \\u escape; write it whole", value)))
    if isinstance(value, int) and value.bit_length() > 1023:  # the largest double has 1024 bits
        return math.inf if value > 0 else -math.inf
    return value
