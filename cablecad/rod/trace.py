"""What is kept of a solved cable to start from again: its span and the solver's own state."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, fields

import numpy as np
from numpy.typing import NDArray

from cablecad.rod.equilibria import Equilibria
from cablecad.rod.span import Span


@dataclass(frozen=True)
class Trace:
    """One equilibrium as the planar solver left it.

    Attributes:
        span: The free part of the cable, its plane and its scale.
        row: The equilibrium of a rod of length one, a single row.
        among: All that were found with it, of which `row` is a slice; None where it was found alone.
        place: Where in them it is.
    """

    span: Span
    row: Equilibria
    among: Equilibria | None = field(default=None, repr=False, compare=False)
    place: int = 0


def gathered(traces: Sequence[Trace]) -> Equilibria:
    """Copies of the rows of some traces."""
    among = _common(traces)
    if among is not None:
        return among.take(_places(traces))
    rows = [one.row for one in traces]
    return Equilibria(*(np.concatenate([getattr(row, f.name) for row in rows]) for f in fields(Equilibria)))


def give_back(traces: Sequence[Trace], rows: Equilibria, *names: str) -> None:
    """Write arrays of what `gathered` made, and found more of, into the rows of the traces."""
    among = _common(traces)
    if among is not None:
        places = _places(traces)
        for name in names:
            getattr(among, name)[places] = getattr(rows, name)
        return
    for i, one in enumerate(traces):
        for name in names:
            getattr(one.row, name)[:] = getattr(rows, name)[i : i + 1]


def _common(traces: Sequence[Trace]) -> Equilibria | None:
    """The equilibria that all traces are of, if there are any."""
    among = traces[0].among
    return among if all(one.among is among for one in traces) else None


def _places(traces: Sequence[Trace]) -> NDArray[np.intp]:
    return np.array([one.place for one in traces])
