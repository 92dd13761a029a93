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


@bench.command("planar")
@click.option("--share", type=click.FloatRange(0.0, 1.0, min_open=True), default=1.0, help="Of the full counts.")
def planar(share: float) -> None:
    """What the planar solver solves, against a multi-start search and a discrete rod, and its time: a few minutes."""
    from cablecad.bench.planar import figures

    text, hold = figures(share)
    click.echo(text)
    click.echo("every target holds" if hold else "SOME TARGETS ARE MISSED")
    raise SystemExit(0 if hold else 1)


if __name__ == "__main__":
    bench()
