"""The rise of a shape, its greatest distance from the chord: by Newton's method from the samples next to it.

Between two samples h apart a top of curvature kappa is missed by kappa h^2/8 at most; where the ends coincide, and the
distance from a point counts, by twice that. Tops of the samples that are lower by no more are all followed.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cablecad.centreline import Array, Centreline

SAMPLES = 257
"""As many find the top of any shape."""

STEPS = 6
"""Of Newton's method at most: from so near it takes 2 or 3."""

SETTLED = 1e-9
"""Share of the length: steps below it change nothing."""


def rise_of(centreline: Centreline, begin: Array, finish: Array) -> float:
    """Greatest distance from the chord, or from the point where the ends coincide [mm]."""
    chord = finish - begin
    size = float(np.linalg.norm(chord))
    axis = chord / size if size > 0.0 else np.zeros(3)

    def across(vectors: Array) -> Array:
        left: Array = vectors - (vectors @ axis)[:, None] * axis
        return left

    s = np.linspace(0.0, centreline.length, SAMPLES)
    heights = np.linalg.norm(across(centreline.position(s) - begin), axis=1)
    best = s[tops(heights, missed_height(centreline.greatest_curvature()[0], s[1]))]
    going = np.ones(len(best), dtype=bool)
    for _ in range(STEPS):
        frames, bent = centreline.states(best)
        off, slope = across(frames.position - begin), across(frames.tangent)
        bend = bent[:, :1] * frames.normal + bent[:, 1:] * frames.binormal
        curve = np.sum(slope * slope + off * bend, axis=1)
        going &= curve < 0.0
        step = np.where(going, np.sum(off * slope, axis=1) / np.where(going, curve, 1.0), 0.0)
        best = np.minimum(np.maximum(best - step, 0.0), centreline.length)
        going &= np.abs(step) > SETTLED * centreline.length
        if not going.any():
            break
    highest = np.linalg.norm(across(centreline.position(best) - begin), axis=1)
    return max(float(heights.max()), float(highest.max()))


def missed_height(kappa: float | Array, apart: float | Array) -> float | Array:
    """By how much a top may be above the samples `apart` [mm] next to it, where no curvature is above `kappa`."""
    return kappa * apart * apart / 4.0


def tops(heights: Array, missed: float | Array) -> NDArray[np.bool_]:
    """Which samples are tops that may be next to the highest point, of curves in rows, shape (..., samples)."""
    level = heights.max(axis=-1, keepdims=True) - missed
    found: NDArray[np.bool_] = heights >= level
    found[..., 1:] &= heights[..., 1:] > heights[..., :-1]
    found[..., :-1] &= heights[..., :-1] >= heights[..., 1:]
    return found
