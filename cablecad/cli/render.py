"""`cablecad render`: a picture of a scene."""

from __future__ import annotations

import re
from pathlib import Path

import click

from cablecad.cli.session import note_all, progress_bar, scene_argument, show_errors, verbosity_options, warn_of
from cablecad.errors import UsageError

_EXAMPLES = """\b
Examples:
  cablecad render loom.toml                       writes loom.png
  cablecad render loom.toml -o top.png --view top --size 1200x800
  cablecad render loom.toml -o bends.png --curvature --cable W1
"""


@click.command(epilog=_EXAMPLES)
@scene_argument
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    help="The PNG file to write; the scene's name with .png if not given.",
)
@click.option(
    "--view",
    default="iso",
    show_default=True,
    metavar="VIEW",
    help="iso, front, back, top, bottom, right, left, or the direction from the scene to the eye: x,y,z. Z is up; the "
    "front faces -Y.",
)
@click.option("--size", default="1600x1000", show_default=True, metavar="WxH", help="Of the picture, in pixels.")
@click.option(
    "--cable",
    "cables",
    multiple=True,
    metavar="NAME",
    help="Show this cable only, as large as it can be; may be given several times. Parts stay.",
)
@click.option(
    "--curvature",
    is_flag=True,
    help="Colour cables by their curvature, with a legend in mm of bend radius, and mark the tightest spot.",
)
@verbosity_options
def render(
    scene_path: Path, output: Path | None, view: str, size: str, cables: tuple[str, ...], curvature: bool
) -> int:
    """Solve SCENE and draw its parts and cables as a shaded picture.

    With axes and a scale bar, which holds all over it, for the projection is parallel. A cable is drawn at least 1.6
    pixels thick. Needs no display. Prints the path written. Takes VTK, which comes with Open Cascade
    (pip install "cablecad[ocp]").
    """
    from cablecad.files import write_bytes
    from cablecad.picture.png import png_bytes
    from cablecad.picture.render import check_picture, draw_run, with_cables
    from cablecad.pipeline import read_scene_parts, solve_scene
    from cablecad.scene import load_scene

    scene = with_cables(load_scene(scene_path), cables)
    output = output if output is not None else scene_path.with_suffix(".png")
    pixels = _size(size)
    check_picture(scene, output, view=view, size=pixels)
    with progress_bar(len(scene.cables) + len(scene.parts)) as progress:
        run = solve_scene(scene, progress=progress)
        parts = read_scene_parts(run, progress)
        if not run.errors:
            picture = draw_run(run, parts, view=view, size=pixels, curvature=curvature, closer=bool(cables))
            write_bytes(output, png_bytes(picture.pixels))
    note_all(run.remarks)
    for outcome in run.outcomes:
        warn_of(outcome.cable.name, outcome.warnings)
        warn_of(outcome.cable.name, outcome.violations)
    show_errors(run.errors)
    if not run.errors:
        click.echo(output)
    return run.exit_code


def _size(text: str) -> tuple[int, int]:
    found = re.fullmatch(r"(\d{1,6})[xX×](\d{1,6})", text.strip())
    if found is None:
        raise UsageError(f"size {text!r}: give width and height in pixels, such as 1600x1000")
    return int(found[1]), int(found[2])
