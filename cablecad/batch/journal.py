"""`reports.jsonl`: one line a finished row, appended as it finishes; what a batch knows of itself.

A line is written at one go and taken back where that fails; what a kill left of a line has no line break, and is
dropped when the batch is resumed. Two batches never write to one folder: it is locked while one does.
"""

from __future__ import annotations

import errno
import json
import os
import sys
import time
from array import array
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from hashlib import blake2b
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from cablecad.batch.rows import HASH_BYTES, id_mistakes, same_id
from cablecad.batch.task import JSON, RowResult, step_path
from cablecad.errors import ExchangeError, UsageError
from cablecad.files import explained, replacing

if sys.platform != "win32":
    import fcntl

REPORTS = "reports.jsonl"

FINISHED = frozenset({"done", "failed"})
"""What need not be tried again; a row that crashed or timed out may fare better the next time."""

_SYNC_EVERY = 5.0
"""How long a line may be in memory alone, should the machine lose its power [s]."""


@dataclass(frozen=True, slots=True)
class Line:
    """A line of the journal.

    Attributes:
        place: Where it begins [bytes].
        data: Its keys: id, status, exit_code, hash, overrides, error, and those of report format 1.
    """

    place: int
    data: dict[str, Any]


def read_lines(path: Path, *, number: Callable[[str], Any] = float) -> Iterator[Line]:
    """The whole lines of a journal; of what is no line of a journal nothing is said.

    Args:
        path: Of the journal.
        number: What is made of the digits of a number that is not whole.

    Raises:
        ExchangeError: It cannot be read.
    """
    try:
        with path.open("rb") as file:
            place = 0
            for text in file:
                data = _parsed(text, number)
                if data is not None:
                    yield Line(place, data)
                place += len(text)
    except OSError as error:
        raise ExchangeError(f"{path} cannot be read: {error.strerror or error}; check its permissions") from error


def _parsed(text: bytes, number: Callable[[str], Any] = float) -> dict[str, Any] | None:
    """A line, or None for one that is torn."""
    if not text.endswith(b"\n"):
        return None
    try:
        data = json.loads(text) if number is float else json.loads(text, parse_float=number)
    except ValueError:
        return None
    whole = isinstance(data, dict) and all(isinstance(data.get(key), str) for key in ("id", "status", "hash"))
    return data if whole else None


class RowKeys:
    """Which ids there are, in which row, and the hashes of their inputs, in 20 bytes a row.

    Ids are told apart by hashes of 64 bits, which a million rows share with a chance of 3e-8; whoever asks for
    duplicates looks at the ids themselves.
    """

    def __init__(self) -> None:
        self._hashes = array("Q")
        self._inputs = bytearray()
        self._sorted: NDArray[np.uint64] = np.zeros(0, dtype=np.uint64)
        self._rows: NDArray[np.intp] = np.zeros(0, dtype=np.intp)

    def __len__(self) -> int:
        """How many rows there are."""
        return len(self._hashes)

    def add(self, row_id: str, input_hash: str) -> None:
        """The id of the next row and its `row_hash`."""
        self._hashes.append(_hash(row_id))
        self._inputs += bytes.fromhex(input_hash)

    def input_hash(self, row: int) -> str:
        """The `row_hash` of a row."""
        return self._inputs[row * HASH_BYTES : (row + 1) * HASH_BYTES].hex()

    def settle(self) -> list[int]:
        """Call once all are there; returns the rows, counted from 0, whose ids another row seems to have too."""
        hashes = np.frombuffer(self._hashes, dtype=np.uint64) if len(self._hashes) else self._sorted
        self._rows = np.argsort(hashes, kind="stable")
        self._sorted = hashes[self._rows]
        same = self._sorted[1:] == self._sorted[:-1]
        doubles = np.concatenate([same, [False]]) | np.concatenate([[False], same])
        return sorted(self._rows[doubles].tolist()) if len(self) > 1 else []

    def row(self, row_id: str) -> int | None:
        """The row of an id, counted from 0."""
        key = _hash(row_id)
        at = self._sorted.searchsorted(np.uint64(key))
        return int(self._rows[at]) if at < len(self._sorted) and int(self._sorted[at]) == key else None

    def is_row(self, row: int, row_id: str) -> bool:
        """Whether a row still has the id it had."""
        return row < len(self._hashes) and self._hashes[row] == _hash(row_id)


def _hash(row_id: str) -> int:
    return int.from_bytes(blake2b(same_id(row_id).encode(), digest_size=8).digest(), "little")


