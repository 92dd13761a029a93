"""Raw data to typed tables: every wrong type and unknown key of a scene at once.

pydantic's core tells what does not fit. Each of it is said again in a user's words and at a user's place, then taken
out, and the rest is read. What was taken out is remembered as lost, so that the checks which follow neither miss it nor
repeat it: an unknown key counts as the key it was meant for.
"""

from __future__ import annotations

import copy
import json
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cache
from itertools import pairwise
from typing import Any

from pydantic_core import ErrorDetails, SchemaValidator, ValidationError

from cablecad.errors import Mistake
from cablecad.scene.keys import Table, checker
from cablecad.scene.schema import (
    CABLE,
    END,
    EQUILIBRIUM,
    MATERIAL,
    PART,
    PORT,
    ROTATION,
    SCENE,
    START,
    TOLERANCE,
)

Place = tuple[str | int, ...]
"""Where a value stands in the raw data: keys and indices from the top."""

_LISTS: dict[str, Table] = {"parts": PART, "cables": CABLE}

_HOMES: dict[Table, str] = {
    SCENE: "the top of the file",
    TOLERANCE: "[tolerance]",
    MATERIAL: "[materials.NAME]",
    PART: "[[parts]]",
    PORT: "[[parts.ports]]",
    ROTATION: "rotation",
    CABLE: "[[cables]]",
    START: "start",
    END: "end",
    EQUILIBRIUM: "equilibrium",
}

_THREE_NUMBERS = "must be three numbers [x, y, z]"

_WORDS = {
    "float_type": "must be a number",
    "finite_number": "must be a finite number",
    "int_type": "must be a whole number",
    "string_type": "must be a text in quotes",
    "bool_type": "must be true or false",
    "list_type": _THREE_NUMBERS,
    "too_short": _THREE_NUMBERS,
    "too_long": _THREE_NUMBERS,
    "dict_type": "must be a table",
}
"""pydantic's kinds of error in our words; our own kind, `in_words`, brings them along."""


@dataclass
class Tables:
    """What could be read of a scene, and what could not.

    Attributes:
        scene: The readable rest.
        mistakes: Each with the place it is at; the paths in them are empty.
        lost: By the place of a table: its keys that are there and could not be read.
    """

    scene: dict[str, Any]
    mistakes: list[tuple[Place, Mistake]] = field(default_factory=list)
    lost: dict[Place, set[str | int]] = field(default_factory=dict)

    def lost_at(self, *place: str | int) -> set[str]:
        """The keys of the table at `place` that are there and could not be read."""
        return {key for key in self.lost.get(place, ()) if isinstance(key, str)}

    def is_lost(self, *place: str | int) -> bool:
        """Whether what is at `place` could not be read at all."""
        return place[-1] in self.lost.get(place[:-1], ())


@cache
def _checker() -> SchemaValidator:
    return checker(SCENE)


def read_tables(data: dict[str, object]) -> Tables:
    """Read raw data as a scene, leaving out what is mistaken."""
    lone = [kind for kind, table in _LISTS.items() if _is_lone(data.get(kind), table)]
    readable = {**data, **{kind: [data[kind]] for kind in lone}}
    mistakes: list[tuple[Place, Mistake]] = [((kind,), Mistake("", _array_of_tables(kind))) for kind in lone]
    try:
        return Tables(_checker().validate_python(readable), mistakes)
    except ValidationError as error:
        entries = error.errors(include_url=False, include_context=False)
    rest = copy.deepcopy(readable)
    lost: dict[Place, set[str | int]] = {}
    for entry in entries:
        trail = list(_trail(entry))
        place = trail[-1].place
        mistakes.append((place, _mistake(entry, trail)))
        cut = _cut(place)
        _take_out(rest, cut)
        for *table, key in _meant(trail, readable) if entry["type"] == "extra_forbidden" else (cut,):
            lost.setdefault(tuple(table), set()).add(key)
    return Tables(_checker().validate_python(rest), mistakes, lost)


# --- where a mistake is -------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Step:
    """A step on the way from the top of the file to a value.

    Attributes:
        place: Of the value.
        table: Whose keys are known at the value, where it is a table or a list of tables.
        example: Of the value; None where there is none to show.
    """

    place: Place
    table: Table | None
    example: Any


