"""An elastica as a curve, or many of them: every point from the state at mid-span, many at a time.

The formulas and regimes are those of `flow`: what depends on the state alone is worked out once. `Course` is for one
state in floats, and a call costs a tenth of a millisecond and 60 ns a point; `Courses` for arrays of them.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from cablecad.rod.elliptic import argument
from cablecad.rod.jacobian import Jacobian
from cablecad.rod.midpoint import State, Swing
from cablecad.rod.trial import Array

ALIKE = 1e-12
"""Share by which two crests of the curvature may differ for no other reason than rounding."""

CREST_WITHIN = 0.5 * (1.0 + 1e-12)
"""A crest no further from mid-span stands between the ends, but for rounding."""


class Points(NamedTuple):
    """Points of an elastica in the frame of its compression, arrays of shape (n,).

    Attributes:
        along, across: Position from mid-span, along the compression and 90 degrees ahead of it.
        cosine, sine: Of the tangent's angle psi from the compression.
        kappa: Curvature.
    """

    along: Array
    across: Array
    cosine: Array
    sine: Array
    kappa: Array


class Course:
    """The curve of a rod of length one.

    Args:
        state: At mid-span.
    """

    def __init__(self, state: State) -> None:
        self.state, self._own = state, Swing(state)

    def at(self, s: Array) -> Points:
        """The points at arclengths `s` from mid-span, shape (n,)."""
        own = self._own
        p0, c0, h0, o2 = own.p, own.c, own.h, own.omega * own.omega
        u = own.rate * s
        sn, cn, dn, zeta = own.jacobian(u)
        S = sn / own.rate
        C, D = (cn, dn) if own.swings else (dn, cn)
        below, slope, tilt = self._addition(S, C)
        p, c = (p0 * C * D + slope) / below, (c0 * D - p0 * tilt) / below
        # (1 - C)/omega^2, where 1 - C cancels for small omega and 1 + C vanishes at half a period.
        positive = C >= 0.0
        lift = S * S / np.where(positive, 1.0 + C, 1.0)
        if o2 > 0.0:
            lift = np.where(positive, lift, (1.0 - C) / o2)
        along = s - 2.0 * own.base(u, zeta) - (2.0 * p0) * p * S
        across = 2.0 / below * ((p0 * c0) * S * D + h0 * lift * (c0 * c0 - (p0 * p0) * C))
        kappa = 2.0 * (h0 * C - (o2 * p0 * c0) * S * D) / below
        return Points(along, across, c * c - p * p, 2.0 * p * c, kappa)

    def crest(self) -> float:
        """Arclength from mid-span of the first point from the start on where |curvature| is greatest.

        There the tangent lies along the compression. Beyond 1/2 where there is none between the ends.
        """
        own = self._own
        greatest = self.state.crest_kappa / 2.0
        if greatest == 0.0:
            return math.inf
        if own.swings:
            phase = own.omega * own.p / greatest, own.h / greatest
        else:
            phase = math.copysign(own.p, own.p * own.h), own.c
        u0 = argument(*phase, own.m, own.jacobian.m1)
        period = math.pi / own.jacobian.rate
        first = math.ceil((u0 - own.rate / 2.0) / period - 1e-12)
        s: float = (first * period - u0) / own.rate
        return s

    def tangent(self, s: Array) -> tuple[Array, Array, Array]:
        """cos and sin of the tangent's angle in the frame of `state.direction`, and the curvature, at `s`."""
        own = self._own
        p0, c0, h0, o2 = own.p, own.c, own.h, own.omega * own.omega
        sn, cn, dn, _ = own.jacobian(own.rate * s)
        S = sn / own.rate
        C, D = (cn, dn) if own.swings else (dn, cn)
        below, slope, tilt = self._addition(S, C)
        p, c = (p0 * C * D + slope) / below, (c0 * D - p0 * tilt) / below
        kappa = 2.0 * (h0 * C - (o2 * p0 * c0) * S * D) / below
        x, y = c * c - p * p, 2.0 * p * c
        cosine, sine = math.cos(self.state.compression), math.sin(self.state.compression)
        return cosine * x - sine * y, sine * x + cosine * y, kappa

    def _addition(self, S: Array, C: Array) -> tuple[Array, Array, Array]:
        """N, h0 c0 S and h0 S C of the addition theorems; see `flow`."""
        own = self._own
        return C * C + (own.c * own.omega) ** 2 * (S * S), (own.h * own.c) * S, own.h * S * C


class Marks(NamedTuple):
    """The start of each of n rods, the first crest of |kappa| between its ends, and the end.

    Attributes:
        places: Arclengths from mid-span, shape (n, 3).
        at: The points there.
        has_crest: Whether there is a crest, shape (n,): where there is none the end stands in its place.
        kappa: The greatest |kappa| of each, shape (n,).
        tightest: Arclength from the start where it stands first, shape (n,).
        known: Whether the shape bears that out, shape (n,); where it does not, each has to be looked at alone.
    """

    places: Array
    at: Points
    has_crest: np.ndarray
    kappa: Array
    tightest: Array
    known: np.ndarray


