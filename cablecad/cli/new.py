"""`cablecad new`: a commented starter scene."""

from __future__ import annotations

from pathlib import Path

import click

from cablecad.cli.session import verbosity_options
from cablecad.errors import UsageError

_EXAMPLES = """\b
Example:
  cablecad new loom.toml
"""


@click.command(epilog=_EXAMPLES)
@click.argument("path", metavar="FILE", type=click.Path(path_type=Path))
@click.option("--force", is_flag=True, help="Replace FILE if it exists.")
@verbosity_options
def new(path: Path, force: bool) -> None:
    """Write a commented starter scene to FILE, a .toml file that builds as it stands."""
    from cablecad.files import replacing
    from cablecad.scene import starter_scene

    if path.suffix.lower() != ".toml":
        raise UsageError(f"{path}: the starter scene is TOML; give a name that ends in .toml")
    with replacing(path) as temporary:  # first: a path that cannot be written at all is told as such
        if path.exists() and not force:
            raise UsageError(f"{path} exists; choose another name, or --force to replace it")
        temporary.write_text(starter_scene(), encoding="utf-8")
    click.echo(path)
