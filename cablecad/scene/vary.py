"""A scene with other numbers in a few places, made from the scene that was resolved before: the rows of a batch.

Only what is plain is done here: numbers of cables, and of the ends they have by numbers. The objects of the model are
made anew with all their checks, and whatever they refuse, or is not plain, is left to `resolve_scene`, which alone
tells of mistakes. tests/scene/test_scene_vary.py holds the two together.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from cablecad.errors import SceneError
from cablecad.model import Cable, Clamp, PartPort, Pin, Port, Scene, Toward
from cablecad.scene.override import Target
from cablecad.scene.tables import Place

_NUMBERS = frozenset(
    {"diameter", "length", "slack", "chord", "force", "angle_deg", "rise", "bend_radius", "min_bend_radius"}
)
"""The numbers of a cable."""

_VECTORS = frozenset({"position", "outward", "direction"})
"""The vectors of an end."""

End = Clamp | Pin | Port | PartPort | Toward


class _NotPlainError(Exception):
    """A change that is not made here."""


def vary_scene(scene: Scene, changes: Sequence[tuple[Target, Any]]) -> Scene | None:
    """Make the scene that `resolve_scene` makes of the changed raw data.

    Args:
        scene: What it made of the data as they were.
        changes: Places and their new values, in the order they are set.

    Returns:
        The scene; None where it takes a full resolve to know it, or what is wrong with it.
    """
    cables = list(scene.cables)
    try:
        for target, value in changes:
            kind, *way = target.place
            if kind != "cables":
                return None
            number = int(way[0])
            cables[number] = _changed(cables[number], tuple(way[1:]), value)
    except (_NotPlainError, SceneError):
        # One change may go against another that follows: the full resolve sees all of them.
        return None
    return scene.with_cables(cables)


def _changed(cable: Cable, way: Place, value: Any) -> Cable:
    """A cable with another value.

    Raises:
        SceneError: Mistakes in it.
    """
    key, *below = way
    if key in _NUMBERS and not below:
        # With an end on a part the scene judges the data of a cable by what the part has there.
        if getattr(cable, str(key)) is None and any(isinstance(end, PartPort) for end in (cable.start, cable.end)):
            raise _NotPlainError
        changed: dict[str, Any] = {str(key): _number(value)}
        return replace(cable, **changed)
    if key in ("start", "end") and below:
        end: End = getattr(cable, str(key))
        changed = {str(key): _changed_end(end, below[0], below[1:], value)}
        return replace(cable, **changed)
    raise _NotPlainError


def _changed_end(end: End, key: str | int, below: Sequence[str | int], value: Any) -> End:
    """An end with another value of a key it has.

    Raises:
        SceneError: Mistakes in it.
    """
    found = getattr(end, str(key), None)
    if isinstance(end, PartPort | Toward) or found is None:
        raise _NotPlainError
    if key == "straight" and not below:
        changed: dict[str, Any] = {"straight": _number(value)}
    elif key in _VECTORS and below:
        parts = list(found)
        parts[int(below[0])] = _number(value)
        changed = {str(key): tuple(parts)}
    elif key in _VECTORS and isinstance(value, list) and len(value) == len(found):
        changed = {str(key): tuple(map(_number, value))}
    else:
        raise _NotPlainError
    return replace(end, **changed)


def _number(value: Any) -> float:
    """A finite number as scene files hold it."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise _NotPlainError
    try:
        number = float(value)
    except OverflowError:
        raise _NotPlainError from None
    if not math.isfinite(number):
        raise _NotPlainError
    return number
