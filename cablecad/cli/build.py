"""`cablecad build`: a scene file to one file of solids, or of their triangles."""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

import click

from cablecad.cli.session import note_all, progress_bar, scene_argument, show_errors, verbosity_options, warn_of
from cablecad.errors import UsageError

_EXAMPLES = """\b
Examples:
  cablecad build loom.toml                     writes loom.step
  cablecad build loom.toml -o out/loom.step --report out/loom.json
  cablecad build loom.toml --strict --tolerance 1e-6
  cablecad build loom.toml -o loom.glb         for any viewer
"""


@click.command(epilog=_EXAMPLES)
@scene_argument
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    help="The file to write; its suffix says the format: .step (or .stp), .glb, .stl or .brep. The scene's name with "
    ".step if not given.",
)
@click.option("--report", "report_path", type=click.Path(path_type=Path), help="Also write the report as JSON.")
@click.option("--strict", is_flag=True, help="Treat a broken min_bend_radius as an error: exit 4, write nothing.")
@click.option(
    "--tolerance",
    type=float,
    metavar="MM",
    help="Bound on the distance between a solid's side and the exact tube, instead of the scene's [mm].",
)
@click.option(
    "--mesh-tolerance",
    type=float,
    metavar="MM",
    help="For .glb and .stl: bound on the distance between triangles and surfaces [mm]; if not given a hundredth of "
    "each cable's radius and 1/2000 of each part's extent.",
)
@verbosity_options
def build(
    scene_path: Path,
    output: Path | None,
    report_path: Path | None,
    strict: bool,
    tolerance: float | None,
    mesh_tolerance: float | None,
) -> int:
    """Solve SCENE, make its solids and write one file.

    A STEP file holds the scene's parts and cables as an assembly with names and colours; so does .glb, as triangles
    for any viewer, in metres with Y up as that format has it. .stl and .brep hold no names and no colours. The file
    appears whole or not at all; the same input gives the same bytes. Prints the paths written.
    """
    from cablecad.files import replacing, same_file
    from cablecad.pipeline import MODEL_SUFFIXES, check_output, run_build
    from cablecad.report import to_json
    from cablecad.scene import load_scene

    scene = load_scene(scene_path)
    output = output if output is not None else scene_path.with_suffix(".step")
    if tolerance is not None:
        scene = replace(scene, tolerance=tolerance)
    check_output(scene, output, suffixes=MODEL_SUFFIXES)
    with ExitStack() as stack:
        if report_path is not None:
            check_output(scene, report_path, suffixes=(".json",))
            if same_file(output, report_path):
                raise UsageError(f"output {output} and report {report_path} lead to one file; give two")
            # Begun before the work is: a report that cannot be written is better known before than after.
            report_aside = stack.enter_context(replacing(report_path))
        with progress_bar(2 * len(scene.cables) + len(scene.parts)) as progress:
            run = run_build(scene, output, strict=strict, mesh_tolerance=mesh_tolerance, progress=progress)
        if report_path is not None:
            report_aside.write_text(to_json(run.report()), encoding="utf-8")
    note_all(run.remarks)
    for outcome in run.outcomes:
        warn_of(outcome.cable.name, outcome.warnings)
        if not strict:
            warn_of(outcome.cable.name, outcome.broken_rules)
    show_errors(run.errors)
    if not run.errors:
        click.echo(output)
    if report_path is not None:
        click.echo(report_path)
    return run.exit_code
