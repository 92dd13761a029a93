"""The B-spline of a tube's centreline and frame, to a tolerance.

Each smooth piece becomes one C4 quintic spline through (position, normal, binormal) at its knots, with the first and
third derivatives given at both ends; a straight piece stays a line. Times an exact rational circle that spline is
the tube's side. The number of knots follows from the error of that interpolation,

    f - s = (B6(t) - B6(0)) / 6! h^6 f^(6)   at the share t of a span h,   B6 the Bernoulli polynomial,

which is exact for f^(6) constant: it has no odd derivatives at the knots, so that the end conditions add nothing to
it (with the second derivative instead of the third they would, 40 % in the span beside the end). The knots are
spread so that every span has the same error. The sixth derivatives are exact, and the eighth, which correct the
formula for spans that are not short: they follow from the curvature's by the equations of the frame. The result is
measured between the knots against the exact curve, and refined until it keeps the tolerance.

Nothing here needs Open Cascade.

Source: C. A. Hall, W. W. Meyer, Optimal error bounds for cubic spline interpolation, J. Approx. Theory 16 (1976), for
the argument; the constant was confirmed by tests/convergence/test_spline_order.py.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from cablecad.brep.quintic import QuinticSpline, interpolate
from cablecad.centreline import Array, Centreline, Frames, Line, Side, locate
from cablecad.errors import GeometryError, UsageError

QUINTIC_ERROR = (31.0 / 32.0 + 1.0) / 42.0 / 720.0
"""|B6(1/2) - B6(0)| / 6! = 6.5e-5, the error of a span of length one for a sixth derivative of one."""

SAMPLES_A_SPAN = 16
"""Where the deviation is measured: the error of a span has one crest, in its middle, which 16 points find to 1 %."""

_ANGLES = np.linspace(0.0, 2.0 * math.pi, 64, endpoint=False)
"""Where around the circle the deviation is measured: its square has two waves at most, whose crest 64 points find to
0.5 %."""

_WAVES = np.stack([np.ones(64), np.cos(_ANGLES), np.sin(_ANGLES), np.cos(2.0 * _ANGLES), np.sin(2.0 * _ANGLES)])

_BLOCK = 8192
"""Stations worked on at once: 4 MB for all angles, whatever the number of spans."""

_SAMPLED = 0.985
"""Share of the tolerance the sampled deviation may reach, for the crests between the samples."""

_DENSITY_SAMPLES, _DENSITY_SAMPLES_A_RADIAN = 257, 4.0
"""Where the sixth derivative is taken to spread the knots: in a gentle piece, and a radian of the tightest bend."""

_LEAST_DENSITY = 0.2
"""Least density of knots against the greatest: neighbouring spans stay of like length, and no feature is skipped."""

_LEAST_SPANS = 4.0
"""Spans of the gentlest piece."""

_NEXT_TERM = 0.45
"""The error of a span h of exp(i w s) is 1 + 0.45 (w h)^2 times that of its sixth derivative alone, for w h up to 1."""

_AIM = 0.3
"""Share of the tolerance aimed at, so that the first fit is the last: a third of the error costs 15 % more knots."""

_MOST_SPANS = 100_000
"""A spline of more spans than this is refused: 40 MB of STEP."""


@dataclass(frozen=True)
class FittedPiece:
    """A C4 quintic spline over [0, 1] through position, normal and binormal of one piece.

    Attributes:
        length: Of the exact piece [mm]; the spline's parameter is arclength over length, up to the deviation.
        knots: Distinct knots, shape (spans + 1,).
        poles: Position [mm], normal and binormal, shape (spans + 5, 9).
        deviation: Greatest sampled distance between the tube's side and the exact one [mm].
        end_normal: Normals of the exact frame at both ends, shape (2, 3); likewise the next two.
        end_tangent: Tangents.
        end_position: Positions [mm].
    """

    length: float
    knots: Array
    poles: Array
    deviation: float
    end_position: Array
    end_tangent: Array
    end_normal: Array

    @property
    def spans(self) -> int:
        """Number of polynomial spans."""
        return len(self.knots) - 1

    @cached_property
    def _spline(self) -> QuinticSpline:
        return QuinticSpline(self.knots, self.poles)

    def evaluate(self, s: Array, derivative: int = 0) -> Array:
        """The nine columns, or a derivative of them by s, shape (n, 9)."""
        return self._spline(s / self.length, derivative) / self.length**derivative

    def samples(self) -> Array:
        """Arclengths at `SAMPLES_A_SPAN` points a span, both ends included [mm]."""
        return _samples(self.knots) * self.length


def _samples(knots: Array) -> Array:
    steps = np.arange(SAMPLES_A_SPAN) / SAMPLES_A_SPAN
    inner = knots[:-1, None] + np.diff(knots)[:, None] * steps
    return np.append(inner.ravel(), knots[-1])


@dataclass(frozen=True)
class FittedCentreline:
    """A centreline as CAD gets it: lines and splines. It is a `Curve`, so all that measures curves measures it too.

    Attributes:
        pieces: In the order of travel.
        tolerance: Bound the deviation keeps [mm].
    """

    pieces: tuple[Line | FittedPiece, ...]
    tolerance: float

    @property
    def deviation(self) -> float:
        """Greatest sampled distance between the tube's side and the exact one [mm]."""
        return max((piece.deviation for piece in self.pieces if isinstance(piece, FittedPiece)), default=0.0)

    @property
    def spans(self) -> int:
        """Polynomial spans of all pieces; a line counts as one."""
        return sum(piece.spans if isinstance(piece, FittedPiece) else 1 for piece in self.pieces)

    @cached_property
    def breaks(self) -> Array:
        """Arclengths where pieces begin and end [mm]."""
        return np.concatenate([[0.0], np.cumsum([piece.length for piece in self.pieces])])

    @property
    def length(self) -> float:
        """Length of the exact centreline [mm]."""
        return float(self.breaks[-1])

    def frames(self, s: ArrayLike, side: Side = "right") -> Frames:
        """Positions of the fit and orthonormal frames on it, shape (n, 3) each."""
        return self.states(s, side)[0]

    def bishop(self, s: ArrayLike, order: int = 0, side: Side = "right") -> Array:
        """The fit's curvature along normal and binormal, shape (1, n, 2) [1/mm]; no derivatives of it.

        Raises:
            ValueError: `order` above 0.
        """
        if order > 0:
            raise ValueError("a fit gives its curvature, not derivatives of it; ask the exact centreline")
        return self.states(s, side)[1][None]

    def greatest_curvature(self) -> tuple[float, float]:
        """The greatest sampled |curvature| of the fit [1/mm] and its arclength [mm]."""
        return self._greatest_curvature

    @cached_property
    def _greatest_curvature(self) -> tuple[float, float]:
        best = (0.0, 0.0)
        for start, piece in zip(self.breaks, self.pieces, strict=False):
            if isinstance(piece, FittedPiece):
                s = piece.samples()
                kappa = np.linalg.norm(_frames_and_bend(piece, s)[1], axis=1)
                i = int(np.argmax(kappa))
                best = max(best, (float(kappa[i]), float(start + s[i])))
        return best

    def states(self, s: ArrayLike, side: Side = "right") -> tuple[Frames, Array]:
        """`frames`, and the curvature's components, shape (n, 2) [1/mm]."""
        at, index = locate(s, self.breaks, side)
        frames, bend = Frames(*(np.empty((len(at), 3)) for _ in range(4))), np.empty((len(at), 2))
        for i, piece in enumerate(self.pieces):
            own = index == i
            if own.any():
                local = np.clip(at[own] - self.breaks[i], 0.0, piece.length)
                found, bend[own] = _frames_and_bend(piece, local)
                for target, value in zip(frames, found, strict=True):
                    target[own] = value
        return frames, bend


