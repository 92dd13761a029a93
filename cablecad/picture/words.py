"""Words for pictures and plots, which have only so much room."""

from __future__ import annotations


def shortened(words: str, most: int) -> str:
    """`words`, or as many of their first letters as there is room for, and three dots."""
    return words if len(words) <= most else words[: max(most - 3, 1)].rstrip() + "..."


def counted(count: int, one: str, many: str) -> str:
    """A number with its noun."""
    return f"{count} {one if count == 1 else many}"
