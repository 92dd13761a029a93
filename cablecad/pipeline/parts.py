"""The parts of a scene: their files read, each once, and numbers in place of the cables' ends on them."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import TYPE_CHECKING

from cablecad.errors import CablecadError, ExchangeError
from cablecad.model import Part
from cablecad.pipeline.clock import timed
from cablecad.pipeline.ports import Resolved, parts_to_read, resolve_ports
from cablecad.pipeline.run import Progress, SceneRun, tell

if TYPE_CHECKING:
    from cablecad.brep.document import Document


def import_kernel(run: SceneRun) -> None:
    """Load Open Cascade, by the run's clock."""
    with timed(run.seconds, "import"):
        import cablecad.brep.kernel  # noqa: F401 - most of the time of a small build; named apart in the report


def ends_resolved(run: SceneRun, progress: Progress | None) -> Resolved:
    """Put numbers in place of the ends on parts; only ends taken from geometry need the kernel."""
    needed = parts_to_read(run.scene)
    if not needed:
        resolved = resolve_ports(run.scene, {})
        run.scene = resolved.scene
        return resolved
    names = ", ".join(part.name for part in needed)
    run.remarks.append(f"ends of cables are taken from the geometry of {names}, for which Open Cascade is loaded")
    import_kernel(run)
    read_parts_of(run, needed, progress)
    with timed(run.seconds, "read"):
        resolved = resolve_ports(run.scene, run.documents)
    run.scene = resolved.scene
    for name, remarks in resolved.remarks.items():
        run.remarks += [f"cable {name}: {remark}" for remark in remarks]
    return resolved


def read_scene_parts(run: SceneRun, progress: Progress | None = None) -> list[tuple[Part, Document]]:
    """Read what was not read yet of a scene's parts: each that could be, the others' errors among the run's."""
    read_parts_of(run, run.scene.parts, progress)
    return [(part, run.documents[part.name]) for part in run.scene.parts if part.name in run.documents]


def read_parts_of(run: SceneRun, parts: Iterable[Part], progress: Progress | None) -> None:
    """Read every file once, of parts not looked at before; one that cannot be read does not hide another."""
    by_file: dict[str, list[Part]] = {}
    for part in parts:
        if part.name not in run.looked_at:
            run.looked_at.add(part.name)
            by_file.setdefault(os.path.realpath(part.step), []).append(part)
    known = {os.path.realpath(part.step): part.name for part in run.scene.parts if part.name in run.documents}
    with timed(run.seconds, "read"):
        for path, same in by_file.items():
            from cablecad.brep.step import read_step

            for part in same:
                tell(progress, part.name)
            if path in known:
                run.documents |= dict.fromkeys((part.name for part in same), run.documents[known[path]])
                continue
            try:
                document = (read_step if run.kept is None else run.kept.read)(same[0].step)
                run.documents |= dict.fromkeys((part.name for part in same), document)
            except CablecadError as error:
                names = " and ".join(part.name for part in same)
                run.errors.append(ExchangeError(f"part {names}: {error}"))
