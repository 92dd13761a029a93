"""`results.csv`: a line a row in the order of the rows, made from the journal whenever a batch ends.

Columns: id, status, what was overridden, ``<cable>.<report key>`` for every single value of the cables' reports,
error and seconds. The lists of a report that are no vectors (equilibria, points) are in the journal alone.
"""

from __future__ import annotations

import csv
import json
import re
import tempfile
from array import array
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import IO, Any

import numpy as np

from cablecad.batch.journal import read_lines
from cablecad.batch.keys import RowKeys
from cablecad.batch.summary import Summary
from cablecad.files import replacing

RESULTS = "results.csv"

_FIRST, _LAST = ("id", "status"), ("error", "seconds")

_LEFT_OUT = frozenset({"name", "message", "seconds"})
"""What stands elsewhere in the line: the name in the columns' names, messages under error."""


class _Digits(str):
    """A number that is not whole, as it stands in the journal: so it goes on, and is told from a text."""

    __slots__ = ()


_TEXTS = frozenset({str, _Digits})


_ENDS = ("start", "end")
"""Tables of vectors: position, direction, force, moment."""

_NOWHERE = (None, None, None)
"""The parts of a vector that is not known."""


def write_results(journal: Path, results: Path, keys: RowKeys, summary: Summary) -> None:
    """Write `results.csv`, and take every line of the journal into a summary.

    Raises:
        ExchangeError: The journal cannot be read, or the results not written.
    """
    with replacing(results) as aside, tempfile.TemporaryFile(dir=aside.parent) as scratch:
        table = _Table(scratch)
        for line in read_lines(journal, number=_Digits):
            row = keys.row(line["id"])
            if row is not None:  # else of a batch that was; there is no such row any more
                summary.add(line)
                table.add(row, line)
        with aside.open("wb") as file:
            for data in table.lines():
                file.write(data)


class _Table:
    """The lines of the results as they come, set down until all columns are known; in 20 bytes of memory a row.

    Args:
        scratch: An empty file.
    """

    def __init__(self, scratch: IO[bytes]) -> None:
        self._scratch = scratch
        self._rows, self._places, self._kinds = array("q"), array("q"), array("l")
        # By the columns a line has: its number, and the first row that has them.
        self._layouts: dict[tuple[str, ...], list[int]] = {}
        self._end = 0

    def add(self, row: int, data: Mapping[str, Any]) -> None:
        """Take a line of the journal."""
        values = _values(data)
        layout = self._layouts.setdefault(tuple(values), [len(self._layouts), row])
        layout[1] = min(layout[1], row)
        self._rows.append(row)
        self._places.append(self._end)
        self._kinds.append(layout[0])
        seconds = (data.get("seconds") or {}).get("total")
        error = "; ".join(data["error"].splitlines())
        line = _line([data["id"], data["status"], *_cells(values.values()), error, seconds])
        self._scratch.write(line)
        self._end += len(line)

    def lines(self) -> Iterator[bytes]:
        """The header, then the lines in the order of the rows."""
        # Where a column first stands, by row and not by when the row was done, so that the order is always one.
        columns: dict[str, tuple[int, int]] = {}
        for names, (_, row) in self._layouts.items():
            for i, name in enumerate(names):
                columns[name] = min(columns.get(name, (row, i)), (row, i))
        ordered = sorted(columns, key=lambda column: columns[column])
        yield _line([*_FIRST, *ordered, *_LAST])
        places: list[list[int] | None] = [_places(names, ordered) for names in self._layouts]
        ends = [*self._places[1:], self._end] if self._places else []
        order = np.argsort(np.frombuffer(self._rows, dtype=np.int64), kind="stable") if self._rows else ()
        for i in map(int, order):
            self._scratch.seek(self._places[i])
            line, at = self._scratch.read(ends[i] - self._places[i]), places[self._kinds[i]]
            if at is None:
                yield line
                continue
            (first, second, *cells, error, seconds) = _split(line)
            yield b",".join([first, second, *(b"" if j < 0 else cells[j] for j in at), error, seconds]) + b"\n"


def _places(names: Sequence[str], ordered: Sequence[str]) -> list[int] | None:
    """Where a line has the values of all columns, -1 where it has none; None where it is as it should be."""
    if list(names) == list(ordered):
        return None
    known = {name: i for i, name in enumerate(names)}
    return [known.get(name, -1) for name in ordered]


_QUOTED = re.compile(rb'"[^"]*(?:""[^"]*)*"|[^,]*')


def _split(line: bytes) -> list[bytes]:
    """The cells of a line of ours as they stand in it, of any length: `csv` reads none of more than 131072 letters."""
    if b'"' not in line:
        return line[:-1].split(b",")
    cells, at = [], 0
    while at < len(line):
        found = _QUOTED.match(line, at, len(line) - 1)
        assert found is not None  # it matches nothing at all, too
        cells.append(found[0])
        at = found.end() + 1
    return cells


class _Encoder:
    """What `csv` takes for a file, and gives the line back."""

    write = staticmethod(str.encode)


_line = csv.writer(_Encoder(), lineterminator="\n").writerow
"""The line of some cells, in UTF-8."""


def _values(line: Mapping[str, Any]) -> dict[str, Any]:
    """The values of a line by column: the overrides, then those of each cable."""
    found = dict(line["overrides"])
    for cable in line.get("cables") or ():
        name = cable["name"]
        for key, value in cable.items():
            if value.__class__ in _TEXTS and key not in _LEFT_OUT:
                found[f"{name}.{key}"] = value  # most are, for numbers stay texts
            elif key not in _LEFT_OUT:
                _put(found, f"{name}.{key}", key, value)
    return found


def _put(found: dict[str, Any], column: str, key: str, value: Any) -> None:
    """Set down what stands under a key of a cable's report: a value, or those of the table it is."""
    if isinstance(value, dict):
        if key in _ENDS:
            for name, vector in value.items():
                x, y, z = _axes(f"{column}.{name}")
                found[x], found[y], found[z] = _NOWHERE if vector is None else vector
        else:
            for name, part in value.items():
                _put(found, f"{column}.{name}", f"{key}.{name}", part)
    elif not isinstance(value, list):
        if value is not None or key != "solid":
            found[column] = value
    elif key in ("violations", "warnings"):
        found[column] = "; ".join(value)


@lru_cache(maxsize=1024)
def _axes(column: str) -> tuple[str, str, str]:
    """The columns of a vector."""
    return f"{column}.x", f"{column}.y", f"{column}.z"


def _cells(values: Iterable[Any]) -> list[Any]:
    """Values as they stand in CSV; nothing for none."""
    return [value if value is None or value.__class__ in _TEXTS else _cell(value) for value in values]


def _cell(value: Any) -> Any:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list | dict):
        return _json(value)
    return value


def _json(value: Any) -> str:
    """A value as JSON, with numbers as they were written."""
    if isinstance(value, dict):
        return f"{{{', '.join(f'{_json(key)}: {_json(part)}' for key, part in value.items())}}}"
    if isinstance(value, list):
        return f"[{', '.join(map(_json, value))}]"
    return str(value) if isinstance(value, _Digits) else json.dumps(value, ensure_ascii=False)
