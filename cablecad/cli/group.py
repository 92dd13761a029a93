"""The command `cablecad` itself. Subcommands are loaded when they are called, so `--help` and `solve` stay quick."""

from __future__ import annotations

from importlib import import_module

import click

from cablecad import __version__

_COMMANDS = {
    "build": "Solve a scene, make its solids and write one file: STEP, or another format by its suffix.",
    "solve": "Solve a scene and print what its cables are like; no solids.",
    "check": "Judge a scene as build would, every rule strictly, and write nothing.",
    "resolve": "Print a scene with numbers in place of the ends on parts.",
    "render": "Draw a scene as a shaded picture.",
    "plot": "Draw shapes, curvatures and equilibria of cables, or a family of them.",
    "batch": "Build or solve many variants: rows of a table, a grid, or many scene files.",
    "schema": "Print the JSON Schema of a scene file.",
    "new": "Write a commented starter scene.",
    "bench": "Measure speed against error, ours beside scipy's and Open Cascade's.",
}


_EXAMPLES = """\b
Examples:
  cablecad new loom.toml                   a scene to begin with, every key explained
  cablecad solve loom.toml                 the shape of its cables in numbers
  cablecad build loom.toml -o loom.step    their solids

"""


class _LazyGroup(click.Group):
    """A group that imports a subcommand only when it is called, and lists all of them without importing any."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(_COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in _COMMANDS:
            return None
        command: click.Command = getattr(import_module(f"cablecad.cli.{cmd_name}"), cmd_name)
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl(list(_COMMANDS.items()))


@click.group(
    cls=_LazyGroup,
    context_settings={"help_option_names": ["-h", "--help"]},
    epilog=_EXAMPLES
    + "Exit codes: 0 done, 1 a bug, 2 usage or an invalid scene, 3 no such shape, 4 geometry or a rule failed its "
    "check, 5 a file could not be read or written, 6 some of many failed, 130 interrupted.",
)
@click.version_option(__version__, prog_name="cablecad")
def cablecad() -> None:
    """The true shape of flexible cables: a scene file in, STEP out. Lengths in mm, forces in N."""
