"""Words beside points of a plot, where they hide nothing."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from cablecad.centreline import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_DISTANCES = (10.0, 16.0, 24.0, 36.0, 54.0)
"""From the point to the words [points of type], the nearest first."""

_DIRECTIONS = 24


class Labels:
    """The words of one plot; made when everything else is drawn and the limits are set."""

    def __init__(self, axes: Axes) -> None:
        self.axes = axes
        figure: Any = axes.get_figure()
        figure.draw_without_rendering()  # settles where the axes are
        figure.set_layout_engine("none")
        self._dots: list[Array] = []

    def avoid(self, points: Array) -> None:
        """Keep words off points, shape (n, 2), in the plot's coordinates; off a line, if they are close together."""
        self._dots.append(self.axes.transData.transform(points))

    def put(self, words: str, at: Array, **style: Any) -> None:
        """Write words beside a point, and keep later ones off them."""
        figure: Any = self.axes.get_figure()
        scale = figure.dpi / 72.0
        place = self.axes.transData.transform(at)
        text = self.axes.text(
            0.0, 0.0, words, transform=None, va="center", ha="center", zorder=9,
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.5}, **style,
        )  # fmt: skip
        box = text.get_window_extent()
        half = np.array([box.width, box.height]) / 2.0
        dots = np.concatenate(self._dots) if self._dots else np.empty((0, 2))
        room = self.axes.get_window_extent().padded(-4.0 * scale)
        best = (math.inf, place)
        for rank, distance in enumerate(_DISTANCES):
            for angle in np.arange(_DIRECTIONS) * 2.0 * math.pi / _DIRECTIONS:
                direction = np.array([math.cos(angle), math.sin(angle)])
                # So far that the box just clears a circle of the distance around the point.
                reach = distance * scale + min(half / np.maximum(np.abs(direction), 1e-9))
                middle = place + reach * direction
                hidden = (np.abs(dots - middle) < half + 3.0 * scale).all(axis=1).sum()
                outside = np.maximum([room.x0 + half[0] - middle[0], middle[0] + half[0] - room.x1], 0.0).sum()
                outside += np.maximum([room.y0 + half[1] - middle[1], middle[1] + half[1] - room.y1], 0.0).sum()
                cost = float(hidden) + 0.5 * float(outside) + 2.0 * rank
                if cost < best[0] - 1e-9:
                    best = (cost, middle)
        # In the plot's own coordinates, so that the words stay at their place at any resolution.
        text.set_transform(self.axes.transData)
        text.set_position(tuple(self.axes.transData.inverted().transform(best[1])))
        grid = np.stack(np.meshgrid(*(np.linspace(-h, h, 12) for h in half)), axis=-1).reshape(-1, 2)
        self._dots.append(best[1] + grid)
