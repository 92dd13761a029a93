"""Tables for a terminal, and for a file stdout was sent to."""

from __future__ import annotations

import io

from rich.console import Console
from rich.table import Table as RichTable
from rich.text import Text

from cablecad.bench.table import Table

_WIDTH = 400
"""Columns of a file: wide enough for any table, so that nothing is folded."""


def show_table(table: Table, *, width: int | None, color: bool) -> str:
    """A table, its targets and its notes as text.

    Args:
        table: What to show.
        width: Columns of the terminal; None for a file.
        color: Whether the terminal shows colours.
    """
    stream = io.StringIO()
    console = Console(
        file=stream, width=width or _WIDTH, force_terminal=color, no_color=not color, highlight=False, soft_wrap=False
    )
    shown = RichTable(box=None, pad_edge=False, header_style="bold", show_edge=False, padding=(0, 2, 0, 0))
    cells = table.cells()
    for i, item in enumerate(table.columns):
        words = any(isinstance(row[i], str | bool) for row in cells)
        shown.add_column(Text(item.heading), justify="left" if words else "right", overflow="fold")
    for row in cells:
        shown.add_row(*[Text(item.show(value)) for item, value in zip(table.columns, row, strict=True)])
    console.print(Text(table.title, style="bold"))
    console.print(shown)
    for target in table.targets:
        console.print(Text(str(target), style="green" if target.holds else "bold red"))
    for note in table.notes:
        console.print(Text(f"* {note}", style="dim"))
    return "\n".join(line.rstrip() for line in stream.getvalue().splitlines()) + "\n"
