"""Which ids the rows of a batch have, and the hashes of their inputs: what is kept of each row throughout."""

from __future__ import annotations

from array import array
from hashlib import blake2b

import numpy as np
from numpy.typing import NDArray

from cablecad.batch.rows import HASH_BYTES, same_id


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
