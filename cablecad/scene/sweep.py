"""One value of a scene file changed over a range: ``cables.W1.length=300:400:11``.

The value is changed in the raw data, before they are checked: a variant is what the file would have been.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from cablecad.errors import UsageError

_MOST_VALUES = 1_000_000
"""Of a sweep; more is a slip of the keyboard."""

_FORM = "write PLACE=START:STOP:COUNT or PLACE=VALUE,VALUE,..., such as cables.W1.length=300:400:11"


_STEP = re.compile(r'(?P<joint>\.?)(?:"(?P<quoted>[^"]*)"|\[(?P<number>\d{1,9})\]|(?P<bare>[^.\[\]"]+))')


@dataclass(frozen=True, slots=True)
class Sweep:
    """A place in a scene and the values it takes.

    Attributes:
        place: Dotted, a cable or part by its name: ``cables.W1.end.position[0]``.
        values: At least one.
    """

    place: str
    values: tuple[float, ...]


def parse_sweep(text: str) -> Sweep:
    """Read ``PLACE=START:STOP:COUNT``, both ends included and evenly spaced, or ``PLACE=VALUE,VALUE,...``.

    Raises:
        UsageError: It is neither, or a number in it cannot be.
    """
    place, equals, listed = text.rpartition("=")
    place = place.strip()
    if not equals or not place or not listed.strip():
        raise UsageError(f"{text!r} is no range of values: {_FORM}")
    if ":" not in listed:
        return Sweep(place, tuple(_number(word, text) for word in listed.split(",")))
    words = listed.split(":")
    if len(words) != 3:
        raise UsageError(f"{text!r} is no range of values: {_FORM}")
    start, stop = _number(words[0], text), _number(words[1], text)
    try:
        count = int(words[2])
    except ValueError:
        count = 0
    if not 1 <= count <= _MOST_VALUES or (count == 1 and start != stop):
        raise UsageError(
            f"{text!r}: the third number is how many values there are, both ends included: from 2 to {_MOST_VALUES}"
        )
    return Sweep(place, tuple(_between(start, stop, i, count) for i in range(count)))


def _between(start: float, stop: float, i: int, count: int) -> float:
    """The i-th of evenly spaced values; the ends exactly, and whole numbers whole where they were written so."""
    if i in (0, count - 1):
        return stop if i else start
    value = start + (stop - start) * i / (count - 1)
    both_whole = isinstance(start, int) and isinstance(stop, int)
    return round(value) if both_whole and (stop - start) * i % (count - 1) == 0 else value


def _number(word: str, text: str) -> float:
    """A number, an int where it is written as one: an equilibrium's index is."""
    try:
        return int(word)
    except ValueError:
        pass
    try:
        value = float(word)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise UsageError(f"{text!r}: {word.strip()!r} is no number; {_FORM}")
    return value


def with_value(data: Mapping[str, Any], place: str, value: object) -> dict[str, Any]:
    """Raw data of a scene with one value changed, or added where its table is there; the given data stay as they are.

    Args:
        data: Tables and lists, as a file holds them.
        place: Dotted, as messages about scenes have it: ``cables.W1.end.position[1]``. Cables and parts go by name or
            by number (``cables[0]``); a name with a dot or a bracket stands in quotes.
        value: What stands there then.

    Raises:
        UsageError: There is no such place; the message names what there is.
    """
    changed: dict[str, Any] = _replaced(dict(data), place_steps(place), value, place)
    return changed


def place_steps(place: str) -> list[str | int]:
    """The keys and numbers of a dotted place.

    Raises:
        UsageError: It is none.
    """
    steps: list[str | int] = []
    at = 0
    while at < len(place):
        found = _STEP.match(place, at)
        # Between two keys stands a dot; before a number, and at the beginning, none.
        if found is None or bool(found["joint"]) != (at > 0 and found["number"] is None):
            raise UsageError(f"{place!r} is no place such as cables.W1.end.position[1]: see {place[at:]!r}")
        at = found.end()
        if found["number"] is not None:
            steps.append(int(found["number"]))
        elif found["quoted"] is not None:
            steps.append(found["quoted"])
        else:
            steps.append(found["bare"].strip())
    return steps


def _replaced(level: Any, steps: list[str | int], value: object, place: str) -> Any:
    """A copy of one level with the value changed in or below it."""
    if not steps:
        return value
    step, rest = steps[0], steps[1:]
    if isinstance(level, list):
        names = [entry.get("name") if isinstance(entry, dict) else None for entry in level]
        i = step if isinstance(step, int) else names.index(step) if step in names else len(level)
        if i >= len(level):
            raise _missing(step, [name for name in names if name is not None] or range(len(level)), place)
        return [*level[:i], _replaced(level[i], rest, value, place), *level[i + 1 :]]
    if not isinstance(level, dict):
        raise UsageError(f"{place!r}: there is nothing called {step!r} in a single value; end the place before it")
    if isinstance(step, int) or (rest and step not in level):
        raise _missing(step, level, place)
    return {**level, step: _replaced(level.get(step), rest, value, place)}


def _missing(step: str | int, there: Iterable[object], place: str) -> UsageError:
    listed = ", ".join(map(str, there)) or "nothing"
    return UsageError(f"{place!r}: there is no {step!r} in the scene; there is {listed}")
