"""The whole story: scene, model choice, solve, centreline, tube, check, document, report.

`cable` tells it of one cable, `scene` of all that a scene file holds, whose state is a `run`; `parts` reads the rigid
ones, `ports` takes cables' ends from them, `write` puts what was built into a file.
"""

from cablecad.pipeline.cable import Built, Search, Solid, build, build_solution, solve, solve_many
from cablecad.pipeline.documents import Documents
from cablecad.pipeline.parts import read_scene_parts
from cablecad.pipeline.run import Progress, SceneRun, measure_scenes
from cablecad.pipeline.scene import (
    build_scene,
    check_scene,
    make_scene,
    resolve_ends,
    run_build,
    solve_scene,
    solve_scenes,
)
from cablecad.pipeline.write import MODEL_SUFFIXES, check_output, write_step

__all__ = [
    "MODEL_SUFFIXES",
    "Built",
    "Documents",
    "Progress",
    "SceneRun",
    "Search",
    "Solid",
    "build",
    "build_scene",
    "build_solution",
    "check_output",
    "check_scene",
    "make_scene",
    "measure_scenes",
    "read_scene_parts",
    "resolve_ends",
    "run_build",
    "solve",
    "solve_many",
    "solve_scene",
    "solve_scenes",
    "write_step",
]
