"""Triangles of any shape, by Open Cascade's mesher: for the rigid parts beside the cables.

Cables have a mesher of their own (`cablecad.mesh`), which is exact along the tube and closed at its seam.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cablecad.brep.kernel import IndexedMap_TopoDS_Shape, TopoDS, occ_errors, silence, subshapes

# isort: split
from OCP.BRep import BRep_Tool
from OCP.BRepLib import BRepLib_ToolTriangulatedShape
from OCP.BRepMesh import BRepMesh_IncrementalMesh
from OCP.BRepTools import BRepTools
from OCP.Poly import Poly_PolygonOnTriangulation, Poly_Triangulation
from OCP.TopAbs import TopAbs_Orientation, TopAbs_ShapeEnum
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS_Face, TopoDS_Shape

from cablecad.centreline import Array
from cablecad.errors import GeometryError
from cablecad.mesh import Mesh, merged

SHARE = 5e-4
"""Default chordal tolerance of a part as a share of its greatest extent: a circle as wide as it gets 70 corners."""

_ANGLE = math.radians(15.0)
"""The most the surface turns from one triangle to the next, so that small holes are round too."""

_CREASE = math.cos(math.radians(12.0))
"""Where faces meet at a sharper angle than 12 degrees there is an edge to be drawn; below that they run on smoothly."""

_REMEDY = "check the part's STEP file in the CAD package it came from, or leave the part out"


@dataclass(frozen=True)
class ShapeMesh:
    """The mesh of a shape, face by face.

    Attributes:
        faces: A mesh for each face, in the order of `kernel.subshapes`; without edges.
        edges: Polylines where faces meet at an angle or end, shape (k, 3) each [mm].
    """

    faces: tuple[Mesh, ...]
    edges: tuple[Array, ...]


def mesh_shape(shape: TopoDS_Shape, *, tolerance: float | None = None) -> ShapeMesh:
    """Mesh the faces of a shape.

    Args:
        shape: Any; its own coordinates are kept.
        tolerance: Bound asked of Open Cascade on the distance between triangles and faces [mm]; by default 1/2000 of
            the shape's greatest extent.

    Raises:
        GeometryError: Open Cascade failed.
    """
    with silence(), occ_errors(GeometryError, "meshing a part", _REMEDY):
        BRepTools.Clean_s(shape)  # an older, coarser or finer mesh would be taken as it is
        if tolerance is None:
            tolerance = SHARE * _extent(shape)
        if tolerance > 0.0:
            BRepMesh_IncrementalMesh(shape, tolerance, False, _ANGLE, False)
        faces = [TopoDS.Face(face) for face in subshapes(shape, TopAbs_ShapeEnum.TopAbs_FACE)]
        meshes = tuple(_face_mesh(face) for face in faces)
        return ShapeMesh(meshes, tuple(_sharp_edges(faces, meshes)))


def _extent(shape: TopoDS_Shape) -> float:
    """The greatest side of the box around a shape's vertices [mm]; of its circles at least half is seen by it."""
    points = [BRep_Tool.Pnt_s(TopoDS.Vertex(vertex)) for vertex in subshapes(shape, TopAbs_ShapeEnum.TopAbs_VERTEX)]
    if len(points) < 2:  # a ball or a ring has no size that vertices could tell
        from OCP.Bnd import Bnd_Box
        from OCP.BRepBndLib import BRepBndLib

        box = Bnd_Box()
        BRepBndLib.Add_s(shape, box, False)
        return 0.0 if box.IsVoid() else math.sqrt(box.SquareExtent())
    corners = np.array([[point.X(), point.Y(), point.Z()] for point in points])
    return float(np.ptp(corners, axis=0).max())


def _face_mesh(face: TopoDS_Face) -> Mesh:
    location = TopLoc_Location()
    triangulation = BRep_Tool.Triangulation_s(face, location)
    if triangulation is None or triangulation.NbTriangles() == 0:
        return Mesh(np.empty((0, 3)), np.empty((0, 3)), np.empty((0, 3), dtype=np.intp))
    BRepLib_ToolTriangulatedShape.ComputeNormals_s(face, triangulation)
    count = triangulation.NbNodes()
    vertices, normals = np.empty((count, 3)), np.empty((count, 3))
    for i in range(count):
        point, normal = triangulation.Node(i + 1), triangulation.Normal(i + 1)
        vertices[i] = point.X(), point.Y(), point.Z()
        normals[i] = normal.X(), normal.Y(), normal.Z()
    triangles = np.array(
        [triangulation.Triangle(i + 1).Get() for i in range(triangulation.NbTriangles())], dtype=np.intp
    ).reshape(-1, 3)
    triangles -= 1
    if face.Orientation() == TopAbs_Orientation.TopAbs_REVERSED:
        triangles, normals = triangles[:, ::-1], -normals
    mesh = Mesh(vertices, normals, triangles)
    return mesh if location.IsIdentity() else mesh.placed(_matrix(location))


def _matrix(location: TopLoc_Location) -> Array:
    transformation = location.Transformation()
    return np.array([[transformation.Value(i, j) for j in range(1, 5)] for i in range(1, 4)])


def _sharp_edges(faces: list[TopoDS_Face], meshes: tuple[Mesh, ...]) -> Iterator[Array]:
    """The edges to be drawn: where two faces meet at an angle, and where one ends."""
    places = IndexedMap_TopoDS_Shape()
    met: Mapping[int, list[tuple[Array, Array]]] = defaultdict(list)
    for face, mesh in zip(faces, meshes, strict=True):
        location = TopLoc_Location()
        triangulation = BRep_Tool.Triangulation_s(face, location)
        if triangulation is None or not len(mesh.triangles):
            continue
        for edge in subshapes(face, TopAbs_ShapeEnum.TopAbs_EDGE):
            seam = BRep_Tool.IsClosed_s(TopoDS.Edge(edge), face)
            nodes = None if seam else _edge_nodes(edge, triangulation, location)
            if nodes is not None:
                met[places.Add(edge)].append((mesh.vertices[nodes], mesh.normals[nodes]))
    for sides in met.values():
        (line, normals), *others = sides
        if len(others) == 1 and len(others[0][0]) == len(line):
            other = others[0][1]
            if np.linalg.norm(others[0][0][0] - line[0]) > np.linalg.norm(others[0][0][-1] - line[0]):
                other = other[::-1]
            if np.einsum("ni,ni->n", normals, other).min() > _CREASE:
                continue
        yield line


def _edge_nodes(
    edge: TopoDS_Shape, triangulation: Poly_Triangulation, location: TopLoc_Location
) -> NDArray[np.intp] | None:
    """Numbers of the nodes along an edge; None of one that has none in this face."""
    polygon: Poly_PolygonOnTriangulation | None = BRep_Tool.PolygonOnTriangulation_s(
        TopoDS.Edge(edge), triangulation, location
    )
    if polygon is None:
        return None
    return np.array([polygon.Node(i + 1) - 1 for i in range(polygon.NbNodes())], dtype=np.intp)


def face_meshes(mesh: ShapeMesh, chosen: list[int]) -> Mesh:
    """Some faces as one mesh; without edges."""
    return merged([mesh.faces[i] for i in chosen])
