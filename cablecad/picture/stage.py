"""The things of a scene as VTK draws them: shaded, with their edges, in their colours.

The picture is drawn several times as large and then averaged, which smooths all edges alike. Outlines are found in the
depths of that large picture: where something ends in front of something else the depth has a kink far sharper than any
surface has. They are drawn on the nearer thing, in a dark tone of its own colour.

Vertices are counted from the picture's middle: graphics cards keep 7 digits.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cablecad.centreline import Array
from cablecad.mesh import Mesh
from cablecad.picture.camera import Camera
from cablecad.picture.offscreen import offscreen_window
from cablecad.picture.overlay import Overlay
from cablecad.picture.palette import GROUND, Rgb, rgb
from cablecad.picture.png import Pixels
from cablecad.picture.poly_data import poly_data, poly_lines

if TYPE_CHECKING:
    from vtkmodules.vtkRenderingCore import vtkActor

_FACTORS = ((3, 12e6), (2, 40e6))
"""Pixels drawn for each of the picture in either direction, and the most pixels that may be drawn so."""

_BAND, _ROWS = 64, 256
"""Rows of the picture that are averaged at once, and of the large one that are searched for outlines at once."""

_EDGE_WIDTH = 1.3
"""Of lines where faces meet [pixels]."""

_EDGE, _EDGE_ON_DARK, _DARK = (0.13, 0.15, 0.18), (0.42, 0.45, 0.50), 0.3
"""Their colours, and the brightness below which a thing counts as dark."""

_OUTLINE_WIDTH = 1.5
"""[pixels]"""

_KINK = 12.0
"""From this second difference of the depth [pixels] on there is an outline: a slope of 80 degrees has 6 from one pixel
to the next, but hardly changes."""

_OUTLINE_TONE = 0.38
"""Brightness of outlines against the surface they lie on."""


@dataclass(frozen=True)
class Solid:
    """A thing to draw.

    Attributes:
        mesh: At its place in the scene.
        color: Of all of it, or of each vertex, shape (n, 3).
        opacity: From 0 to 1.
        glow: Share of its colour that needs no light: more of it where the colour tells a number.
        outlined: Whether it has an outline: a thin thing would be nothing else.
    """

    mesh: Mesh
    color: Rgb | Array
    opacity: float = 1.0
    glow: float = 0.0
    outlined: bool = True


class Stage:
    """A window with a scene in it.

    Attributes:
        camera: How it is seen.
        overlay: What lies over it.
    """

    def __init__(self, camera: Camera) -> None:
        width, height = camera.size
        self.camera = camera
        self._factor = next((factor for factor, most in _FACTORS if width * height * factor**2 <= most), 1)
        self._window = offscreen_window(width * self._factor, height * self._factor)
        from vtkmodules.vtkRenderingCore import vtkRenderer

        self._renderer = vtkRenderer()
        self._renderer.SetBackground(*rgb(GROUND))
        over = vtkRenderer()
        over.SetLayer(1)
        over.InteractiveOff()
        self._window.SetNumberOfLayers(2)
        self._window.AddRenderer(self._renderer)
        self._window.AddRenderer(over)
        self.overlay = Overlay(over, camera.size, self._factor)
        self._surfaces: list[tuple[vtkActor, float]] = []
        self._lines: list[vtkActor] = []
        self._bare: list[vtkActor] = []
        self._outline: NDArray[np.bool_] | None = None
        self._aim()
        self._light()

    def add(self, solid: Solid) -> None:
        """Put a thing on the stage."""
        from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

        mesh, one_color = solid.mesh, isinstance(solid.color, tuple)
        data = poly_data(
            mesh.vertices - self.camera.centre,
            mesh.triangles,
            normals=mesh.normals,
            colors=None if one_color else np.asarray(solid.color),
        )
        mapper = vtkPolyDataMapper()
        mapper.SetInputData(data)
        mapper.SetResolveCoincidentTopologyToPolygonOffset()
        mapper.SetRelativeCoincidentTopologyPolygonOffsetParameters(1.0, 2.0)
        actor = vtkActor()
        actor.SetMapper(mapper)
        look = actor.GetProperty()
        if one_color:
            look.SetColor(*solid.color)
        look.SetAmbient(0.22 + 0.5 * solid.glow)
        look.SetDiffuse(0.80 - 0.5 * solid.glow)
        look.SetSpecular(0.22 * (1.0 - solid.glow))
        look.SetSpecularPower(40.0)
        look.SetInterpolationToPhong()
        self._renderer.AddActor(actor)
        self._surfaces.append((actor, solid.opacity))
        if not solid.outlined:
            self._bare.append(actor)
        if mesh.edges:
            self._add_edges(mesh.edges, solid.color if one_color else (1.0, 1.0, 1.0))

    def _add_edges(self, edges: tuple[Array, ...], color: Rgb | Array) -> None:
        from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

        mapper = vtkPolyDataMapper()
        mapper.SetInputData(poly_lines([edge - self.camera.centre for edge in edges]))
        actor = vtkActor()
        actor.SetMapper(mapper)
        look = actor.GetProperty()
        # On dark things a lighter line, else none of their edges would be seen.
        dark = float(np.dot(color, (0.21, 0.72, 0.07))) < _DARK
        look.SetColor(*(_EDGE_ON_DARK if dark else _EDGE))
        look.SetLineWidth(_EDGE_WIDTH * self._factor)
        look.LightingOff()
        self._renderer.AddActor(actor)
        self._lines.append(actor)

    def survey(self) -> NDArray[np.bool_]:
        """Where in the picture things are, shape (height, width); what is added after it has no outline."""
        self._outline, covered = self._find_outline()
        width, height = self.camera.size
        n = self._factor
        return np.asarray(covered.reshape(height, n, width, n).any(axis=(1, 3)))

    def shoot(self) -> Pixels:
        """The picture, shape (height, width, 3)."""
        outline = self._find_outline()[0] if self._outline is None else self._outline
        for actor, opacity in self._surfaces:
            actor.GetProperty().SetOpacity(opacity)
        for line in self._lines:
            line.VisibilityOn()
        self._renderer.DrawOn()
        if any(opacity < 1.0 for _, opacity in self._surfaces):
            self._renderer.SetUseDepthPeeling(True)
            self._renderer.SetMaximumNumberOfPeels(12)
            self._renderer.SetOcclusionRatio(0.0)
        over = self.overlay.renderer
        over.DrawOff()
        below = self._colors()
        # The overlay alone on two grounds: that tells its opacity.
        for actor in [*(actor for actor, _ in self._surfaces), *self._lines]:
            actor.VisibilityOff()
        over.DrawOn()
        on_black, on_white = (self._colors_on(ground) for ground in (0.0, 1.0))
        width, height = self.camera.size
        n, pixels = self._factor, np.empty((height, width, 3), dtype=np.uint8)
        for first in range(0, height, _BAND):  # a whole large picture in single precision would take gigabytes
            rows = slice(n * first, n * (first + _BAND))
            tone = np.where(outline[rows], np.float32(_OUTLINE_TONE), np.float32(1.0))[:, :, None]
            clear = (on_white[rows].astype(np.float32) - on_black[rows]) / np.float32(255.0)
            large = on_black[rows] + clear * tone * below[rows]
            mean = large.reshape(-1, n, width, n, 3).mean(axis=(1, 3))
            pixels[first : first + _BAND] = np.clip(np.rint(mean), 0, 255)
        return pixels

    def _colors_on(self, ground: float) -> NDArray[np.uint8]:
        self._renderer.SetBackground(ground, ground, ground)
        return self._colors()

    def _find_outline(self) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Where outlines are in the large picture, and where anything is."""
        for line in self._lines:
            line.VisibilityOff()
        self.overlay.renderer.DrawOff()
        depth = self._depths()
        covered = depth < 1.0
        hidden = np.zeros(depth.shape, dtype=bool)
        if self._bare:
            for actor in self._bare:
                actor.VisibilityOff()
            behind = self._depths()
            for actor in self._bare:
                actor.VisibilityOn()
            hidden, depth = depth < behind, behind
        pixel = self.camera.mm_per_pixel / self._factor
        outline = np.empty(depth.shape, dtype=bool)
        steps = round(_OUTLINE_WIDTH * self._factor / 2.0)
        reach = steps + 1
        for first in range(0, len(depth), _ROWS):  # with the rows around it that have a say in a band
            last, low = min(first + _ROWS, len(depth)), max(first - reach, 0)
            band = _kinks(depth[low : last + reach], 2.0 * self.camera.depth / pixel, steps)
            outline[first:last] = band[first - low : last - low]
        return outline & ~hidden, covered

    def _depths(self) -> NDArray[np.float32]:
        """Of the large picture, from 0 at the eye to 1 where nothing is."""
        from vtkmodules.vtkCommonCore import vtkFloatArray

        self._window.Render()
        width, height = self._window.GetSize()
        buffer = vtkFloatArray()
        self._window.GetZbufferData(0, 0, width - 1, height - 1, buffer)
        return np.frombuffer(buffer, np.float32).reshape(height, width)[::-1]

    def _colors(self) -> NDArray[np.uint8]:
        from vtkmodules.vtkCommonCore import vtkUnsignedCharArray

        self._window.Render()
        width, height = self._window.GetSize()
        buffer = vtkUnsignedCharArray()
        self._window.GetPixelData(0, 0, width - 1, height - 1, 0, buffer, 0)
        return np.frombuffer(buffer, np.uint8).reshape(height, width, 3)[::-1]

    def _aim(self) -> None:
        camera, eye = self._renderer.GetActiveCamera(), self.camera
        reach = eye.depth
        camera.ParallelProjectionOn()
        camera.SetFocalPoint(0.0, 0.0, 0.0)
        camera.SetPosition(*(2.0 * reach * eye.toward))
        camera.SetViewUp(*eye.up)
        camera.SetParallelScale(eye.mm_per_pixel * eye.size[1] / 2.0)
        camera.SetClippingRange(reach, 3.0 * reach)

    def _light(self) -> None:
        """A key light over the viewer's left shoulder, a fill from the right, a little from behind."""
        from vtkmodules.vtkRenderingCore import vtkLight

        self._renderer.AutomaticLightCreationOff()
        for place, strength in (((-0.5, 0.8, 1.0), 0.82), ((0.9, 0.1, 0.7), 0.46), ((0.0, -0.6, 0.5), 0.14)):
            light = vtkLight()
            light.SetLightTypeToCameraLight()
            light.SetPosition(*place)
            light.SetFocalPoint(0.0, 0.0, 0.0)
            light.SetIntensity(strength)
            self._renderer.AddLight(light)


def _kinks(depth: NDArray[np.float32], scale: float, steps: int) -> NDArray[np.bool_]:
    """Where depths, times a scale in pixels, have a kink on the near side of a step, made wider by some pixels."""
    nothing = depth >= 1.0
    z = (depth * np.float32(scale)).astype(np.float32)
    z[nothing] += np.float32(1e6)
    found = np.zeros(z.shape, dtype=bool)
    for axis in (0, 1):
        kink = np.diff(z, n=2, axis=axis)  # positive at the near side of a step
        if axis == 0:
            found[1:-1] |= kink > _KINK
        else:
            found[:, 1:-1] |= kink > _KINK
    return _thickened(found & ~nothing, steps) & ~nothing


def _thickened(mask: NDArray[np.bool_], steps: int) -> NDArray[np.bool_]:
    """A mask grown by some pixels in the four directions."""
    for _ in range(steps):
        grown = mask.copy()
        grown[1:] |= mask[:-1]
        grown[:-1] |= mask[1:]
        grown[:, 1:] |= mask[:, :-1]
        grown[:, :-1] |= mask[:, 1:]
        mask = grown
    return mask
