"""The curve r(s) of a cable: all that passes from mechanics to CAD.

A `Centreline` is an ordered list of smooth pieces, each with its own closed form, joined at the breaks with the same
tangent and the same frame; the curvature may jump there, so every evaluation says from which side it is taken. A
tube gets one side face a piece and keeps full smoothness inside it.

The frame is rotation-minimising (Bishop): with k1, k2 the components of the curvature along normal and binormal,

    T' = k1 N + k2 B,   N' = -k1 T,   B' = -k2 T,   T = N x B.

In a plane curve B is the plane's normal, k2 = 0 and k1 the signed curvature about B; a space curve is carried
without change. All arclengths and positions in mm.

Source: R. L. Bishop, There is more than one way to frame a curve, Amer. Math. Monthly 82 (1975) 246-251.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import accumulate, pairwise
from typing import Literal, NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cablecad.errors import GeometryError

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
Side = Literal["left", "right"]

JOINT_TOLERANCE = 1e-9
"""Largest gap at a break, relative to the length in position and absolute in tangent and normal: a true corner is far
above it, the rounding of a solver's output far below."""


class Frames(NamedTuple):
    """Positions and orthonormal frames at n arclengths, each of shape (n, 3); positions in mm."""

    position: Array
    tangent: Array
    normal: Array
    binormal: Array


class Curve(Protocol):
    """A curve by arclength, or by a parameter that is arclength up to a fit's deviation."""

    @property
    def length(self) -> float:
        """Length [mm]."""
        ...

    @property
    def breaks(self) -> Array:
        """Arclengths between which the curve is smooth, both ends included."""
        ...

    def frames(self, s: ArrayLike, side: Side = "right") -> Frames:
        """Positions and frames at `s`, shape (n, 3) each."""
        ...

    def states(self, s: ArrayLike, side: Side = "right") -> tuple[Frames, Array]:
        """Frames, and (k1, k2), shape (n, 2): both for little more than one of them."""
        ...

    def bishop(self, s: ArrayLike, order: int = 0, side: Side = "right") -> Array:
        """Derivatives 0..order of (k1, k2) at `s`, shape (order + 1, n, 2) [1/mm^(1 + order)]."""
        ...

    def greatest_curvature(self) -> tuple[float, float]:
        """The greatest |curvature| [1/mm] and the arclength where it stands [mm]."""
        ...


class Piece(Protocol):
    """One smooth stretch of a centreline, by its own arclength from 0 to `length`."""

    @property
    def length(self) -> float:
        """Length [mm]."""
        ...

    def frames(self, s: Array) -> Frames:
        """Positions and frames at `s` of shape (n,)."""
        ...

    def states(self, s: Array) -> tuple[Frames, Array]:
        """Frames, and (k1, k2), shape (n, 2)."""
        ...

    def bishop(self, s: Array, order: int) -> Array:
        """Derivatives 0..order of (k1, k2) at `s`, shape (order + 1, n, 2)."""
        ...

    def turns(self, s: Array, order: int) -> ComplexArray | None:
        """Derivatives 0..order of the tangent by the share of the length, which has them finite at any size.

        As complex numbers, tangent and normal at `s` being 1 and i, shape (order + 1, n); None for a piece that may
        leave the plane.
        """
        ...

    def greatest_curvature(self) -> tuple[float, float]:
        """The greatest |curvature| of the piece [1/mm], exactly, and the arclength where it stands [mm]."""
        ...


@dataclass(frozen=True)
class Placement:
    """A right-handed frame in space: `origin` (3,) [mm], unit axes `e1`, `e2` (3,) of the plane and its normal `e3`."""

    origin: Array
    e1: Array
    e2: Array

    @property
    def e3(self) -> Array:
        """The plane's normal, e1 x e2."""
        (a, b, c), (x, y, z) = self.e1.tolist(), self.e2.tolist()  # a tenth of the time of np.cross
        return np.array([b * z - c * y, c * x - a * z, a * y - b * x])

    def frames(self, x: Array, y: Array, cosine: Array, sine: Array) -> Frames:
        """Frames of a curve in the plane from its local position and the cosine and sine of its tangent's angle."""
        local = np.empty((3, len(x), 2))  # one product for all three: a quarter of the time
        local[0, :, 0], local[0, :, 1] = x, y
        local[1, :, 0], local[1, :, 1] = cosine, sine
        local[2, :, 0], local[2, :, 1] = -sine, cosine
        position, tangent, normal = local @ np.stack([self.e1, self.e2])
        position += self.origin
        return Frames(position, tangent, normal, np.broadcast_to(self.e3, position.shape))


