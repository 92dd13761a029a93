"""`python -m cablecad.bench hard-cases | planar`."""

from __future__ import annotations

import click


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
def bench() -> None:
    """Tables of speed against error, and of the cases that break solvers."""


@bench.command("hard-cases")
def hard_cases() -> None:
    """The cases that break solvers of planar rods: expected, obtained, residual, time."""
    from cablecad.bench.hard_cases import table

    text, right = table()
    click.echo(text)
    click.echo("every row is right" if right else "SOME ROWS ARE WRONG")
    raise SystemExit(0 if right else 1)


if __name__ == "__main__":
    bench()
