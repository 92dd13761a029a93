"""Lines, areas and words over a picture: scale bar, axes, legend, marks.

All in pixels of the finished picture from its top left corner, x to the right and y down, whatever resolution it is
drawn at. Later things lie over earlier ones.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Literal

import numpy as np

from cablecad.centreline import Array
from cablecad.mesh import Triangles
from cablecad.picture.palette import INK, rgb
from cablecad.picture.poly_data import poly_data

if TYPE_CHECKING:
    from vtkmodules.vtkRenderingCore import vtkRenderer

Anchor = Literal["left", "centre", "right"]

_ROUND = np.stack([np.cos(np.linspace(0, 2 * np.pi, 65)), np.sin(np.linspace(0, 2 * np.pi, 65))], axis=1)


class Overlay:
    """What lies over a picture.

    Attributes:
        renderer: The renderer it is drawn by.
        size: Of the finished picture [pixels].
        factor: Pixels drawn for each of them.
    """

    def __init__(self, renderer: vtkRenderer, size: tuple[int, int], factor: int) -> None:
        self.renderer, self.size, self.factor = renderer, size, factor

    # --- areas and lines ------------------------------------------------------------------------------------------

    def area(self, corners: Array, color: str, *, opacity: float = 1.0) -> None:
        """A convex area, corners of shape (n, 2)."""
        fan = np.stack([np.zeros(len(corners) - 2), np.arange(1, len(corners) - 1), np.arange(2, len(corners))], axis=1)
        self._triangles(np.asarray(corners, dtype=float), fan.astype(int), rgb(color), opacity)

    def line(self, start: Array, end: Array, width: float, color: str) -> None:
        """A straight line with round ends."""
        start, end = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
        along = end - start
        length = math.hypot(*along)
        if length > 0.0:
            across = np.array([-along[1], along[0]]) / length * width / 2.0
            self.area(np.array([start + across, end + across, end - across, start - across]), color)
        for point in (start, end):
            self.disc(point, width / 2.0, color)

    def disc(self, centre: Array, radius: float, color: str) -> None:
        """A round area."""
        self.area(np.asarray(centre) + radius * _ROUND[:-1], color)

    def ring(self, centre: Array, radius: float, width: float, color: str) -> None:
        """A circle of a width."""
        inner, outer = (np.asarray(centre) + (radius + side * width / 2.0) * _ROUND for side in (-1.0, 1.0))
        i = np.arange(len(_ROUND) - 1)
        n = len(_ROUND)
        quads = np.concatenate([np.stack([i, i + 1, n + i + 1], axis=1), np.stack([i, n + i + 1, n + i], axis=1)])
        self._triangles(np.concatenate([inner, outer]), quads, rgb(color), 1.0)

    def arrow(self, start: Array, end: Array, width: float, color: str) -> None:
        """A line with a head at its end."""
        start, end = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
        length = math.hypot(*(end - start))
        if length == 0.0:
            return
        along = (end - start) / length
        across = np.array([-along[1], along[0]])
        head = min(5.0 * width, length)
        base = end - head * along
        self.line(start, base, width, color)
        self.area(np.array([end, base + 0.45 * head * across, base - 0.45 * head * across]), color)

    def bar(self, corner: Array, size: tuple[float, float], colors: Array) -> None:
        """A bar of colours one above the other, the first at its bottom; `corner` is its top left one."""
        width, height = size
        y = np.linspace(corner[1] + height, corner[1], len(colors) + 1)
        x = (corner[0], corner[0] + width)
        for low, high, color in zip(y, y[1:], colors, strict=False):
            box = np.array([[x[0], low], [x[1], low], [x[1], high], [x[0], high]])
            self._triangles(box, np.array([[0, 1, 2], [0, 2, 3]]), tuple(color), 1.0)

    def _triangles(self, points: Array, triangles: Triangles, color: tuple[float, ...], opacity: float) -> None:
        from vtkmodules.vtkRenderingCore import vtkActor2D, vtkPolyDataMapper2D

        flipped = np.column_stack([points[:, 0], self.size[1] - points[:, 1], np.zeros(len(points))]) * self.factor
        mapper = vtkPolyDataMapper2D()
        mapper.SetInputData(poly_data(flipped, triangles))
        actor = vtkActor2D()
        actor.SetMapper(mapper)
        actor.GetProperty().SetColor(*color)
        actor.GetProperty().SetOpacity(opacity)
        self.renderer.AddViewProp(actor)

    # --- words ----------------------------------------------------------------------------------------------------

    def text(
        self,
        words: str,
        place: Array,
        *,
        height: float,
        color: str = INK,
        anchor: Anchor = "left",
        bold: bool = False,
    ) -> None:
        """Words of a type size; `place` is the middle of their height, at the end `anchor` names."""
        from vtkmodules.vtkRenderingCore import vtkTextActor

        actor = vtkTextActor()
        actor.SetInput(words)
        style = actor.GetTextProperty()
        self._style(style, height, bold)
        style.SetColor(*rgb(color))
        {"left": style.SetJustificationToLeft, "right": style.SetJustificationToRight}.get(
            anchor, style.SetJustificationToCentered
        )()
        # By the middle of capitals, whether or not there are letters that hang below the line.
        style.SetVerticalJustificationToBottom()
        drop = self._descent(words, height, bold)
        x, y = place[0], self.size[1] - place[1] - 0.36 * height - drop
        actor.SetDisplayPosition(round(x * self.factor), round(y * self.factor))
        self.renderer.AddViewProp(actor)

    def width_of(self, words: str, *, height: float, bold: bool = False) -> float:
        """How wide words are."""
        box = self._box(words, height, bold)
        return (box[1] - box[0] + 1) / self.factor

    def _descent(self, words: str, height: float, bold: bool) -> float:
        """How far words reach below their line."""
        return -self._box(words, height, bold)[2] / self.factor

    def _box(self, words: str, height: float, bold: bool) -> list[int]:
        """Left, right, bottom and top of words set at a line's beginning [pixels drawn]."""
        from vtkmodules.vtkRenderingCore import vtkTextProperty, vtkTextRenderer

        style, box = vtkTextProperty(), [0, 0, 0, 0]
        self._style(style, height, bold)
        vtkTextRenderer.GetInstance().GetBoundingBox(style, words, box, 72)
        return box

    def _style(self, style: object, height: float, bold: bool) -> None:
        style.SetFontFamilyToArial()  # type: ignore[attr-defined]
        style.SetFontSize(round(height * self.factor))  # type: ignore[attr-defined]
        style.SetBold(bold)  # type: ignore[attr-defined]


def can_be_set(words: str) -> bool:
    """Whether VTK's own type has all the letters: it knows the Latin ones."""
    return all(" " <= letter <= "~" or "\xa0" <= letter <= "\u017f" for letter in words)
