"""The entities of a STEP text as Open Cascade writes it: each on a line of its own, and what it refers to.

All of it happens in place, on the bytes as one array: no text gets longer but strings, which come first. What is too
much becomes NUL, and one pass drops every NUL at the end. A long text goes through in blocks, which stay in the
processor's cache.

1. Strings become ASCII (`part21`); what would mislead the rest stands masked in them.
2. Line breaks within an entity go, with the spaces after them.
3. Every # is a definition, where it begins a line, or a reference. Their numbers are read digit by digit, a digit of
   all of them at once.
4. Every real is replaced by the fewest digits that are the same double (`reals`).
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from cablecad.brep.part21 import requoted
from cablecad.brep.reals import Bytes, Places, Tokens, digits_of, shorten_reals
from cablecad.errors import GeometryError

_NOT_FINITE = re.compile(rb"[(,]-?(?:NAN|INF)")

# # and . within strings, while outside they mean a reference and a real; strings hold no controls otherwise.
HASH_IN_STRING = b"\x01"
_POINT_IN_STRING = b"\x02"
_UNMASKED = bytes.maketrans(_POINT_IN_STRING, b".")
_NOTHING = 0

INITIALS = 8
"""Characters at the beginning of an entity that are kept beside it: they tell the kinds from each other."""

_BLOCK = 1 << 19
"""Characters worked on at once: 2^18 take a tenth more time, all of 4 MB a quarter."""


@dataclass(eq=False)
class Entities:
    """The entities of a DATA section, counted from 0 in the order they stand there.

    Attributes:
        text: A line of each, ``#12=KIND(...);``, with `HASH_IN_STRING` for every # in a string.
        bounds: Where in the text the line of each begins, and where the last one's ends.
        numbers: Of each, such as 12.
        initials: The first characters of each one's text, as many as `INITIALS`.
        targets: The entities that are referred to, by one after the other.
        starts: Where in `targets` those of each entity begin, and where the last one's end.
    """

    text: bytes
    bounds: Places
    numbers: Places
    initials: Tokens
    targets: Places
    starts: Places

    def __len__(self) -> int:
        return len(self.numbers)

    def line(self, entity: int) -> bytes:
        """Of one entity, without the line's end."""
        return self.text[self.bounds[entity] : self.bounds[entity + 1] - 1]


class _Block(NamedTuple):
    """Some entities: their lines, first characters, and all numbers behind a #, with whether each is a definition."""

    text: bytearray
    initials: Tokens
    values: Places
    defines: np.ndarray


def read_entities(text: bytes, begin: int, end: int) -> Entities:
    """Take a DATA section apart.

    Args:
        text: Its reals are written in `REAL_FORMAT`.
        begin: Where in the text the section does, behind ``DATA;``.
        end: Where it ends, before ``ENDSEC;``.

    Raises:
        GeometryError: A real is not finite, or an entity is referred to and not there.
    """
    blocks = [_read_block(block) for block in _blocks(text, begin, end)]
    lines = b"".join(block.text for block in blocks)
    bounds = np.append(0, np.flatnonzero(np.frombuffer(lines, np.uint8) == ord("\n")) + 1)
    initials, values, defines = (
        np.concatenate(parts)
        for parts in zip(*((block.initials, block.values, block.defines) for block in blocks), strict=True)
    )
    numbers = values[defines]
    entity = np.full(int(values.max(initial=0)) + 1, -1)
    entity[numbers] = np.arange(len(numbers))
    targets = entity[values[~defines]]
    if (targets < 0).any():
        raise GeometryError("Open Cascade refers to an entity that it did not write; check the solids that were given")
    starts = np.append(np.flatnonzero(defines) - np.arange(len(numbers)), len(targets))
    return Entities(lines, bounds, numbers, initials, targets, starts)


