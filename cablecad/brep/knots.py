"""How many knots a fit takes, and where: every span has the same error, by exact derivatives.

The error of interpolation at the knots by a spline of odd degree, of order q = degree + 1, is

    f - s = (Bq(t) - Bq(0)) / q! h^q f^(q)   at the share t of a span h,   Bq the Bernoulli polynomial,

exact for f^(q) constant. It has no odd derivatives at the knots, so that those given at the ends of the spline add
nothing to it; to a changing f^(q) they add as much again, in the two spans beside an end. For f = exp(i w s) it is so
many times as large in the middle of a span, with x = w h / (2 pi),

    ((1 - x)^-q + (1 + x)^-q) / 2

but for terms below 3^-q: what is left of the sums over k of (x + k)^-q, odd k over all k. With w^2 from the derivatives
of the orders q and q + 2 that corrects the formula for spans that are not short. All derivatives follow from the
curvature's by the equations of the frame; they are by the share of the length, which keeps them finite at any size.

Nothing here needs Open Cascade.

Source: C. A. Hall, W. W. Meyer, Optimal error bounds for cubic spline interpolation, J. Approx. Theory 16 (1976), for
the argument; the constant is confirmed by tests/convergence/test_spline_order.py.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablecad.brep.bspline import end_orders
from cablecad.bundle import Bundle, bundled
from cablecad.centreline import Array, ComplexArray, Piece

DEGREE = 9
"""Of the spline. To 1e-2 mm it takes no more poles than degrees five or seven, to 1e-6 mm half and five sixths of
theirs; with a higher one rounding comes into sight (tests/experiments/spline_counts.py)."""

ORDER = DEGREE + 1
"""Of the error: that of the first derivative a spline does not follow."""

SPAN_ERROR = (2.0 - 0.5**DEGREE) * (5.0 / 66.0) / math.factorial(ORDER)
"""|B10(1/2) - B10(0)| / 10! = 4.2e-8, the error of a span of length one for a tenth derivative of one."""

_END_ORDERS = np.array(end_orders(DEGREE))

_SAMPLES, _SAMPLES_A_RADIAN = 65, 2.0
"""Where the derivatives are taken: in a gentle piece, and a radian of the tightest bend."""

_MOST_SAMPLES = 400_000
"""Four a span of the longest spline there may be."""

_BLOCK = 8192
"""Samples worked on at once."""

_REACH = 1
"""To how many samples on either side the greatest density nearby counts."""

_LEAST_DENSITY = 0.2
"""Least density of knots against the greatest: neighbouring spans stay of like length, and no feature is skipped."""

_GROWTH = 0.1
"""Where `_LEAST_DENSITY` would mean many spans, far from the tightest bend of a taut cable, they may grow instead: by
this share from one to the next."""

_LEAST_SPANS = 2.0
"""Spans of the gentlest piece."""

_MOST_OF_A_WAVE = 0.4
"""Greatest x of the formula: of half a wave a span a spline knows nothing more."""

_NO_SIZE = 1e-100
"""In place of a derivative or a density that vanishes; its square does not."""


class KnotCount(NamedTuple):
    """How many knots one smooth piece takes from its start on, and the derivatives at its ends.

    Attributes:
        share: Of its length, shape (n,).
        knots: Knots up to there, shape (n,); the last is the number of spans.
        ends: Derivatives of position [mm], normal and binormal by the share at the start and at the end, in the frame
            there, of the orders that a spline is given, shape (2, orders, 3, 3).
    """

    share: Array
    knots: Array
    ends: Array


def count_knots(pieces: Sequence[Piece], radii: Array, errors: Array) -> list[KnotCount]:
    """Count the knots of smooth pieces, by exact derivatives; those alike are looked at together.

    Args:
        pieces: Exact curves.
        radii: Of the tubes, shape (n,) [mm].
        errors: Of the tubes' sides, that every span shall have, shape (n,) [mm].
    """
    counts: list[KnotCount | None] = [None] * len(pieces)
    alike: dict[tuple[type, int], list[int]] = defaultdict(list)
    for i, piece in enumerate(pieces):
        alike[type(piece), _samples_of(piece)].append(i)
    for (_, samples), members in alike.items():
        most = max(1, _BLOCK // samples)
        for low in range(0, len(members), most):
            own = members[low : low + most]
            found = _count_alike(bundled([pieces[i] for i in own]), samples, radii[own], errors[own])
            for i, count in zip(own, found, strict=True):
                counts[i] = count
    return [count for count in counts if count is not None]


def _samples_of(piece: Piece) -> int:
    """Where to take the derivatives of a piece: at so many equal shares of its length."""
    wanted = _SAMPLES_A_RADIAN * piece.greatest_curvature()[0] * piece.length
    return max(_SAMPLES, math.ceil(min(wanted, _MOST_SAMPLES)))


@lru_cache(maxsize=16)
def _shares(samples: int) -> Array:
    shares = np.linspace(0.0, 1.0, samples)
    shares.flags.writeable = False
    return shares


def _count_alike(bundle: Bundle, samples: int, radii: Array, errors: Array) -> list[KnotCount]:
    """`count_knots` for pieces of one kind by as many samples each."""
    length = np.array([[piece.length] for piece in bundle.pieces])
    share, size = _shares(samples), radii[:, None] / length
    sizes, ends = np.empty((2, len(length), samples)), np.empty((len(length), 2, len(_END_ORDERS), 3, 3))
    for low in range(0, samples, _BLOCK):
        turning = _turning(bundle, length * share[low : low + _BLOCK])
        sizes[..., low : low + _BLOCK] = turning.sizes(size)
        if not low:
            ends[:, 0] = turning.derivatives(0, _END_ORDERS)
    ends[:, 1] = turning.derivatives(-1, _END_ORDERS)
    ends[..., 0, :] *= length[..., None, None]
    density = _spread(knot_density(sizes[0], sizes[1], errors[:, None] / length))
    knots = np.zeros((len(length), samples))
    np.cumsum((density[:, 1:] + density[:, :-1]) / (2.0 * (samples - 1)), axis=1, out=knots[:, 1:])
    return [KnotCount(share, *each) for each in zip(knots, ends, strict=True)]


def knot_density(first: Array, second: Array, error: float | Array) -> Array:
    """Knots a unit that leave an error, from the sizes of the derivatives of the orders q and q + 2."""
    density = np.maximum((SPAN_ERROR / error * first) ** (1.0 / ORDER), _NO_SIZE)
    x2 = second / (np.maximum(first, _NO_SIZE) * (2.0 * math.pi * density) ** 2)
    x = np.minimum(np.sqrt(x2) * (1.0 + ORDER * (ORDER + 1) / 2.0 * x2) ** (-1.0 / ORDER), _MOST_OF_A_WAVE)
    density *= (((1.0 - x) ** -ORDER + (1.0 + x) ** -ORDER) / 2.0) ** (1.0 / ORDER)
    return density


def _spread(density: Array) -> Array:
    """Densities of knots by the share of the length, shape (n, samples), evened out."""
    # A knot needs its neighbours: take the greatest nearby, so that no sharp drop stands beside a crest.
    for _ in range(_REACH):
        wide = density.copy()
        np.maximum(wide[:, 1:], density[:, :-1], out=wide[:, 1:])
        np.maximum(wide[:, :-1], density[:, 1:], out=wide[:, :-1])
        density = wide
    least = np.minimum(_LEAST_DENSITY * density.max(axis=1, keepdims=True), _graded(density))
    evened: Array = np.maximum(density, np.maximum(least, _LEAST_SPANS))
    return evened


def _graded(density: Array) -> Array:
    """The least densities, no less than these, from which a span is longer than the one beside it by `_GROWTH` at most.

    Lengths of spans then grow by no more than that share of the way from anywhere.
    """
    grown = np.linspace(0.0, _GROWTH, density.shape[1])
    length = 1.0 / density
    forth = np.minimum.accumulate(length - grown, axis=1) + grown
    back = (np.minimum.accumulate((length + grown)[:, ::-1], axis=1) - grown[::-1])[:, ::-1]
    return np.asarray(1.0 / np.minimum(forth, back))


class _Turning(NamedTuple):
    """Derivatives of the tangents T and of M = N + i B by the share, in the frame at each point, (orders, n, k, 3)."""

    tangent: Array
    normals: ComplexArray

    def sizes(self, radius: Array) -> Array:
        """Bounds on derivatives q and q + 2 of points of the sides, over the length like the radii, shape (2, n, k)."""
        along, around = np.linalg.norm(self.tangent, axis=3), np.linalg.norm(self.normals, axis=3)
        bounds: Array = along[ORDER - 1 : -1 : 2] + radius * around[ORDER::2]
        return bounds

    def derivatives(self, i: int, orders: NDArray[np.int_]) -> Array:
        """Derivatives of position (over the length), normal and binormal at one of the points, (n, orders, 3, 3)."""
        normals = self.normals[orders, :, i]
        each = np.stack([self.tangent[orders - 1, :, i], normals.real, normals.imag], axis=2)
        return np.moveaxis(each, 0, 1)


class _PlaneTurning(NamedTuple):
    """The same of plane curves: tangents as complex numbers z, to which the normals are i z, shape (orders, n, k)."""

    tangent: ComplexArray

    def sizes(self, radius: Array) -> Array:
        turns = np.abs(self.tangent)
        bounds: Array = turns[ORDER - 1 : -1 : 2] + radius * turns[ORDER::2]
        return bounds

    def derivatives(self, i: int, orders: NDArray[np.int_]) -> Array:
        before, z = self.tangent[orders - 1, :, i].T, self.tangent[orders, :, i].T
        found = np.zeros((*z.shape, 3, 3))
        found[..., 0, 0], found[..., 0, 1] = before.real, before.imag
        found[..., 1, 0], found[..., 1, 1] = -z.imag, z.real
        return found


def _turning(bundle: Bundle, s: Array) -> _Turning | _PlaneTurning:
    """From the pieces, or by a recursion for Taylor coefficients; arclengths of shape (n, k) [mm].

    With k = k1 + i k2 the frame obeys T' = Re(conj(k) M), M' = -k T.
    """
    highest = ORDER + 2
    turns = bundle.turns(s, highest)
    if turns is not None:
        return _PlaneTurning(turns)
    each = [piece.bishop(row, highest - 1) for piece, row in zip(bundle.pieces, s, strict=True)]
    k1, k2 = np.moveaxis(np.stack(each, axis=1), 3, 0)
    factorials = np.array([[[math.factorial(n)]] for n in range(highest + 1)], dtype=float)
    length = np.array([[piece.length] for piece in bundle.pieces])
    k = (k1 + 1j * k2) * length ** np.arange(1.0, highest + 1)[:, None, None] / factorials[:-1]
    t, m = np.zeros((highest + 1, *s.shape, 3)), np.zeros((highest + 1, *s.shape, 3), dtype=complex)
    t[0], m[0] = [1.0, 0.0, 0.0], [0.0, 1.0, 1.0j]
    for n in range(highest):
        before = k[n::-1]  # k_n to k_0, to meet the frame's coefficients 0 to n
        t[n + 1] = np.einsum("j...,j...c->...c", before.conj(), m[: n + 1]).real / (n + 1)
        m[n + 1] = -np.einsum("j...,j...c->...c", before, t[: n + 1]) / (n + 1)
    return _Turning(t * factorials[..., None], m * factorials[..., None])
