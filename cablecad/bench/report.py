"""A run of the benchmark: what was measured on which machine, and the files it is written to.

Files are written stage by stage, so that a run that is broken off leaves what it has done.
"""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from cablecad.bench.machine import describe_machine, machine_line
from cablecad.bench.table import Cell, Table, Target
from cablecad.files import write_bytes


@dataclass
class StageResult:
    """What a stage gave.

    Attributes:
        name: Of the stage.
        seconds: It took.
        tables: In its order.
        skipped: Why it was not run; empty if it was.
    """

    name: str
    seconds: float = 0.0
    tables: list[Table] = field(default_factory=list)
    skipped: str = ""


@dataclass
class BenchReport:
    """All stages of a run.

    Attributes:
        quick: Whether counts were cut down.
        stages: Those done so far.
        complete: Whether all that were asked for are done.
        machine: Versions and the machine.
    """

    quick: bool
    stages: list[StageResult] = field(default_factory=list)
    complete: bool = False
    machine: dict[str, str | int | float | None] = field(default_factory=describe_machine)

    @property
    def tables(self) -> Iterator[Table]:
        """Of all stages."""
        for stage in self.stages:
            yield from stage.tables

    @property
    def missed(self) -> list[Target]:
        """Targets that do not hold."""
        return [target for table in self.tables for target in table.targets if not target.holds]

    def as_dict(self) -> dict[str, Any]:
        """What goes into report.json, format 1."""
        return {
            "format": 1,
            "machine": self.machine,
            "quick": self.quick,
            "complete": self.complete,
            "stages": [
                {
                    "name": stage.name,
                    "seconds": stage.seconds,
                    "skipped": stage.skipped or None,
                    "tables": [_table_dict(table) for table in stage.tables],
                }
                for stage in self.stages
            ],
        }

    def write(self, folder: Path) -> None:
        """Write report.json, tables.md and a CSV file a table; what is there is replaced.

        Raises:
            ExchangeError: A file cannot be written.
        """
        for table in self.tables:
            write_bytes(folder / f"{table.name}.csv", _csv(table))
        text = json.dumps(self.as_dict(), indent=1, ensure_ascii=False, allow_nan=False) + "\n"
        write_bytes(folder / "report.json", text.encode("utf-8"))
        write_bytes(folder / "tables.md", self.markdown().encode("utf-8"))

    def summary(self) -> str:
        """Every figure that is aimed at, as a table in Markdown."""
        lines = ["| what | figure | aimed at | |", "|---|---:|---:|---|"]
        for table in self.tables:
            for target in table.targets:
                verdict = "holds" if target.holds else "**missed**"
                lines.append(f"| {target.text} | {target.figure:.3g} | {target.sense} {target.bound:.3g} | {verdict} |")
        return "\n".join(lines)

    def markdown(self) -> str:
        """The summary and all tables, to be pasted into a document."""
        kind = "quick run" if self.quick else "full run"
        parts = [f"{kind}: {machine_line(self.machine)}", self.summary()]
        for table in self.tables:
            parts += [f"### {table.title}", markdown_table(table)]
            parts += ["\n".join(f"* {line}" for line in [*map(str, table.targets), *table.notes])]
        return "\n\n".join(part for part in parts if part) + "\n"


def markdown_table(table: Table) -> str:
    """A table in Markdown."""
    columns = table.columns
    lines = [
        "| " + " | ".join(item.heading for item in columns) + " |",
        "|" + "|".join("---:" if _is_number(table, i) else "---" for i in range(len(columns))) + "|",
    ]
    for cells in table.cells():
        shown = [item.show(value).replace("|", "\\|") for item, value in zip(columns, cells, strict=True)]
        lines.append("| " + " | ".join(shown) + " |")
    return "\n".join(lines)


def _is_number(table: Table, index: int) -> bool:
    return not any(isinstance(cells[index], str | bool) for cells in table.cells())


def _table_dict(table: Table) -> dict[str, Any]:
    columns = table.columns
    return {
        "name": table.name,
        "title": table.title,
        "columns": [{"key": item.key, "title": item.title, "unit": item.unit} for item in columns],
        "rows": [dict(zip((item.key for item in columns), cells, strict=True)) for cells in table.cells()],
        "targets": [
            {
                "text": target.text,
                "figure": target.figure if abs(target.figure) < float("inf") else None,
                "sense": target.sense,
                "bound": target.bound,
                "holds": target.holds,
            }
            for target in table.targets
        ],
        "notes": list(table.notes),
    }


def _csv(table: Table) -> bytes:
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow([f"{item.key} [{item.unit}]" if item.unit else item.key for item in table.columns])
    for cells in table.cells():
        writer.writerow([_csv_cell(value) for value in cells])
    return stream.getvalue().encode("utf-8")


def _csv_cell(value: Cell) -> str | int | float:
    if value is None:
        return ""
    return ("true" if value else "false") if isinstance(value, bool) else value
