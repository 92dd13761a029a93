"""Reals of a STEP text with the fewest digits that are the same doubles.

Open Cascade's default keeps 13 digits, which at 1 m is 1e-9 mm; asked for `REAL_FORMAT` it keeps all, and more than
most doubles need. Each distinct text is worked out once: of the reals of a hundred cables one in five.

The digits themselves come from pydantic's core, which is here for the scenes anyway: its JSON takes a tenth of the time
of `float` and `repr`, and they are the same.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from pydantic_core import from_json, to_json

Bytes = np.ndarray[Any, np.dtype[np.uint8]]
Places = np.ndarray[Any, np.dtype[np.intp]]
Tokens = np.ndarray[Any, np.dtype[np.bytes_]]

REAL_FORMAT = "%.16E"
"""How Open Cascade is to write reals: 17 significant digits name any double, and the E tells them from integers. Open
Cascade 7.9 has room for 23 characters and no more, which this takes to the last."""

_MANTISSA = 18  # characters of d.dddddddddddddddd; the sign stays where it is
_DIGITS = [0, *range(2, _MANTISSA)]

_MIXING = np.array([0x9E3779B97F4A7C15, 0xBF58476D1CE4E5B9, 0x94D049BB133111EB], np.uint64)
"""Odd numbers without any pattern: the upper bits of the sum of words times these are as good as drawn by lot."""

_PLAIN = 1e-4, 1e16
"""Positive reals from the one to below the other are written without an exponent by JSON and Python alike."""


def shorten_reals(text: Bytes) -> None:
    """Write every real, E and sign and 16 digits before it, with the fewest digits; never longer, so in its own place.

    Args:
        text: As Open Cascade writes it, without any point in its strings; what gets free becomes NUL.
    """
    marks = np.flatnonzero(text == ord("E"))
    marks = marks[marks >= _MANTISSA]
    signs = text[marks + 1]
    marks = marks[((signs == ord("-")) | (signs == ord("+"))) & (text[marks - _MANTISSA + 1] == ord("."))]
    three = digits_of(text[marks + 4]) < 10  # digits of the exponent; else two
    for width, ends in ((_MANTISSA + 4, marks[~three]), (_MANTISSA + 5, marks[three])):
        windows = np.ndarray((len(text) - width,), f"S{width}", text, strides=(1,))  # one that begins at each character
        places = ends - _MANTISSA
        tokens = windows[places]
        whole = (digits_of(_characters(tokens)[:, _DIGITS]) < 10).all(axis=1)
        places, tokens = places[whole], tokens[whole]
        first, rank = _distinct(tokens)
        windows[places] = np.array(reals(_values(tokens[first])), windows.dtype)[rank]


def digits_of(text: Bytes) -> Bytes:
    """What each character says as a digit; above 9 it is none."""
    return text - np.uint8(ord("0"))  # wraps round


def reals(values: list[float]) -> list[bytes]:
    """The fewest digits that read back as the same doubles, as ISO 10303-21 wants them: with a point.

    Args:
        values: Finite, and none below 0.
    """
    if not values:
        return []
    texts = to_json(values).replace(b".0,", b".,").replace(b".0]", b".]")[1:-1].split(b",")
    array = np.array(values)
    least, beyond = _PLAIN
    for i in np.flatnonzero((array != 0.0) & ~((array >= least) & (array < beyond))).tolist():
        digits, _, exponent = repr(values[i]).partition("e")
        texts[i] = f"{digits}{'' if '.' in digits else '.'}E{exponent}".encode("ascii")
    return texts


def _values(tokens: Tokens) -> list[float]:
    """What reals in `REAL_FORMAT` say."""
    listed = np.full((len(tokens), tokens.itemsize + 1), ord(","), np.uint8)
    listed[:, :-1] = _characters(tokens)
    values: list[float] = from_json(b"[" + listed.tobytes()[:-1] + b"]")
    return values


def _characters(tokens: Tokens) -> Bytes:
    """One by one, shape (n, characters a token)."""
    return tokens.view(np.uint8).reshape(len(tokens), tokens.itemsize)


def _distinct(tokens: Tokens) -> tuple[Places, Places]:
    """Where a token of each text stands, hardly any text twice, and for every token which of these is its own."""
    count, width = len(tokens), 8 * len(_MIXING)
    padded = np.zeros((count, width), np.uint8)
    padded[:, : tokens.itemsize] = _characters(tokens)
    words = np.ascontiguousarray(padded.view(np.uint64).T)
    bits = max(count.bit_length(), 1)
    drawn = (_MIXING @ words >> np.uint64(64 - bits)).astype(np.intp)
    own = np.arange(count)
    last = np.empty(1 << bits, np.intp)
    last[drawn] = own
    same = last[drawn]
    same = np.where(np.logical_and.reduce([word[same] == word for word in words]), same, own)  # else it stands alone
    chosen = same == own
    return np.flatnonzero(chosen), (np.cumsum(chosen) - 1)[same]
