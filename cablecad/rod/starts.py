"""Where the search for planar equilibria starts: windings and shapes, for every kind of ends.

A start is an angle at each end and two Legendre coefficients. Symmetric starts alone would stay symmetric (parallel
clamps at 0.6 of the length: energy 40.0 instead of 17.66), hence the pairs (3, -3). Small excess means small angles:
coefficients shrink with its square root.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cablecad.rod.taut import wrap
from cablecad.rod.trial import Array

_BENDS = ((0.0, 0.0), (3.0, 3.0), (-3.0, -3.0), (-3.0, 3.0), (3.0, -3.0))
_MORE_BENDS = (
    *_BENDS,
    (6.0, 0.0),
    (-6.0, 0.0),
    (0.0, 5.0),
    (0.0, -5.0),
    (7.0, 7.0),
    (-7.0, 7.0),
    (-7.0, -7.0),
    (7.0, -7.0),
)
_PIN_BENDS = ((0.0, 0.0), (2.0, 3.0), (-2.0, 3.0))
_PIN_TURNS = (-5.0, -3.0, -1.0, 1.0, 3.0, 5.0)
_PINNED = (
    (2.0, -2.0, 0.3, 0.2),
    (-2.0, 2.0, 0.3, -0.2),
    (3.0, -3.5, 0.0, 2.0),
    (-3.0, 3.5, 0.0, -2.0),
    (2.0, 2.0, 3.0, 3.0),
)


class Starts(NamedTuple):
    """Starts of many scenes: scene of each, shape (n,), and (a0, a1, c1, c2), shape (n, 4)."""

    scene: np.ndarray
    data: Array


def starts(
    start: Array,
    end: Array,
    start_clamped: bool,
    end_clamped: bool,
    excess: Array,
    *,
    windings: tuple[int, ...],
    wide: bool,
) -> Starts:
    """Starts for scenes with angles from the chord `start`, `end`, in [-pi, pi] (not read at pins).

    `windings` count full turns of the end angle from where it lies within half a turn of the start's.
    """
    small = np.minimum(1.0, 1.5 * np.sqrt(excess))[:, None, None]
    scenes = np.arange(len(excess))
    bends = np.array(_MORE_BENDS if wide else _BENDS)
    if start_clamped and end_clamped:
        turn = wrap(end - start)[:, None] + 2.0 * np.pi * np.array(windings)
        data = np.empty((len(excess), len(windings), len(bends), 4))
        data[..., 0] = start[:, None, None]
        data[..., 1] = (start[:, None] + turn)[:, :, None]
        data[..., 2:] = bends * small[..., None]
    elif start_clamped or end_clamped:
        held = start if start_clamped else end
        turns = np.array(_PIN_TURNS if not wide else (*_PIN_TURNS, -8.0, -6.5, 6.5, 8.0))
        pin_bends = np.array(_PIN_BENDS if not wide else _MORE_BENDS)
        data = np.empty((len(excess), len(turns), len(pin_bends), 4))
        data[..., 0 if start_clamped else 1] = held[:, None, None]
        data[..., 1 if start_clamped else 0] = held[:, None, None] + (turns * small[..., 0])[:, :, None]
        data[..., 2:] = pin_bends * small[..., None]
    else:
        shapes = np.array(_PINNED)
        if wide:
            shapes = np.concatenate([shapes, 1.7 * shapes, shapes[:, [1, 0, 3, 2]] + 1.0])
        data = (shapes * small)[:, None]
    each = data.shape[1] * data.shape[2]
    return Starts(np.repeat(scenes, each), data.reshape(-1, 4))
