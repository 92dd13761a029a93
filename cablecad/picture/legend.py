"""Scale bar, axes, legend and mark: what a picture says in words and numbers."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cablecad.centreline import Array
from cablecad.picture.camera import Camera, Margins
from cablecad.picture.overlay import Overlay, can_be_set
from cablecad.picture.palette import ALERT, FAINT, GROUND, INK, bend_color
from cablecad.picture.round_number import round_below, shown

_AXES = (("X", (1.0, 0.0, 0.0), "#c2410c"), ("Y", (0.0, 1.0, 0.0), "#007a5a"), ("Z", (0.0, 0.0, 1.0), "#0060a0"))


@dataclass(frozen=True)
class BendLegend:
    """What the colours of a picture mean.

    Attributes:
        tightest: The least bend radius of all, at the dark end [mm].
        limit: The least the cables are allowed, or None [mm].
    """

    tightest: float
    limit: float | None = None

    def ticks(self) -> list[float]:
        """Bend radii to name, the tightest first: round ones, spread over the bar [mm]."""
        found = [self.tightest]
        radius = self.tightest * 1.15
        while len(found) < 5:
            radius = _round_above(radius)
            if self.place(found[-1]) - self.place(radius) > 0.11 and self.place(radius) > 0.1:
                found.append(radius)
            radius *= 1.001
            if self.place(radius) <= 0.1:
                break
        return found

    def place(self, radius: float) -> float:
        """How far up the bar a radius stands: curvature runs evenly from 0 to 1."""
        return self.tightest / radius


def _round_above(value: float) -> float:
    """The least of 1, 1.5, 2, 3, 5, 7 times a power of ten that is not below a value."""
    power = 10.0 ** math.floor(math.log10(value))
    return next(step * power for step in (1.0, 1.5, 2.0, 3.0, 5.0, 7.0, 10.0) if step * power >= value * (1.0 - 1e-12))


def unit_of(size: tuple[int, int]) -> float:
    """The size of a line of type, from which all else follows [pixels]; legible when the picture is halved."""
    width, height = size
    return max(9.0, min(math.sqrt(width * height) / 50.6, width / 28.0, height / 16.0))


def margins_of(size: tuple[int, int], *, legend: bool) -> Margins:
    """The room that axes, scale bar and legend need."""
    em = unit_of(size)
    return Margins(bottom=5.2 * em / size[1], right=9.2 * em / size[0] if legend else Margins.right)


def draw_axes(overlay: Overlay, camera: Camera) -> None:
    """The three axes in the bottom left corner, as the camera sees them."""
    em = unit_of(overlay.size)
    origin = np.array([3.2 * em, overlay.size[1] - 3.2 * em])
    length = 2.0 * em
    # What points away from the eye is drawn first.
    for name, axis, color in sorted(_AXES, key=lambda entry: float(np.dot(entry[1], camera.toward))):
        flat = np.array([np.dot(axis, camera.right), -np.dot(axis, camera.up)])
        if math.hypot(*flat) < 0.05:  # to the eye, or from it
            overlay.disc(origin, 0.22 * em, color)
            overlay.text(
                name, origin + np.array([-0.75, 0.75]) * em, height=0.8 * em, color=color, anchor="centre", bold=True
            )
            continue
        overlay.arrow(origin, origin + length * flat, 0.13 * em, color)
        tip = origin + length * flat + 0.55 * em * flat / math.hypot(*flat)
        overlay.text(name, tip, height=0.8 * em, color=color, anchor="centre", bold=True)


def draw_scale_bar(overlay: Overlay, camera: Camera) -> None:
    """A bar of a round length beside the axes."""
    em = unit_of(overlay.size)
    width, height = overlay.size
    length = round_below(0.2 * width * camera.mm_per_pixel)
    pixels = length / camera.mm_per_pixel
    left, y = 7.5 * em, height - 2.2 * em
    start, end = np.array([left, y]), np.array([left + pixels, y])
    thick = 0.16 * em
    overlay.line(start, end, thick, INK)
    tick = np.array([0.0, 0.35 * em])
    for point in (start, end):
        overlay.line(point - tick, point + tick, thick, INK)
    overlay.text(
        f"{shown(length)} mm", (start + end) / 2.0 - np.array([0.0, 0.95 * em]), height=0.95 * em, anchor="centre"
    )


def draw_legend(overlay: Overlay, legend: BendLegend) -> None:
    """The bar of colours at the right, with bend radii beside it."""
    em = unit_of(overlay.size)
    width, height = overlay.size
    tall, wide = 0.5 * height, 1.1 * em
    corner = np.array([width - 7.6 * em, max(0.2 * height, 3.6 * em)])  # its title stands above
    overlay.text("bend radius", corner - np.array([0.0, 2.6 * em]), height=em, bold=True)
    overlay.text("mm", corner - np.array([0.0, 1.35 * em]), height=0.9 * em, color=FAINT)
    overlay.bar(corner, (wide, tall), bend_color(np.linspace(0.0, 1.0, 128)))

    def tick(share: float, words: str, color: str = INK, *, bold: bool = False) -> None:
        y = corner[1] + tall * (1.0 - share)
        edge = corner[0] + wide
        overlay.line(np.array([edge, y]), np.array([edge + 0.4 * em, y]), 0.1 * em, color)
        overlay.text(words, np.array([edge + 0.75 * em, y]), height=0.95 * em, color=color, bold=bold)

    taken = [0.0]
    tick(0.0, "straight")
    limit = legend.limit
    if limit is not None and legend.place(limit) <= 1.0:
        share = legend.place(limit)
        taken.append(share)
        left = np.array([corner[0] - 0.5 * em, corner[1] + tall * (1.0 - share)])
        overlay.line(left, left + np.array([wide + 0.5 * em, 0.0]), 0.14 * em, ALERT)
        tick(share, f"{shown(limit)} least", ALERT, bold=True)
    for i, radius in enumerate(legend.ticks()):
        share = legend.place(radius)
        if all(abs(share - other) * tall > 1.3 * em for other in taken):
            taken.append(share)
            tick(share, f"{radius:.4g}" if i == 0 else shown(radius), bold=i == 0)


def draw_note(overlay: Overlay, words: str) -> None:
    """Words in the top right corner, in place of a legend."""
    em = unit_of(overlay.size)
    overlay.text(words, np.array([overlay.size[0] - 1.5 * em, 1.5 * em]), height=em, color=FAINT, anchor="right")


def draw_mark(
    overlay: Overlay, camera: Camera, position: Array, words: tuple[str, str], covered: NDArray[np.bool_]
) -> None:
    """A ring around a place of the scene, and words beside it.

    Args:
        overlay: To draw on.
        camera: How the scene is seen.
        position: The place, shape (3,) [mm].
        words: A line to be read at once, and a second one.
        covered: Where words would hide something, shape (height, width): they stand where they hide least.
    """
    em = unit_of(overlay.size)
    at = camera.project(position)
    radius = 0.8 * em
    lines = [line for line in words if can_be_set(line)]
    sizes = (1.05 * em, 0.85 * em)
    widest = max(
        overlay.width_of(line, height=size, bold=i == 0)
        for i, (line, size) in enumerate(zip(lines, sizes, strict=False))
    )
    box = np.array([widest + 1.2 * em, (0.9 + 1.2 * len(lines)) * em])
    corner, elbow = _free_place(at, box, em, covered)
    start = at + radius * (elbow - at) / math.hypot(*(elbow - at))
    overlay.line(start, elbow, 0.34 * em, GROUND)
    overlay.ring(at, radius, 0.44 * em, GROUND)
    overlay.ring(at, radius, 0.2 * em, ALERT)
    overlay.line(start, elbow, 0.14 * em, ALERT)
    frame = corner + np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]) * box
    overlay.area(frame, "#ffffff")
    for first, second in zip(frame, np.roll(frame, -1, axis=0), strict=True):
        overlay.line(first, second, 0.1 * em, ALERT)
    y = corner[1] + box[1] / 2.0 - 0.6 * em * (len(lines) - 1)
    for i, (line, size) in enumerate(zip(lines, sizes, strict=False)):
        overlay.text(line, np.array([corner[0] + 0.6 * em, y + 1.2 * em * i]), height=size, bold=i == 0)


def _free_place(at: Array, box: Array, em: float, covered: NDArray[np.bool_]) -> tuple[Array, Array]:
    """The top left corner of a box near a place, and where the line to it ends: it hides least, then lies nearest."""
    height, width = covered.shape
    sums = np.zeros((height + 1, width + 1))
    sums[1:, 1:] = covered.cumsum(axis=0).cumsum(axis=1)
    room = 0.5 * em

    def hidden(corner: Array) -> float:
        x, y = (
            np.clip([corner[i] - room, corner[i] + box[i] + room], 0, (width, height)[i]).astype(int) for i in (0, 1)
        )
        return float(sums[y[1], x[1]] - sums[y[0], x[1]] - sums[y[1], x[0]] + sums[y[0], x[0]])

    best = (math.inf, math.inf, at, at)
    for distance in (2.6, 3.6, 5.0, 7.0, 10.0, 14.0, 20.0):
        for angle in np.arange(16) * math.pi / 8.0 + math.pi / 16.0:  # none quite level: a line to be seen as one
            elbow = at + distance * em * np.array([math.cos(angle), -math.sin(angle)])
            corner = elbow - np.array([0.0 if elbow[0] >= at[0] else box[0], box[1] / 2.0])
            inside = (corner >= room).all() and (corner + box + room <= (width, height)).all()
            # Not on the ring itself, whichever way the box hangs from its line.
            clear = (np.maximum(corner - at, at - corner - box) > 1.2 * em).any()
            if inside and clear:
                best = min(best, (round(hidden(corner) / em**2, 1), distance, corner, elbow), key=lambda one: one[:2])
    if math.isinf(best[0]):  # hardly any picture at all
        corner = np.clip(at + em, 0.0, np.maximum(np.array([width, height]) - box, 0.0))
        return corner, corner + box / 2.0
    return best[2], best[3]
