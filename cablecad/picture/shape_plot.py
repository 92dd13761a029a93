"""The shape of a cable in its plane: its ends, what they apply to it, and its tightest spot."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from cablecad.centreline import Array
from cablecad.model import Clamp
from cablecad.picture.equilibria_plot import DASHES, WORDS, kind_of
from cablecad.picture.figure import fitted_size, plain_ticks, subtitled, title_room
from cablecad.picture.flat_view import FlatView, flat_view
from cablecad.picture.label import Labels
from cablecad.picture.palette import ALERT, INK
from cablecad.picture.round_number import significant
from cablecad.picture.words import shortened

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from cablecad.rod.solution import EndState, RodSolution

SAMPLES = 801
"""Points along a cable."""

FORCE = "#6a3d9a"
"""Of forces and moments: no cable of the palette has it."""


def shape_size(solution: RodSolution) -> tuple[float, float]:
    """Width and height of the sheet it needs [inches]."""
    low, high = _limits(_flat_points(solution), solution)
    width, height = high - low
    return fitted_size((width, height))


def plot_shape(figure: Figure, solution: RodSolution, color: str) -> None:
    """Draw the shape on a sheet of its own."""
    axes, view, points = figure.add_subplot(), flat_view(solution.centreline), _flat_points(solution)
    low, high = _limits(points, solution)
    extent = float(np.ptp(points, axis=0).max())
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.set_aspect("equal")
    axes.set_xlabel(view.labels[0])
    axes.set_ylabel(view.labels[1])
    axes.grid(visible=True)
    plain_ticks(axes)
    kind = kind_of(solution.equilibrium)
    verdict = _verdict(solution, kind)
    room = title_room(figure.get_figwidth()) - len(verdict)
    subtitled(axes, shortened(solution.cable.name, room) + verdict, _summary(solution))
    tube = _draw_tube(axes, view, solution, color)
    axes.plot(*points.T, color=color, linewidth=1.6, linestyle=DASHES[kind], zorder=3)
    cable, equilibrium = solution.cable, solution.equilibrium
    ends = [
        _End("start", equilibrium.start, isinstance(cable.start_support, Clamp), 1.0),
        _End("end", equilibrium.end, isinstance(cable.end_support, Clamp), -1.0),
    ]
    drawn = [tube]
    for end in ends:
        drawn.append(_draw_end(axes, view, end, extent, cable.section.radius))
        drawn.append(_draw_force(axes, view, solution, end.state, extent))
    spot = _draw_tightest(axes, view, solution, extent)
    labels = Labels(axes)
    for line in drawn:
        labels.avoid(line)
    if spot is not None:
        radius, at = solution.bend_radius_min, solution.bend_radius_min_at
        words = f"R {radius:.4g} mm\ns = {at:.4g} mm"
        labels.put(words, spot, color=ALERT, fontsize=10.0, fontweight="bold")
    for end in ends:
        labels.put(_end_words(solution, view, end), view.flat(end.state.position), color=FORCE, fontsize=10.0)


@dataclass(frozen=True)
class _End:
    """One end of the cable: `inward` turns its direction into the way the cable leaves it."""

    name: str
    state: EndState
    clamped: bool
    inward: float


def _flat_points(solution: RodSolution) -> Array:
    return flat_view(solution.centreline).flat(solution.points(SAMPLES))


def _limits(points: Array, solution: RodSolution) -> tuple[Array, Array]:
    """The corners of the drawing: room around the shape for arrows and words, beyond the cable's sides."""
    extent = float(np.ptp(points, axis=0).max())
    room = np.array([0.26, 0.2]) * extent + solution.cable.section.radius
    return points.min(axis=0) - room, points.max(axis=0) + room


def _summary(solution: RodSolution) -> str:
    radius = solution.bend_radius_min
    bend = "no bend" if radius is None else f"least bend radius {radius:.4g} mm"
    return f"length {solution.length:.6g} mm, chord {solution.chord:.6g} mm, {bend}"


def _verdict(solution: RodSolution, kind: str) -> str:
    """What is wrong with a shape, for its title; nothing of one that is stable and breaks no rule."""
    words = [] if kind == "stable" else [WORDS[kind]]
    broken = {violation.rule for violation in solution.violations}
    if "curvature" in broken:
        words.append("folds over")
    if solution.self_gap is not None and solution.self_gap < 0.0:
        words.append("cuts into itself")
    if "min_bend_radius" in broken:
        words.append("breaks its rule")
    return ": " + ", ".join(words) if words else ""


