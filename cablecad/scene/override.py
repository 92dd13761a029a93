"""Dotted names such as ``cables.W1.end.position[1]``: which place of a scene's raw data they name, and setting it.

A dotted name is what the messages about a scene print. Cables and parts go by name or by number (``cables[0]``), and a
name with a dot or a bracket in it stands in quotes (``cables."W1.a".length``).
"""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from cablecad.errors import Mistake, SceneError
from cablecad.scene.keys import TEXT, VECTOR, Table
from cablecad.scene.schema import MATERIAL, SCENE
from cablecad.scene.tables import Place, nearest_key

_STEP = re.compile(r'(?P<joint>\.?)(?:(?P<quoted>"(?:[^"\\]|\\.)*")|\[(?P<index>\d{1,9})\]|(?P<bare>[^.\[\]"]+))')


@dataclass(frozen=True, slots=True)
class Target:
    """A place in the raw data of a scene that a dotted name names.

    Attributes:
        name: As it was given.
        place: Keys and indices from the top.
        is_text: Whether a text goes there as it is, so that "007" stays one.
        whole: The vector that is there if nothing was written: one number of it may be changed.
    """

    name: str
    place: Place
    is_text: bool = False
    whole: tuple[float, ...] | None = None

    def put(self, data: dict[str, Any], value: Any) -> dict[str, Any]:
        """A copy of raw data with another value here; it shares all that is not on the way. None takes the key out."""
        changed: dict[str, Any] = self._put(data, self.place, value)
        return changed

    def _put(self, there: Any, place: Place, value: Any) -> Any:
        step, *rest = place
        if isinstance(step, int):
            parts = list(there if isinstance(there, list) else self.whole or ())
            parts[step] = self._put(parts[step], tuple(rest), value) if rest else value
            return parts
        table = dict(there) if isinstance(there, dict) else {}
        if rest:
            table[step] = self._put(table.get(step), tuple(rest), value)
        elif value is None:
            table.pop(step, None)
        else:
            table[step] = value
        return table


def overlaps(one: Target, other: Target) -> bool:
    """Whether two targets are one place, or one lies within the other."""
    shared = min(len(one.place), len(other.place))
    return one.place[:shared] == other.place[:shared]


def find_target(name: str, data: dict[str, Any]) -> Target:
    """Look a dotted name up in a scene.

    Args:
        name: Such as ``cables.W1.length``, ``cables[0].end.position[1]``, ``tolerance.shape``.
        data: The raw data of the scene, free of values of a wrong type; a known key need not be there.

    Raises:
        SceneError: No such key, cable, part or material; the message has the nearest there is.
    """
    place: Place = ()
    table: Table | None = SCENE
    there: Any = data
    is_text, whole = False, None
    for step in _steps(name):
        if _has_members(place):
            step = _member(name, str(place[-1]), step, there)  # noqa: PLW2901 - its index is the step
        elif place == ("materials",):
            _known_material(name, step, there)
            table = MATERIAL
        elif isinstance(step, int):
            if not _is_vector(table, place, there, whole):
                raise _unknown(name, f"{_shown(place)} is no list of numbers: leave out [{step}]")
            if step > 2:
                raise _unknown(name, f"[{step}] is beyond the three numbers of {_shown(place)}: [0], [1] and [2]")
            if there is None and whole is None:
                problem = f"the scene has no {_shown(place)} to change one number of: give it whole, as [x, y, z]"
                raise _unknown(name, problem)
        elif table is None:
            raise _unknown(name, f"{_shown(place)} holds no keys: leave out .{step}")
        else:
            if step not in table.keys:
                raise _unknown(name, _unknown_key(step, table, place))
            known = table.keys[step]
            is_text = known.kind is TEXT
            whole = tuple(known.default) if isinstance(known.default, list) else None
            table = known.kind.table
        there = _below(there, step)
        place = (*place, step)
        if isinstance(step, int) and not _has_members(place[:-1]):
            table = None
    if _has_members(place) or _has_members(place[:-1]) or (place[0] == "materials" and len(place) < 3):
        raise _unknown(name, "names no single value: go on to one of its keys, as in cables.W1.length")
    return Target(name, place, is_text, whole)


