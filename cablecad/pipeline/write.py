"""Built cables and rigid parts into one file, whose suffix says of which format; and which outputs cannot be meant."""

from __future__ import annotations

from collections.abc import Iterable
from os import PathLike, fspath
from pathlib import Path
from typing import TYPE_CHECKING

from cablecad import __version__
from cablecad.errors import UsageError
from cablecad.model import Part, Scene
from cablecad.pipeline.cable import Built

if TYPE_CHECKING:
    from collections.abc import Sequence

    from cablecad.brep.document import CableSolid, Document

STEP_SUFFIXES = (".step", ".stp")

MESH_SUFFIXES = (".glb", ".stl")
"""Of the formats that hold triangles."""

MODEL_SUFFIXES = (*STEP_SUFFIXES, *MESH_SUFFIXES, ".brep")
"""Of all formats a scene can be built into."""


def write_step(items: Iterable[Built | Part], path: str | PathLike[str], *, name: str | None = None) -> None:
    """Write built cables and rigid parts as one assembly in a STEP file.

    Args:
        items: In any order; names must be unique.
        path: The STEP file, written whole or not at all.
        name: Of the assembly; the file's name without its suffix if not given.

    Raises:
        SceneError: Two items of one name.
        UsageError: An item that is neither, or an output that is one of the parts' files or no STEP file by its name.
        ExchangeError: A part cannot be read, or the output not written.
    """
    items, path = list(items), Path(fspath(path))
    for i, item in enumerate(items):
        if not isinstance(item, Built | Part):
            raise UsageError(
                f"items[{i}] is a {type(item).__name__}, which cannot be written: give what build() returns (of a "
                "shape of the adapters its .built), or a Part"
            )
    parts = tuple(item for item in items if isinstance(item, Part))
    cables = [item for item in items if isinstance(item, Built)]
    scene = Scene(name if name is not None else path.stem, tuple(built.cable for built in cables), parts)
    check_output(scene, path)
    from cablecad.brep.step import read_parts
    from cablecad.brep.step import write_step as write_document

    write_document(path, scene.name, read_parts(parts), [cable_solid(built) for built in cables])


def cable_solid(built: Built) -> CableSolid:
    """A built cable as files take it."""
    from cablecad.brep.document import CableSolid

    cable = built.cable
    return CableSolid(cable.name, built.solid.wrapped, cable.color, built.solution.centreline, cable.section.radius)


def write_model(
    path: Path,
    name: str,
    parts: Sequence[tuple[Part, Document]],
    cables: Sequence[CableSolid],
    *,
    mesh_tolerance: float | None = None,
) -> None:
    """Write parts and cables into a file of the format its suffix names, whole or not at all.

    Args:
        path: Its suffix is one of `MODEL_SUFFIXES`.
        name: Of the scene.
        parts: Each with what was read for it.
        cables: At their places, with their curves.
        mesh_tolerance: For triangles: bound on their distance to the surfaces [mm]; from the sizes if not given.

    Raises:
        ExchangeError: The file cannot be written.
        GeometryError: A shape cannot be meshed.
        UsageError: A mesh that fine would be too large.
    """
    from cablecad.files import write_bytes

    suffix = path.suffix.lower()
    if suffix in STEP_SUFFIXES:
        from cablecad.brep.step import write_step as write_document

        write_document(path, name, parts, cables)
    elif suffix == ".brep":
        from cablecad.brep.native import brep_bytes

        write_bytes(path, brep_bytes(parts, cables))
    else:
        from cablecad.brep.model import mesh_scene

        root = mesh_scene(name, parts, cables, tolerance=mesh_tolerance)
        if suffix == ".glb":
            from cablecad.brep.glb import glb_bytes

            write_bytes(path, glb_bytes(root, generator=f"cablecad {__version__}"))
        else:
            from cablecad.brep.stl import stl_bytes
            from cablecad.mesh import TUBE_SHARE

            finest = min((TUBE_SHARE * cable.radius for cable in cables), default=1e-3)
            write_bytes(path, stl_bytes(root, finest=mesh_tolerance if mesh_tolerance is not None else finest))


def check_output(scene: Scene, path: Path, *, suffixes: tuple[str, ...] = STEP_SUFFIXES) -> None:
    """Refuse an output that cannot be meant, before any work is done.

    Raises:
        UsageError: Another suffix, or one of the scene's own inputs.
    """
    from cablecad.files import same_file

    if path.suffix.lower() not in suffixes:
        *most, last = suffixes
        listed = f"{', '.join(most)} or {last}" if most else last
        raise UsageError(f"output {path}: its name must end in {listed}")
    for source in scene.inputs:
        if same_file(path, source):
            raise UsageError(f"output {path} is also an input of the scene; write to another file")