def _frames_and_bend(piece: Line | FittedPiece, s: Array) -> tuple[Frames, Array]:
    """Frames of one piece made orthonormal, and the curvature's components in them, shape (n, 2)."""
    if isinstance(piece, Line):
        return piece.frames(s), np.zeros((len(s), 2))
    values, first, second = (piece.evaluate(s, derivative) for derivative in range(3))
    speed = np.linalg.norm(first[:, :3], axis=1)
    tangent = first[:, :3] / speed[:, None]
    normal = values[:, 3:6] - _dot(values[:, 3:6], tangent)[:, None] * tangent
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    binormal = np.cross(tangent, normal)
    bend = np.stack([_dot(second[:, :3], normal), _dot(second[:, :3], binormal)], axis=1) / speed[:, None] ** 2
    return Frames(values[:, :3], tangent, normal, binormal), bend


def _dot(a: Array, b: Array) -> Array:
    products: Array = np.einsum("ni,ni->n", a, b)
    return products


def fit_centreline(centreline: Centreline, radius: float, *, tolerance: float) -> FittedCentreline:
    """Fit lines and C4 quintic splines to a centreline and its frame.

    Args:
        centreline: The exact curve.
        radius: Of the tube whose side shall keep the tolerance [mm].
        tolerance: Bound on the distance between the side and the exact tube's [mm].

    Returns:
        The fit with its measured deviation. The distance is taken between points of equal parameters, which bounds
        the distance between the surfaces from above.

    Raises:
        UsageError: Radius or tolerance is not a positive number.
        GeometryError: The tolerance cannot be kept: below rounding, or more than 100 000 spans.
    """
    if not (0.0 < radius < math.inf and 0.0 < tolerance < math.inf):
        raise UsageError(f"a fit needs a positive radius and tolerance; got {radius!r} mm and {tolerance!r} mm")
    pieces: list[Line | FittedPiece] = []
    for start, piece in zip(centreline.breaks, centreline.pieces, strict=False):
        if isinstance(piece, Line):
            pieces.append(piece)
        else:
            pieces.append(_fit_piece(Centreline([piece]), radius, tolerance, float(start)))
    return FittedCentreline(tuple(pieces), tolerance)


