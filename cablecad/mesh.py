"""Triangles for what shows or stores no exact surfaces: viewers, printers, pictures.

A cable is meshed straight from its centreline: circles at stations along it, joined by triangles, with exact normals.
Stations and circles lie on the exact surface, and both spacings follow from the tolerance: of a linear piece over a
triangle with legs of `a` radians around and `b` mm along, the distance to the surface is at most

    (r a^2 + 2 kappa r a b + kappa (1 + kappa r) b^2) / 8,

which is the tolerance when the first and last term are `_SHARE` of it each (kappa r < 1). Nothing here needs Open
Cascade, whose mesher may leave out a strip along a tube's seam (see `brep.tube`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from cablecad.centreline import Array, Curve
from cablecad.errors import UsageError

Triangles = NDArray[np.intp]

TUBE_SHARE = 1e-2
"""Default chordal tolerance of a cable as a share of its radius: circles of 28 corners, round to the eye."""

_SHARE = 1.0 / (2.0 + math.sqrt(2.0))
"""Share of the tolerance each of the two spacings takes: the mixed term takes what is left."""

_LEAST_CORNERS = 12
"""A circle of fewer corners looks like a nut, whatever the tolerance."""

_MOST_TURN = math.radians(10.0)
"""The most a cable turns between two stations, so that shading stays smooth where the tolerance is coarse."""

_MOST_VERTICES = 20_000_000
"""A finer mesh than this is refused: a file of 500 MB."""

_SAMPLES, _SAMPLES_A_RADIAN, _MOST_SAMPLES = 257, 16.0, 1_000_000
"""Where the curvature is taken to spread the stations: in a gentle piece, a radian of the tightest bend; at most."""


@dataclass(frozen=True)
class Mesh:
    """Triangles with a normal at each corner.

    Attributes:
        vertices: Shape (n, 3) [mm]; a vertex where faces meet at an angle stands there once for each of them.
        normals: Outward unit normals at the vertices, shape (n, 3).
        triangles: Numbers of three vertices, counterclockwise seen from outside, shape (m, 3).
        edges: Polylines where faces meet, to be drawn as lines, shape (k, 3) each [mm].
    """

    vertices: Array
    normals: Array
    triangles: Triangles
    edges: tuple[Array, ...] = field(default=())

    def placed(self, placement: Array) -> Mesh:
        """The mesh under a rotation and move, shape (3, 4) [mm]."""
        turn, move = placement[:, :3], placement[:, 3]
        edges = tuple(edge @ turn.T + move for edge in self.edges)
        return Mesh(self.vertices @ turn.T + move, self.normals @ turn.T, self.triangles, edges)


def merged(meshes: list[Mesh]) -> Mesh:
    """Several meshes as one, in their order."""
    starts = np.cumsum([0] + [len(mesh.vertices) for mesh in meshes])
    return Mesh(
        np.concatenate([mesh.vertices for mesh in meshes]),
        np.concatenate([mesh.normals for mesh in meshes]),
        np.concatenate([mesh.triangles + start for mesh, start in zip(meshes, starts, strict=False)]),
        tuple(edge for mesh in meshes for edge in mesh.edges),
    )


@dataclass(frozen=True)
class TubeMesh:
    """The mesh of a cable, and where along it each vertex lies.

    Attributes:
        mesh: Side and caps; the rims of the caps are its edges.
        arclengths: Of each vertex, shape (n,) [mm].
    """

    mesh: Mesh
    arclengths: Array


def mesh_tube(curve: Curve, radius: float, *, tolerance: float | None = None) -> TubeMesh:
    """Mesh the tube around a centreline, closed by flat caps.

    Args:
        curve: Centreline, or its fit.
        radius: Of the tube [mm].
        tolerance: Bound on the distance between triangles and tube [mm]; a hundredth of the radius if not given.

    Returns:
        The mesh. It is closed: the rim of a cap stands twice, at the same places to the last bit.

    Raises:
        UsageError: The tolerance is no positive number, or needs more than 20 million vertices.
    """
    tolerance = TUBE_SHARE * radius if tolerance is None else tolerance
    if not 0.0 < tolerance < math.inf:
        raise UsageError(f"a mesh needs a positive tolerance; got {tolerance!r} mm")
    corners = _corners(radius, tolerance)
    spans = [
        _span_stations(curve, float(start), float(end), radius, tolerance, _MOST_VERTICES // corners)
        for start, end in pairwise(curve.breaks)
    ]
    s = np.concatenate([spans[0], *(span[1:] for span in spans[1:])])
    frames = curve.frames(s)
    angle = 2.0 * math.pi * np.arange(corners) / corners
    outward = np.cos(angle)[:, None] * frames.normal[:, None] + np.sin(angle)[:, None] * frames.binormal[:, None]
    rings = frames.position[:, None] + radius * outward  # (stations, corners, 3)
    side = Mesh(rings.reshape(-1, 3), outward.reshape(-1, 3), _side_triangles(len(s), corners))
    start, end = (
        _cap(rings[i], frames.position[i], sign * frames.tangent[i]) for i, sign in ((0, -1.0), (len(s) - 1, 1.0))
    )
    arclengths = np.concatenate([np.repeat(s, corners), np.full(corners + 1, s[0]), np.full(corners + 1, s[-1])])
    return TubeMesh(merged([side, start, end]), arclengths)


def _corners(radius: float, tolerance: float) -> int:
    """Corners of a circle."""
    step = math.sqrt(8.0 * _SHARE * tolerance / radius)
    return max(_LEAST_CORNERS, math.ceil(min(2.0 * math.pi / step, 1e6)))


def _span_stations(curve: Curve, start: float, end: float, radius: float, tolerance: float, most: int) -> Array:
    """Arclengths of the stations of one smooth piece, both its ends included; a straight one needs no others."""
    turn = curve.greatest_curvature()[0] * (end - start)
    s = np.linspace(start, end, math.ceil(max(_SAMPLES, min(_SAMPLES_A_RADIAN * turn, _MOST_SAMPLES))))
    inner = s.copy()
    # Within the piece, on its own side of both breaks.
    inner[[0, -1]] += np.array([1.0, -1.0]) * 1e-9 * (end - start)
    kappa = np.linalg.norm(curve.bishop(inner)[0], axis=1)
    density = np.maximum(np.sqrt(kappa * (1.0 + kappa * radius) / (8.0 * _SHARE * tolerance)), kappa / _MOST_TURN)
    # The greatest nearby: a span's bound is that of its tightest place.
    density = np.max([np.pad(density, 2, mode="edge")[i : i + len(s)] for i in range(5)], axis=0)
    share = np.concatenate([[0.0], np.cumsum(np.maximum(density[1:], density[:-1]) * np.diff(s))])
    if share[-1] > most:
        raise UsageError(
            f"a mesh to {tolerance:g} mm needs more than {_MOST_VERTICES:.0e} vertices; ask for a larger tolerance"
        )
    if share[-1] == 0.0:
        return np.array([start, end])
    stations: Array = np.interp(np.linspace(0.0, share[-1], math.ceil(share[-1]) + 1), share, s)
    stations[[0, -1]] = start, end
    return stations


def _side_triangles(stations: int, corners: int) -> Triangles:
    """Two triangles for each field between two stations and two neighbouring corners, closed around."""
    i, j = np.meshgrid(np.arange(stations - 1), np.arange(corners), indexing="ij")
    k = (j + 1) % corners
    a, b, c, d = i * corners + j, i * corners + k, (i + 1) * corners + k, (i + 1) * corners + j
    return np.stack([np.stack([a, b, c], axis=-1), np.stack([a, c, d], axis=-1)], axis=2).reshape(-1, 3)


def _cap(ring: Array, centre: Array, outward: Array) -> Mesh:
    """A fan from the centre to a ring."""
    corners = len(ring)
    j = np.arange(corners)
    k = (j + 1) % corners
    x = np.cross(ring[0] - centre, ring[1] - centre) @ outward  # which way round the ring runs, seen from outside
    fan = np.stack([np.full(corners, corners), j, k] if x > 0.0 else [np.full(corners, corners), k, j], axis=1)
    normals = np.broadcast_to(outward, (corners + 1, 3))
    return Mesh(np.vstack([ring, centre]), normals, fan, (np.vstack([ring, ring[:1]]),))
