"""Rigid parts that were read once and serve many scenes."""

from __future__ import annotations

import os
from collections import OrderedDict
from os import PathLike
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cablecad.brep.document import Document

_MOST = 64
"""Documents kept: a loom has a handful of parts, and a sweep over a catalogue must not fill the memory."""


class Documents:
    """Keeps what was read of STEP files, as long as the files stay as they are.

    A document is not changed by being written: every scene's assembly takes copies of its labels.
    """

    def __init__(self) -> None:
        self._kept: OrderedDict[tuple[str, int, int], Document] = OrderedDict()

    def read(self, path: str | PathLike[str]) -> Document:
        """What is in a STEP file, from memory where its time and size are those of the last reading.

        Raises:
            ExchangeError: As `cablecad.brep.step.read_step`.
        """
        from cablecad.brep.step import read_step

        try:
            status = os.stat(path)  # noqa: PTH116 - a path that cannot be one is read_step's to tell
        except (OSError, ValueError):
            return read_step(path)
        key = (os.path.realpath(path), status.st_mtime_ns, status.st_size)
        if key in self._kept:
            self._kept.move_to_end(key)
            return self._kept[key]
        document = read_step(path)
        self._kept[key] = document
        while len(self._kept) > _MOST:
            self._kept.popitem(last=False)
        return document
