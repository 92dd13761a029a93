"""The files a batch reads: it writes to none of them, and stops where one changes while it works.

Of a row's files their state is kept in 8 bytes, and looked at again when the row is done: where it is another, the
row's hash is taken anew.
"""

from __future__ import annotations

import os
from array import array
from collections.abc import Iterable
from pathlib import Path

from cablecad.batch.grid import GridRows
from cablecad.batch.keys import RowKeys
from cablecad.batch.rows import Contents, Row, file_state, files_state, raw_parts, row_input
from cablecad.batch.table import TableRows
from cablecad.errors import ExchangeError, UsageError
from cablecad.files import same_file
from cablecad.scene import RawScene

_MOST_FILES = 1000
"""So many files of parts have their hashes kept while rows are looked over."""


class Inputs:
    """The files of the rows of a batch, and of their table.

    Args:
        rows: Where the rows come from.
        settings: What their results depend on beside them.
    """

    def __init__(self, rows: Iterable[Row], settings: tuple[object, ...]) -> None:
        self._settings = settings
        self._contents: Contents = {}
        self._readers: dict[Path, str] = {}
        self._known: dict[int, Path] | None = None
        self._states = array("q")
        # Rows that are scene files: which parts there are stands in the file, which is not read a third time.
        self._parts: dict[int, tuple[Path, ...]] = {}
        self._table = rows.path if isinstance(rows, TableRows) else None
        self._table_state = 0 if self._table is None else file_state(self._table)
        self._fixed = isinstance(rows, list | tuple | GridRows)
        if self._table is not None:
            self._readers[self._table] = "the table"

    def look_at(self, row: Row) -> str:
        """Learn the files of the next row; returns its `row_hash`."""
        found = row_input(row, *self._settings, contents=self._contents)
        if len(self._contents) > _MOST_FILES:
            self._contents.clear()
        source = None if isinstance(row.scene, Path) else row.scene.source
        for path in found.files if source is None else (source, *found.files):
            if path not in self._readers:
                self._readers[path] = f"read by row {row.id!r}"
        if isinstance(row.scene, Path) and len(found.files) > 1:
            self._parts[len(self._states)] = found.files[1:]
        self._states.append(found.state)
        return found.hash

    def check_output(self, output: Path) -> None:
        """Refuse to write to one of the files.

        Raises:
            UsageError: Both of them.
        """
        self._refuse(output, f"output {output} is also an input")

    def check_removal(self, output: Path) -> None:
        """Refuse to remove one of the files, which an earlier run wrote.

        Raises:
            UsageError: Both of them.
        """
        self._refuse(output, f"{output}, which an earlier run wrote and this one is to remove, is an input")

    def _refuse(self, output: Path, problem: str) -> None:
        if self._known is None:  # once all rows were looked at
            self._known = {_identity(path): path for path in self._readers}
        path = self._known.get(_identity(output))
        if path is not None and same_file(path, output):
            raise UsageError(f"{problem}: {path}, {self._readers[path]}; write to another folder")

    def check_handed_out(self, first: int, rows: Iterable[Row], keys: RowKeys) -> None:
        """See that rows are still those that were looked at, where they may have changed.

        Args:
            first: Which row the first of them is, counted from 0.
            rows: The rows, as they were read again.
            keys: What they were.

        Raises:
            ExchangeError: One is not.
        """
        if self._fixed or (self._table is not None and file_state(self._table) == self._table_state):
            return
        for i, row in enumerate(rows, first):
            if row_input(row, *self._settings).hash != keys.input_hash(i):
                raise _changed(i, row)

    def check_done(self, i: int, row: Row, keys: RowKeys) -> None:
        """See that the files of a row that was worked on are those that were looked at.

        Raises:
            ExchangeError: One is not.
        """
        scene = row.scene
        if isinstance(scene, Path):
            files: list[Path] = [scene, *self._parts.get(i, ())]
        else:
            files = raw_parts(scene) if isinstance(scene, RawScene) else [part.step for part in scene.parts]
        if files_state(files) != self._states[i] and row_input(row, *self._settings).hash != keys.input_hash(i):
            raise _changed(i, row)


def _changed(i: int, row: Row) -> ExchangeError:
    return ExchangeError(
        f"the rows changed while they were worked on: row {i + 1}, {row.id!r}, has other values, or a file it reads "
        "was written to; leave its files alone, and start the batch with --resume"
    )


def _identity(path: Path) -> int:
    """What two paths to one file have in common; of a file that is not there it is where it would be."""
    try:
        status = path.stat()
    except OSError:
        return hash(os.path.normcase(os.path.realpath(path)))
    except ValueError:  # a null character: no file has it
        return hash(path)
    return hash((status.st_dev, status.st_ino))