def _steps(name: str) -> list[str | int]:
    """The keys and indices of a dotted name."""
    steps: list[str | int] = []
    at = 0
    while at < len(name):
        found = _STEP.match(name, at)
        # Between two keys stands a dot; before an index, and at the beginning, none.
        if found is None or bool(found["joint"]) != (at > 0 and found["index"] is None):
            raise _unknown(name, f"is no dotted name such as cables.W1.end.position[1]: see {name[at:]!r}")
        if found["index"] is not None:
            steps.append(int(found["index"]))
        elif found["quoted"] is not None:
            try:
                steps.append(json.loads(found["quoted"]))
            except ValueError:
                raise _unknown(name, f"{found['quoted']} is no text in quotes as JSON has it") from None
        else:
            steps.append(found["bare"].strip())
        at = found.end()
    if not steps:
        raise _unknown(name, "is empty; write a dotted name such as cables.W1.length")
    return steps


def _has_members(place: Place) -> bool:
    """Whether at a place is a list of tables that have names: cables, parts, or the ports of a part."""
    return place in (("cables",), ("parts",)) or (len(place) == 3 and place[0] == "parts" and place[2] == "ports")


def _member(name: str, kind: str, step: str | int, there: Any) -> int:
    """The index of a cable or part."""
    names = [one.get("name") for one in there or ()]
    if isinstance(step, int):
        if step < len(names):
            return step
        raise _unknown(name, f"the scene has {len(names)} {kind}, counted from 0")
    if names.count(step) > 1:
        raise _unknown(name, f"{names.count(step)} {kind} are called {step!r}: write {kind}[0] and so on")
    if step in names:
        return names.index(step)
    raise _unknown(name, f"no {kind[:-1]} {step!r}; {_nearest_of(step, [n for n in names if isinstance(n, str)])}")


def _known_material(name: str, step: str | int, there: Any) -> None:
    known = list(there or ())
    if step not in known:
        raise _unknown(name, f"no material {step!r}; {_nearest_of(str(step), known)}")


def _nearest_of(word: str, known: Sequence[str]) -> str:
    from difflib import get_close_matches

    near = get_close_matches(word, known, n=1)
    if near:
        return f"did you mean {near[0]!r}?"
    shown = ", ".join(known[:10]) + (", ..." if len(known) > 10 else "")
    return f"the scene has {shown or 'none'}"


def _unknown_key(key: str | int, table: Table, place: Place) -> str:
    near = nearest_key(str(key), table)
    where = f" of {_shown(place)}" if place else ""
    return f"unknown key {key!r}{where}; " + (f"did you mean {near!r}?" if near else f"known: {', '.join(table.keys)}")


def _is_vector(table: Table | None, place: Place, there: Any, whole: tuple[float, ...] | None) -> bool:
    """Whether single numbers of what is at `place` can be named: the vectors, by the model of the scene."""
    if table is not None or not place or isinstance(place[-1], int):
        return False
    return isinstance(there, list) or (there is None and (whole is not None or place[-1] in _VECTORS))


def _vectors(table: Table) -> set[str]:
    """The keys of a table, and of those in it, that hold three numbers."""
    found = set()
    for name, key in table.keys.items():
        if key.kind.table is not None:
            found |= _vectors(key.kind.table)
        elif key.kind is VECTOR:
            found.add(name)
    return found


_VECTORS = _vectors(SCENE)


def _below(there: Any, step: str | int) -> Any:
    if isinstance(there, dict):
        return there.get(str(step))
    return there[step] if isinstance(there, list) and isinstance(step, int) and step < len(there) else None


def _shown(place: Place) -> str:
    return "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in place)[1:]


def _unknown(name: str, problem: str) -> SceneError:
    return SceneError([Mistake(name, problem)])
