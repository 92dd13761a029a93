"""The equilibria of a cable side by side, all to one scale: which are stable, and what energy each has."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from cablecad.picture.figure import LEAVES_PLANE, STABLE, UNSTABLE, title_room
from cablecad.picture.flat_view import flat_view
from cablecad.picture.round_number import significant
from cablecad.picture.words import counted, shortened

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from cablecad.rod.solution import Equilibrium, RodSolution

MOST = 16
"""More equilibria than this are not drawn, and that is said."""

_COLUMNS = 4

_KINDS = {
    "stable": (STABLE, "solid", "stable"),
    "leaves": (LEAVES_PLANE, "solid", "stable only in its plane"),
    "unstable": (UNSTABLE, (0, (4.0, 2.0)), "unstable"),
}

DASHES = {"stable": "solid", "leaves": (0, (8.0, 1.5, 1.5, 1.5)), "unstable": (0, (3.5, 2.5))}
"""Of lines whose colours tell something else."""

WORDS = {kind: words for kind, (_, _, words) in _KINDS.items()}
"""What the kinds of equilibria are called."""


def kind_of(equilibrium: Equilibrium) -> str:
    """stable, leaves (its plane) or unstable."""
    if not equilibrium.stability.stable_in_plane:
        return "unstable"
    return "stable" if equilibrium.stability.stable_out_of_plane else "leaves"


def line_of(kind: str) -> dict[str, object]:
    """How a shape of a kind is drawn."""
    color, dashes, _ = _KINDS[kind]
    return {"color": color, "linestyle": dashes, "linewidth": 2.0}


def equilibria_size(solution: RodSolution) -> tuple[float, float]:
    """Width and height of the sheet they need [inches]."""
    count = min(len(solution.equilibria), MOST)
    columns = min(count, _COLUMNS)
    return max(6.4, 3.0 * columns), 1.2 + 3.1 * math.ceil(count / columns)


def plot_equilibria(figure: Figure, solution: RodSolution) -> None:
    """Draw the equilibria of a solution on a sheet of their own."""
    found = solution.equilibria[:MOST]
    columns = min(len(found), _COLUMNS)
    figure.get_layout_engine().set(hspace=0.09)  # words stand below a field, and above the next
    grid = figure.subplots(math.ceil(len(found) / columns), columns, squeeze=False)
    view = flat_view(found[0].centreline)
    drawn = [view.flat(equilibrium.centreline.points(401)) for equilibrium in found]
    # One scale for all, each in the middle of its field.
    half = max(float(np.ptp(points, axis=0).max()) for points in drawn) / 2.0 * 1.2
    used = set()
    for i, axes in enumerate(grid.ravel()):
        axes.set_axis_off()
        if i >= len(found):
            continue
        kind = kind_of(found[i])
        used.add(kind)
        points = drawn[i]
        middle = (points.min(axis=0) + points.max(axis=0)) / 2.0
        axes.plot(*points.T, **line_of(kind))
        axes.plot(*points[[0, -1]].T, linestyle="none", marker="o", markersize=5.0, color="#22272e")
        axes.set_xlim(middle[0] - half, middle[0] + half)
        axes.set_ylim(middle[1] - half, middle[1] + half)
        axes.set_aspect("equal")
        chosen = i == solution.index
        axes.set_title(f"{i} – the answer" if chosen else f"{i}", fontsize=12.0, pad=14.0)
        axes.annotate(
            _facts(solution, found[i]),
            (0.0, 1.0),
            xytext=(0.0, 0.0),
            xycoords="axes fraction",
            textcoords="offset points",
            fontsize=10.5,
            color="#4b535e",
        )
        if kind != "stable":
            color, _, words = _KINDS[kind]
            axes.annotate(
                words, (0.0, 0.0), xytext=(0.0, -9.0), xycoords="axes fraction", textcoords="offset points",
                color=color, fontsize=10.5, fontweight="bold",
            )  # fmt: skip
    more = len(solution.equilibria) - len(found)
    rest = f", {more} more not drawn" if more else ""
    said = f": {counted(len(solution.equilibria), 'equilibrium', 'equilibria')} found{rest}"
    room = title_room(figure.get_figwidth()) - len(said)
    figure.suptitle(
        shortened(solution.cable.name, room) + said,
        x=0.012, ha="left", fontsize=13.0, fontweight="bold",
    )  # fmt: skip
    _key(figure, used)


def _facts(solution: RodSolution, equilibrium: Equilibrium) -> str:
    """Energy and tightest bend, on one line."""
    EI, radius = solution.EI, equilibrium.bend_radius_min
    size = equilibrium.energy_per_EI
    energy = f"{size:.4g} EI /mm" if EI is None else f"{significant(EI * size)} N mm"
    return energy if radius is None else f"{energy},  R {significant(radius, 3)} mm"


def _key(figure: Figure, used: set[str]) -> None:
    """What the lines mean."""
    from matplotlib.lines import Line2D

    handles = [Line2D([], [], **line_of(kind), label=_KINDS[kind][2]) for kind in _KINDS if kind in used]
    figure.legend(handles=handles, loc="outside lower left", ncols=len(handles), fontsize=10.0)
