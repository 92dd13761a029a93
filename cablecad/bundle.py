"""Pieces of centrelines evaluated together: calls for each take longer than the arithmetic of its points.

A kind of piece that can do so has a class method ``bundle`` that makes a `Bundle` of some; others are asked one by one.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np

from cablecad.centreline import Array, ComplexArray, Frames, Piece


class Bundle(Protocol):
    """Some pieces; arclengths are given in a row for each, shape (n, k) [mm]."""

    @property
    def pieces(self) -> Sequence[Piece]:
        """The pieces, n of them."""
        ...

    def frames(self, s: Array) -> Frames:
        """Positions and frames at `s`, shape (n, k, 3) each."""
        ...

    def turns(self, s: Array, order: int) -> ComplexArray | None:
        """`Piece.turns` of all, shape (order + 1, n, k); None if one of them has none."""
        ...


class OneByOne:
    """Pieces of any kinds."""

    def __init__(self, pieces: Sequence[Piece]) -> None:
        self.pieces = pieces

    def frames(self, s: Array) -> Frames:
        """Positions and frames at `s`, shape (n, k, 3) each."""
        if len(self.pieces) == 1:
            return Frames(*(field[None] for field in self.pieces[0].frames(s[0])))
        each = [piece.frames(row) for piece, row in zip(self.pieces, s, strict=True)]
        return Frames(*map(np.stack, zip(*each, strict=True)))

    def turns(self, s: Array, order: int) -> ComplexArray | None:
        """`Piece.turns` of all, shape (order + 1, n, k); None if one of them has none."""
        found = []
        for piece, row in zip(self.pieces, s, strict=True):
            turns = piece.turns(row, order)
            if turns is None:
                return None
            found.append(turns)
        return found[0][:, None] if len(found) == 1 else np.stack(found, axis=1)


def bundled(pieces: Sequence[Piece]) -> Bundle:
    """Some pieces of one kind, together if that kind can."""
    together: Any = getattr(type(pieces[0]), "bundle", OneByOne)
    bundle: Bundle = OneByOne(pieces) if len(pieces) == 1 else together(pieces)
    return bundle