def _trail(entry: ErrorDetails) -> Iterator[_Step]:
    """The steps from the top of the file to where pydantic found a mistake.

    pydantic's locations also hold the tags of unions, which are no place in the file.
    """
    step = _Step((), SCENE, None)
    yield step
    for i, part in enumerate(entry["loc"]):
        keys = step.table.keys if step.table is not None else {}
        if step.place == ("materials",):  # its keys are free
            step = _Step((*step.place, part), MATERIAL, next(iter(step.example.values())))
        elif isinstance(part, int):
            step = _Step((*step.place, part), step.table, None)
        elif part in keys:
            step = _Step((*step.place, part), keys[part].kind.table, keys[part].example)
        elif entry["type"] == "extra_forbidden" and i + 1 == len(entry["loc"]):
            step = _Step((*step.place, part), None, None)
        else:
            continue
        yield step


def _cut(place: Place) -> Place:
    """What to take out for a mistake at `place`: a vector whole, but only the one of several cables or ports."""
    if (len(place) == 2 and place[0] in _LISTS) or (len(place) == 4 and place[2] == "ports"):
        return place
    while isinstance(place[-1], int):
        place = place[:-1]
    return place


def _take_out(data: Any, place: Place) -> None:
    *way, last = place
    for part in way:
        data = data[part]
    if isinstance(data, list):
        data[int(last)] = {}  # the indices of the others stay
    else:
        data.pop(last, None)


# --- what to say of it --------------------------------------------------------------------------------------------


def _mistake(entry: ErrorDetails, trail: list[_Step]) -> Mistake:
    """The mistake in a user's words, with the value and the fix."""
    kind, value, here = entry["type"], entry["input"], trail[-1]
    if kind == "extra_forbidden":
        return Mistake("", _unknown_key(trail), value)
    problem = _WORDS.get(kind, entry["msg"])
    if kind in {"list_type", "dict_type"} and str(here.place[0]) in _LISTS and len(here.place) <= 2:
        return Mistake("", _array_of_tables(str(here.place[0])), value)
    if kind in {"list_type", "dict_type"} and (here.place[2:] == ("ports",) or here.place[2:-1] == ("ports",)):
        return Mistake("", _array_of_tables("parts.ports"), value)
    if kind == "float_type" and isinstance(value, str):
        problem += " without quotes or a unit"
    if here.example is not None and kind in _WORDS:
        problem += f", such as {_as_toml(here.example)}"
    return Mistake("", problem, value)


def _array_of_tables(kind: str) -> str:
    return f"must be an array of tables: in TOML each begins with [[{kind}]], in JSON write [{{...}}, {{...}}]"


def _is_lone(value: object, table: Table) -> bool:
    """Whether [cables] was written for [[cables]], so that it can be read as the one cable it holds."""
    return isinstance(value, dict) and not table.keys.keys().isdisjoint(value)


def _unknown_key(trail: list[_Step]) -> str:
    key, table = str(trail[-1].place[-1]), trail[-2].table
    assert table is not None  # pydantic finds unknown keys in tables only
    near = nearest_key(key, table)
    text = f"unknown key {key!r}; " + (f"did you mean {near!r}?" if near else f"known: {', '.join(table.keys)}")
    homes = [home for other, home in _HOMES.items() if key in other.keys]
    return f"{text} ({key} is a key of {', '.join(homes)})" if homes else text


def nearest_key(key: str, table: Table) -> str | None:
    """The key of a table that another one was probably meant for."""
    from difflib import get_close_matches

    near = get_close_matches(key.lower().replace("-", "_"), table.keys, n=1)
    return near[0] if near else None


def _meant(trail: list[_Step], data: Any) -> Iterator[Place]:
    """The keys an unknown key may stand for and that are not there themselves: they must not be called missing."""
    key = str(trail[-1].place[-1])
    for step, following in pairwise(trail):
        if isinstance(data, dict) and step.table is not None:
            meant = nearest_key(key, step.table) if following is trail[-1] else key
            if meant in step.table.keys and meant not in data:
                yield (*step.place, meant)
        data = data[following.place[-1]]


def _as_toml(value: object) -> str:
    """A value as it stands in a TOML file, on one line."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {_as_toml(part)}" for key, part in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(_as_toml(part) for part in value) + "]"
    return json.dumps(value)
