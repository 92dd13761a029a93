"""`cablecad solve`: what the cables of a scene are like, without solids."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from cablecad.cli.session import note_all, progress_bar, say, scene_argument, show_errors, verbosity_options, warn_of

if TYPE_CHECKING:
    from cablecad.report import CableOutcome


_EXAMPLES = """\b
Examples:
  cablecad solve loom.toml
  cablecad solve loom.toml --json --points 200 > loom.json
"""


@click.command(epilog=_EXAMPLES)
@scene_argument
@click.option("--json", "as_json", is_flag=True, help="Print the whole report as JSON.")
@click.option(
    "--points",
    type=click.IntRange(min=2),
    metavar="N",
    help="With --json: N points at equal arclengths, ends included.",
)
@click.option(
    "--equilibria",
    "wide",
    is_flag=True,
    help="Look for more equilibria: windings -2..2, more starts. The report lists all that were found.",
)
@verbosity_options
def solve(scene_path: Path, as_json: bool, points: int | None, wide: bool) -> int:
    """Solve SCENE and print one line a cable, or the report as JSON: lengths in mm, forces in N.

    Makes no solids, and needs no Open Cascade unless an end is taken from a part's geometry (near).
    """
    from cablecad.pipeline import solve_scene
    from cablecad.report import to_json
    from cablecad.scene import load_scene

    if points is not None and not as_json:
        say("warning: --points goes into the report: add --json to see it")
    scene = load_scene(scene_path)
    with progress_bar(len(scene.cables)) as progress:
        run = solve_scene(scene, search="wide" if wide else "answer", progress=progress)
    if as_json:
        click.echo(to_json(run.report(points=points)), nl=False)
    else:
        for outcome in run.outcomes:
            click.echo(_line(outcome))
    note_all(run.remarks)
    for outcome in run.outcomes:
        warn_of(outcome.cable.name, outcome.warnings)
        warn_of(outcome.cable.name, outcome.violations)
    show_errors(run.errors)
    return run.exit_code


def _line(outcome: CableOutcome) -> str:
    """One cable on one line."""
    solution = outcome.solution
    if solution is None:
        return f"{outcome.cable.name}: {outcome.result}"
    radius = solution.bend_radius_min
    parts = [
        f"{outcome.cable.name}: solved",
        f"{solution.model} ({solution.equilibrium.branch})",
        f"length {solution.length:.7g} mm",
        f"chord {solution.chord:.7g} mm",
        "no bend"
        if radius is None
        else f"least bend radius {radius:.7g} mm at s = {solution.bend_radius_min_at:.7g} mm",
    ]
    if solution.EI is not None:
        force = solution.EI * float((solution.equilibrium.end.force_per_EI**2).sum() ** 0.5)
        parts.append(f"end force {force:.7g} N")
    stability = solution.stability
    if not stability.stable_in_plane:
        parts.append("unstable")
    elif not stability.stable_out_of_plane:
        parts.append("stable only in its plane")
    else:
        parts.append("stable")
    return ", ".join(parts)
