"""The curvature of a cable over its arclength, with the rule it has to keep."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from cablecad.centreline import Array
from cablecad.picture.figure import plain_ticks, subtitled
from cablecad.picture.palette import ALERT, FAINT
from cablecad.picture.round_number import shown

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from cablecad.rod.solution import RodSolution

_SAMPLES_A_PIECE = 401

_RADII = tuple(step * 10.0**power for power in range(-6, 9) for step in (1.0, 2.0, 5.0))
"""Bend radii that may be named beside the curvature [mm]."""


def plot_curvature(figure: Figure, solution: RodSolution, color: str) -> None:
    """Draw the curvature on a sheet of its own, its sign such that the tightest bend is positive.

    The bend radius is told at the right.
    """
    axes = figure.add_subplot()
    s, kappa = curvature_samples(solution)
    # By the exact tightest spot: that of the samples may be its mirror image's.
    at = solution.bend_radius_min_at
    if at is not None and float(solution.curvature(at)[0]) < 0.0:
        kappa = -kappa
    axes.axhline(0.0, color=FAINT, linewidth=0.8)
    axes.fill_between(s, kappa, color=color, alpha=0.14, linewidth=0.0)
    axes.plot(s, kappa, color=color, linewidth=2.0)
    cable, radius = solution.cable, solution.bend_radius_min
    low, high = min(0.0, float(kappa.min())), max(0.0, float(kappa.max()))
    limit = None if cable.min_bend_radius is None else 1.0 / cable.min_bend_radius
    greatest = max(high, -low)
    if greatest == 0.0:  # straight
        low, high = (-1.0, 1.0) if limit is None else (-limit, limit)
    # The rule is shown wherever it is in sight of the curve, on the sides the curve goes to.
    shows_limit = limit is not None and (limit < 3.0 * greatest or greatest == 0.0)
    if limit is not None and shows_limit:
        low, high = (
            (min(low, -limit) if low < -0.02 * greatest else low),
            (max(high, limit) if high > 0.02 * greatest else high),
        )
    room = 0.14 * (high - low)
    low, high = (low - room if low < 0.0 else 0.0), high + room
    if limit is not None and shows_limit:
        for sign in (-1.0, 1.0):
            edge = sign * limit
            if low < edge < high:
                axes.axhline(edge, color=ALERT, linewidth=1.4, linestyle=(0, (6, 3)))
                axes.axhspan(edge, high if sign > 0.0 else low, color=ALERT, alpha=0.07, linewidth=0.0)
        top = low < limit < high
        axes.annotate(
            f"rule: at least {shown(1.0 / limit)} mm",
            (0.995, limit if top else -limit),
            xycoords=("axes fraction", "data"),
            xytext=(0.0, 4.0 if top else -4.0),
            textcoords="offset points",
            color=ALERT,
            fontsize=10.0,
            ha="right",
            va="bottom" if top else "top",
        )
    if radius is not None and at is not None:
        peak = 1.0 / radius
        axes.plot(
            at, peak, marker="o", markersize=10, markerfacecolor="none", markeredgecolor=ALERT, markeredgewidth=2.0
        )
        share = at / solution.length
        axes.annotate(
            f"R {radius:.4g} mm at s = {at:.4g} mm",
            (at, peak),
            xytext=(-8.0 if share > 0.7 else 8.0 if share < 0.3 else 0.0, 12.0),
            textcoords="offset points",
            color=ALERT,
            fontsize=10.0,
            fontweight="bold",
            ha="right" if share > 0.7 else "left" if share < 0.3 else "center",
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.0},
            zorder=5,
        )
    axes.set_xlim(0.0, solution.length)
    axes.set_ylim(low, high)
    axes.set_xlabel("arclength s [mm]")
    axes.set_ylabel("curvature [1/mm]")
    axes.grid(visible=True, axis="x")
    plain_ticks(axes)
    if greatest == 0.0 and limit is None:  # there is no scale to show
        axes.set_yticks([0.0])
    _radius_axis(axes, low, high, _RADII if greatest > 0.0 or limit is not None else ())
    rule = "" if cable.min_bend_radius is None else _verdict(radius, cable.min_bend_radius)
    subtitled(axes, cable.name, f"curvature along {solution.length:.6g} mm{rule}")


def curvature_samples(solution: RodSolution) -> tuple[Array, Array]:
    """Arclengths [mm] and signed curvature [1/mm], one-sided at the breaks, where the curvature may jump."""
    arclengths, values = [], []
    breaks = solution.centreline.breaks
    for start, end in pairwise(breaks):
        s = np.linspace(start, end, _SAMPLES_A_PIECE)
        arclengths.append(s)
        before = solution.curvature(s[-1:], side="left")
        values.append(np.concatenate([solution.curvature(s[:-1]), before]))
    return np.concatenate(arclengths), np.concatenate(values)


def _verdict(radius: float | None, least: float) -> str:
    kept = radius is None or radius >= least
    return f"; its rule of at least {shown(least)} mm is {'kept' if kept else 'broken'}"


def _radius_axis(axes: Axes, low: float, high: float, radii: Sequence[float]) -> None:
    """Bend radii beside the curvature."""
    beside = axes.twinx()
    beside.set_ylim(low, high)
    beside.spines["right"].set_visible(True)
    places: list[float] = []
    labels = []
    for radius in radii:  # the tightest first
        for place in (1.0 / radius, -1.0 / radius):
            near = min((abs(place - other) for other in [*places, 0.0]), default=high - low)
            if low < place < high and near > 0.06 * (high - low):
                places.append(place)
                labels.append(shown(radius))
    beside.set_yticks([*places, 0.0], [*labels, "straight"])
    beside.set_ylabel("bend radius [mm]")
