"""The colours of pictures and plots, told apart by the colour-blind too.

Sources: M. Okabe, K. Ito, Color Universal Design (2008), https://jfly.uni-koeln.de/color; N. Smith, S. van der Walt,
viridis (2015), matplotlib.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from cablecad.centreline import Array

Rgb = tuple[float, float, float]

OKABE_ITO = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00")
"""For cables without a colour, in turn."""

GROUND = "#f6f7f9"
INK = "#22272e"
"""Of text and scales."""
FAINT = "#8a929c"
PART = "#b9bec6"
"""Of parts without a colour."""
ALERT = "#d55e00"
"""Of the tightest spot, and of broken rules."""

_LIGHTEST = 0.62
"""Brightness of lines on white paper at most: that of the lightest of `OKABE_ITO`."""

_VIRIDIS = (
    "#440154", "#482475", "#414487", "#355f8d", "#2a788e", "#21918c", "#22a884", "#44bf70", "#7ad151", "#bddf26",
    "#fde725",
)  # fmt: skip


def rgb(color: str) -> Rgb:
    """Red, green and blue of ``#rrggbb``, each from 0 to 1; what may follow (opacity) is left out."""
    red, green, blue = (value / 255.0 for value in bytes.fromhex(color[1:7]))
    return red, green, blue


def on_paper(color: str) -> str:
    """``#rrggbb`` for lines on white paper: a colour too light to be seen there is darkened, its opacity left out."""
    red, green, blue = rgb(color)
    light = 0.21 * red + 0.72 * green + 0.07 * blue
    share = min(1.0, _LIGHTEST / max(light, 1e-9))
    return "#" + "".join(f"{round(255.0 * share * value):02x}" for value in (red, green, blue))


def opacity(color: str) -> float:
    """The opacity of ``#rrggbb`` or ``#rrggbbaa``, from 0 to 1."""
    return bytes.fromhex(f"{color[1:]:f<8}")[3] / 255.0


def cable_color(color: str | None, index: int) -> str:
    """A cable's own colour, or the one its number in the scene gives it."""
    return color if color is not None else OKABE_ITO[index % len(OKABE_ITO)]


def bend_color(share: ArrayLike) -> Array:
    """The colour of a curvature as a share of the greatest, shape (n, 3): light where gentle, dark where tight."""
    table = np.array([rgb(color) for color in reversed(_VIRIDIS)])
    at = np.clip(np.asarray(share, dtype=float), 0.0, 1.0)
    places = np.linspace(0.0, 1.0, len(table))
    return np.stack([np.interp(at, places, table[:, i]) for i in range(3)], axis=-1)


def paled(color: Rgb, share: float) -> Rgb:
    """A colour mixed with the ground."""
    red, green, blue = (value + share * (ground - value) for value, ground in zip(color, rgb(GROUND), strict=True))
    return red, green, blue
