"""Tables of measurements: a frozen dataclass a row, its fields the columns, and the targets the figures are held to."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields
from typing import Any, Literal

Cell = str | int | float | bool | None
"""None where there is nothing to tell, or the number is not finite."""


@dataclass(frozen=True)
class Column:
    """A column of a table.

    Attributes:
        key: Name of the row's field, and of the column in CSV and JSON.
        title: What stands above it.
        unit: Of its numbers; empty for counts, shares and words.
        form: Format of a number.
    """

    key: str
    title: str
    unit: str
    form: str

    @property
    def heading(self) -> str:
        """Title and unit."""
        return f"{self.title} [{self.unit}]" if self.unit else self.title

    def show(self, value: Cell) -> str:
        """A value as it is printed."""
        if value is None:
            return "-"
        if isinstance(value, bool):
            return "yes" if value else "NO"
        return value if isinstance(value, str) else format(value, self.form)


def column(title: str, unit: str = "", form: str = ".3g", **default: Any) -> Any:
    """A field of a row that is a column."""
    return field(metadata={"title": title, "unit": unit, "form": form}, **default)


@dataclass(frozen=True)
class Target:
    """What a figure is held to.

    Attributes:
        text: What it is.
        figure: What came out.
        bound: What it is held to.
        sense: Whether the figure must stay below the bound or above it.
    """

    text: str
    figure: float
    bound: float
    sense: Literal["<=", ">="] = "<="

    @property
    def holds(self) -> bool:
        """Whether the target is met; a figure that is not a number meets none."""
        return self.figure <= self.bound if self.sense == "<=" else self.figure >= self.bound

    def __str__(self) -> str:
        verdict = "holds" if self.holds else "MISSED"
        return f"{verdict}: {self.text}: {self.figure:.3g} ({self.sense} {self.bound:g} is aimed at)"


@dataclass(frozen=True)
class Plot:
    """Two columns against each other, on logarithmic axes.

    Attributes:
        x: Key of the column along.
        y: Key of the column across.
        series: Gives a row's curve its name; rows of one name are joined in their order. None leaves a row out.
        title: Above it; the table's if empty.
    """

    x: str
    y: str
    series: Callable[[Any], str | None]
    title: str = ""


@dataclass(frozen=True)
class Table:
    """Rows of one kind, and what they show.

    Attributes:
        name: Of the files it is written to, without a suffix.
        title: A sentence.
        rows: Dataclasses of one type, whose fields were made by `column`.
        targets: What its figures are held to.
        notes: What has to be known to read it: counts, seeds, what the error is taken against, where a rival is better.
        plot: What of it is worth a picture.
    """

    name: str
    title: str
    rows: Sequence[Any]
    targets: Sequence[Target] = ()
    notes: Sequence[str] = ()
    plot: Plot | None = None

    @property
    def columns(self) -> tuple[Column, ...]:
        """Of its rows."""
        return tuple(Column(item.name, **item.metadata) for item in fields(self.rows[0]))

    def cells(self) -> list[list[Cell]]:
        """The rows' values, in the order of the columns."""
        return [[_finite(getattr(row, item.key)) for item in self.columns] for row in self.rows]


def _finite(value: Any) -> Cell:
    if isinstance(value, bool | str | int) or value is None:
        return value
    number = float(value)
    return number if math.isfinite(number) else None
