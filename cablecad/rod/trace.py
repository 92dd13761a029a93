"""What is kept of a solved cable to start from again: its span and the solver's own state."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from cablecad.rod.equilibria import Equilibria
from cablecad.rod.span import Span


@dataclass(frozen=True)
class Trace:
    """One equilibrium as the planar solver left it.

    Attributes:
        span: The free part of the cable, its plane and its scale.
        among: Equilibria of rods of length one, all that were found with this one.
        place: Where in them it is.
    """

    span: Span
    among: Equilibria = field(repr=False, compare=False)
    place: int = 0

    def __reduce__(self) -> tuple[object, ...]:
        return Trace, (self.span, self.row)  # pickled or copied without all the others

    @cached_property
    def row(self) -> Equilibria:
        """The equilibrium of a rod of length one, a single row: a slice of all, whose arrays it shares."""
        return self.among if len(self.among) == 1 else self.among.take(slice(self.place, self.place + 1))

    @property
    def is_taut(self) -> bool:
        """Whether the shape is the closed form of `Taut`."""
        return bool(self.among.taut[self.place])


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
