"""A solved scene as a shaded picture.

Cables are meshed from their exact centrelines, so a scene without parts needs no Open Cascade. With `curvature` they
are coloured by it, the tightest spot of all is marked, and parts step back into the ground.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from os import PathLike, fspath
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from cablecad.centreline import Array
from cablecad.errors import UsageError
from cablecad.files import write_bytes
from cablecad.mesh import mesh_tube
from cablecad.model import Cable, Scene
from cablecad.picture.camera import Camera, aim_camera, view_direction
from cablecad.picture.legend import BendLegend, draw_axes, draw_legend, draw_mark, draw_note, draw_scale_bar, margins_of
from cablecad.picture.offscreen import load_vtk
from cablecad.picture.overlay import can_be_set
from cablecad.picture.palette import PART, bend_color, cable_color, opacity, paled, rgb
from cablecad.picture.png import Pixels, png_bytes
from cablecad.picture.stage import Solid, Stage
from cablecad.picture.words import shortened
from cablecad.pipeline import SceneRun, check_output, read_scene_parts, solve_scene

if TYPE_CHECKING:
    from cablecad.brep.document import Document
    from cablecad.model import Part
    from cablecad.rod.solution import RodSolution

SIZE = (1600, 1000)
"""Width and height of a picture if not said otherwise [pixels]."""

LEAST_SIZE, MOST_SIZE = 200, 8192
"""[pixels]; below it scale and legend find no room, above it graphics cards do."""

_FINEST = 0.15
"""A cable's mesh need not be finer than this share of a pixel."""

_THINNEST = 1.6
"""Cables are drawn as thick as this at least [pixels]: what is thinner would be dots, or nothing."""

_OUTLINED = 7.0
"""Cables thinner than this in the picture have no outline [pixels]: it would leave nothing of their colour."""

_LONGEST = 28
"""Letters of a name beside the mark."""

_PALE = 0.62
"""How far parts step back where colours tell the curvature."""


@dataclass(frozen=True)
class Spot:
    """The tightest bend of a picture's cables.

    Attributes:
        cable: Its name.
        number: Which it is of the cables drawn, counted from 1.
        arclength: Where along it [mm].
        bend_radius: [mm].
        position: In the scene, shape (3,) [mm].
    """

    cable: str
    number: int
    arclength: float
    bend_radius: float
    position: Array


@dataclass(frozen=True)
class Picture:
    """A picture and how it was taken.

    Attributes:
        pixels: Shape (height, width, 3).
        camera: Tells where points of the scene fall in it.
        tightest: What is marked, or None.
    """

    pixels: Pixels
    camera: Camera
    tightest: Spot | None


def render_scene(
    scene: Scene,
    path: str | PathLike[str],
    *,
    view: str = "iso",
    size: tuple[int, int] = SIZE,
    cables: Sequence[str] = (),
    curvature: bool = False,
) -> Picture:
    """Solve a scene and write a picture of it.

    Args:
        scene: From `load_scene`, or made in Python.
        path: Of the PNG file, written whole or not at all.
        view: iso, front, back, top, bottom, right, left, or the direction to the eye as "x,y,z".
        size: Width and height [pixels].
        cables: Names of those to show; all if none are named.
        curvature: Whether cables are coloured by their curvature and the tightest spot is marked.

    Raises:
        UsageError: No PNG by its name, no such view or cable, or a size that cannot be.
        MissingDependencyError: VTK or OpenGL is missing.
        CablecadError: The first thing that went wrong; the others are notes on it.
    """
    path = Path(fspath(path))
    check_picture(scene, path, view=view, size=size)
    run = solve_scene(with_cables(scene, cables))
    placed = read_scene_parts(run)
    run.raise_first()
    picture = draw_run(run, placed, view=view, size=size, curvature=curvature, closer=bool(cables))
    write_bytes(path, png_bytes(picture.pixels))
    return picture


def check_picture(scene: Scene, path: Path, *, view: str, size: tuple[int, int]) -> None:
    """Refuse a picture that cannot be meant, before any work is done.

    Raises:
        UsageError: No PNG by its name, one of the scene's inputs, no such view, or a size that cannot be.
        MissingDependencyError: There is no VTK.
    """
    check_output(scene, path, suffixes=(".png",))
    view_direction(view)
    if not all(LEAST_SIZE <= side <= MOST_SIZE for side in size):
        raise UsageError(
            f"size {size[0]}x{size[1]}: both sides must have {LEAST_SIZE} to {MOST_SIZE} pixels, such as 1600x1000"
        )
    load_vtk()


def with_cables(scene: Scene, names: Sequence[str]) -> Scene:
    """The scene with the named cables only; all of them if none are named.

    Raises:
        UsageError: There is no such cable.
    """
    known = [cable.name for cable in scene.cables]
    for name in names:
        if name not in known:
            listed = ", ".join(known) or "none"
            raise UsageError(f"cable {name!r}: there is no such cable in the scene; it has {listed}")
    # Colours that come from a cable's number stay its own.
    numbered = tuple(
        replace(cable, color=cable_color(cable.color, i))
        for i, cable in enumerate(scene.cables)
        if not names or cable.name in names
    )
    return replace(scene, cables=numbered)


