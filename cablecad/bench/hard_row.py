"""A row of the table of hard cases, and how failures are told in it."""

from __future__ import annotations

from dataclasses import dataclass

from cablecad.bench.table import column


@dataclass(frozen=True)
class HardRow:
    """One case.

    Attributes:
        right: Whether ours is as expected.
    """

    case: str = column("case")
    regime: str = column("regime")
    model: str = column("model")
    ours: str = column("ours")
    error: float | None = column("error", form=".0e")
    right: bool = column("right")
    time: float = column("time", "ms", ".3g")
    rival: str = column("rival")
    theirs: str = column("theirs")


def shortened(message: object, most: int = 58) -> str:
    """The first of a message, on one line."""
    text = " ".join(str(message).split())
    return text if len(text) <= most else text[: most - 3].rstrip() + "..."
