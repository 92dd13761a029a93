"""Round numbers for scales and legends."""

from __future__ import annotations

import math


def round_below(value: float) -> float:
    """The greatest of 1, 2 and 5 times a power of ten that is not above a positive value."""
    power = 10.0 ** math.floor(math.log10(value))
    # What rounding leaves of 5 / 5 may lie a hair below one.
    return max(step * power for step in (0.5, 1.0, 2.0, 5.0) if step * power <= value * (1.0 + 1e-12))


def shown(value: float) -> str:
    """A number as people write it: no exponent where digits do."""
    return f"{value:.10g}" if 1e-3 <= abs(value) < 1e6 or value == 0.0 else f"{value:.3g}"


def significant(value: float, digits: int = 4) -> str:
    """A measured number, rounded to some digits: no exponent where digits do."""
    return shown(float(f"{value:.{digits}g}"))
