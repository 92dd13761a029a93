"""From where a scene is seen, and where its points fall in the picture.

Pictures are parallel projections, as drawings are: one scale bar holds all over them. Z is up; the front is seen along
+Y, the right side along -X, the top along -Z with +Y up.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cablecad.centreline import Array
from cablecad.errors import UsageError

VIEWS: dict[str, tuple[float, float, float]] = {
    "iso": (1.0, -1.0, 1.0),
    "front": (0.0, -1.0, 0.0),
    "back": (0.0, 1.0, 0.0),
    "top": (0.0, 0.0, 1.0),
    "bottom": (0.0, 0.0, -1.0),
    "right": (1.0, 0.0, 0.0),
    "left": (-1.0, 0.0, 0.0),
}
"""The views that have a name: the direction from the scene to the eye."""


@dataclass(frozen=True)
class Margins:
    """Room around a scene that belongs to scales and legends, as shares of the picture's width or height."""

    left: float = 0.05
    right: float = 0.05
    top: float = 0.05
    bottom: float = 0.13


@dataclass(frozen=True)
class Camera:
    """A parallel projection onto a picture.

    Attributes:
        centre: The point seen in the middle of the picture [mm], shape (3,).
        right: Unit vector to the right of the picture, shape (3,); likewise the next two.
        up: Upwards.
        toward: Out of the picture, to the eye.
        mm_per_pixel: The scale.
        size: Width and height [pixels].
        depth: How far what is drawn lies before and behind the centre at most [mm].
    """

    centre: Array
    right: Array
    up: Array
    toward: Array
    mm_per_pixel: float
    size: tuple[int, int]
    depth: float

    def project(self, points: Array) -> Array:
        """Where points fall, shape (n, 2): pixels to the right and down from the picture's top left corner."""
        x, y = ((np.asarray(points) - self.centre) @ axis for axis in (self.right, self.up))
        width, height = self.size
        return np.stack([width / 2.0 + x / self.mm_per_pixel, height / 2.0 - y / self.mm_per_pixel], axis=-1)


def view_direction(view: str) -> Array:
    """The unit vector from the scene to the eye that a view's name or ``x,y,z`` stands for.

    Raises:
        UsageError: It is neither.
    """
    if view in VIEWS:
        direction = np.array(VIEWS[view])
    else:
        try:
            direction = np.array([float(number) for number in view.split(",")])
        except ValueError:
            direction = np.zeros(0)
        if direction.shape != (3,) or not np.isfinite(direction).all() or not direction.any():
            raise UsageError(
                f"view {view!r}: give one of {', '.join(VIEWS)}, or the direction to the eye as three numbers, "
                "such as 1,-2,0.5"
            )
    direction = direction / np.abs(direction).max()  # first, for numbers whose squares overflow
    unit: Array = direction / np.linalg.norm(direction)
    return unit


def aim_camera(points: Array, toward: Array, size: tuple[int, int], margins: Margins, *, depth_points: Array) -> Camera:
    """The camera that shows all points as large as the margins let them be.

    Args:
        points: What must be seen, shape (n, 3) [mm].
        toward: Unit vector to the eye.
        size: Of the picture [pixels].
        margins: Room to leave around.
        depth_points: All that is drawn, shape (m, 3) [mm]: nothing of it is cut off in depth.
    """
    upright = np.array([0.0, 0.0, 1.0]) if abs(toward[2]) < 1.0 - 1e-9 else np.array([0.0, 1.0, 0.0])
    right = np.cross(upright, toward)
    right /= np.linalg.norm(right)
    up = np.cross(toward, right)
    x, y = points @ right, points @ up
    width, height = size
    wide = width * (1.0 - margins.left - margins.right)
    high = height * (1.0 - margins.top - margins.bottom)
    scale = max(float(np.ptp(x)) / wide, float(np.ptp(y)) / high)
    scale = scale if scale > 0.0 else 1.0 / min(wide, high)
    # The middle of the points goes to the middle of the room.
    middle = (float(x.min() + x.max()) / 2.0, float(y.min() + y.max()) / 2.0)
    shift = ((margins.left - margins.right) * width / 2.0, (margins.bottom - margins.top) * height / 2.0)
    z = depth_points @ toward
    far = float(z.min() + z.max()) / 2.0
    centre = (middle[0] - shift[0] * scale) * right + (middle[1] - shift[1] * scale) * up + far * toward
    depth = float(np.ptp(z)) / 2.0 + 2.0 * scale
    return Camera(centre, right, up, toward, scale, size, depth)