class Courses(NamedTuple):
    """The curves of many rods of length one: `Course` for states in arrays, which broadcast with the arclengths.

    Attributes:
        p, c: sin and cos of half the angle from the compression at mid-span.
        h: Half the curvature there.
        square: The force, omega^2.
        swings: Whether the branch is the inflexional one.
        rate: The elliptic argument is rate s.
        m: Parameter.
        jacobian: Its functions.
    """

    p: Array
    c: Array
    h: Array
    square: Array
    swings: np.ndarray
    rate: Array
    m: Array
    jacobian: Jacobian

    def take(self, index: Any) -> Courses:
        """Some of the rods; or all of them along another axis, by an index such as ``np.s_[:, None]``."""
        p, c, h, square, swings, rate, m = (array[index] for array in self[:-1])
        return Courses(p, c, h, square, swings, rate, m, self.jacobian.take(index))

    def at(self, s: Array) -> Points:
        """The points at arclengths `s` from mid-span."""
        u = self.rate * s
        sn, cn, dn, zeta = self.jacobian(u)
        S, C, D, below = self._factors(sn, cn, dn)
        p, c = self._half(S, C, D, below)
        # (1 - C)/omega^2, where 1 - C cancels for small omega and 1 + C vanishes at half a period.
        positive = C >= 0.0
        lift = S * S / np.where(positive, 1.0 + C, 1.0)
        if not positive.all():
            lift = np.where(positive, lift, (1.0 - C) / np.where(positive, 1.0, self.square))
        f = self.jacobian
        base = np.where(self.swings, self.m * (f.mean_sn2 * u - zeta), u - (f.mean_cn2 * u + zeta)) / self.rate
        along = s - 2.0 * base - (2.0 * self.p) * p * S
        bent = self.h * lift * (self.c * self.c - (self.p * self.p) * C)
        across = 2.0 / below * ((self.p * self.c) * S * D + bent)
        return Points(along, across, c * c - p * p, 2.0 * p * c, self._kappa(S, C, D, below))

    @property
    def crest_kappa(self) -> Array:
        """|curvature| where the tangent lies along the compression."""
        return 2.0 * np.hypot(self.h, np.sqrt(self.square) * self.p)

    def crest(self) -> Array:
        """`Course.crest` of each."""
        lift, greatest = np.sqrt(self.square) * self.p, self.crest_kappa / 2.0
        bent = greatest > 0.0
        size = np.where(bent, greatest, 1.0)
        sine = np.where(self.swings, lift / size, np.copysign(self.p, self.p * self.h))
        cosine = np.where(self.swings, np.where(bent, self.h / size, 1.0), self.c)
        u0 = argument(sine, cosine, self.m, self.jacobian.m1)
        period = math.pi / self.jacobian.rate
        first = np.ceil((u0 - self.rate / 2.0) / period - 1e-12)
        return np.where(bent, (first * period - u0) / self.rate, np.inf)

    def marks(self) -> Marks:
        """Of rods in arrays of shape (n,)."""
        crest = self.crest()
        ends = np.full(len(crest), 0.5)
        places = np.stack([-ends, np.minimum(crest, ends), ends], axis=1)
        at, has_crest = self.take(np.s_[:, None]).at(places), crest <= CREST_WITHIN
        kappa, greatest = np.abs(at.kappa), self.crest_kappa
        known = ~has_crest | (np.abs(kappa[:, 1] - greatest) <= ALIKE * greatest)
        most = kappa.max(axis=1)
        first = np.argmax(kappa >= (1.0 - ALIKE) * most[:, None], axis=1)
        return Marks(places, at, has_crest, most, places[np.arange(len(first)), first] + 0.5, known)

    def tangent(self, s: Array) -> tuple[Array, Array, Array]:
        """cos and sin of the tangent's angle from the compression, and the curvature, at `s` from mid-span."""
        sn, cn, dn = self.jacobian.elementary(self.rate * s)
        S, C, D, below = self._factors(sn, cn, dn)
        p, c = self._half(S, C, D, below)
        return c * c - p * p, 2.0 * p * c, self._kappa(S, C, D, below)

    def kappa(self, s: Array) -> Array:
        """The curvature at arclengths `s` from mid-span."""
        sn, cn, dn = self.jacobian.elementary(self.rate * s)
        return self._kappa(*self._factors(sn, cn, dn))

    def _factors(self, sn: Array, cn: Array, dn: Array) -> tuple[Array, Array, Array, Array]:
        """S, C, D and N of the addition theorems; see `flow`."""
        S = sn / self.rate
        C, D = np.where(self.swings, cn, dn), np.where(self.swings, dn, cn)
        return S, C, D, C * C + (self.c * self.c * self.square) * (S * S)

    def _half(self, S: Array, C: Array, D: Array, below: Array) -> tuple[Array, Array]:
        """sin and cos of half the angle from the compression."""
        return (self.p * C * D + self.h * self.c * S) / below, (self.c * D - self.p * self.h * S * C) / below

    def _kappa(self, S: Array, C: Array, D: Array, below: Array) -> Array:
        kappa: Array = 2.0 * (self.h * C - (self.square * self.p * self.c) * S * D) / below
        return kappa


def courses(p: Array, c: Array, kappa: Array, omega: Array) -> Courses:
    """The curves of states; arguments as for `flow.jump`, shape (n,) each."""
    h, square = kappa / 2.0, omega * omega
    w2 = h * h + square * p * p
    gap = (omega * c - np.abs(h)) * (omega * c + np.abs(h))
    swings = gap >= 0.0
    r2 = np.where(swings, square, w2)
    # A line has rate 0, and then any scale does.
    rate = np.sqrt(np.maximum(r2, 1e-200))
    m = np.where(swings, w2, square) / (rate * rate)
    m1 = np.where(r2 > 1e-200, np.maximum(np.abs(gap) / (rate * rate), 1e-100), 1.0)
    return Courses(p, c, h, square, swings, rate, m, Jacobian(m, m1))
