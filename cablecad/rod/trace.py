"""What is kept of a solved cable to start from again: its span and the solver's own state."""

from __future__ import annotations

from dataclasses import dataclass

from cablecad.rod.equilibria import Equilibria
from cablecad.rod.span import Span


@dataclass(frozen=True)
class Trace:
    """One equilibrium as the planar solver left it.

    Attributes:
        span: The free part of the cable, its plane and its scale.
        row: The equilibrium of a rod of length one, a single row.
    """

    span: Span
    row: Equilibria
