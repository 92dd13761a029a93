"""`results.csv`: a line a row in the order of the rows, made from the journal whenever a batch ends.

Columns: id, status, what was overridden, ``<cable>.<report key>`` for every single value of the cables' reports,
error and seconds. The lists of a report that are no vectors (equilibria, points) are in the journal alone.
"""

from __future__ import annotations

import csv
import json
from array import array
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from cablecad.batch.journal import RowKeys, read_lines
from cablecad.batch.summary import Summary
from cablecad.files import replacing

RESULTS = "results.csv"

_FIRST, _LAST = ("id", "status"), ("error", "seconds")

_LEFT_OUT = frozenset({"name", "message", "seconds"})
"""What stands elsewhere in the line: the name in the columns' names, messages under error."""


_ENDS = ("start.", "end.")
"""Tables of vectors: position, direction, force, moment."""


def write_results(journal: Path, results: Path, keys: RowKeys, summary: Summary) -> None:
    """Write `results.csv`, and take every line of the journal into a summary.

    Raises:
        ExchangeError: The journal cannot be read, or the results not written.
    """
    columns: dict[str, tuple[int, int]] = {}
    rows, places = array("q"), array("q")
    for line in read_lines(journal):
        row = keys.row(line.data["id"])
        if row is None:  # of a batch that was; there is no such row any more
            continue
        summary.add(line.data)
        rows.append(row)
        places.append(line.place)
        for i, column in enumerate(_values(line.data)):
            # Where a column first stands, by row and not by when the row was done, so that the order is always one.
            columns[column] = min(columns.get(column, (row, i)), (row, i))
    ordered = sorted(columns, key=lambda column: columns[column])
    header = [*_FIRST, *ordered, *_LAST]
    with (
        replacing(results) as aside,
        aside.open("w", encoding="utf-8", newline="") as file,
        journal.open("rb") as lines,
    ):
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        for at in np.argsort(np.frombuffer(rows, dtype=np.int64), kind="stable") if len(rows) else ():
            lines.seek(places[at])
            data = json.loads(lines.readline())
            found = dict(_values(data))
            cells = [found.get(column) for column in ordered]
            seconds = (data.get("seconds") or {}).get("total")
            error = "; ".join(data["error"].splitlines())
            writer.writerow([data["id"], data["status"], *map(_cell, cells), error, _cell(seconds)])


def _values(line: Mapping[str, Any]) -> dict[str, Any]:
    """The values of a line by column: the overrides, then those of each cable."""
    found = dict(line["overrides"])
    for cable in line.get("cables") or ():
        for key, value in _flat("", cable):
            found[f"{cable['name']}.{key}"] = value
    return found


def _flat(prefix: str, table: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """The single values in a table, by dotted key; a vector is three of them."""
    for key, value in table.items():
        if not prefix and key in _LEFT_OUT:
            continue
        if isinstance(value, dict):
            yield from _flat(f"{prefix}{key}.", value)
        elif prefix in _ENDS:
            for i, axis in enumerate("xyz"):
                yield f"{prefix}{key}.{axis}", None if value is None else value[i]
        elif not isinstance(value, list) and (key != "solid" or value is not None):
            yield f"{prefix}{key}", value
        elif isinstance(value, list) and key in ("violations", "warnings"):
            yield f"{prefix}{key}", "; ".join(value)


def _cell(value: Any) -> Any:
    """A value as it stands in CSV; nothing for none."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list | dict):
        return json.dumps(value, ensure_ascii=False)
    return value
