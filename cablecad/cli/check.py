"""`cablecad check`: judge a scene as build would, and write nothing."""

from __future__ import annotations

from pathlib import Path

import click

from cablecad.cli.session import note_all, progress_bar, scene_argument, show_errors, verbosity_options, warn_of

_EXAMPLES = """\b
Example:
  cablecad check loom.toml && cablecad build loom.toml
"""


@click.command(epilog=_EXAMPLES)
@scene_argument
@click.option("--json", "as_json", is_flag=True, help="Print the whole report as JSON.")
@verbosity_options
def check(scene_path: Path, as_json: bool) -> int:
    """Solve SCENE, read its parts, make and measure every solid, and write nothing.

    Prints one line a cable. A broken rule, min_bend_radius among them, is an error here: exit 4.
    """
    from cablecad.pipeline import check_scene
    from cablecad.report import to_json
    from cablecad.scene import load_scene

    scene = load_scene(scene_path)
    with progress_bar(2 * len(scene.cables) + len(scene.parts)) as progress:
        run = check_scene(scene, progress=progress)
    if as_json:
        click.echo(to_json(run.report()), nl=False)
    else:
        for outcome in run.outcomes:
            broken = outcome.solution is not None and outcome.solution.violations
            verdict = outcome.result if outcome.error is not None else "broken rules" if broken else "ok"
            detail = ""
            if outcome.fit is not None and outcome.check is not None:
                detail = f", deviation {outcome.fit.deviation:.3g} mm of {outcome.fit.tolerance:g} mm allowed"
            click.echo(f"{outcome.cable.name}: {verdict}{detail}")
    note_all(run.remarks)
    for outcome in run.outcomes:
        warn_of(outcome.cable.name, outcome.warnings)
    show_errors(run.errors)
    return run.exit_code
