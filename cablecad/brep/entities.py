"""The entities of a STEP text as Open Cascade writes it: each on a line of its own, and what it refers to.

All of it happens in place, on the bytes as one array: no text gets longer but strings, which come first. What is too
much becomes NUL, and one pass drops every NUL at the end.

1. Strings become ASCII (`part21`); what would mislead the rest stands masked in them.
2. Line breaks within an entity go, with the spaces after them.
3. Every # is a definition, where it begins a line, or a reference. Their numbers are read digit by digit, a digit of
   all of them at once.
4. Every real, E and sign and 16 digits before it, is replaced by the fewest digits that are the same double, which
   never are longer; each distinct text is worked out once.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

import numpy as np

from cablecad.brep.part21 import requoted
from cablecad.errors import GeometryError

Bytes = np.ndarray[Any, np.dtype[np.uint8]]
Places = np.ndarray[Any, np.dtype[np.intp]]
Tokens = np.ndarray[Any, np.dtype[np.bytes_]]

REAL_FORMAT = "%.16E"
"""How Open Cascade is to write reals: 17 significant digits name any double, and the E tells them from integers. Open
Cascade 7.9 has room for 23 characters and no more, which this takes to the last."""

_NOT_FINITE = re.compile(rb"[(,]-?(?:NAN|INF)")
_BARE_EXPONENT = re.compile(r"\n(\d)E")

_MANTISSA = 18  # characters of d.dddddddddddddddd; the sign stays where it is
_DIGITS = [0, *range(2, _MANTISSA)]

_MIXING = np.array([0x9E3779B97F4A7C15, 0xBF58476D1CE4E5B9, 0x94D049BB133111EB], np.uint64)
"""Odd numbers without any pattern: words times these hardly ever have the same sum, modulo 2^64."""

# # and . within strings, while outside they mean a reference and a real; strings hold no controls otherwise.
HASH_IN_STRING = b"\x01"
_POINT_IN_STRING = b"\x02"
_UNMASKED = bytes.maketrans(_POINT_IN_STRING, b".")
_NOTHING = 0


@dataclass(eq=False)
class Entities:
    """The entities of a DATA section, counted from 0 in the order they stand there.

    Attributes:
        lines: ``#12=KIND(...);`` of each, with `HASH_IN_STRING` for every # in a string.
        numbers: Of each, such as 12.
        initials: The first character of each one's text.
        targets: The entities that are referred to, by one after the other.
        starts: Where in `targets` those of each entity begin, and where the last one's end.
    """

    lines: list[bytes]
    numbers: Places
    initials: Bytes
    targets: Places
    starts: Places


def read_entities(data: bytes) -> Entities:
    """Take a DATA section apart.

    Args:
        data: From behind ``DATA;`` to before ``ENDSEC;``, its reals written in `REAL_FORMAT`.

    Raises:
        GeometryError: A real is not finite, or an entity is referred to and not there.
    """
    # A line before the first, so that all begin alike; and room to look beyond the last.
    text = np.frombuffer(bytearray(b"".join((b";\n", _with_plain_strings(data), bytes(24)))), np.uint8)
    if _may_be_infinite(text) and _NOT_FINITE.search(b"'".join(data.split(b"'")[::2])):
        raise GeometryError(
            "a solid has coordinates that are not finite numbers, and STEP cannot hold them; "
            "check the solids that were given"
        )
    _join_lines(text)
    hashes = np.flatnonzero(text == ord("#"))
    values, behind = _integers(text, hashes + 1)
    defines = text[hashes - 1] == ord("\n")
    bodies = _without_spaces(text, _without_spaces(text, behind[defines]) + 1)  # around the =
    initials = text[bodies]
    _shorten_reals(text)

    numbers, count = values[defines], int(np.count_nonzero(defines))
    entity = np.full(int(values.max(initial=0)) + 1, -1)
    entity[numbers] = np.arange(count)
    targets = entity[values[~defines]]
    if (targets < 0).any():
        raise GeometryError("Open Cascade refers to an entity that it did not write; check the solids that were given")
    starts = np.append(np.flatnonzero(defines) - np.arange(count), len(targets))
    lines = text.tobytes().translate(_UNMASKED, bytes([_NOTHING])).split(b"\n")[1:-1]
    return Entities(lines, numbers, initials, targets, starts)


def _with_plain_strings(data: bytes) -> bytes:
    """The text with its strings as they are to be written, but for what is masked."""
    quotes = np.flatnonzero(np.frombuffer(data, np.uint8) == ord("'"))
    # A quote within a string is doubled: its two halves are strings, with nothing between them.
    first, last = quotes[::2] + 1, quotes[1::2]
    filled = first < last
    known: dict[bytes, bytes] = {}
    pieces: list[bytes] = []
    done = 0
    for begin, end in zip(first[filled].tolist(), last[filled].tolist(), strict=True):
        string = data[begin:end]
        if string not in known:
            plain = requoted(b"'" + string + b"'")[1:-1]
            known[string] = plain.replace(b"#", HASH_IN_STRING).replace(b".", _POINT_IN_STRING)
        pieces += (data[done:begin], known[string])
        done = end
    return b"".join((*pieces, data[done:]))


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
    while (more := (digits := _digits(text[places])) < 10).any():
        values = np.where(more, 10 * values + digits, values)
        places += more
    return values, places


def _shorten_reals(text: Bytes) -> None:
    """Write every real with the fewest digits, in its own place."""
    marks = np.flatnonzero(text == ord("E"))
    marks = marks[marks >= _MANTISSA]
    signs = text[marks + 1]
    marks = marks[((signs == ord("-")) | (signs == ord("+"))) & (text[marks - _MANTISSA + 1] == ord("."))]
    three = _digits(text[marks + 4]) < 10  # digits of the exponent; else two
    for width, ends in ((_MANTISSA + 4, marks[~three]), (_MANTISSA + 5, marks[three])):
        windows = np.ndarray((len(text) - width,), f"S{width}", text, strides=(1,))  # one that begins at each character
        places = ends - _MANTISSA
        tokens = windows[places]
        whole = (_digits(tokens.view(np.uint8).reshape(-1, width)[:, _DIGITS]) < 10).all(axis=1)
        places, tokens = places[whole], tokens[whole]
        first, rank = _distinct(tokens)
        windows[places] = np.array(reals(list(map(float, tokens[first].tolist()))), windows.dtype)[rank]


def _distinct(tokens: Tokens) -> tuple[Places, Places]:
    """Where each distinct token first stands, and for every token which of these it is."""
    words = tokens.astype("S24").view(np.uint64).reshape(-1, 3)
    _, first, rank = np.unique((words * _MIXING).sum(axis=1), return_index=True, return_inverse=True)
    if (tokens[first][rank] != tokens).any():  # two texts of one sum: as likely as a wrong bit in memory
        _, first, rank = np.unique(tokens, return_index=True, return_inverse=True)
    return first, rank


def _digits(text: Bytes) -> Bytes:
    """What each character says as a digit; above 9 it is none."""
    return text - np.uint8(ord("0"))  # wraps round


def reals(values: list[float]) -> list[bytes]:
    """The fewest digits that read back as the same doubles, as ISO 10303-21 wants them: with a point.

    Args:
        values: None below 0.
    """
    text = "\n" + repr(values)[1:-1].replace(", ", "\n") + "\n"
    text = _BARE_EXPONENT.sub(r"\n\1.E", text.replace(".0\n", ".\n").replace("e", "E"))
    return text.encode("ascii").split(b"\n")[1:-1]
