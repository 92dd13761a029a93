"""`reports.jsonl`: one line a finished row, appended as it finishes; what a batch knows of itself.

A line is written at one go and taken back where that fails; what a kill left of a line has no line break, and is
dropped when the batch is resumed. So is a line that is not as it was written, which its last key tells: a checksum of
all before it. Two batches never write to one folder: it is locked while one does.
"""

from __future__ import annotations

import errno
import json
import os
import sys
import time
import zlib
from array import array
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import IO, Any, Self

from cablecad.batch.inputs import Inputs
from cablecad.batch.keys import RowKeys
from cablecad.batch.rows import id_mistakes
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


def read_lines(path: Path, *, number: Callable[[str], Any] = float) -> Iterator[dict[str, Any]]:
    """The whole lines of a journal; of what is no line of a journal nothing is said.

    Args:
        path: Of the journal.
        number: What is made of the digits of a number that is not whole.

    Yields:
        The keys of a line: id, status, exit_code, hash, overrides, error, size, those of report format 1 and checksum.

    Raises:
        ExchangeError: It cannot be read.
    """
    try:
        with path.open("rb") as file:
            for text in file:
                data = _parsed(text, number) if _is_whole(text) else None
                if data is not None:
                    yield data
    except OSError as error:
        raise ExchangeError(f"{path} cannot be read: {error.strerror or error}; check its permissions") from error


def _ending(line: bytes) -> bytes:
    """How a line ends: with a checksum of 32 bits, which no burst of errors as short leaves as it was."""
    return b', "checksum": "%08x"}\n' % zlib.crc32(line)


_ENDING = len(_ending(b""))


def _is_whole(text: bytes) -> bool:
    """Whether a line is what was written."""
    return text.endswith(_ending(text[:-_ENDING]))


def _parsed(text: bytes, number: Callable[[str], Any] = float) -> dict[str, Any] | None:
    """A line, or None for one that is torn or no line of a journal; whether it is whole is not looked at."""
    if not text.endswith(b"\n"):
        return None
    try:
        data = json.loads(text) if number is float else json.loads(text, parse_float=number)
    except (ValueError, RecursionError):
        return None
    known = isinstance(data, dict) and all(isinstance(data.get(key), str) for key in ("id", "status", "hash"))
    return data if known else None


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
        data = b"".join(_line(*entry) for entry in entries)
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


def _line(result: RowResult, input_hash: str, overrides: Mapping[str, Any]) -> bytes:
    """A line: who the row is and how it ended, then the report, then what shows whether all of it is there."""
    head = {
        "id": result.id,
        "status": result.status,
        "exit_code": result.exit_code,
        "hash": input_hash,
        "overrides": dict(overrides),
        "error": result.error,
        "size": result.size,
    }
    try:
        text = JSON.encode(head)
    except (TypeError, ValueError):  # overrides that are no values of JSON stand as texts: they are only a remark
        text = JSON.encode(head | {"overrides": {str(key): repr(value) for key, value in overrides.items()}})
    line = (text[:-1] if result.report is None else f"{text[:-1]}, {result.report[1:-1]}").encode()
    return line + _ending(line)


def forget(path: Path, folder: Path, inputs: Inputs) -> None:
    """Remove a journal and the STEP files it tells of, of which none may be taken for another run's.

    Raises:
        ExchangeError: It cannot be read or removed.
        UsageError: One of these files is an input of this run; then nothing was removed.
    """
    told = array("Q")
    with explained(str(path)):
        with path.open("rb") as file:
            for place, text in _placed(file):
                data = _parsed(text)
                if data is not None and (_is_whole(text) or _is_old(data)) and _has_step(data):
                    inputs.check_removal(step_path(folder, data["id"]))
                    told.append(place)
            for data in _lines_at(file, told):
                _remove(step_path(folder, data["id"]))
        path.unlink()


def _remove(step: Path) -> None:
    with explained(str(step)):
        step.unlink(missing_ok=True)


def _placed(file: IO[bytes]) -> Iterator[tuple[int, bytes]]:
    """Lines, and where each begins [bytes]."""
    place = 0
    for text in file:
        yield place, text
        place += len(text)


def _lines_at(file: IO[bytes], places: Iterable[int]) -> Iterator[dict[str, Any]]:
    """The lines of a journal at some places."""
    for place in places:
        file.seek(place)
        data = _parsed(file.readline())
        if data is not None:
            yield data


def _is_old(data: Mapping[str, Any]) -> bool:
    """Whether a line is of an earlier version, whose lines had neither checksums nor the sizes of STEP files."""
    return "checksum" not in data


def _has_step(data: Mapping[str, Any]) -> bool:
    """Whether a line says that a STEP file was written; an id that was tampered with must lead nowhere else."""
    return data["status"] == "done" and data.get("size", 0) is not None and not id_mistakes(data["id"])


def keep_finished(path: Path, keys: RowKeys, folder: Path, inputs: Inputs, *, builds: bool) -> bytearray:
    """Take what need not be done again from a journal, and drop the rest: torn lines, other inputs, crashes.

    With a line goes the STEP file it tells of, so that none is left that is not of its row.

    Args:
        path: Of the journal.
        keys: The rows there are.
        folder: Where the STEP files are.
        inputs: What must not be removed.
        builds: Whether STEP files are asked for; then a row is not finished whose file is gone or is not whole, or
            which failed and has one.

    Returns:
        For each row whether it is finished, 1 or 0.

    Raises:
        ExchangeError: The journal cannot be read or written.
        UsageError: A file that would be removed is an input, or the journal is of a version whose lines had no
            checksums; then nothing was removed.
    """
    finished = bytearray(len(keys))
    dropped = array("Q")
    whole = old = False
    with replacing(path) as aside, aside.open("wb") as kept, path.open("rb") as file:
        for place, text in _placed(file):
            data = _parsed(text)
            if data is None or not _is_whole(text):  # of a damaged line not even the id can be trusted
                old = old or (data is not None and _is_old(data))
                continue
            whole = True
            row = keys.row(data["id"])
            if row is not None and not finished[row] and _holds(data, keys.input_hash(row), folder, builds):
                finished[row] = 1
                kept.write(text)
            elif _has_step(data) and not (row is not None and finished[row]):
                inputs.check_removal(step_path(folder, data["id"]))
                dropped.append(place)
        if old and not whole:
            raise UsageError(
                f"{path} is of an earlier version of cablecad, whose lines cannot be verified: --force forgets it; or "
                "give another folder"
            )
        for data in _lines_at(file, dropped):
            row = keys.row(data["id"])
            if row is None or not finished[row]:  # else of another line of the same row
                _remove(step_path(folder, data["id"]))
    return finished


def _holds(data: Mapping[str, Any], input_hash: str, folder: Path, builds: bool) -> bool:
    """Whether a line tells of a row that is finished, and is so still."""
    if data["status"] not in FINISHED or data["hash"] != input_hash:
        return False
    if not builds:
        return True
    step = step_path(folder, data["id"])
    return bool(data["size"] == (step.stat().st_size if step.is_file() else None))
