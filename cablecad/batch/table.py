"""Rows from a table: CSV or JSON Lines, whose columns override values of a scene by dotted names.

A cell that is empty (in JSON Lines: a key that is not there) keeps the scene's value; `null` in JSON Lines takes the
key out of the scene, to give `slack` instead of `length`, say. The table is read a row at a time, once to find all its
mistakes and then for every pass over the rows, so that its size is no matter.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from os import PathLike
from pathlib import Path
from typing import Any

from cablecad.batch.rows import Row, id_mistakes
from cablecad.errors import ExchangeError, Mistake, SceneError
from cablecad.scene import RawScene, Target, clean_value, find_target, load_raw_scene, overlaps, parse_json

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")

_MOST_MISTAKES = 100
"""Mistakes told of one by one: who has more has made one of them a thousand times."""

_MOST_LAYOUTS = 1000
"""Sets of columns that are remembered as naming nothing twice: most tables have one."""

Cells = dict[str, Any]


@dataclass(frozen=True)
class TableRows:
    """The rows of a table that was checked; they can be gone through any number of times.

    Attributes:
        path: Of the table.
        base: The scene the rows override.
    """

    path: Path
    base: RawScene
    _targets: dict[str, Target] = field(default_factory=dict, compare=False)
    _wholes: dict[str, bool] = field(default_factory=dict, compare=False)
    _apart: set[tuple[str, ...]] = field(default_factory=set, compare=False)

    def __iter__(self) -> Iterator[Row]:
        """Read the table once more.

        Raises:
            ExchangeError: It cannot be read any more.
            SceneError: It was changed, and is mistaken now.
        """
        for number, (_line, cells) in enumerate(_lines(self.path), 1):
            yield self.row(number, cells)

    def row(self, number: int, cells: Cells) -> Row:
        """The row that stands at a place of the table, counted from 1."""
        clashes = self.clashes(tuple(name for name in cells if name != "id"))
        if clashes:
            raise SceneError(clashes.values())
        changes, shown = [], {}
        for name, cell in cells.items():
            if name == "id":
                continue
            target = self.target(name)
            if isinstance(cell, _Text):
                if not cell.text.strip():
                    continue
                value = cell_value(cell.text, is_text=target.is_text)
                if isinstance(value, float) and self._whole(name, target):  # as spreadsheets write a column with gaps
                    value = as_whole(value)
            else:
                value = cell
            value, mistakes = clean_value(value)
            if mistakes:
                raise SceneError([mistake.under(name) for mistake in mistakes])
            changes.append((target, value))
            shown[name] = value
        return Row(_id_of(number, cells), self.base.overridden(changes), shown)

    def _whole(self, name: str, target: Target) -> bool:
        """Whether a column takes whole numbers alone."""
        if name not in self._wholes:
            self._wholes[name] = takes_whole_numbers(self.base, target)
        return self._wholes[name]

    def target(self, name: str) -> Target:
        """The place a column names."""
        if name not in self._targets:
            self._targets[name] = find_target(name, self.base.data)
        return self._targets[name]

    def clashes(self, names: tuple[str, ...]) -> dict[str, Mistake]:
        """Which columns of a row name what an earlier one of it names; JSON Lines have other columns in each row."""
        if names in self._apart:
            return {}
        found: dict[str, Mistake] = {}
        for i, name in enumerate(names):
            for other in names[:i]:
                if overlaps(self.target(name), self.target(other)):
                    found[name] = Mistake(name, f"names what {other} names too, or a part of it; keep one")
        if not found:
            if len(self._apart) >= _MOST_LAYOUTS:
                self._apart.clear()
            self._apart.add(names)
        return found


def table_rows(table: str | PathLike[str], scene: str | PathLike[str]) -> TableRows:
    """Read and check a table of overrides of a scene.

    Args:
        table: A file that ends in .csv (comma, semicolon or tab), .jsonl or .ndjson.
        scene: The scene file the rows override.

    Returns:
        The rows, whose keys and types are known to be right; what their values demand of each other is not.

    Raises:
        ExchangeError: A file cannot be read.
        SceneError: All mistakes of the scene, or all of the table's header and types, each with its line.
    """
    rows = TableRows(Path(table), load_raw_scene(scene))
    mistakes: list[Mistake] = []
    told: set[str] = set()
    number = 0
    for number, (line, cells) in enumerate(_lines(rows.path), 1):
        for mistake in _row_mistakes(rows, number, cells, told):
            mistakes.append(replace(mistake, path=f"line {line}, {mistake.path}".removesuffix(", ")))
        if len(mistakes) >= _MOST_MISTAKES:
            mistakes.append(Mistake("", f"there may be more: no line after {line} was looked at"))
            break
    if number == 0:
        mistakes.append(Mistake("", "holds no rows; the first line of CSV names the columns, the next are rows"))
    if mistakes:
        raise SceneError(mistakes, source=str(table))
    return rows


def _row_mistakes(rows: TableRows, number: int, cells: Cells, told: set[str]) -> Iterator[Mistake]:
    """What is wrong with a row; of a column that is wrong in itself only once."""
    if isinstance(cells.get(""), _Wrong):
        yield Mistake("", cells[""].problem)
        return
    good = {}
    for name, cell in cells.items():
        try:
            if name != "id":
                rows.target(name)
        except SceneError as error:
            if name not in told:
                told.add(name)
                yield from error.mistakes
        else:
            good[name] = cell
    for name, mistake in rows.clashes(tuple(name for name in good if name != "id")).items():
        del good[name]
        if name not in told:
            told.add(name)
            yield mistake
    for problem in id_mistakes(_id_of(number, cells)):
        yield Mistake("id", problem, _id_of(number, cells))
    try:
        row = rows.row(number, good)
    except SceneError as error:
        yield from error.mistakes
        return
    assert isinstance(row.scene, RawScene)
    yield from row.scene.type_mistakes()


def _id_of(number: int, cells: Cells) -> Any:
    """The id of a row: its own, else its number in the table."""
    cell = cells.get("id")
    if isinstance(cell, _Text):
        return cell.text.strip() or str(number)
    if isinstance(cell, int | float) and not isinstance(cell, bool):
        return str(cell)
    return str(number) if cell is None else cell


def takes_whole_numbers(base: RawScene, target: Target) -> bool:
    """Whether a place of a scene takes whole numbers and no others."""
    half, one = (bool(base.overridden([(target, value)]).type_mistakes()) for value in (0.5, 1))
    return half and not one


def as_whole(value: Any) -> Any:
    """A float that is a whole number as that number; anything else as it is."""
    return int(value) if isinstance(value, float) and value.is_integer() else value


def cell_value(text: str, *, is_text: bool) -> Any:
    """What a cell means: a text where one belongs, else a number, true or false, or a list or table as JSON has it."""
    text = text.strip()
    if is_text:
        return text
    if _NUMBER.fullmatch(text):
        digits = text.lstrip("+-")
        return int(text) if digits.isdigit() and len(digits) < 300 else float(text)
    if text.lower() in ("true", "false"):
        return text.lower() == "true"
    try:
        return parse_json(text)
    except ValueError:
        return text  # which the check of types tells of, or which is "shortest"


# --- the two kinds of table ---------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class _Text:
    """A cell of CSV, whose type the column decides."""

    text: str


@dataclass(frozen=True, slots=True)
class _Wrong:
    """A line that is no row, under the name of no column."""

    problem: str


def _lines(path: Path) -> Iterator[tuple[int, Cells]]:
    """Each row with the line it ends on; a line that is none is told by a `_Wrong` under the empty name."""
    suffix = path.suffix.lower()
    if suffix not in (".csv", ".tsv", ".jsonl", ".ndjson"):
        raise ExchangeError(f"table {path}: its name must end in .csv or .jsonl, so that its kind is known")
    try:
        if path.exists() and not path.is_file():
            raise ExchangeError(f"table {path} is no file; it is read more than once, so give a file")
        with path.open(encoding="utf-8-sig", newline="") as file:
            yield from (_csv(file, path) if suffix in (".csv", ".tsv") else _jsonl(file))
    except UnicodeDecodeError as error:
        raise ExchangeError(f"table {path} is not UTF-8 text ({error.reason}); save it with that encoding") from error
    except OSError as error:
        if isinstance(error, ExchangeError):
            raise
        raise ExchangeError(f"table {path} cannot be read: {error.strerror or error}; check the path") from error


def _csv(file: Any, path: Path) -> Iterator[tuple[int, Cells]]:
    first = _header_text(file)
    # Outside of quotes a dotted name holds none of these, so the one that is there most parts the columns.
    delimiter = max(",;\t", key=first.count)
    reader = csv.reader(file, delimiter=delimiter, strict=True)
    header: list[str] | None = None
    try:
        for cells in reader:
            if not any(cell.strip() for cell in cells):
                continue
            if header is None:
                header = [cell.strip() for cell in cells]
                _check_header(header, path)
            elif len(cells) != len(header):
                problem = f"has {len(cells)} cells, and the header {len(header)}"
                yield reader.line_num, {"": _Wrong(problem)}
            else:
                yield reader.line_num, {name: _Text(cell) for name, cell in zip(header, cells, strict=True)}
    except csv.Error as error:
        yield reader.line_num, {"": _Wrong(f"is no CSV: {error}")}


def _header_text(file: Any) -> str:
    """The line of the header without what stands in quotes; the file is at its beginning again."""
    text = ""
    for line in iter(file.readline, ""):
        text += line
        if text.strip(" ,;\t\r\n") and text.count('"') % 2 == 0:
            break
        if not text.strip(" ,;\t\r\n"):
            text = ""  # a blank line before it
    file.seek(0)
    return re.sub('"[^"]*"', "", text)


def _check_header(header: list[str], path: Path) -> None:
    """Refuse a header that names no columns, or one of them twice."""
    mistakes = [
        Mistake(f"column {i}", "has no name; every column is `id` or a dotted name such as cables.W1.length")
        for i, name in enumerate(header, 1)
        if not name
    ]
    for name in dict.fromkeys(name for name in header if name and header.count(name) > 1):
        mistakes.append(Mistake(name, f"names {header.count(name)} columns; keep one"))
    if mistakes:
        raise SceneError(mistakes, source=str(path))


def _jsonl(file: Any) -> Iterator[tuple[int, Cells]]:
    for number, line in enumerate(file, 1):
        if not line.strip():
            continue
        try:
            cells = parse_json(line)
        except ValueError as error:
            yield number, {"": _Wrong(f"is not valid JSON: {error}")}
            continue
        repeated = getattr(cells, "repeated", ())
        if not isinstance(cells, dict):
            yield number, {"": _Wrong('must be a table of dotted names: {"id": "a", "cables.W1.length": 350.0}')}
        elif repeated:
            yield number, {"": _Wrong(f"has {', '.join(map(repr, repeated))} more than once; keep one")}
        elif "" in cells:
            yield number, {"": _Wrong("has a key without a name")}
        else:
            yield number, cells
