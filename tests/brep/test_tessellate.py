"""Meshes of parts: their faces, and which of their edges are drawn."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cablecad.brep.tessellate import SHARE, mesh_shape
from cablecad.mesh import merged


def box(x, y, z):
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox

    return BRepPrimAPI_MakeBox(x, y, z).Solid()


def cylinder(radius, height):
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeCylinder

    return BRepPrimAPI_MakeCylinder(radius, height).Solid()


def rounded_box():
    """With one upright edge rounded: its fillet meets both walls smoothly."""
    from OCP.BRepFilletAPI import BRepFilletAPI_MakeFillet
    from OCP.TopAbs import TopAbs_ShapeEnum

    from cablecad.brep.kernel import TopoDS, subshapes

    shape = box(30.0, 20.0, 10.0)
    fillet = BRepFilletAPI_MakeFillet(shape)
    fillet.Add(5.0, TopoDS.Edge(subshapes(shape, TopAbs_ShapeEnum.TopAbs_EDGE)[0]))
    return fillet.Shape()


def areas(mesh):
    a, b, c = np.moveaxis(mesh.vertices[mesh.triangles], 1, 0)
    return np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2.0


def test_box_face_by_face():
    mesh = mesh_shape(box(30.0, 20.0, 10.0))
    assert [round(float(areas(face).sum()), 9) for face in mesh.faces] == [200, 200, 300, 300, 600, 600]
    assert len(mesh.edges) == 12
    whole = merged(list(mesh.faces))
    middle = whole.vertices[whole.triangles].mean(axis=1) - [15.0, 10.0, 5.0]
    assert (np.einsum("ni,ni->n", middle, whole.normals[whole.triangles[:, 0]]) > 0.0).all()


@pytest.mark.parametrize("tolerance", [None, 0.5, 0.01])
def test_cylinder_keeps_the_tolerance(tolerance):
    mesh = mesh_shape(cylinder(10.0, 25.0), tolerance=tolerance)
    side = max(mesh.faces, key=lambda face: areas(face).sum())
    middles = side.vertices[side.triangles].mean(axis=1)
    corners = (side.vertices[side.triangles] + side.vertices[np.roll(side.triangles, 1, axis=1)]).reshape(-1, 3) / 2.0
    deviation = 10.0 - min(np.hypot(*points[:, :2].T).min() for points in (middles, corners))
    assert 0.0 < deviation <= (SHARE * 25.0 if tolerance is None else tolerance) * 1.05
    outward = side.vertices * [0.1, 0.1, 0.0]
    np.testing.assert_allclose(side.normals, outward, atol=1e-9)


def test_a_finer_mesh_after_a_coarse_one_and_the_other_way_round():
    shape = cylinder(10.0, 25.0)
    counts = [sum(len(f.triangles) for f in mesh_shape(shape, tolerance=t).faces) for t in (0.5, 0.01, 0.5)]
    assert counts[0] == counts[2] < counts[1]


def test_edges_drawn_are_those_where_faces_meet_at_an_angle():
    rims = mesh_shape(cylinder(10.0, 25.0)).edges  # not the seam
    assert len(rims) == 2
    for rim in rims:
        np.testing.assert_allclose(np.hypot(*rim[:, :2].T), 10.0, atol=1e-9)
        assert np.ptp(rim[:, 2]) == 0.0
    # 15 edges, of which the fillet's two straight ones are smooth.
    edges = mesh_shape(rounded_box()).edges
    assert len(edges) == 13


def test_an_open_shell_shows_where_it_ends():
    from OCP.TopAbs import TopAbs_ShapeEnum

    from cablecad.brep.kernel import subshapes

    face = subshapes(box(30.0, 20.0, 10.0), TopAbs_ShapeEnum.TopAbs_FACE)[0]
    assert len(mesh_shape(face).edges) == 4


def test_a_ball_has_no_vertices_to_tell_its_size():
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeSphere

    (face,) = mesh_shape(BRepPrimAPI_MakeSphere(10.0).Solid()).faces
    assert float(areas(face).sum()) == pytest.approx(4.0 * math.pi * 100.0, rel=0.01)
    assert len(face.triangles) > 300
