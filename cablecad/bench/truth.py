"""What errors are measured against: numbers mpmath gave at 50 digits (tests/experiments/bench_truth.py made them)."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import lru_cache
from importlib.resources import files
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class WaveTruth:
    """A wave of the elastica of parameter 1 - m1, |n| = EI = 1: its argument u is arclength from the first crest.

    Attributes:
        m1: The complementary parameter, as a double.
        quarter: K, a quarter of the length.
        u: Arguments from -K to 3 K, ascending, shape (n,).
        place: (2 E(u) - u, 2 k cn(u)), shape (n, 2).
    """

    m1: float
    quarter: float
    u: Array
    place: Array


@dataclass(frozen=True)
class ArchTruth:
    """A wave of the elastica, two arches one up and one down, at equal arclengths.

    Attributes:
        k: The modulus.
        length: Of the wave [mm].
        s: Arclengths, shape (n,) [mm].
        place: From the start, the chord along x, shape (n, 2) [mm].
        angle: Of the tangent from the chord, shape (n,) [rad].
        kappa: Curvature, shape (n,) [1/mm].
    """

    k: float
    length: float
    s: Array
    place: Array
    angle: Array
    kappa: Array


@dataclass(frozen=True)
class PlanarTruth:
    """A two-point problem with one shape of least energy; L = EI = 1, the start at the origin.

    Attributes:
        name: In the table of references.
        a: Angle at the start.
        b: Angle at the end.
        end: Place of the end, shape (2,).
        energy: The least.
        points: At nine equal arclengths, shape (9, 2).
    """

    name: str
    a: float
    b: float
    end: Array
    energy: float
    points: Array


@dataclass(frozen=True)
class FunctionTruth:
    """One value of an elliptic function or integral.

    Attributes:
        name: "cn", "E(u)" (Jacobi's epsilon), "E(phi)", or "K - E".
        u: The argument, the amplitude, or the parameter m.
        m1: The complementary parameter.
        value: The truth.
    """

    name: str
    u: float
    m1: float
    value: float


@lru_cache(maxsize=1)
def function_truths() -> tuple[FunctionTruth, ...]:
    """Values where functions of scipy fail."""
    return tuple(
        FunctionTruth(row["name"], float(row["u"]), float(row["m1"]), float(row["value"])) for row in _read("functions")
    )


@lru_cache(maxsize=1)
def wave_truths() -> tuple[WaveTruth, ...]:
    """For each m1 from 0.9 to 1e-16."""
    truths = []
    for row in _read("points"):
        u, x, y = (_numbers(row[key]) for key in ("u", "x", "y"))
        quarter = float(row["K"])
        # From the crest to the end of the arch; its mirror image; and the same upside down, two K further.
        u, x, y = (np.concatenate([sign * v[:0:-1], v]) for sign, v in ((-1, u), (-1, x), (1, y)))
        u, x, y = (np.concatenate(pair) for pair in ((u, u[1:] + 2.0 * quarter), (x, x[1:] + 2.0 * x[-1]), (y, -y[1:])))
        truths.append(WaveTruth(float(row["m1"]), quarter, u, np.stack([x, y], axis=1)))
    return tuple(truths)


@lru_cache(maxsize=8)
def arch_truths(length: float) -> tuple[ArchTruth, ...]:
    """For k = 0.342, 0.8 and 0.999, a wave of `length` [mm] each."""
    truths = []
    for row in _read("arches"):
        x, y, psi, slope = (_numbers(row[key]) for key in ("x", "y", "psi", "slope"))
        omega = 4.0 * float(row["K"]) / length
        # A quarter of the wave, mirrored to an arch from -K to K, which is then repeated upside down.
        x = np.concatenate([-x[:0:-1], x]) + x[-1]
        y, psi, slope = (np.concatenate([sign * v[:0:-1], v]) for sign, v in ((1, y), (-1, psi), (1, slope)))
        x = np.concatenate([x, x[-1] + x[1:]])
        y, psi, slope = (np.concatenate([v, -v[1:]]) for v in (y, psi, slope))
        s = np.linspace(0.0, length, len(x))
        # y of the elastica is -2 k cn(u)/omega about an axis that lets the curvature be +2 k omega cn(u).
        place = np.stack([x, -(y - y[0])], axis=1) / omega
        truths.append(ArchTruth(float(row["k"]), length, s, place, psi, slope * omega))
    return tuple(truths)


@lru_cache(maxsize=1)
def planar_truths() -> tuple[PlanarTruth, ...]:
    """Scenes with a clamp at either end, solved to 26 digits without elliptic functions."""
    return tuple(
        PlanarTruth(
            row["name"],
            float(row["start_angle"]),
            float(row["end_angle"]),
            _numbers(row["end"]),
            float(row["energy"]),
            np.array(row["points"], dtype=float),
        )
        for row in _read("planar")
    )


def _read(name: str) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = json.loads(files(__package__).joinpath("truth", f"{name}.json").read_text("utf-8"))
    return found


def _numbers(texts: list[str]) -> Array:
    return np.array(texts, dtype=float)
