"""A cable for a person to read: its name at the start of a line, and what is known of it below, a line each.

Colours are asked for here and shown on a terminal only; so is the table itself, unless asked for.
"""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from cablecad.report import CableOutcome
    from cablecad.rod.solution import EndState, RodSolution

Row = tuple[str, str, str | None]
"""A label, what is said under it, and a colour."""

_LABEL = 14
"""Columns of the words at the left."""


def cable_table(outcome: CableOutcome, width: int) -> str:
    """A cable as lines of text of at most `width` columns, as far as its words allow, with colours."""
    name, solution = outcome.cable.name, outcome.solution
    if solution is None:
        return "\n".join([_head(name, outcome.result, "red"), *_lines([("", str(outcome.error), "red")], width)])
    verdict, color = _verdict(solution)
    rows = list(_rows(solution))
    rows += [("broken rule", message, "red") for message in outcome.violations]
    rows += [("warning", message, "yellow") for message in outcome.warnings]
    return "\n".join([_head(name, verdict, color), *_lines(rows, width)])


def _head(name: str, verdict: str, color: str) -> str:
    return f"{click.style(name, bold=True)}: {click.style(verdict, fg=color)}"


def _verdict(solution: RodSolution) -> tuple[str, str]:
    """Whether a real cable would take the shape, and the colour for that."""
    stability = solution.stability
    if not stability.stable_in_plane:
        return "solved, unstable", "red"
    if not stability.stable_out_of_plane:
        return "solved, stable only in its plane", "yellow"
    return "solved, stable", "green"


def _rows(solution: RodSolution) -> Iterator[Row]:
    yield "model", f"{solution.model} ({solution.equilibrium.branch}): {solution.reason}", None
    slack = "" if solution.slack is None else f", slack {solution.slack:.4g}"
    yield "length", f"{solution.length:.7g} mm, chord {solution.chord:.7g} mm{slack}", None
    yield "bend radius", *_bend(solution)
    room = solution.self_gap
    if room is not None:
        yield "room to itself", f"{room:.4g} mm", None if room >= 0.0 else "red"
    for label, state in (("at the start", solution.equilibrium.start), ("at the end", solution.equilibrium.end)):
        yield label, _wrench(solution, state), None
    energy = solution.energy
    yield (
        "energy",
        f"{solution.equilibrium.energy_per_EI:.4g} EI /mm" if energy is None else f"{energy:.4g} N mm",
        None,
    )
    stability = solution.stability
    margins = f"margin {float(stability.in_plane):.3g} in its plane, {float(stability.out_of_plane):.3g} out of it"
    count = len(solution.equilibria)
    others = "the only equilibrium found" if count == 1 else f"equilibrium {solution.index} of {count} found"
    yield "stability", f"{margins} (EI/L², above 0 is stable); {others}", None


def _bend(solution: RodSolution) -> tuple[str, str | None]:
    """The tightest bend, and whether it keeps the rule."""
    radius, least = solution.bend_radius_min, solution.cable.min_bend_radius
    if radius is None:
        return "no bend", None
    words = f"{radius:.7g} mm at s = {solution.bend_radius_min_at:.7g} mm"
    if least is None:
        return words, None
    return f"{words} (rule: at least {least:g} mm)", "red" if radius < least else None


def _wrench(solution: RodSolution, state: EndState) -> str:
    """What the support applies: sizes first, then the components."""
    EI = solution.EI
    if EI is None:
        force, moment, units = state.force_per_EI, state.moment_per_EI, ("EI /mm²", "EI /mm")
    else:
        force, moment, units = EI * state.force_per_EI, EI * state.moment_per_EI, ("N", "N mm")
    return f"{_vector('force', force, units[0])}, {_vector('moment', moment, units[1])}"


def _vector(name: str, vector: NDArray[np.float64], unit: str) -> str:
    size = float((vector**2).sum() ** 0.5)
    if size == 0.0:
        return f"no {name}"
    # What rounding leaves beside a component of size is no number to show.
    parts = ", ".join(f"{0.0 if abs(value) < 1e-12 * size else value:.4g}" for value in vector.tolist())
    return f"{name} {size:.4g} {unit} ({parts})"


def _lines(rows: Sequence[Row], width: int) -> Iterator[str]:
    room = max(width - _LABEL - 3, 30)
    for label, words, color in rows:
        first, *others = textwrap.wrap(words, room, break_long_words=False, break_on_hyphens=False) or [""]
        yield f"  {click.style(f'{label:<{_LABEL}}', dim=True)} {click.style(first, fg=color)}"
        for line in others:
            yield f"  {'':<{_LABEL}} {click.style(line, fg=color)}"
