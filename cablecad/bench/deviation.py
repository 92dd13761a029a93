"""How far a solid's side lies from the exact tube, measured on the solid, whoever made it.

The exact centreline is mpmath's, 1025 points with tangent and curvature, between them a quintic Hermite polynomial
(its error is below 1e-12 of the length). The side is sampled on a grid; of each sample the nearest point of the
centreline is sought near the same share of its length, so that a tube which crosses itself is measured too.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.GeomAbs import GeomAbs_SurfaceType
from OCP.TopAbs import TopAbs_ShapeEnum
from OCP.TopoDS import TopoDS, TopoDS_Shape

from cablecad.bench.truth import ArchTruth, Array
from cablecad.brep.kernel import subshapes

AROUND, ALONG = 13, 601
_NEWTON_STEPS = 6
_REACH = 0.1
"""Share of the length around the expected place in which the nearest point is sought."""


class Side(NamedTuple):
    """What a solid's side is: greatest sampled deviation [mm], and the number of poles of its surfaces."""

    deviation: float
    poles: int


def measure_side(solid: TopoDS_Shape, truth: ArchTruth, radius: float) -> Side:
    """Measure the side faces of a tube along a wave of the elastica in the plane of x and y.

    A solid without side faces is infinitely far off.
    """
    worst, poles = 0.0, 0
    faces = [BRepAdaptor_Surface(TopoDS.Face(face)) for face in subshapes(solid, TopAbs_ShapeEnum.TopAbs_FACE)]
    sides = [face for face in faces if face.GetType() != GeomAbs_SurfaceType.GeomAbs_Plane]
    for side in sides:
        share = np.linspace(0.0, 1.0, ALONG)
        u = np.linspace(side.FirstUParameter(), side.LastUParameter(), AROUND).tolist()
        v = (side.FirstVParameter() + (side.LastVParameter() - side.FirstVParameter()) * share).tolist()
        points = np.array([[_place(side, a, b) for b in v] for a in u])
        # One face goes along the whole centreline; several need a wider look.
        reach = _REACH if len(sides) == 1 else 1.0
        distance = _distances(points, truth, np.broadcast_to(share, (AROUND, ALONG)), reach)
        worst = max(worst, float(np.abs(distance - radius).max()))
        if side.GetType() == GeomAbs_SurfaceType.GeomAbs_BSplineSurface:
            poles += side.NbUPoles() * side.NbVPoles()
    return Side(worst if sides else float("inf"), poles)


def _place(side: BRepAdaptor_Surface, u: float, v: float) -> tuple[float, float, float]:
    point = side.Value(u, v)
    return point.X(), point.Y(), point.Z()


def _distances(points: Array, truth: ArchTruth, share: Array, reach: float) -> Array:
    """Distances of points, shape (k, n, 3), from the centreline near the given shares of its length."""
    flat, near = points.reshape(-1, 3), share.ravel()
    last = len(truth.s) - 1
    steps = np.arange(-round(reach * last), round(reach * last) + 1)
    nearest = np.empty(len(flat), dtype=int)
    for rows in np.array_split(np.arange(len(flat)), max(1, len(flat) * len(steps) // 2_000_000)):
        candidates = np.clip(np.rint(near[rows] * last).astype(int)[:, None] + steps, 0, last)
        off = truth.place[candidates] - flat[rows, None, :2]
        best = np.argmin((off**2).sum(axis=2), axis=1)
        nearest[rows] = candidates[np.arange(len(rows)), best]
    s = truth.s[nearest]
    for _ in range(_NEWTON_STEPS):
        place, tangent, bend = _curve(truth, s)
        gap = flat[:, :2] - place
        slope = np.maximum(1.0 - (gap * bend).sum(axis=1), 0.1)  # a point within the radius of curvature
        s = np.clip(s + (gap * tangent).sum(axis=1) / slope, 0.0, truth.length)
    place = _curve(truth, s)[0]
    distance: Array = np.sqrt(((flat[:, :2] - place) ** 2).sum(axis=1) + flat[:, 2] ** 2)
    return distance.reshape(share.shape)


def _curve(truth: ArchTruth, s: Array) -> tuple[Array, Array, Array]:
    """Place, tangent and second derivative of the quintic Hermite interpolant at arclengths, shape (n, 2) each."""
    h = truth.s[1] - truth.s[0]
    i = np.minimum((s / h).astype(int), len(truth.s) - 2)
    t = (s - truth.s[i])[:, None] / h
    direction = np.stack([np.cos(truth.angle), np.sin(truth.angle)], axis=1)
    turned = np.stack([-direction[:, 1], direction[:, 0]], axis=1) * truth.kappa[:, None]
    p0, p1 = truth.place[i], truth.place[i + 1]
    v0, v1 = h * direction[i], h * direction[i + 1]
    a0, a1 = h * h * turned[i], h * h * turned[i + 1]
    rest, speed, bend = p1 - p0 - v0 - a0 / 2.0, v1 - v0 - a0, a1 - a0
    c3, c4, c5 = 10 * rest - 4 * speed + bend / 2, -15 * rest + 7 * speed - bend, 6 * rest - 3 * speed + bend / 2
    place = p0 + t * (v0 + t * (a0 / 2.0 + t * (c3 + t * (c4 + t * c5))))
    first = v0 + t * (a0 + t * (3.0 * c3 + t * (4.0 * c4 + t * 5.0 * c5)))
    second = a0 + t * (6.0 * c3 + t * (12.0 * c4 + t * 20.0 * c5))
    return place, first / h, second / h**2
