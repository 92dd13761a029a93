"""Meshes of cables: closed, true to the tube to the tolerance asked for, and no finer than that."""

from __future__ import annotations

import math
from collections import Counter

import numpy as np
import pytest
from curves import Helix
from scipy.spatial import cKDTree

from cablecad.centreline import Arc, Centreline, Line, Placement
from cablecad.errors import UsageError
from cablecad.mesh import TUBE_SHARE, Mesh, mesh_tube

X, Y = np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])
PLACE = Placement(np.zeros(3), X, Y)


def bend(radius: float, turn: float) -> Centreline:
    return Centreline([Arc(PLACE, radius * turn, 1.0 / radius)])


def lead_in() -> Centreline:
    """A line and a half circle: the curvature jumps at the break."""
    return Centreline([Line(PLACE, 30.0), Arc(Placement(30.0 * X, X, Y), 20.0 * math.pi, 1.0 / 20.0)])


CURVES = {
    "helix": (Centreline([Helix.of_turns(15.0, 25.0, 1.5)]), 4.0),
    "gentle": (bend(300.0, 0.8), 2.0),
    "tight": (bend(10.0, 3.0), 9.0),
    "lead-in": (lead_in(), 3.0),
    "line": (Centreline([Line(PLACE, 50.0)]), 3.0),
}


def sampled(mesh: Mesh, n: int = 3) -> np.ndarray:
    """Points all over the triangles."""
    weights = np.array([(i, j, n - i - j) for i in range(n + 1) for j in range(n + 1 - i)]) / n
    return np.einsum("wk,tkc->twc", weights, mesh.vertices[mesh.triangles]).reshape(-1, 3)


def distance_to_side(centreline: Centreline, radius: float, points: np.ndarray) -> np.ndarray:
    """Of points near the side of a tube: refined from the nearest of many stations."""
    s = np.linspace(0.0, centreline.length, 4001)
    at = s[cKDTree(centreline.position(s)).query(points)[1]]
    for _ in range(3):
        frames = centreline.frames(at)
        at = np.clip(at + np.einsum("ni,ni->n", points - frames.position, frames.tangent), 0.0, centreline.length)
    return np.abs(np.linalg.norm(points - centreline.position(at), axis=1) - radius)


def volume(mesh: Mesh) -> float:
    a, b, c = np.moveaxis(mesh.vertices[mesh.triangles], 1, 0)
    return float(np.einsum("ni,ni->", a, np.cross(b, c)) / 6.0)


@pytest.mark.parametrize("name", CURVES)
def test_closed_and_outward(name):
    centreline, radius = CURVES[name]
    mesh = mesh_tube(centreline, radius).mesh
    _, same = np.unique(mesh.vertices, axis=0, return_inverse=True)
    triangles = same.ravel()[mesh.triangles]
    # Each side of a triangle meets its neighbour's once, and the other way round.
    sides = Counter(map(tuple, triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2).tolist()))
    assert set(sides.values()) == {1}
    assert all((b, a) in sides for a, b in sides)
    # Inscribed: a little less than pi r^2 L.
    assert 0.97 < volume(mesh) / (math.pi * radius**2 * centreline.length) < 1.0
    np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1.0, atol=1e-12)
    a, b, c = np.moveaxis(mesh.vertices[mesh.triangles], 1, 0)
    assert (np.einsum("ni,ni->n", np.cross(b - a, c - a), mesh.normals[mesh.triangles].mean(axis=1)) > 0.0).all()


@pytest.mark.parametrize("name", CURVES)
@pytest.mark.parametrize("share", [3e-2, 4e-3])
def test_keeps_the_tolerance_and_does_not_waste_it(name, share):
    centreline, radius = CURVES[name]
    tube = mesh_tube(centreline, radius, tolerance=share * radius)
    caps = 2 * len(tube.mesh.edges[0])
    side = Mesh(tube.mesh.vertices[:-caps], tube.mesh.normals[:-caps], tube.mesh.triangles[: -caps + 2])
    assert side.triangles.max() < len(side.vertices)
    deviation = distance_to_side(centreline, radius, sampled(side)).max()
    assert 0.15 * share * radius < deviation <= share * radius * (1.0 + 1e-9)
    # Vertices are on the exact side, under their own arclength.
    out = side.vertices - centreline.position(tube.arclengths[:-caps])
    np.testing.assert_allclose(np.linalg.norm(out, axis=1), radius, rtol=1e-12)


def test_default_tolerance_is_a_share_of_the_radius():
    centreline, radius = CURVES["helix"]
    chosen, asked = mesh_tube(centreline, radius), mesh_tube(centreline, radius, tolerance=TUBE_SHARE * radius)
    np.testing.assert_array_equal(chosen.mesh.vertices, asked.mesh.vertices)


def test_straight_pieces_need_no_stations_between_their_ends():
    tube = mesh_tube(lead_in(), 3.0)
    stations = np.unique(tube.arclengths)
    assert stations[0] == 0.0
    assert stations[1] == 30.0


def test_a_tube_scaled_has_a_mesh_scaled():
    small, large = (mesh_tube(bend(size * 40.0, 2.0), size * 3.0) for size in (1e-6, 1e6))
    np.testing.assert_array_equal(small.mesh.triangles, large.mesh.triangles)
    np.testing.assert_allclose(small.mesh.vertices * 1e12, large.mesh.vertices, rtol=1e-9, atol=1e-3)


@pytest.mark.parametrize("tolerance", [0.0, -1.0, math.nan, math.inf, 1e-16])
def test_tolerances_that_cannot_be(tolerance):
    with pytest.raises(UsageError, match=r"needs a positive tolerance|ask for a larger tolerance"):
        mesh_tube(bend(40.0, 2.0), 3.0, tolerance=tolerance)
