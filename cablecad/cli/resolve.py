"""`cablecad resolve`: a scene with numbers in place of the ends on parts."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import click

from cablecad.cli.session import note_all, scene_argument, show_errors, verbosity_options

_EXAMPLES = """\b
Examples:
  cablecad resolve loom.toml                     prints TOML; paths of parts become absolute
  cablecad resolve loom.toml -o out/loom.toml    writes it; paths of parts begin in out/
  cablecad resolve loom.toml --json
"""


@click.command(epilog=_EXAMPLES)
@scene_argument
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    help="Write to this file, .toml or .json, and print its path.",
)
@click.option("--json", "as_json", is_flag=True, help="JSON in place of TOML.")
@verbosity_options
def resolve(scene_path: Path, output: Path | None, as_json: bool) -> int:
    """Print SCENE with numbers in place of every end that is given by a part: by port, or by near.

    What is printed is a scene: it solves and builds as SCENE does, byte for byte, without looking at geometry for its
    ends. Comments are not kept. Needs Open Cascade only where an end is given by near.
    """
    from cablecad.files import write_bytes
    from cablecad.pipeline import check_output, resolve_ends
    from cablecad.scene import load_scene, resolved_text

    scene = load_scene(scene_path)
    if output is not None:
        check_output(scene, output, suffixes=(".json",) if as_json else (".toml", ".json"))
    to_json = as_json or (output is not None and output.suffix.lower() == ".json")
    syntax: Literal["toml", "json"] = "json" if to_json else "toml"
    run = resolve_ends(scene)
    note_all(run.remarks)
    show_errors(run.errors)
    if not run.errors:
        text = resolved_text(scene_path, run.scene, syntax=syntax, folder=None if output is None else output.parent)
        if output is None:
            click.echo(text, nl=False)
        else:
            write_bytes(output, text.encode())
            click.echo(output)
    return run.exit_code