class Folder:
    """The folder of a batch, locked while the batch runs."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._handle: int | None = None

    def __enter__(self) -> Self:
        """Make the folder if it is not there, and lock it.

        Raises:
            ExchangeError: It cannot be made or written to.
            UsageError: Another batch is writing to it.
        """
        with explained(str(self.path)):
            self.path.mkdir(parents=True, exist_ok=True)
            if not os.access(self.path, os.W_OK | os.X_OK):
                raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(self.path))
            if sys.platform != "win32":
                self._handle = os.open(self.path, os.O_RDONLY | os.O_DIRECTORY)
                try:
                    fcntl.flock(self._handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
                except BlockingIOError:
                    os.close(self._handle)
                    self._handle = None
                    raise UsageError(f"another batch is writing to {self.path}; give this one its own folder") from None
                except OSError:  # no locks on this file system
                    pass
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Unlock it."""
        if self._handle is not None:
            os.close(self._handle)


class Journal:
    """The journal, open for writing."""

    def __init__(self, path: Path) -> None:
        """Open it, at its end.

        Raises:
            ExchangeError: It cannot be written.
        """
        self.path = path
        self._synced = time.monotonic()
        with explained(str(path)):
            self._handle = os.open(path, os.O_CREAT | os.O_WRONLY | os.O_APPEND, 0o666)

    def append(self, entries: Sequence[tuple[RowResult, str, Mapping[str, Any]]]) -> None:
        """Write the lines of some rows: each its result, the hash of its input, and what was overridden.

        Raises:
            ExchangeError: They could not be written; then none of them is there.
        """
        data = "".join(_line(*entry) for entry in entries).encode()
        with explained(str(self.path)):
            begun = os.fstat(self._handle).st_size
            try:
                written = 0
                while written < len(data):
                    written += os.write(self._handle, data[written:])
            except BaseException:
                os.ftruncate(self._handle, begun)
                raise
            if time.monotonic() - self._synced > _SYNC_EVERY:
                self.sync()

    def sync(self) -> None:
        """Bring all lines to the disk."""
        with explained(str(self.path)):
            os.fsync(self._handle)
        self._synced = time.monotonic()

    def close(self) -> None:
        """Close it; what was appended stays."""
        os.close(self._handle)


def _line(result: RowResult, input_hash: str, overrides: Mapping[str, Any]) -> str:
    """A line: who the row is and how it ended, then the report."""
    head = {
        "id": result.id,
        "status": result.status,
        "exit_code": result.exit_code,
        "hash": input_hash,
        "overrides": dict(overrides),
        "error": result.error,
    }
    try:
        text = JSON.encode(head)
    except (TypeError, ValueError):  # overrides that are no values of JSON stand as texts: they are only a remark
        text = JSON.encode(head | {"overrides": {str(key): repr(value) for key, value in overrides.items()}})
    return f"{text}\n" if result.report is None else f"{text[:-1]}, {result.report[1:]}\n"


def forget(path: Path, folder: Path) -> None:
    """Remove a journal and the STEP files it tells of, of which none may be taken for another run's.

    Raises:
        ExchangeError: It cannot be read or removed.
    """
    with explained(str(path)):
        for line in read_lines(path):
            _remove_step(folder, line.data)
        path.unlink()


def _remove_step(folder: Path, data: Mapping[str, Any]) -> None:
    """Remove the file that a line of the journal says was written."""
    if data["status"] == "done" and not id_mistakes(data["id"]):  # an id that was tampered with must lead nowhere else
        step_path(folder, data["id"]).unlink(missing_ok=True)


def keep_finished(path: Path, keys: RowKeys, folder: Path | None) -> bytearray:
    """Take what need not be done again from a journal, and drop the rest: torn lines, other inputs, crashes.

    With a line goes the STEP file it tells of, so that none is left that is not of its row.

    Args:
        path: Of the journal.
        keys: The rows there are.
        folder: Where the STEP files are; a row whose file is gone is not finished. None for results only.

    Returns:
        For each row whether it is finished, 1 or 0.

    Raises:
        ExchangeError: The journal cannot be read or written.
    """
    finished = bytearray(len(keys))
    with replacing(path) as aside, aside.open("wb") as kept, path.open("rb") as file:
        for text in file:
            data = _parsed(text)
            if data is None:
                continue
            row = keys.row(data["id"])
            if row is not None and not finished[row] and _holds(data, keys.input_hash(row), folder):
                finished[row] = 1
                kept.write(text)
            elif folder is not None and (row is None or not finished[row]):
                _remove_step(folder, data)
    return finished


def _holds(data: Mapping[str, Any], input_hash: str, folder: Path | None) -> bool:
    """Whether a line tells of a row that is finished, and is so still."""
    if data["status"] not in FINISHED or data["hash"] != input_hash:
        return False
    return folder is None or data["status"] != "done" or step_path(folder, data["id"]).is_file()
