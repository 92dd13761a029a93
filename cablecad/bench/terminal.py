"""Tables for a terminal, and for a file stdout was sent to."""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import Literal

from rich.console import Console
from rich.table import Table as RichTable
from rich.text import Text

from cablecad.bench.table import Cell, Table

_WIDTH = 400
"""Columns of a file: wide enough for any table, so that nothing is folded."""

_GAP = 2
"""Columns between columns."""

_FOLDED = 16
"""Columns at least of words, which may be folded."""


def show_table(table: Table, *, width: int | None, color: bool) -> str:
    """A table, its targets and its notes as text.

    Args:
        table: What to show.
        width: Columns of the terminal; None for a file.
        color: Whether the terminal shows colours.
    """
    cells = table.cells()
    widths = _widths(table, cells, _WIDTH if width is None else width)
    stream = io.StringIO()
    # Where the least widths do not fit, the terminal shall break the lines.
    wide = max(width or _WIDTH, sum(widths) + _GAP * len(widths))
    console = Console(file=stream, width=wide, force_terminal=color, no_color=not color, highlight=False)
    shown = RichTable(box=None, pad_edge=False, header_style="bold", show_edge=False, padding=(0, _GAP, 0, 0))
    for i, item in enumerate(table.columns):
        side: Literal["left", "right"] = "left" if _is_words(cells, i) else "right"
        shown.add_column(Text(item.heading), justify=side, overflow="fold", width=widths[i])
    for row in cells:
        shown.add_row(*[Text(item.show(value)) for item, value in zip(table.columns, row, strict=True)])
    console.print(Text(table.title, style="bold"))
    console.print(shown)
    for target in table.targets:
        console.print(Text(str(target), style="green" if target.holds else "bold red"))
    for note in table.notes:
        console.print(Text(f"* {note}", style="dim"))
    return "\n".join(line.rstrip() for line in stream.getvalue().splitlines()) + "\n"


def _is_words(cells: Sequence[Sequence[Cell]], index: int) -> bool:
    return any(isinstance(row[index], str | bool) for row in cells)


def _widths(table: Table, cells: Sequence[Sequence[Cell]], most: int) -> list[int]:
    """Widths of columns: what they need, and if that is too much the widest give way.

    None becomes less than its longest number, for a number that is folded is two numbers, or than a part of its words,
    or than a word of its heading.
    """
    widths, least = [], []
    for i, item in enumerate(table.columns):
        longest = max(len(item.show(row[i])) for row in cells)
        widths.append(max(longest, len(item.heading)))
        kept = min(longest, _FOLDED) if _is_words(cells, i) else longest
        least.append(max(kept, *(len(word) for word in item.heading.split())))
    while sum(widths) + _GAP * len(widths) > most:
        room = [width - small for width, small in zip(widths, least, strict=True)]
        if not any(room):
            break
        widths[max(range(len(widths)), key=lambda i: (room[i] > 0, widths[i]))] -= 1
    return widths
