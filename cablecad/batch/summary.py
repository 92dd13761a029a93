"""What a batch amounts to: counts, slowest rows, worst deviation, broken rules."""

from __future__ import annotations

import heapq
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

SOME_FAILED = 6
"""The exit code of a batch in which rows failed."""

_MOST_SLOW = 3
_MOST_IDS = 5


@dataclass
class Summary:
    """What all rows of a batch amount to, those finished by an earlier run too.

    Attributes:
        folder: Where the results are.
        counts: Rows by status.
        kept: How many of them an earlier run had finished.
        slowest: Seconds and id of the slowest rows, the slowest first.
        worst_deviation: The greatest deviation of a solid [mm], its row and its cable; None without solids.
        broken_rules: How many rows break a rule.
        breakers: Ids of the first of them.
        seconds: Time of this run.
    """

    folder: Path
    counts: Counter[str] = field(default_factory=Counter)
    kept: int = 0
    slowest: list[tuple[float, str]] = field(default_factory=list)
    worst_deviation: tuple[float, str, str] | None = None
    broken_rules: int = 0
    breakers: list[str] = field(default_factory=list)
    seconds: float = 0.0

    @property
    def total(self) -> int:
        """How many rows there are."""
        return self.counts.total()

    @property
    def failed(self) -> int:
        """How many have no result: failed, crashed and timed out."""
        return self.total - self.counts["done"]

    @property
    def exit_code(self) -> int:
        """0, or 6 where rows failed."""
        return SOME_FAILED if self.failed else 0

    def add(self, line: Mapping[str, Any]) -> None:
        """Take a line of the journal into account, whose numbers may be texts."""
        self.counts[line["status"]] += 1
        seconds = (line.get("seconds") or {}).get("total")
        if seconds is not None:
            heapq.heappush(self.slowest, (float(seconds), line["id"]))
            if len(self.slowest) > _MOST_SLOW:
                heapq.heappop(self.slowest)
        broken = False
        for cable in line.get("cables") or ():
            broken = broken or bool(cable["violations"])
            deviation = None if cable["solid"] is None else float(cable["solid"]["deviation"])
            if deviation is not None and (self.worst_deviation is None or deviation > self.worst_deviation[0]):
                self.worst_deviation = deviation, line["id"], cable["name"]
        if broken:
            self.broken_rules += 1
            if len(self.breakers) < _MOST_IDS:
                self.breakers.append(line["id"])

    def lines(self) -> Iterator[str]:
        """What to tell a user, a line each."""
        others = [f"{self.counts[status]} {status.replace('_', ' ')}" for status in ("failed", "crashed", "timed_out")]
        counts = [f"{self.counts['done']} done", *(text for text in others if not text.startswith("0 "))]
        again = f", {self.kept} of them by an earlier run" if self.kept else ""
        yield f"{self.total} rows: {', '.join(counts)}{again}; {self.seconds:.1f} s"
        if self.slowest:
            slow = ", ".join(f"{row_id} ({seconds:.3g} s)" for seconds, row_id in sorted(self.slowest, reverse=True))
            yield f"slowest rows: {slow}"
        if self.worst_deviation is not None:
            deviation, row_id, cable = self.worst_deviation
            yield f"worst deviation: {deviation:.3g} mm, row {row_id}, cable {cable}"
        if self.broken_rules:
            more = ", ..." if self.broken_rules > len(self.breakers) else ""
            yield f"rows that break a rule: {self.broken_rules} ({', '.join(self.breakers)}{more})"
