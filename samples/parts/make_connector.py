"""Makes connector.step beside this file: a housing with a bore, and a gasket, as any CAD package would export them.

The bore's mouth is at the origin and its axis points along +X, out of the connector. Run with OCP installed:
    python samples/parts/make_connector.py
"""

from pathlib import Path

from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut
from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox, BRepPrimAPI_MakeCylinder
from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt
from OCP.Quantity import Quantity_Color, Quantity_TypeOfColor
from OCP.STEPCAFControl import STEPCAFControl_Writer
from OCP.STEPControl import STEPControl_StepModelType
from OCP.TCollection import TCollection_ExtendedString
from OCP.TDataStd import TDataStd_Name
from OCP.TDocStd import TDocStd_Document
from OCP.TopLoc import TopLoc_Location
from OCP.XCAFApp import XCAFApp_Application
from OCP.XCAFDoc import XCAFDoc_ColorType, XCAFDoc_DocumentTool


def cylinder(start, radius, length):
    return BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(start, 0, 0), gp_Dir(1, 0, 0)), radius, length).Shape()


def cut(shape, tool):
    return BRepAlgoAPI_Cut(shape, tool).Shape()


block = BRepPrimAPI_MakeBox(gp_Pnt(-24, -8, -8), 24, 16, 16).Shape()
housing = cut(cut(block, cylinder(-16, 2.2, 20)), cylinder(-3, 5.0, 4))
gasket = cut(cylinder(-3, 5.0, 2), cylinder(-4, 2.2, 6))

document = TDocStd_Document(TCollection_ExtendedString("BinXCAF"))
XCAFApp_Application.GetApplication_s().InitDocument(document)
shapes = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
colors = XCAFDoc_DocumentTool.ColorTool_s(document.Main())
connector = shapes.NewShape()
TDataStd_Name.Set_s(connector, TCollection_ExtendedString("connector"))
for name, shape, rgb in (("housing", housing, (0.20, 0.22, 0.25)), ("gasket", gasket, (0.85, 0.45, 0.10))):
    product = shapes.AddShape(shape, False)
    TDataStd_Name.Set_s(product, TCollection_ExtendedString(name))
    color = Quantity_Color(*rgb, Quantity_TypeOfColor.Quantity_TOC_sRGB)
    colors.SetColor(product, color, XCAFDoc_ColorType.XCAFDoc_ColorSurf)
    component = shapes.AddComponent(connector, product, TopLoc_Location())
    TDataStd_Name.Set_s(component, TCollection_ExtendedString(name))
shapes.UpdateAssemblies()

writer = STEPCAFControl_Writer()
writer.Transfer(document, STEPControl_StepModelType.STEPControl_AsIs)
writer.Write(str(Path(__file__).with_name("connector.step")))