@dataclass(frozen=True)
class Line:
    """A straight piece from the origin of `placement` along its e1."""

    placement: Placement
    length: float

    def frames(self, s: Array) -> Frames:
        """Positions and frames at `s`."""
        zero = np.zeros_like(s)
        return self.placement.frames(s, zero, zero + 1.0, zero)

    def states(self, s: Array) -> tuple[Frames, Array]:
        """Positions and frames at `s`, and no curvature."""
        return self.frames(s), np.zeros((len(s), 2))

    def bishop(self, s: Array, order: int) -> Array:
        """Zeros, shape (order + 1, n, 2)."""
        return np.zeros((order + 1, len(s), 2))

    def turns(self, s: Array, order: int) -> ComplexArray:
        """A tangent that does not turn, shape (order + 1, n)."""
        return np.repeat(np.eye(1, order + 1, dtype=complex).T, len(s), axis=1)

    def greatest_curvature(self) -> tuple[float, float]:
        """No curvature anywhere."""
        return 0.0, 0.0


@dataclass(frozen=True)
class Arc:
    """A circular arc that leaves the origin of `placement` along its e1 with signed `kappa` [1/mm] about its e3."""

    placement: Placement
    length: float
    kappa: float

    def frames(self, s: Array) -> Frames:
        """Positions and frames at `s`, to rounding for any curvature, zero included."""
        half = self.kappa * s / 2.0
        along = s * np.sinc(half / math.pi)  # the chord of the arc; numpy's sinc has the factor pi inside
        return self.placement.frames(along * np.cos(half), along * np.sin(half), np.cos(2 * half), np.sin(2 * half))

    def states(self, s: Array) -> tuple[Frames, Array]:
        """Positions and frames at `s`, and the constant curvature."""
        return self.frames(s), self.bishop(s, 0)[0]

    def bishop(self, s: Array, order: int) -> Array:
        """The constant curvature and its vanishing derivatives."""
        values = np.zeros((order + 1, len(s), 2))
        values[0, :, 0] = self.kappa
        return values

    def turns(self, s: Array, order: int) -> ComplexArray:
        """Powers of i kappa times the length, shape (order + 1, n)."""
        return np.repeat((1j * self.kappa * self.length) ** np.arange(order + 1)[:, None], len(s), axis=1)

    def greatest_curvature(self) -> tuple[float, float]:
        """The curvature; it is the same all along and is said to stand at the middle."""
        return abs(self.kappa), self.length / 2.0


def _ends(piece: Piece) -> Frames:
    """Positions and frames at both ends of a piece, shape (2, 3) each; some have them at hand."""
    known: Callable[[], Frames] | None = getattr(piece, "ends", None)
    return piece.frames(np.array([0.0, piece.length])) if known is None else known()


def locate(s: ArrayLike, breaks: Array, side: Side) -> tuple[Array, NDArray[np.intp]]:
    """Arclengths checked and clipped, shape (n,), and the number of the piece each belongs to seen from `side`.

    Raises:
        ValueError: An arclength outside the breaks by more than rounding, or not a number.
    """
    at, last = _within(s, breaks), len(breaks) - 2
    if not last:
        return at, np.zeros(len(at), dtype=np.intp)
    return at, np.minimum(np.maximum(np.searchsorted(breaks, at, side=side) - 1, 0), last)


def _within(s: ArrayLike, breaks: Array) -> Array:
    """Arclengths checked and clipped, shape (n,)."""
    at = np.asarray(s, dtype=np.float64).ravel()
    length = float(breaks[-1])
    beyond = 1e-12 * length  # the rounding of a caller's own sums
    if len(at) and not (at.min() >= -beyond and at.max() <= length + beyond):  # a NaN is its array's least
        raise ValueError(f"arclengths must be within 0 and {length!r} mm; got {at.min()!r} to {at.max()!r}")
    return np.minimum(np.maximum(at, 0.0), length)


