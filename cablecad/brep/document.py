"""The tree of products Open Cascade keeps in memory (an XCAF document): built from parts and cables, read as `Node`s.

A product is a shape or an assembly of occurrences of products; an occurrence is a product's place in an assembly. Both
have a name and may have a colour; a product also has layers and colours of its faces. Lengths in mm.

Traps of XCAF from Python this module keeps to itself: `FindAttribute` of what is not there kills the process; a name
that was not given reads as "=>[0:1:1:1]"; labels must not outlive their document.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from cablecad.brep.kernel import IndexedMap_TopoDS_Shape, Sequence_TDF_Label, items_of

# isort: split
from OCP.BRep import BRep_Builder
from OCP.BRepBuilderAPI import BRepBuilderAPI_Copy
from OCP.gp import gp_Trsf
from OCP.Quantity import Quantity_Color, Quantity_ColorRGBA, Quantity_TypeOfColor
from OCP.TCollection import TCollection_ExtendedString
from OCP.TDataStd import TDataStd_Name
from OCP.TDF import TDF_ChildIterator, TDF_Label
from OCP.TDocStd import TDocStd_Document
from OCP.TopAbs import TopAbs_ShapeEnum
from OCP.TopExp import TopExp, TopExp_Explorer
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS_Compound, TopoDS_Shape
from OCP.XCAFApp import XCAFApp_Application
from OCP.XCAFDoc import XCAFDoc_ColorTool, XCAFDoc_ColorType, XCAFDoc_DocumentTool, XCAFDoc_Editor

from cablecad.brep.check import volume_of
from cablecad.brep.part21 import shielded
from cablecad.centreline import Curve
from cablecad.errors import GeometryError
from cablecad.model import Part

Color = tuple[float, float, float, float]
"""Red, green, blue in sRGB and opacity, each from 0 to 1."""

_UNNAMED = re.compile(r"(=>\[[\d:]*\])?\s*")  # what XCAF says of a name that was not given

# A face is seen in its surface colour; exporters that know only one colour give the general one.
_COLOR_TYPES = (
    XCAFDoc_ColorType.XCAFDoc_ColorSurf,
    XCAFDoc_ColorType.XCAFDoc_ColorGen,
    XCAFDoc_ColorType.XCAFDoc_ColorCurv,
)

_KINDS = {
    TopAbs_ShapeEnum.TopAbs_SOLID: "solid",
    TopAbs_ShapeEnum.TopAbs_SHELL: "shell",
    TopAbs_ShapeEnum.TopAbs_FACE: "face",
    TopAbs_ShapeEnum.TopAbs_EDGE: "edge",
}


@dataclass(frozen=True, eq=False)
class Node:
    """A product where it occurs in the tree.

    Attributes:
        name: Of the product.
        occurrence: Name of the occurrence; that of the product at a root.
        placement: Rotation and position in the parent, shape (3, 4) [mm]: x -> placement[:, :3] @ x + placement[:, 3].
        color: Of the product, or None.
        occurrence_color: Of the occurrence, where it overrides the product's, or None.
        subshape_colors: Kind of subshape and its index within `shape` (in the order of `kernel.subshapes`) to colour.
        layers: Names of the product's layers, sorted.
        shape: The product's shape in its own frame [mm]; of an assembly, a compound.
        children: Of an assembly.
    """

    name: str
    occurrence: str
    placement: NDArray[np.float64]
    color: Color | None
    occurrence_color: Color | None
    subshape_colors: dict[tuple[str, int], Color]
    layers: tuple[str, ...]
    shape: TopoDS_Shape
    children: tuple[Node, ...]

    @cached_property
    def volume(self) -> float:
        """[mm^3], to about 1e-9 of itself; see `volume_of`."""
        return volume_of(self.shape)

    def walk(self) -> Iterator[Node]:
        """This node and all below it, parents first."""
        yield self
        for child in self.children:
            yield from child.walk()


@dataclass(frozen=True, slots=True)
class CableSolid:
    """A cable as it goes into a file.

    Attributes:
        name: Of the cable.
        solid: At its place in the scene [mm].
        color: ``#rrggbb`` or ``#rrggbbaa``, or None.
        curve: Its centreline, for formats that hold triangles.
        radius: Of the cable [mm], likewise.
    """

    name: str
    solid: TopoDS_Shape
    color: str | None = None
    curve: Curve | None = None
    radius: float = 0.0


class Document:
    """A tree of products, with names, colours and layers.

    Attributes:
        name: What it is called where its root has no name.
        handle: Open Cascade's own object.
        warnings: What a file held that is not here.
    """

    def __init__(self, name: str) -> None:
        self.name = name
        self.warnings: tuple[str, ...] = ()
        self.handle = TDocStd_Document(TCollection_ExtendedString("BinXCAF"))
        XCAFApp_Application.GetApplication_s().InitDocument(self.handle)
        self._shapes = XCAFDoc_DocumentTool.ShapeTool_s(self.handle.Main())
        self._colors = XCAFDoc_DocumentTool.ColorTool_s(self.handle.Main())
        self._layers = XCAFDoc_DocumentTool.LayerTool_s(self.handle.Main())

    # --- reading ----------------------------------------------------------------------------------------------------

    @property
    def shape(self) -> TopoDS_Shape:
        """All there is in one shape, placed [mm]; a compound where there are several roots."""
        shapes = [self._shapes.GetShape_s(root) for root in self._roots()]
        if len(shapes) == 1:
            return shapes[0]
        compound, builder = TopoDS_Compound(), BRep_Builder()
        builder.MakeCompound(compound)
        for shape in shapes:
            builder.Add(compound, shape)
        return compound

    @property
    def solids(self) -> int:
        """How many solids there are, each occurrence counted."""
        count, explorer = 0, TopExp_Explorer(self.shape, TopAbs_ShapeEnum.TopAbs_SOLID)
        while explorer.More():
            count += 1
            explorer.Next()
        return count

    @property
    def is_empty(self) -> bool:
        """Whether there is no shape at all."""
        return all(_is_hollow(self._shapes.GetShape_s(root)) for root in self._roots())

    def hollow_products(self) -> list[str]:
        """Names of the products that are no assemblies and have no shape, sorted."""
        return sorted(
            _name(product)
            for product in self._products()
            if not self._shapes.IsAssembly_s(product) and _is_hollow(self._shapes.GetShape_s(product))
        )

    def tree(self) -> tuple[Node, ...]:
        """The roots, each with all below it."""
        return tuple(self._node(root, root, TopLoc_Location()) for root in self._roots())

    def _roots(self) -> list[TDF_Label]:
        roots = Sequence_TDF_Label()
        self._shapes.GetFreeShapes(roots)
        return items_of(roots)

    def _products(self) -> list[TDF_Label]:
        products = Sequence_TDF_Label()
        self._shapes.GetShapes(products)
        return items_of(products)

    def _node(self, occurrence: TDF_Label, product: TDF_Label, location: TopLoc_Location) -> Node:
        shape = self._shapes.GetShape_s(product)
        layers = Sequence_TDF_Label()
        self._layers.GetLayers(product, layers)
        return Node(
            name=_name(product),
            occurrence=_name(occurrence),
            placement=_matrix(location.Transformation()),
            color=_color(product),
            occurrence_color=None if occurrence is product else _color(occurrence),
            subshape_colors=dict(self._subshape_colors(product, shape)),
            layers=tuple(sorted(_name(layer) for layer in items_of(layers))),
            shape=shape,
            children=tuple(
                self._node(component, self._product(component), self._shapes.GetLocation_s(component))
                for component in self._components(product)
            ),
        )

    def _components(self, assembly: TDF_Label) -> list[TDF_Label]:
        components = Sequence_TDF_Label()
        self._shapes.GetComponents_s(assembly, components)
        return items_of(components)

    def _product(self, component: TDF_Label) -> TDF_Label:
        product = TDF_Label()
        self._shapes.GetReferredShape_s(component, product)
        return product

    def _subshape_colors(self, product: TDF_Label, shape: TopoDS_Shape) -> Iterator[tuple[tuple[str, int], Color]]:
        labels = Sequence_TDF_Label()
        self._shapes.GetSubShapes_s(product, labels)
        places: dict[TopAbs_ShapeEnum, IndexedMap_TopoDS_Shape] = {}
        for label in items_of(labels):
            color, subshape = _color(label), self._shapes.GetShape_s(label)
            kind = subshape.ShapeType()
            if color is None or kind not in _KINDS:
                continue
            if kind not in places:
                places[kind] = IndexedMap_TopoDS_Shape()
                TopExp.MapShapes_s(shape, kind, places[kind])
            yield (_KINDS[kind], places[kind].FindIndex(subshape) - 1), color

    # --- building ---------------------------------------------------------------------------------------------------

    @classmethod
    def assembled(cls, name: str, parts: Sequence[tuple[Part, Document]], cables: Sequence[CableSolid]) -> Document:
        """One tree of a scene: ``name / parts / ...`` and ``name / cables / ...``; a group without members is left out.

        A document that stands for several parts is taken over once and placed several times.

        Raises:
            GeometryError: A cable's solid is null.
        """
        document = cls(name)
        scene = document._assembly(name)
        products: dict[int, TDF_Label] = {}
        if parts:
            group = document._group(scene, "parts")
            for part, source in parts:
                if id(source) not in products:
                    products[id(source)] = document._adopt(source)
                document._place(group, products[id(source)], part.name, part_frame(part))
        document._shield_names()
        if cables:
            group = document._group(scene, "cables")
            taken = IndexedMap_TopoDS_Shape()
            for cable in cables:
                if cable.solid.IsNull():
                    raise GeometryError(f"cable {cable.name!r} has no solid to write; build it first")
                shape = cable.solid.Located(TopLoc_Location())  # its location is the occurrence's
                if taken.Contains(shape):  # one geometry is one product, and that has one name and one colour
                    shape = BRepBuilderAPI_Copy(shape).Shape()
                taken.Add(shape)
                product, name = document._shapes.AddShape(shape, False), shielded(cable.name)
                _set_name(product, name)
                if cable.color is not None:
                    document._colors.SetColor(product, _rgba(cable.color), XCAFDoc_ColorType.XCAFDoc_ColorSurf)
                document._place(group, product, name, cable.solid.Location())
        document._shapes.UpdateAssemblies()
        return document

    def _assembly(self, name: str) -> TDF_Label:
        label = self._shapes.NewShape()
        _set_name(label, name)
        return label

    def _group(self, scene: TDF_Label, name: str) -> TDF_Label:
        group = self._assembly(name)
        self._place(scene, group, name, TopLoc_Location())
        return group

    def _place(self, assembly: TDF_Label, product: TDF_Label, name: str, location: TopLoc_Location) -> None:
        _set_name(self._shapes.AddComponent(assembly, product, location), name)

    def _adopt(self, source: Document) -> TDF_Label:
        """Copy the labels of another document, not its shapes; several roots get an assembly around them."""
        taken = Sequence_TDF_Label()
        for root in source._roots():
            taken.Append(root)
        before = {product.Tag() for product in self._products()}
        XCAFDoc_Editor.Extract_s(taken, self._shapes.BaseLabel())
        self._name_missing([product for product in self._products() if product.Tag() not in before], source.name)
        roots = [root for root in self._roots() if root.Tag() not in before]
        if len(roots) == 1:
            return roots[0]
        assembly = self._assembly(source.name)
        for root in roots:
            self._place(assembly, root, _name(root), TopLoc_Location())
        return assembly

    def _name_missing(self, products: Sequence[TDF_Label], name: str) -> None:
        """Name products after occurrences of theirs, else by `name`, and occurrences after their products."""
        occurrences = [(c, self._product(c)) for product in products for c in self._components(product)]
        for occurrence, product in occurrences:
            if not _name(product) and _name(occurrence):
                _set_name(product, _name(occurrence))
        for product in products:
            if not _name(product):
                _set_name(product, name)
        for occurrence, product in occurrences:
            if not _name(occurrence):
                _set_name(occurrence, _name(product))

    def _shield_names(self) -> None:
        """Make every name that is given by now one that Open Cascade writes without loss."""
        labels = TDF_ChildIterator(self.handle.Main(), True)
        while labels.More():
            name = _name(labels.Value())
            if shielded(name) != name:
                _set_name(labels.Value(), shielded(name))
            labels.Next()


# --- single values --------------------------------------------------------------------------------------------------


def _is_hollow(shape: TopoDS_Shape) -> bool:
    """Whether there is neither a face (which may be a mere mesh) nor a vertex."""
    kinds = (TopAbs_ShapeEnum.TopAbs_FACE, TopAbs_ShapeEnum.TopAbs_VERTEX)
    return shape.IsNull() or not any(TopExp_Explorer(shape, kind).More() for kind in kinds)


def _name(label: TDF_Label) -> str:
    """A label's name; empty where it has none."""
    if not label.IsAttribute(TDataStd_Name.GetID_s()):
        return ""
    attribute = TDataStd_Name()
    label.FindAttribute(TDataStd_Name.GetID_s(), attribute)
    name = str(attribute.Get().ToExtString())
    return "" if _UNNAMED.fullmatch(name) else name


