"""Vectors of three floats: what a single cable's ends need, in a tenth of the time of arrays."""

from __future__ import annotations

import math

from cablecad.model import Vector


def dot(a: Vector, b: Vector) -> float:
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> Vector:
    """Vector product."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def norm(a: Vector) -> float:
    """Length, safe for components near the limits of a double."""
    return math.hypot(*a)


def minus(a: Vector, b: Vector) -> Vector:
    """a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def scaled(a: Vector, by: float) -> Vector:
    """A multiple of `a`."""
    return by * a[0], by * a[1], by * a[2]


def plus(a: Vector, b: Vector, by: float = 1.0) -> Vector:
    """a + by b."""
    return a[0] + by * b[0], a[1] + by * b[1], a[2] + by * b[2]


def across(a: Vector, axis: Vector) -> Vector:
    """What of `a` is normal to a unit `axis`."""
    return plus(a, axis, -dot(a, axis))