class Centreline:
    """An ordered list of smooth pieces that meet with one tangent and one frame.

    Attributes:
        pieces: In the order of travel.
        breaks: Arclengths where pieces begin and end, shape (pieces + 1,) [mm].
        length: Total length [mm].

    Raises:
        GeometryError: Pieces do not meet, or meet at a corner or with different frames.
    """

    def __init__(self, pieces: Sequence[Piece]) -> None:
        self.pieces = tuple(pieces)
        if not self.pieces:
            raise GeometryError("a centreline needs at least one piece")
        lengths = [piece.length for piece in self.pieces]
        if not all(length > 0.0 and math.isfinite(length) for length in lengths):
            raise GeometryError(f"every piece of a centreline needs a positive length; got {lengths} mm")
        self.breaks: Array = np.array([0.0, *accumulate(lengths)])
        self.length = float(self.breaks[-1])
        self._check_joints()

    def _check_joints(self) -> None:
        if len(self.pieces) == 1:
            return
        ends = [_ends(piece) for piece in self.pieces]
        for i, (before, after) in enumerate(pairwise(ends)):
            place = before.position[1]
            gap = math.dist(place, after.position[0])
            reach = self.length + max(map(abs, place.tolist()))
            turn = max(math.dist(before.tangent[1], after.tangent[0]), math.dist(before.normal[1], after.normal[0]))
            if not (gap <= JOINT_TOLERANCE * reach and turn <= JOINT_TOLERANCE):  # a NaN does not join either
                raise GeometryError(
                    f"pieces {i} and {i + 1} of the centreline do not join at s = {self.breaks[i + 1]:g} mm: "
                    f"gap {gap:.3g} mm, frames turned by {turn:.3g} rad; give them one end and one frame"
                )

    def frames(self, s: ArrayLike, side: Side = "right") -> Frames:
        """Positions and frames at arclengths.

        Args:
            s: Arclengths, scalar or shape (n,) [mm].
            side: At a break, whether the piece after it ("right") or before it ("left") is taken.

        Returns:
            Positions [mm], tangents, normals and binormals, shape (n, 3) each.

        Raises:
            ValueError: An arclength outside 0..length, or not a number.
        """
        if len(self.pieces) == 1:
            return self.pieces[0].frames(_within(s, self.breaks))
        at, index = locate(s, self.breaks, side)
        result = Frames(*(np.empty((len(at), 3)) for _ in range(4)))
        for piece, own, local in self._shares(at, index):
            for target, value in zip(result, piece.frames(local), strict=True):
                target[own] = value
        return result

    def ends(self) -> Frames:
        """Positions and frames at the start and at the end, shape (2, 3) each."""
        start = _ends(self.pieces[0])
        if len(self.pieces) == 1:
            return start
        end = _ends(self.pieces[-1])
        return Frames(*(np.stack([one[0], other[1]]) for one, other in zip(start, end, strict=True)))

    def states(self, s: ArrayLike, side: Side = "right") -> tuple[Frames, Array]:
        """`frames`, and the curvature's components along normal and binormal, shape (n, 2) [1/mm]."""
        if len(self.pieces) == 1:
            return self.pieces[0].states(_within(s, self.breaks))
        at, index = locate(s, self.breaks, side)
        result, bend = Frames(*(np.empty((len(at), 3)) for _ in range(4))), np.empty((len(at), 2))
        for piece, own, local in self._shares(at, index):
            frames, bend[own] = piece.states(local)
            for target, value in zip(result, frames, strict=True):
                target[own] = value
        return result, bend

    def _shares(self, at: Array, index: NDArray[np.intp]) -> Iterator[tuple[Piece, NDArray[np.bool_], Array]]:
        """The pieces asked for, which of the arclengths are theirs, and those in their own count."""
        for i, piece in enumerate(self.pieces):
            own = index == i
            if own.any():
                yield piece, own, np.minimum(np.maximum(at[own] - self.breaks[i], 0.0), piece.length)

    def bishop(self, s: ArrayLike, order: int = 0, side: Side = "right") -> Array:
        """Derivatives 0..order with respect to arclength of the curvature's components along normal and binormal.

        Args:
            s: Arclengths, scalar or shape (n,) [mm].
            order: Highest derivative.
            side: As in `frames`.

        Returns:
            Shape (order + 1, n, 2) [1/mm^(1 + derivative)].
        """
        at, index = locate(s, self.breaks, side)
        result = np.empty((order + 1, len(at), 2))
        for piece, own, local in self._shares(at, index):
            result[:, own] = piece.bishop(local, order)
        return result

    def position(self, s: ArrayLike, side: Side = "right") -> Array:
        """Positions at arclengths, shape (n, 3) [mm]."""
        return self.frames(s, side).position

    def tangent(self, s: ArrayLike, side: Side = "right") -> Array:
        """Unit tangents, shape (n, 3)."""
        return self.frames(s, side).tangent

    def normal(self, s: ArrayLike, side: Side = "right") -> Array:
        """Unit normals of the rotation-minimising frame, shape (n, 3)."""
        return self.frames(s, side).normal

    def binormal(self, s: ArrayLike, side: Side = "right") -> Array:
        """Unit binormals of the rotation-minimising frame, shape (n, 3); a plane curve's is the plane's normal."""
        return self.frames(s, side).binormal

    def curvature(self, s: ArrayLike, derivative: int = 0, side: Side = "right") -> Array:
        """Curvature about the binormal, signed, or a derivative of it by arclength.

        In a plane curve that is the curvature; of a space curve it is one of two components (see `bishop`).

        Returns:
            Shape (n,) [1/mm^(1 + derivative)].
        """
        return self.bishop(s, derivative, side)[derivative, :, 0]

    def points(self, count: int) -> Array:
        """`count` >= 2 positions at equal arclengths, both ends included, shape (count, 3) [mm]."""
        if count < 2:
            raise ValueError(f"points need both ends, so at least 2; got {count}")
        return self.position(np.linspace(0.0, self.length, count))

    def greatest_curvature(self) -> tuple[float, float]:
        """The greatest |curvature| [1/mm], exactly, and the arclength where it stands [mm]."""
        found = [piece.greatest_curvature() for piece in self.pieces]
        i = max(range(len(found)), key=lambda j: found[j][0])
        return found[i][0], float(self.breaks[i]) + found[i][1]