def _draw_tube(axes: Axes, view: FlatView, solution: RodSolution, color: str) -> Array:
    """The cable as thick as it is; its outline."""
    s = np.linspace(0.0, solution.length, SAMPLES)
    points, tangents = view.flat(solution.position(s)), solution.tangent(s) @ np.stack([view.right, view.up], axis=1)
    across = solution.cable.section.radius * np.stack([-tangents[:, 1], tangents[:, 0]], axis=1)
    outline = np.concatenate([points + across, (points - across)[::-1]])
    axes.fill(*outline.T, color=color, alpha=0.22, linewidth=0.0, zorder=2)
    return np.concatenate([outline, points])


def _draw_end(axes: Axes, view: FlatView, end: _End, extent: float, radius: float) -> Array:
    """A clamp as a wall with hatching, a pin as a ring; points on it."""
    at, tangent = view.flat(end.state.position), end.inward * view.vector(end.state.direction)
    if not end.clamped:
        axes.plot(*at, marker="o", markersize=8, markerfacecolor="white", markeredgecolor=INK, zorder=5)
        return at[None]
    across = np.array([-tangent[1], tangent[0]])
    half, deep = max(0.045 * extent, 1.2 * radius), 0.018 * extent
    wall = np.array([at + half * across, at - half * across])
    wall = np.vstack([wall, wall[::-1] - deep * tangent])
    axes.fill(*wall.T, facecolor="#d4d8de", edgecolor=INK, linewidth=0.9, hatch="////", zorder=4)
    return np.linspace(wall[2], wall[3], 24)


def _noticeable_force(solution: RodSolution, state: EndState) -> float | None:
    """The force per EI [1/mm^2], unless it is rounding: against EI / length^2."""
    size = float(np.linalg.norm(state.force_per_EI))
    return size if size * solution.length**2 > 1e-6 else None


def _draw_force(axes: Axes, view: FlatView, solution: RodSolution, state: EndState, extent: float) -> Array:
    """The force the support applies as an arrow that ends where it acts; points on it."""
    size, at = _noticeable_force(solution, state), view.flat(state.position)
    if size is None:
        return at[None]
    ends = (solution.equilibrium.start, solution.equilibrium.end)
    greatest = max(float(np.linalg.norm(end.force_per_EI)) for end in ends)
    tail = at - 0.14 * extent * size / greatest * view.vector(state.force_per_EI) / size
    style = {"arrowstyle": "-|>,head_width=0.35,head_length=0.7", "color": FORCE, "linewidth": 2.0}
    axes.annotate("", at, xytext=tuple(tail), arrowprops={**style, "shrinkA": 0.0, "shrinkB": 0.0}, zorder=7)
    return np.linspace(at, tail, 40)


def _end_words(solution: RodSolution, view: FlatView, end: _End) -> str:
    """The end's name, and force and moment in numbers."""
    EI, words = solution.EI, [end.name]
    force, moment = _noticeable_force(solution, end.state), float(end.state.moment_per_EI @ view.toward)
    if force is not None:
        words.append(f"{force:.3g} EI /mm²" if EI is None else f"{significant(EI * force)} N")
    if abs(moment) * solution.length > 1e-6:  # against EI / length
        turn = "↺" if moment > 0.0 else "↻"
        words.append(
            f"{turn} {abs(moment):.3g} EI /mm" if EI is None else f"{turn} {significant(EI * abs(moment))} N mm"
        )
    return "\n".join(words)


def _draw_tightest(axes: Axes, view: FlatView, solution: RodSolution, extent: float) -> Array | None:
    """The tightest spot and the circle that touches there, if it is not too large; where it is, shape (2,)."""
    radius, at = solution.bend_radius_min, solution.bend_radius_min_at
    if radius is None or at is None:
        return None
    spot, tangent = view.flat(solution.position(at)[0]), view.vector(solution.tangent(at)[0])
    kappa, binormal = float(solution.curvature(at)[0]), solution.centreline.binormal(at)[0]
    normal = np.array([-tangent[1], tangent[0]]) * math.copysign(1.0, kappa * float(binormal @ view.toward))
    if radius < 0.6 * extent:
        angle = np.linspace(-math.pi, math.pi, 361)[:, None]
        circle = spot + radius * (np.sin(angle) * tangent + (1.0 - np.cos(angle)) * normal)
        axes.plot(*circle.T, color=ALERT, linewidth=0.9, linestyle=(0, (4, 3)), zorder=2.5)
    axes.plot(
        *spot, marker="o", markersize=11, markerfacecolor="none", markeredgecolor=ALERT, markeredgewidth=2.0, zorder=6
    )
    return spot
