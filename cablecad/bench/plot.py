"""Pictures of tables: time against error on logarithmic axes, by matplotlib."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from cablecad.bench.table import Table
from cablecad.errors import MissingDependencyError
from cablecad.files import write_bytes

_MARKS = "osD^v<>PX*hp"


def write_plot(table: Table, folder: Path) -> None:
    """Write DIR/NAME.png of a table that has a plot and points on it; others are passed over.

    Raises:
        MissingDependencyError: matplotlib is not installed.
        ExchangeError: The file cannot be written.
    """
    series = {} if table.plot is None else _series(table)
    if table.plot is None or not series:
        return
    try:
        from matplotlib.figure import Figure
        from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
    except ImportError as error:
        raise MissingDependencyError('plots need matplotlib: pip install "cablecad[plot]"') from error
    figure = Figure(figsize=(7.2, 4.6), dpi=100, layout="constrained")
    axes = figure.add_subplot()
    for i, (name, points) in enumerate(series.items()):
        ours = name.startswith("cablecad")
        axes.loglog(
            *zip(*points, strict=True),
            _MARKS[i % len(_MARKS)],
            linestyle="-",
            linewidth=2.0 if ours else 1.0,
            markersize=7.0 if ours else 5.0,
            label=name,
        )
    columns = {item.key: item for item in table.columns}
    axes.set_xlabel(columns[table.plot.x].heading)
    axes.set_ylabel(columns[table.plot.y].heading)
    axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if _is_short(series) else (1.0,)))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_title(table.plot.title or table.title, fontsize="medium")
    axes.grid(True, which="major", linewidth=0.4)
    axes.legend(fontsize="x-small", loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)
    stream = io.BytesIO()
    figure.savefig(stream, format="png")
    write_bytes(folder / f"{table.name}.png", stream.getvalue())


def _series(table: Table) -> dict[str, list[tuple[float, float]]]:
    """Points of each curve; what is missing, zero or negative has no logarithm."""
    assert table.plot is not None
    found: dict[str, list[tuple[float, float]]] = {}
    keys = [item.key for item in table.columns]
    for row, cells in zip(table.rows, table.cells(), strict=True):
        name = table.plot.series(row)
        values = dict(zip(keys, cells, strict=True))
        x, y = values[table.plot.x], values[table.plot.y]
        if name is not None and _positive(x) and _positive(y):
            found.setdefault(name, []).append((float(x), float(y)))  # type: ignore[arg-type]
    return found


def _is_short(series: dict[str, list[tuple[float, float]]]) -> bool:
    """Whether the axis along is of two decades at most, where tens alone would be too few numbers on it."""
    along = [x for points in series.values() for x, _ in points]
    return max(along) < 100.0 * min(along)


def _positive(value: Any) -> bool:
    return isinstance(value, int | float) and value > 0.0


def write_plots(tables: Sequence[Table], folder: Path) -> None:
    """Write the plots of tables."""
    for table in tables:
        write_plot(table, folder)
