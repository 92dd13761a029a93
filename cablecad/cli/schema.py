"""`cablecad schema`: the JSON Schema of a scene file."""

from __future__ import annotations

import json

import click

from cablecad.cli.session import verbosity_options

_EXAMPLES = """\b
Example:
  cablecad schema > scene.schema.json
"""


@click.command(epilog=_EXAMPLES)
@verbosity_options
def schema() -> None:
    """Print the JSON Schema of a scene file, for an editor or a generator of scenes.

    It describes TOML and JSON scenes alike, with the unit of every number.
    """
    from cablecad.scene import scene_schema

    click.echo(json.dumps(scene_schema(), indent=2, ensure_ascii=False))