def _fit_piece(piece: Centreline, radius: float, tolerance: float, start: float) -> FittedPiece:
    """Fit one smooth piece; `start` is its arclength on the whole centreline, for messages."""
    s, density = _knot_density(piece, radius, tolerance)
    share = np.concatenate([[0.0], np.cumsum((density[1:] + density[:-1]) / 2.0 * np.diff(s))])
    spans = math.ceil(share[-1] * (1.0 - 1e-12))
    least = math.inf
    while spans <= _MOST_SPANS:
        knots = np.interp(np.linspace(0.0, share[-1], spans + 1), share, s / piece.length)
        fitted = _interpolate(piece, radius, knots)
        if fitted.deviation <= _SAMPLED * tolerance:
            return fitted
        if fitted.deviation > 0.7 * least and spans > 64:
            # More knots stopped helping: the error is rounding, not interpolation.
            raise GeometryError(
                f"the piece of the centreline at s = {start:g} mm cannot be fitted to {tolerance:g} mm: "
                f"rounding leaves {fitted.deviation:.2g} mm; ask for a larger tolerance"
            )
        least = min(least, fitted.deviation)
        spans = math.ceil(spans * min(4.0, max(1.1, (fitted.deviation / (_AIM * tolerance)) ** (1.0 / 6.0))))
    raise GeometryError(
        f"the piece of the centreline at s = {start:g} mm needs more than {_MOST_SPANS} spans to keep "
        f"{tolerance:g} mm; ask for a larger tolerance"
    )


def _knot_density(piece: Centreline, radius: float, tolerance: float) -> tuple[Array, Array]:
    """Arclengths, and the density of knots that gives every span the error aimed at [1/mm]."""
    samples = _DENSITY_SAMPLES_A_RADIAN * piece.greatest_curvature()[0] * piece.length
    s = np.linspace(0.0, piece.length, math.ceil(min(max(_DENSITY_SAMPLES, samples), 4 * _MOST_SPANS)))
    sizes = [_derivative_sizes(piece, at, radius, (6, 8)) for at in _blocks(s)]
    sixth, eighth = np.concatenate(sizes, axis=1)
    density = _spread(sixth, piece.length, tolerance)
    return s, _spread(sixth + _NEXT_TERM * eighth / density**2, piece.length, tolerance)


def _derivative_sizes(piece: Centreline, s: Array, radius: float, orders: tuple[int, ...]) -> Array:
    """Bounds on derivatives of the points of the side, shape (orders, n) [mm^(1 - order)]."""
    tangent, normal, binormal = _frame_derivatives(piece, s, max(orders))
    return np.array(
        [
            np.sqrt(_dot(tangent[n - 1], tangent[n - 1]))
            + radius * np.sqrt(_dot(normal[n], normal[n]) + _dot(binormal[n], binormal[n]))
            for n in orders
        ]
    )


def _blocks(values: Array) -> list[Array]:
    return np.split(values, range(_BLOCK, len(values), _BLOCK))


def _spread(sixth: Array, length: float, tolerance: float) -> Array:
    """The density of knots for a sixth derivative, evened out [1/mm]."""
    density = (QUINTIC_ERROR / (_AIM * tolerance) * sixth) ** (1.0 / 6.0)
    # A knot needs its neighbours: take the greatest nearby, so that no sharp drop stands beside a crest.
    count, wide = len(density), np.pad(density, 4, mode="edge")
    density = np.max([wide[shift : shift + count] for shift in (0, 2, 4, 6, 8)], axis=0)
    evened: Array = np.maximum(density, max(_LEAST_DENSITY * float(density.max()), _LEAST_SPANS / length))
    return evened


