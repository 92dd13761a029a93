"""A cable in its plane, as a flat drawing: which way is up, and what the two directions are called."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cablecad.centreline import Array, Centreline

_LEVEL = 1e-6
"""A plane within this of one of the coordinates' is taken for it [rad]."""


@dataclass(frozen=True)
class FlatView:
    """Coordinates in the plane of a cable.

    Attributes:
        origin: Where they count from, shape (3,) [mm].
        right: Unit vector, shape (3,); likewise up.
        up: Upwards, as far as the plane has an upwards.
        labels: Of the two directions, with the unit.
    """

    origin: Array
    right: Array
    up: Array
    labels: tuple[str, str]

    def flat(self, points: Array) -> Array:
        """Points in the drawing, shape (n, 2) [mm]."""
        return (np.asarray(points) - self.origin) @ np.stack([self.right, self.up], axis=1)

    def vector(self, vector: Array) -> Array:
        """A vector in the drawing, shape (2,)."""
        found: Array = np.asarray(vector) @ np.stack([self.right, self.up], axis=1)
        return found

    @property
    def toward(self) -> Array:
        """Unit vector out of the drawing, shape (3,)."""
        return np.cross(self.right, self.up)


def flat_view(centreline: Centreline) -> FlatView:
    """The view of a plane cable: Z is up, or Y where the plane is level; the other direction grows to the right.

    In a plane of the coordinates they are the scene's own; in another they count from the cable's start.
    """
    frames = centreline.frames([0.0])
    normal, tangent = frames.binormal[0], frames.tangent[0]
    # A straight cable lies in many planes: the upright one is taken.
    if centreline.greatest_curvature()[0] == 0.0:
        for axis in (np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0])):
            across = np.cross(axis, tangent)
            if np.linalg.norm(across) > 1e-3:
                normal = across / np.linalg.norm(across)
                break
    upright = np.array([0.0, 0.0, 1.0]) if abs(normal[2]) < 1.0 - _LEVEL else np.array([0.0, 1.0, 0.0])
    up = upright - (upright @ normal) * normal
    up /= np.linalg.norm(up)
    right = np.cross(up, normal)
    right *= np.sign(right[int(np.argmax(np.abs(right)))])
    names = (_axis(right), _axis(up))
    if None in names:
        return FlatView(frames.position[0], right, up, ("in the plane, from the start [mm]", "upwards [mm]"))
    return FlatView(np.zeros(3), np.rint(right), np.rint(up), (f"{names[0]} [mm]", f"{names[1]} [mm]"))


def _axis(direction: Array) -> str | None:
    """X, Y or Z, if that is the direction."""
    i = int(np.argmax(direction))
    return "XYZ"[i] if np.linalg.norm(direction - np.eye(3)[i]) < _LEVEL else None