def draw_run(
    run: SceneRun,
    parts: Sequence[tuple[Part, Document]],
    *,
    view: str = "iso",
    size: tuple[int, int] = SIZE,
    curvature: bool = False,
    closer: bool = False,
) -> Picture:
    """Draw a scene that was solved; cables without a solution are not there.

    Args:
        run: From `solve_scene`.
        parts: From `read_scene_parts`.
        view: As in `render_scene`; likewise size and curvature.
        size: [pixels].
        curvature: Whether colours tell it.
        closer: Whether the picture is as large as the cables let it be, even if parts reach out of it.

    Raises:
        MissingDependencyError: VTK or OpenGL is missing.
        GeometryError: A part could not be meshed.
    """
    solved = [(outcome.cable, outcome.solution) for outcome in run.outcomes if outcome.solution is not None]
    tightest = _tightest(solved) if curvature else None
    solids = _part_solids(parts, pale=curvature)
    toward = view_direction(view)
    part_points = [solid.mesh.vertices for solid in solids]
    cable_points = [_reach(cable, solution) for cable, solution in solved]
    seen = cable_points if closer and cable_points else part_points + cable_points
    if not seen or not sum(map(len, seen)):
        raise UsageError("there is nothing to draw: the parts have no faces")
    points = np.concatenate(part_points + cable_points)
    margins = margins_of(size, legend=tightest is not None)
    camera = aim_camera(np.concatenate(seen), toward, size, margins, depth_points=points)
    stage = Stage(camera)
    for solid in solids:
        stage.add(solid)
    for i, (cable, solution) in enumerate(solved):
        stage.add(_cable_solid(cable, solution, i, camera, tightest if curvature else None, curvature))
    draw_axes(stage.overlay, camera)
    draw_scale_bar(stage.overlay, camera)
    if curvature and tightest is None:
        draw_note(stage.overlay, "no cable bends")
    if tightest is not None:
        limits = {cable.min_bend_radius for cable, _ in solved}
        limit = limits.pop() if len(limits) == 1 else None
        draw_legend(stage.overlay, BendLegend(tightest.bend_radius, limit))
        covered = stage.survey()
        width, height = size
        # The words keep off the scale, the axes and the legend too.
        covered[int(height * (1.0 - margins.bottom)) :, : width // 2] = True
        covered[:, int(width * (1.0 - margins.right)) :] = True
        draw_mark(stage.overlay, camera, tightest.position, _mark_words(tightest, len(solved)), covered)
    return Picture(stage.shoot(), camera, tightest)


def _tightest(solved: Sequence[tuple[Cable, RodSolution]]) -> Spot | None:
    """The tightest spot of all cables; None where all are straight."""
    spots = [
        Spot(cable.name, number, at, radius, solution.position(at)[0])
        for number, (cable, solution) in enumerate(solved, 1)
        if (radius := solution.bend_radius_min) is not None and (at := solution.bend_radius_min_at) is not None
    ]
    return min(spots, key=lambda spot: spot.bend_radius, default=None)


def _mark_words(spot: Spot, cables: int) -> tuple[str, str]:
    """What stands beside the mark: a line to be read at once, and one that says where."""
    where = f"s = {spot.arclength:.4g} mm"
    return f"R {spot.bend_radius:.4g} mm", where if cables == 1 else f"{_called(spot)}, {where}"


def _called(spot: Spot) -> str:
    """The cable's name, shortened, or its number where VTK's type lacks letters of it."""
    return shortened(spot.cable, _LONGEST) if can_be_set(spot.cable) else f"cable {spot.number}"


def _part_solids(parts: Sequence[tuple[Part, Document]], *, pale: bool) -> list[Solid]:
    if not parts:
        return []
    from cablecad.brep.model import mesh_parts

    solids = []
    for node in mesh_parts(parts):
        for patch in node.placed_patches():
            color, clear = (rgb(PART), 1.0) if patch.color is None else (patch.color[:3], patch.color[3])
            solids.append(Solid(patch.mesh, paled(color, _PALE) if pale else color, clear))
    return solids


def _reach(cable: Cable, solution: RodSolution) -> Array:
    """Points around a cable that reach as far as it does, to a hundredth of its radius or so."""
    return mesh_tube(solution.centreline, cable.section.radius, tolerance=0.05 * cable.section.radius).mesh.vertices


def _cable_solid(
    cable: Cable, solution: RodSolution, index: int, camera: Camera, tightest: Spot | None, curvature: bool
) -> Solid:
    radius = max(cable.section.radius, _THINNEST * camera.mm_per_pixel / 2.0)
    outlined = 2.0 * radius >= _OUTLINED * camera.mm_per_pixel
    tube = mesh_tube(solution.centreline, radius, tolerance=max(_FINEST * camera.mm_per_pixel, 1e-3 * radius))
    color = cable_color(cable.color, index)
    if not curvature:
        return Solid(tube.mesh, rgb(color), opacity(color), outlined=outlined)
    kappa = np.abs(solution.curvature(np.clip(tube.arclengths, 0.0, solution.length)))
    greatest = 1.0 if tightest is None else 1.0 / tightest.bend_radius
    return Solid(tube.mesh, bend_color(kappa / greatest), glow=0.45, outlined=outlined)