def _set_name(label: TDF_Label, name: str) -> None:
    # True: the text is UTF-8, as everything from Python; without it only ASCII arrives whole.
    TDataStd_Name.Set_s(label, TCollection_ExtendedString(name, True))


def _color(label: TDF_Label) -> Color | None:
    color = Quantity_ColorRGBA()
    for kind in _COLOR_TYPES:
        if XCAFDoc_ColorTool.GetColor_s(label, kind, color):
            red, green, blue = color.GetRGB().Values(Quantity_TypeOfColor.Quantity_TOC_sRGB)
            return float(red), float(green), float(blue), float(color.Alpha())
    return None


def color_of(text: str) -> Color:
    """The colour that ``#rrggbb`` or ``#rrggbbaa`` writes."""
    red, green, blue, alpha = (value / 255.0 for value in bytes.fromhex(f"{text[1:]:f<8}"))
    return red, green, blue, alpha


def _rgba(text: str) -> Quantity_ColorRGBA:
    red, green, blue, alpha = color_of(text)
    return Quantity_ColorRGBA(Quantity_Color(red, green, blue, Quantity_TypeOfColor.Quantity_TOC_sRGB), alpha)


def _matrix(transformation: gp_Trsf) -> NDArray[np.float64]:
    return np.array([[transformation.Value(row, column) for column in range(1, 5)] for row in range(1, 4)])


def part_placement(part: Part) -> NDArray[np.float64]:
    """Rotation and position of a part, shape (3, 4) [mm]."""
    return np.column_stack([part.rotation.rows, part.position])


def part_frame(part: Part) -> TopLoc_Location:
    """Where a part is placed in its scene."""
    return frame_of(part_placement(part))


def frame_of(placement: NDArray[np.float64]) -> TopLoc_Location:
    """The frame of a placement, shape (3, 4) [mm]: x -> placement[:, :3] @ x + placement[:, 3]."""
    transformation = gp_Trsf()
    transformation.SetValues(*placement.ravel().tolist())
    return TopLoc_Location(transformation)
