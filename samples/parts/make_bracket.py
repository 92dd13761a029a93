"""Makes bracket.step beside this file: a sheet folded up at one end, for the six connectors of the loom.

Its upper side is z = 0 and the inner side of its wall is x = -24, where connectors stand with their backs. Run with OCP
installed:
    python samples/parts/make_bracket.py
"""

from pathlib import Path

from OCP.BRep import BRep_Tool
from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut, BRepAlgoAPI_Fuse
from OCP.BRepFilletAPI import BRepFilletAPI_MakeFillet
from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox, BRepPrimAPI_MakeCylinder
from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt
from OCP.Quantity import Quantity_Color, Quantity_TypeOfColor
from OCP.ShapeUpgrade import ShapeUpgrade_UnifySameDomain
from OCP.STEPCAFControl import STEPCAFControl_Writer
from OCP.STEPControl import STEPControl_StepModelType
from OCP.TCollection import TCollection_ExtendedString
from OCP.TDataStd import TDataStd_Name
from OCP.TDocStd import TDocStd_Document
from OCP.TopAbs import TopAbs_ShapeEnum
from OCP.TopExp import TopExp_Explorer
from OCP.TopoDS import TopoDS
from OCP.XCAFApp import XCAFApp_Application
from OCP.XCAFDoc import XCAFDoc_ColorType, XCAFDoc_DocumentTool

SHEET = 4.0
"""Thickness [mm]."""


def box(x, y, z):
    return BRepPrimAPI_MakeBox(gp_Pnt(x[0], y[0], z[0]), gp_Pnt(x[1], y[1], z[1])).Shape()


def hole(at, along, radius):
    return BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(*at), gp_Dir(*along)), radius, 20.0).Shape()


def rounded(shape, chosen, radius):
    """Round the straight edges of which `chosen` takes both ends."""
    fillet = BRepFilletAPI_MakeFillet(shape)
    explorer, seen = TopExp_Explorer(shape, TopAbs_ShapeEnum.TopAbs_EDGE), []
    while explorer.More():
        edge = TopoDS.Edge(explorer.Current())
        ends = TopExp_Explorer(edge, TopAbs_ShapeEnum.TopAbs_VERTEX)
        points = []
        while ends.More():
            points.append(BRep_Tool.Pnt_s(TopoDS.Vertex(ends.Current())))
            ends.Next()
        if (
            len(points) == 2
            and chosen(*((p.X(), p.Y(), p.Z()) for p in points))
            and not any(edge.IsSame(e) for e in seen)
        ):
            seen.append(edge)
            fillet.Add(radius, edge)
        explorer.Next()
    return fillet.Shape()


foot, wall = box((-28, 214), (0, 100), (-SHEET, 0)), box((-28, -24), (0, 100), (-SHEET, 108))
unified = ShapeUpgrade_UnifySameDomain(BRepAlgoAPI_Fuse(foot, wall).Shape(), True, True, False)
unified.Build()
bracket = unified.Shape()
# The free corners of wall and foot; then the fold, outside and inside.
bracket = rounded(bracket, lambda a, b: a[2] == b[2] == 108.0 and a[1] == b[1], 14.0)
bracket = rounded(bracket, lambda a, b: a[0] == b[0] == 214.0 and a[1] == b[1], 14.0)
bracket = rounded(bracket, lambda a, b: a[2] == b[2] == -SHEET and a[0] == b[0] == -28.0, SHEET + 2.0)
bracket = rounded(bracket, lambda a, b: a[2] == b[2] == 0.0 and a[0] == b[0] == -24.0, 2.0)
for x, y in ((8.0, 12.0), (8.0, 88.0), (196.0, 88.0)):
    bracket = BRepAlgoAPI_Cut(bracket, hole((x, y, -10), (0, 0, 1), 3.2)).Shape()

document = TDocStd_Document(TCollection_ExtendedString("BinXCAF"))
XCAFApp_Application.GetApplication_s().InitDocument(document)
shapes = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
colors = XCAFDoc_DocumentTool.ColorTool_s(document.Main())
product = shapes.AddShape(bracket, False)
TDataStd_Name.Set_s(product, TCollection_ExtendedString("bracket"))
colors.SetColor(
    product,
    Quantity_Color(0.78, 0.80, 0.83, Quantity_TypeOfColor.Quantity_TOC_sRGB),
    XCAFDoc_ColorType.XCAFDoc_ColorSurf,
)

writer = STEPCAFControl_Writer()
writer.Transfer(document, STEPControl_StepModelType.STEPControl_AsIs)
writer.Write(str(Path(__file__).with_name("bracket.step")))
