"""A family of cables in one drawing: what becomes of the shape as one value of the scene changes."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from cablecad.centreline import Array
from cablecad.picture.equilibria_plot import DASHES, WORDS, kind_of
from cablecad.picture.figure import fitted_size, plain_ticks, subtitled
from cablecad.picture.flat_view import FlatView, flat_view
from cablecad.picture.round_number import shown
from cablecad.picture.words import counted

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from cablecad.rod.solution import RodSolution

_UNITS = {
    "length": "mm", "chord": "mm", "rise": "mm", "bend_radius": "mm", "min_bend_radius": "mm", "diameter": "mm",
    "straight": "mm", "position": "mm", "force": "N", "angle_deg": "degrees", "slack": "",
}  # fmt: skip

_IN_PLANE = 1e-6
"""A member this far out of the first one's plane, as a share of its length, lies in another."""


@dataclass(frozen=True)
class Member:
    """A cable of the family and the value it has."""

    value: float
    solution: RodSolution


def family_size(members: Sequence[Member]) -> tuple[float, float]:
    """Width and height of the sheet they need [inches]."""
    drawn = [view.flat(member.solution.points(65)) for member, view in zip(members, _views(members), strict=True)]
    width, height = np.subtract(*_limits(drawn)[::-1]).tolist()
    return fitted_size((width, height), beside=2.3, above=2.1)


def plot_family(figure: Figure, name: str, place: str, members: Sequence[Member], missing: int) -> None:
    """Draw a family on a sheet of its own.

    Args:
        figure: The sheet.
        name: Of the cable.
        place: What changes, as in the scene file.
        members: At least one.
        missing: How many values have no solution.
    """
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize
    from matplotlib.lines import Line2D

    axes = figure.add_subplot()
    views = _views(members)
    values = [member.value for member in members]
    # Without its lightest end, which white paper swallows.
    colors = colormaps["viridis"].resampled(256)
    norm = Normalize(min(values), max(values) + 0.12 * (max(values) - min(values)) or 1.0)
    used, drawn = set(), []
    for member, view in zip(members, views, strict=True):
        kind = kind_of(member.solution.equilibrium)
        used.add(kind)
        points = view.flat(member.solution.points(401))
        drawn.append(points)
        axes.plot(*points.T, color=colors(norm(member.value)), linewidth=2.0, linestyle=DASHES[kind])
        axes.plot(*points[[0, -1]].T, linestyle="none", marker="o", markersize=4.5, color=colors(norm(member.value)))
    axes.set_aspect("equal")
    low, high = _limits(drawn)
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.grid(visible=True)
    plain_ticks(axes)
    one_plane = all(view is views[0] for view in views)
    axes.set_xlabel(views[0].labels[0] if one_plane else "in each one's own plane, from its start [mm]")
    axes.set_ylabel(views[0].labels[1] if one_plane else "upwards [mm]")
    if len(values) > 1:
        bar = figure.colorbar(ScalarMappable(norm, colors), ax=axes, pad=0.02, aspect=22)
        bar.ax.set_ylim(min(values), max(values))
        bar.set_label(label_of(place))
        if len(values) <= 12:
            bar.set_ticks(values, labels=[shown(value) for value in values])
    handles = [
        Line2D([], [], color="#22272e", linewidth=2.0, linestyle=DASHES[kind], label=WORDS[kind])
        for kind in DASHES
        if kind in used
    ]
    figure.legend(handles=handles, loc="outside lower left", ncols=len(handles), fontsize=10.0)
    gone = f"; {missing} more {'has' if missing == 1 else 'have'} no solution" if missing else ""
    spread = f"from {shown(min(values))} to {shown(max(values))}" if len(values) > 1 else f"at {shown(values[0])}"
    subtitled(axes, name, f"{label_of(place)}: {counted(len(members), 'shape', 'shapes')} {spread}{gone}")


def _limits(drawn: Sequence[Array]) -> tuple[Array, Array]:
    """The corners of the drawing: a little room around the shapes, and more beside straight ones."""
    points = np.concatenate(drawn)
    low, high = points.min(axis=0), points.max(axis=0)
    size = high - low
    room = np.maximum(0.06 * size, (0.2 * size.max() - size) / 2.0)
    return low - room, high + room


def label_of(place: str) -> str:
    """What changes, with its unit: the last words of a place such as ``cables.W1.end.position[1]``."""
    *above, key = place.partition("[")[0].split(".")
    number = re.search(r"\[(\d)\]$", place)
    words = key.removesuffix("_deg").replace("_", " ")
    if number is not None and int(number[1]) < 3:
        words += f" {'XYZ'[int(number[1])]}"
    if above and above[-1] in ("start", "end"):
        words = f"{above[-1]} {words}"
    unit = _UNITS.get(key, "")
    return words + (f" [{unit}]" if unit else "")


def _views(members: Sequence[Member]) -> list[FlatView]:
    """One view for all members of one plane; otherwise each has its own, counted from its start."""
    first = flat_view(members[0].solution.centreline)
    for member in members:
        points = member.solution.points(33)
        if (
            np.abs((points - members[0].solution.position(0.0)) @ first.toward).max()
            > _IN_PLANE * member.solution.length
        ):
            break
    else:
        return [first] * len(members)
    views = [flat_view(member.solution.centreline) for member in members]
    return [
        FlatView(member.solution.position(0.0)[0], view.right, view.up, view.labels)
        for member, view in zip(members, views, strict=True)
    ]
