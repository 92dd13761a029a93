"""Times that can be compared: rivals take turns in one run, and the median of each one's turns counts."""

from __future__ import annotations

import time
from collections.abc import Callable, Hashable, Mapping
from statistics import median
from typing import TypeVar

K = TypeVar("K", bound=Hashable)


def once(work: Callable[[], object]) -> float:
    """The time of one call [s]."""
    begun = time.perf_counter()
    work()
    return time.perf_counter() - begun


def take_turns(rivals: Mapping[K, Callable[[], object]], repeats: int) -> dict[K, float]:
    """Median time of each rival [s], after one call that does not count.

    A machine that slows down for a while slows down all of them: they are called in turn, not one after the other.
    """
    for work in rivals.values():
        work()
    times: dict[K, list[float]] = {name: [] for name in rivals}
    for _ in range(repeats):
        for name, work in rivals.items():
            times[name].append(once(work))
    return {name: median(taken) for name, taken in times.items()}