def _blocks(text: bytes, begin: int, end: int) -> Iterator[bytes]:
    """Some whole entities after the other; one block at least."""
    characters = np.frombuffer(text, np.uint8)
    while True:
        cut = begin + _BLOCK
        while True:
            cut = text.find(b";\n", cut, end) + 2
            if cut < 2:
                yield text[begin:end]
                return
            quotes = np.count_nonzero(characters[begin:cut] == ord("'"))
            if quotes % 2 == 0:  # else the line ends within a string
                break
        yield text[begin:cut]
        begin = cut


def _read_block(block: bytes) -> _Block:
    # A line before the first, so that all begin alike; and room to look beyond the last.
    before = b";\n"
    written = bytearray().join((before, *_with_plain_strings(block), bytes(24)))
    text = np.frombuffer(written, np.uint8)
    if _may_be_infinite(text) and _NOT_FINITE.search(b"'".join(block.split(b"'")[::2])):
        raise GeometryError(
            "a solid has coordinates that are not finite numbers, and STEP cannot hold them; "
            "check the solids that were given"
        )
    _join_lines(text)
    hashes = np.flatnonzero(text == ord("#"))
    values, behind = _integers(text, hashes + 1)
    defines = text[hashes - 1] == ord("\n")
    bodies = _without_spaces(text, _without_spaces(text, behind[defines]) + 1)  # around the =
    initials = np.ndarray((len(text) - INITIALS,), f"S{INITIALS}", text, strides=(1,))[bodies]
    shorten_reals(text)
    text[: len(before)] = _NOTHING
    return _Block(written.translate(_UNMASKED, bytes([_NOTHING])), initials, values, defines)


def _with_plain_strings(data: bytes) -> list[bytes]:
    """A text in pieces, its strings as they are to be written, but for what is masked."""
    quotes = np.flatnonzero(np.frombuffer(data, np.uint8) == ord("'"))
    # A quote within a string is doubled: its two halves are strings, with nothing between them.
    first, last = quotes[::2] + 1, quotes[1::2]
    filled = first < last
    known: dict[bytes, bytes] = {}
    pieces: list[bytes] = []
    done = 0
    for begin, end in zip(first[filled].tolist(), last[filled].tolist(), strict=True):
        string = data[begin:end]
        plain = known.get(string)
        if plain is None:
            plain = requoted(b"'" + string + b"'")[1:-1]
            plain = known[string] = plain.replace(b"#", HASH_IN_STRING).replace(b".", _POINT_IN_STRING)
        if plain != string:
            pieces += (data[done:begin], plain)
            done = end
    return [*pieces, data[done:]]


def _may_be_infinite(text: Bytes) -> bool:
    """Whether NAN or INF is in a text; several times as fast as looking for the words."""
    middle, last = np.flatnonzero(text == ord("A")), np.flatnonzero(text == ord("F"))
    nan = (text[middle - 1] == ord("N")) & (text[middle + 1] == ord("N"))
    infinite = (text[last - 2] == ord("I")) & (text[last - 1] == ord("N"))
    return bool(nan.any() or infinite.any())


def _join_lines(text: Bytes) -> None:
    """Erase the line breaks within entities, with the spaces after each."""
    breaks = np.flatnonzero(text == ord("\n"))
    breaks = breaks[text[breaks - 1] != ord(";")]
    text[breaks] = _NOTHING
    _without_spaces(text, breaks + 1)


def _without_spaces(text: Bytes, places: Places) -> Places:
    """Erase the spaces from each place on, and give what is behind them."""
    places, going = places.copy(), np.arange(len(places))
    while len(going := going[text[places[going]] == ord(" ")]):
        text[places[going]] = _NOTHING
        places[going] += 1
    return places


def _integers(text: Bytes, places: Places) -> tuple[Places, Places]:
    """The whole number from each place on, and what is behind it."""
    places, values = places.copy(), np.zeros(len(places), np.intp)
    while (more := (digits := digits_of(text[places])) < 10).any():
        values = np.where(more, 10 * values + digits, values)
        places += more
    return values, places