def _frame_derivatives(piece: Centreline, s: Array, order: int) -> tuple[Array, Array, Array]:
    """Derivatives 0..order of tangent, normal and binormal by arclength, in the frame at `s`, shape (order + 1, n, 3).

    With M = N + i B and k = k1 + i k2 the frame obeys T' = Re(conj(k) M), M' = -k T: a recursion for Taylor
    coefficients.
    """
    factorials = np.array([math.factorial(n) for n in range(order + 1)], dtype=float)[:, None]
    k1, k2 = np.moveaxis(piece.bishop(s, order - 1), 2, 0)
    if not k2.any():
        return _plane_frame_derivatives(k1 / factorials[:-1], factorials)
    k = (k1 + 1j * k2) / factorials[:-1]
    t, m = np.zeros((order + 1, len(s), 3)), np.zeros((order + 1, len(s), 3), dtype=complex)
    t[0], m[0] = [1.0, 0.0, 0.0], [0.0, 1.0, 1.0j]
    for n in range(order):
        before = k[n::-1]  # k_n to k_0, to meet the frame's coefficients 0 to n
        t[n + 1] = np.einsum("jn,jnc->nc", before.conj(), m[: n + 1]).real / (n + 1)
        m[n + 1] = -np.einsum("jn,jnc->nc", before, t[: n + 1]) / (n + 1)
    t, m = t * factorials[:, None], m * factorials[:, None]
    return t, m.real, m.imag


def _plane_frame_derivatives(k: Array, factorials: Array) -> tuple[Array, Array, Array]:
    """The same for a plane curve, whose tangent as a complex number z obeys z' = i k z, and whose normal is i z."""
    count = len(factorials)
    z = np.zeros((count, k.shape[1]), dtype=complex)
    z[0] = 1.0
    for n in range(count - 1):
        z[n + 1] = np.einsum("jn,jn->n", k[n::-1], z[: n + 1]) * (1j / (n + 1))
    z *= factorials
    tangent, normal, binormal = (np.zeros((*z.shape, 3)) for _ in range(3))
    tangent[:, :, 0], tangent[:, :, 1] = z.real, z.imag
    normal[:, :, 0], normal[:, :, 1] = -z.imag, z.real
    binormal[0, :, 2] = 1.0
    return tangent, normal, binormal


def _interpolate(piece: Centreline, radius: float, knots: Array) -> FittedPiece:
    """The spline through a piece at given knots of [0, 1], and its measured deviation."""
    length = piece.length
    frames, ends = piece.frames(knots * length), piece.frames([0.0, length])
    columns = np.hstack([frames.position, frames.normal, frames.binormal])
    tangent, normal, binormal = _frame_derivatives(piece, np.array([0.0, length]), 3)
    axes = np.stack(ends[1:], axis=1)
    first, third = (
        np.hstack([np.einsum("ni,nij->nj", field, axes) for field in (tangent[n - 1], normal[n], binormal[n])])
        * length**n
        for n in (1, 3)
    )
    poles = interpolate(knots, columns, (1, 3), (first[0], third[0]), (first[1], third[1])).poles
    # The binormal of a plane curve: a constant has constant poles, to the last digit.
    level = (columns == columns[0]).all(axis=0) & ~first.any(axis=0) & ~third.any(axis=0)
    poles[:, level] = columns[0, level]
    spline = QuinticSpline(knots, poles)
    measured = (_deviation(spline(at), piece.frames(at * length), radius) for at in _blocks(_samples(knots)))
    return FittedPiece(length, knots, poles, max(measured), ends.position, ends.tangent, ends.normal)


def _deviation(columns: Array, exact: Frames, radius: float) -> float:
    """Greatest distance [mm] of points of the side at some stations, (position, normal, binormal), from the exact ones.

    With the errors p, n, b of position, normal and binormal its square is |p + r (n cos(u) + b sin(u))|^2.
    """
    p, n, b = np.split(columns - np.hstack([exact.position, exact.normal, exact.binormal]), 3, axis=1)
    n, b = radius * n, radius * b
    nn, bb = _dot(n, n) / 2.0, _dot(b, b) / 2.0
    waves = np.stack([_dot(p, p) + nn + bb, 2.0 * _dot(p, n), 2.0 * _dot(p, b), nn - bb, _dot(n, b)], axis=1)
    return math.sqrt(max(float((waves @ _WAVES).max()), 0.0))
