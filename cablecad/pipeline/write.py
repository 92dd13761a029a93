"""Built cables and rigid parts into one STEP file, and which outputs cannot be meant."""

from __future__ import annotations

from collections.abc import Iterable
from os import PathLike, fspath
from pathlib import Path

from cablecad.errors import UsageError
from cablecad.files import same_file
from cablecad.model import Part, Scene
from cablecad.pipeline.cable import Built


def write_step(items: Iterable[Built | Part], path: str | PathLike[str], *, name: str | None = None) -> None:
    """Write built cables and rigid parts as one assembly in a STEP file.

    Args:
        items: In any order; names must be unique.
        path: The STEP file, written whole or not at all.
        name: Of the assembly; the file's name without its suffix if not given.

    Raises:
        SceneError: Two items of one name.
        UsageError: The output is one of the parts' files, or is no STEP file by its name.
        ExchangeError: A part cannot be read, or the output not written.
    """
    items, path = list(items), Path(fspath(path))
    parts = tuple(item for item in items if isinstance(item, Part))
    cables = [item for item in items if isinstance(item, Built)]
    scene = Scene(name if name is not None else path.stem, tuple(built.cable for built in cables), parts)
    check_output(scene, path)
    from cablecad.brep.document import CableSolid
    from cablecad.brep.step import read_parts
    from cablecad.brep.step import write_step as write_document

    solids = [CableSolid(built.name, built.solid.wrapped, built.cable.color) for built in cables]
    write_document(path, scene.name, read_parts(parts), solids)


def check_output(scene: Scene, path: Path, *, suffixes: tuple[str, ...] = (".step", ".stp")) -> None:
    """Refuse an output that cannot be meant, before any work is done.

    Raises:
        UsageError: Another suffix, or one of the scene's own inputs.
    """
    if path.suffix.lower() not in suffixes:
        raise UsageError(f"output {path}: its name must end in {' or '.join(suffixes)}")
    for source in scene.inputs:
        if same_file(path, source):
            raise UsageError(f"output {path} is also an input of the scene; write to another file")
