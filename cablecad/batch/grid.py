"""Rows from a grid: every combination of the values of some places of a scene."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from os import PathLike
from typing import Any

from cablecad.batch.rows import Row
from cablecad.batch.table import as_whole, cell_value, takes_whole_numbers
from cablecad.errors import Mistake, SceneError, UsageError
from cablecad.scene import RawScene, Target, clean_value, find_target, load_raw_scene, overlaps, parse_json

_RANGE = re.compile(r"(?P<start>[^:]+):(?P<stop>[^:]+):(?P<count>[^:]+)")

_MOST_POINTS = 10_000_000
"""More rows than this are a slip of the pen."""


@dataclass(frozen=True)
class GridRows:
    """The rows of a grid, the last axis running fastest; called by their numbers from 1.

    Attributes:
        base: The scene.
        axes: A place and its values each.
    """

    base: RawScene
    axes: tuple[tuple[Target, tuple[Any, ...]], ...]

    def __len__(self) -> int:
        """How many rows there are."""
        return math.prod(len(values) for _, values in self.axes)

    def __iter__(self) -> Iterator[Row]:
        """Every combination of values."""
        targets = [target for target, _ in self.axes]
        for number, point in enumerate(itertools.product(*(values for _, values in self.axes)), 1):
            changes = list(zip(targets, point, strict=True))
            shown = {target.name: value for target, value in changes}
            yield Row(str(number), self.base.overridden(changes), shown)


def grid_rows(scene: str | PathLike[str], axes: Sequence[str], *, source: str = "--grid") -> GridRows:
    """Make the rows of a full factorial sweep.

    Args:
        scene: The scene file whose values are overridden.
        axes: Such as ``cables.W1.length=300:400:11`` (from, to, how many, both ends included) or
            ``cables.W1.material=pvc,pur`` (these).
        source: Where they were written, for messages.

    Raises:
        ExchangeError: The scene file cannot be read.
        SceneError: All mistakes of the scene, or of the axes and their types.
    """
    base = load_raw_scene(scene)
    found: list[tuple[Target, tuple[Any, ...]]] = []
    mistakes: list[Mistake] = []
    for axis in axes:
        name, equals, text = axis.partition("=")
        try:
            if not equals:
                raise UsageError("write it as NAME=START:STOP:COUNT or NAME=VALUE,VALUE,...")
            target = find_target(name.strip(), base.data)
            values = _values(text.strip(), is_text=target.is_text)
        except SceneError as error:
            mistakes += error.mistakes
            continue
        except UsageError as error:
            mistakes.append(Mistake(axis, str(error)))
            continue
        for other, _ in found:
            if overlaps(target, other):
                mistakes.append(Mistake(target.name, f"names what {other.name} names too, or a part of it; keep one"))
        if any(isinstance(value, float) for value in values) and takes_whole_numbers(base, target):
            values = tuple(map(as_whole, values))
        found.append((target, values))
        for value in values:
            mistakes += [mistake.under(target.name) for mistake in clean_value(value)[1]]
            mistakes += base.overridden([(target, value)]).type_mistakes()
    rows = GridRows(base, tuple(found))
    if not mistakes and len(rows) > _MOST_POINTS:
        mistakes.append(Mistake("", f"the grid has {len(rows)} rows, more than {_MOST_POINTS}; take fewer values"))
    if mistakes:
        raise SceneError(mistakes, source=source)
    return rows


def _values(text: str, *, is_text: bool) -> tuple[Any, ...]:
    """The values of an axis.

    Raises:
        UsageError: The text is none of the two forms.
    """
    if not text:
        raise UsageError("has no values; write NAME=START:STOP:COUNT or NAME=VALUE,VALUE,...")
    if text[0] in "[{" and not is_text:  # vectors and tables hold commas and colons themselves
        try:
            listed = parse_json(f"[{text}]")
        except ValueError as error:
            raise UsageError(f"is no list of [x, y, z], [x, y, z], ..., or of {{ }}, {{ }}, ...: {error}") from error
        return tuple(listed)
    spread = None if is_text else _RANGE.fullmatch(text)
    if spread is not None:
        start, stop = (_number(spread[key].strip()) for key in ("start", "stop"))
        count = cell_value(spread["count"], is_text=False)
        if not isinstance(count, int) or isinstance(count, bool) or not 1 <= count <= _MOST_POINTS:
            raise UsageError(
                f"the count {spread['count']!r} of a range must be a whole number from 1 to {_MOST_POINTS}"
            )
        if count == 1 and start != stop:
            raise UsageError("a range of one value must begin where it ends; write a count of 2 or more")
        # In fractions, so that both ends are met and 0.1:0.7:7 has a 0.3 in it.
        step = (stop - start) / max(count - 1, 1)
        return tuple(float(start + i * step) for i in range(count))
    return tuple(cell_value(part, is_text=is_text) for part in text.split(","))


def _number(text: str) -> Fraction:
    """The number a range begins or ends with, as it is written.

    Raises:
        UsageError: It is none, or one that is too small for a double.
    """
    value = cell_value(text, is_text=False)
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise UsageError(f"{text!r} is no number; write a range as START:STOP:COUNT, such as 300:400:11")
    if value == 0:  # whatever its exponent, which as a fraction may have any number of digits
        if re.search("[1-9]", text.lower().partition("e")[0]):
            raise UsageError(f"{text!r} is too small to be told from 0; write 0")
        return Fraction(0)
    try:
        return Fraction(text)
    except ValueError:  # of more digits than Python reads as a whole number
        return Fraction(value)
