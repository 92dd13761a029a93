"""The plane a cable bends in, where its ends leave that open."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from cablecad.centreline import Array
from cablecad.errors import Mistake, SceneError
from cablecad.model import Vector, unit
from cablecad.rod.vector import across, cross, norm

NEAR_VERTICAL = 1e-3
"""Within this angle of the default bulge +Z [rad] a chord takes +X instead, so that no plane hangs on rounding."""

PARALLEL = 1e-9
"""A given bulge within this angle of the chord [rad] names no side."""


def unit_vector(vector: ArrayLike) -> Array:
    """`vector` (3,) scaled to length one, safe for very small and very large components."""
    values = np.asarray(vector, dtype=np.float64)
    scaled = values / np.abs(values).max()
    result: Array = scaled / math.sqrt(scaled @ scaled)
    return result


def bulge_direction(axis: Vector, bulge: Vector | None, line: str = "chord") -> Vector:
    """The side to bend to: `bulge` made perpendicular to a unit `axis` (the chord, or the tangent of a ring).

    Args:
        axis: Unit vector.
        bulge: As the cable gives it; None stands for +Z, or +X where +Z is along the axis.
        line: What the axis is, for the message.

    Returns:
        Unit vector perpendicular to `axis`.

    Raises:
        SceneError: The given bulge is parallel to the axis.
    """
    wanted = unit(bulge if bulge is not None else (0.0, 0.0, 1.0))
    off = norm(cross(axis, wanted))
    if bulge is None and off < NEAR_VERTICAL:
        wanted = (1.0, 0.0, 0.0)
    elif bulge is not None and off < PARALLEL:
        shown = tuple(round(part, 6) for part in axis)
        problem = f"is parallel to the {line} {shown}; give a direction across it"
        raise SceneError([Mistake("bulge", problem, bulge)])
    side = unit(across(wanted, axis))
    return unit(across(side, axis))  # twice: a bulge near the axis loses digits the first time
