"""The planar elastica by power series: lines, circles and all that is close to them.

The closed forms divide by the force, or by the parameter q of a nearly circular shape. Where those vanish the equation
itself has no trouble: psi'' = -P sin(psi) gives the Taylor coefficients of psi, sin(psi) and cos(psi) by recurrence,
and those of the positions by integration. The stretch is cut into panels short against the radius of convergence, each
with series about its own middle.

Source: K. Makino, M. Berz, the automatic Taylor method; the recurrence is Leibniz' rule for sine and cosine.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cablecad.centreline import Array, Frames, Placement
from cablecad.rod.elastica import curvature_derivatives

_DEGREE = 20
"""A panel turns by at most one radian, half to either side: (1/2)^20 / 20! is far below rounding."""


@dataclass(frozen=True)
class SeriesElastica:
    """A stretch of an elastica under a weak force, as a piece of a centreline.

    Attributes:
        placement: Origin at the stretch's start; e1 along the compression -n (any direction where there is none).
        length: [mm].
        force: P, per unit EI [1/mm^2]; may be zero.
        at: Arclength where the state is known [mm].
        psi: Angle of the tangent from e1 there [rad].
        kappa: Curvature there [1/mm].

    Accuracy: a few eps (length), measured against mpmath in tests/rod/test_series.py.
    """

    placement: Placement
    length: float
    force: float
    at: float
    psi: float
    kappa: float

    @cached_property
    def _panels(self) -> tuple[float, Array, Array]:
        """Panel length [mm], and per panel the coefficients of psi, shape (panels, degree + 1), and of x and y.

        Panels are walked outwards from the one that begins or ends at `at`, so that errors grow over half the length.
        """
        scale = math.hypot(self.kappa, 2.0 * math.sqrt(self.force))  # bounds |kappa| all along
        count = max(1, math.ceil(self.length * scale))
        width = self.length / count
        middle = min(max(round(self.at / width), 0), count)
        angles = np.empty((count, _DEGREE + 1))
        for panels, direction in ((range(middle, count), 1.0), (range(middle - 1, -1, -1), -1.0)):
            s, psi, kappa = self.at, self.psi, self.kappa
            for i in panels:
                centre = (i + 0.5) * width
                psi, kappa = _advance(psi, kappa, self.force, centre - s)
                angles[i] = _angle_series(psi, kappa, self.force, width)
                s = centre
        places = np.empty((count, 2, _DEGREE + 2))
        place = np.zeros(2)
        for i in range(count):
            cosine, sine = _cosine_and_sine(angles[i])
            for axis, series in enumerate((cosine, sine)):
                places[i, axis, 1:] = series * width / np.arange(1.0, _DEGREE + 2.0)
            ends = places[i, :, 1:] * (-0.5) ** np.arange(1, _DEGREE + 2)
            places[i, :, 0] = place - ends.sum(axis=1)
            place = places[i, :, 0] + (places[i, :, 1:] * 0.5 ** np.arange(1, _DEGREE + 2)).sum(axis=1)
        return width, angles, places

    def _local(self, s: Array) -> tuple[np.ndarray[tuple[int], np.dtype[np.intp]], Array]:
        """The panel of each arclength and the place in it, -1/2 to 1/2."""
        width = self._panels[0]
        count = len(self._panels[1])
        index = np.clip((s / width).astype(np.intp), 0, count - 1)
        return index, s / width - index - 0.5

    def frames(self, s: Array) -> Frames:
        """Positions and frames at `s`, shape (n, 3) each."""
        _, angles, places = self._panels
        index, z = self._local(s)
        psi = _evaluate(angles[index], z)
        return self.placement.frames(
            _evaluate(places[index, 0], z), _evaluate(places[index, 1], z), np.cos(psi), np.sin(psi)
        )

    def bishop(self, s: Array, order: int) -> Array:
        """Derivatives 0..order of the curvature, in the first of the two components."""
        width, angles, _ = self._panels
        index, z = self._local(s)
        slopes = angles[:, 1:] * np.arange(1.0, _DEGREE + 1.0) / width
        psi, kappa = _evaluate(angles[index], z), _evaluate(slopes[index], z)
        values = np.zeros((order + 1, len(s), 2))
        values[:, :, 0] = curvature_derivatives(kappa, np.sin(psi), np.cos(psi), self.force, order)
        return values

    def greatest_curvature(self) -> tuple[float, float]:
        """At an end or where kappa' = 0, refined by Newton from the panels' samples."""
        s = np.linspace(0.0, self.length, 8 * len(self._panels[1]) + 1)
        kappa = np.abs(self.bishop(s, 0)[0, :, 0])
        best = float(s[int(np.argmax(kappa))])
        for _ in range(4):
            first, second = self.bishop(np.array([best]), 2)[1:, 0, 0]
            step = -first / second if second != 0.0 else 0.0
            if abs(step) < self.length:
                best = min(max(best + step, 0.0), self.length)
        refined = float(np.abs(self.bishop(np.array([best]), 0)[0, 0, 0]))
        i = int(np.argmax(kappa))
        return (refined, best) if refined >= kappa[i] else (float(kappa[i]), float(s[i]))


def _angle_series(psi: float, kappa: float, force: float, width: float) -> Array:
    """Taylor coefficients of psi in z = (s - centre) / width."""
    angle = [psi, kappa * width]
    sine, cosine = [math.sin(psi)], [math.cos(psi)]
    pull = force * width**2
    for n in range(1, _DEGREE):
        angle.append(-pull * sine[n - 1] / (n * (n + 1)))
        sine.append(sum(k * angle[k] * cosine[n - k] for k in range(1, n + 1)) / n)
        cosine.append(-sum(k * angle[k] * sine[n - k] for k in range(1, n + 1)) / n)
    return np.array(angle)


def _cosine_and_sine(angle: Array) -> tuple[Array, Array]:
    """Taylor coefficients of cos and sin of a series."""
    a = angle.tolist()
    sine, cosine = [math.sin(a[0])], [math.cos(a[0])]
    for n in range(1, len(a)):
        sine.append(sum(k * a[k] * cosine[n - k] for k in range(1, n + 1)) / n)
        cosine.append(-sum(k * a[k] * sine[n - k] for k in range(1, n + 1)) / n)
    return np.array(cosine), np.array(sine)


def _advance(psi: float, kappa: float, force: float, step: float) -> tuple[float, float]:
    """The state `step` further along, at most a panel away."""
    if step == 0.0:
        return psi, kappa
    series = _angle_series(psi, kappa, force, step)
    return float(series.sum()), float((series[1:] * np.arange(1.0, _DEGREE + 1.0)).sum()) / step


def _evaluate(coefficients: Array, z: Array) -> Array:
    """Horner's rule, a row of coefficients for each z."""
    value = coefficients[:, -1].copy()
    for i in range(coefficients.shape[1] - 2, -1, -1):
        value = value * z + coefficients[:, i]
    return value
