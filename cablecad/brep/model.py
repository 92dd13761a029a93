"""A scene as a tree of meshes with names and colours: what GLB, STL and pictures are made of.

The tree is that of the STEP file: ``name / parts / ...`` and ``name / cables / ...``. One geometry that occurs several
times is meshed once.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from cablecad.brep.document import CableSolid, Color, Document, Node, color_of, part_placement
from cablecad.brep.kernel import IndexedMap_TopoDS_Shape, subshapes
from cablecad.brep.tessellate import ShapeMesh, face_meshes, mesh_shape

# isort: split
from OCP.TopAbs import TopAbs_ShapeEnum
from OCP.TopLoc import TopLoc_Location

from cablecad.centreline import Array
from cablecad.errors import GeometryError
from cablecad.mesh import Mesh, mesh_tube
from cablecad.model import Part


@dataclass(frozen=True)
class Patch:
    """Triangles of one colour; None where none was given."""

    mesh: Mesh
    color: Color | None


@dataclass(frozen=True)
class MeshNode:
    """A thing where it occurs in the tree.

    Attributes:
        name: Of the occurrence.
        placement: Rotation and position in the parent, shape (3, 4) [mm].
        patches: Its own triangles; where one geometry occurs again, the same meshes.
        children: Of an assembly.
    """

    name: str
    placement: Array
    patches: tuple[Patch, ...] = ()
    children: tuple[MeshNode, ...] = ()

    def placed_patches(self, above: Array | None = None) -> Iterator[Patch]:
        """All triangles at and below this node, where they lie in the scene."""
        placement = self.placement if above is None else _joined(above, self.placement)
        for patch in self.patches:
            yield Patch(patch.mesh.placed(placement), patch.color)
        for child in self.children:
            yield from child.placed_patches(placement)


def mesh_scene(
    name: str,
    parts: Sequence[tuple[Part, Document]],
    cables: Sequence[CableSolid],
    *,
    tolerance: float | None = None,
) -> MeshNode:
    """Mesh a scene.

    Args:
        name: Of the scene.
        parts: Each with what `read_parts` read for it.
        cables: With their curves.
        tolerance: Bound on the distance between triangles and surfaces [mm]; by default a hundredth of each cable's
            radius and 1/2000 of each part's extent.

    Raises:
        GeometryError: Open Cascade failed, or a cable has no curve.
        UsageError: The tolerance is no positive number, or too small.
    """
    still = np.eye(3, 4)
    mesher = _Mesher(tolerance)
    groups = []
    if parts:
        groups.append(MeshNode("parts", still, children=tuple(mesher.part(*placed) for placed in parts)))
    if cables:
        groups.append(MeshNode("cables", still, children=tuple(mesher.cable(cable) for cable in cables)))
    return MeshNode(name, still, children=tuple(groups))


def mesh_parts(parts: Sequence[tuple[Part, Document]], *, tolerance: float | None = None) -> tuple[MeshNode, ...]:
    """Mesh parts alone, each at its place in the scene; arguments and errors as of `mesh_scene`."""
    mesher = _Mesher(tolerance)
    return tuple(mesher.part(*placed) for placed in parts)


class _Mesher:
    """Meshes each geometry once."""

    def __init__(self, tolerance: float | None) -> None:
        self.tolerance = tolerance
        self._shapes = IndexedMap_TopoDS_Shape()
        self._meshes: dict[int, ShapeMesh] = {}
        self._patches: dict[tuple[object, ...], tuple[Patch, ...]] = {}

    def cable(self, cable: CableSolid) -> MeshNode:
        """A cable, its vertices counted from its start, so that it keeps its digits far from the origin."""
        if cable.curve is None:
            raise GeometryError(f"cable {cable.name!r} has no centreline to mesh; build it first")
        tube = mesh_tube(cable.curve, cable.radius, tolerance=self.tolerance).mesh
        origin = cable.curve.frames(0.0).position[0]
        placement = np.column_stack([np.eye(3), origin])
        back = np.column_stack([np.eye(3), -origin])
        color = None if cable.color is None else color_of(cable.color)
        return MeshNode(cable.name, placement, (Patch(tube.placed(back), color),))

    def part(self, part: Part, document: Document) -> MeshNode:
        """A part; a file of one product gives the product's triangles the part's name."""
        roots = [self._node(root, None) for root in document.tree()]
        placement = part_placement(part)
        if len(roots) == 1:
            (root,) = roots
            return MeshNode(part.name, _joined(placement, root.placement), root.patches, root.children)
        return MeshNode(part.name, placement, children=tuple(roots))

    def _node(self, node: Node, inherited: Color | None) -> MeshNode:
        color = node.occurrence_color or node.color or inherited
        children = tuple(self._node(child, color) for child in node.children)
        patches = () if node.children else self._product(node, color)
        return MeshNode(node.occurrence or node.name, node.placement, patches, children)

    def _product(self, node: Node, color: Color | None) -> tuple[Patch, ...]:
        """The triangles of a product that is no assembly, parted by colour."""
        shape = node.shape.Located(TopLoc_Location())
        key = self._shapes.Add(shape)
        if key not in self._meshes:
            self._meshes[key] = mesh_shape(shape, tolerance=self.tolerance)
        known = (key, color, tuple(sorted(node.subshape_colors.items())))
        if known not in self._patches:
            self._patches[known] = tuple(self._colored(node, color, self._meshes[key]))
        return self._patches[known]

    def _colored(self, node: Node, color: Color | None, mesh: ShapeMesh) -> Iterator[Patch]:
        """A face is seen in its own colour, else in that of its shell or solid, else in its product's."""
        own = dict(node.subshape_colors)
        faces = subshapes(node.shape, TopAbs_ShapeEnum.TopAbs_FACE)
        colors: list[Color | None] = [color] * len(faces)
        wider = [(kind, shapes) for kind, shapes in _WIDER.items() if any(found == kind for found, _ in own)]
        for kind, shape_kind in wider:
            index = IndexedMap_TopoDS_Shape()
            for face in faces:
                index.Add(face)
            for i, body in enumerate(subshapes(node.shape, shape_kind)):
                if (kind, i) in own:
                    for face in subshapes(body, TopAbs_ShapeEnum.TopAbs_FACE):
                        colors[index.FindIndex(face) - 1] = own[kind, i]
        colors = [own.get(("face", i), color) for i, color in enumerate(colors)]
        groups: dict[Color | None, list[int]] = defaultdict(list)
        for i, face_color in enumerate(colors):
            if len(mesh.faces[i].triangles):
                groups[face_color].append(i)
        edges = mesh.edges
        for group_color, chosen in groups.items():
            found = face_meshes(mesh, chosen)
            # The edges are drawn once, with the first colour.
            yield Patch(Mesh(found.vertices, found.normals, found.triangles, edges), group_color)
            edges = ()


_WIDER = {"solid": TopAbs_ShapeEnum.TopAbs_SOLID, "shell": TopAbs_ShapeEnum.TopAbs_SHELL}


def _joined(outer: Array, inner: Array) -> Array:
    """First the inner, then the outer placement."""
    return np.column_stack([outer[:, :3] @ inner[:, :3], outer[:, :3] @ inner[:, 3] + outer[:, 3]])
