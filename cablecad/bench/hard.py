"""The cases that break solvers and sweeps, a row each: functions, shapes, tubes."""

from __future__ import annotations

from importlib.util import find_spec

from cablecad.bench.hard_functions import function_rows
from cablecad.bench.hard_row import HardRow
from cablecad.bench.hard_solving import solving_rows
from cablecad.bench.stage import Effort, Tell
from cablecad.bench.table import Table, Target


def run(_effort: Effort, tell: Tell) -> list[Table]:
    """The stage; without Open Cascade its tubes are left out."""
    tell("elliptic functions")
    rows: list[HardRow] = function_rows()
    tell("shapes")
    rows += solving_rows()
    if find_spec("OCP") is not None:
        from cablecad.bench.hard_tubes import tube_rows

        rows += tube_rows(tell)
    wrong = sum(not row.right for row in rows)
    return [
        Table(
            "hard-cases",
            "Hard cases: what comes out, and what scipy or Open Cascade gives on the same",
            rows,
            [Target("hard cases: rows that are not as expected", wrong, 0)],
            (
                "error: of a function over 1 + |u|, of an energy or a volume relative; energies times length over EI, "
                "against published figures or 26 digits, volumes against pi r^2 L",
                "solve_bvp finds one equilibrium from a start that knows nothing; more starts would find more",
                "the tubes' rivals run in processes of their own: some of them die",
            ),
        )
    ]
