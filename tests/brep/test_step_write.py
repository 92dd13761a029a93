"""STEP files out: there and back, the same tree; and the same bytes wherever it is written."""

import hashlib
import math
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from binary_geometry import surface_of
from scipy.spatial.transform import Rotation as Turn

from cablecad.brep.binary import KnotVector, spline_surface
from cablecad.brep.document import Document
from cablecad.brep.kernel import (
    TopoDS,
    interface_settings,
    silence,
    subshapes,
)
from cablecad.brep.part21 import flaw
from cablecad.brep.step import CableSolid, read_parts, read_tree, step_text, write_step
from cablecad.errors import ExchangeError, GeometryError, UsageError
from cablecad.model import Part, Rotation

DATA = Path(__file__).parents[1] / "data"
AS1 = DATA / "as1-oc-214.stp"
IO1 = DATA / "io1-cm-214.stp"
HERE = np.eye(3, 4)


def box(x, y, z):
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox

    return BRepPrimAPI_MakeBox(x, y, z).Solid()


def cylinder(radius, height):
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeCylinder

    return BRepPrimAPI_MakeCylinder(radius, height).Solid()


def moved(shape, x, y, z):
    from OCP.gp import gp_Trsf, gp_Vec
    from OCP.TopLoc import TopLoc_Location

    transformation = gp_Trsf()
    transformation.SetTranslation(gp_Vec(x, y, z))
    return shape.Moved(TopLoc_Location(transformation))


def write_plain(path, shapes, unit="MM"):
    """A file by Open Cascade's plain writer: a root for each shape, no names given."""
    from OCP.STEPControl import STEPControl_StepModelType, STEPControl_Writer

    with silence(), interface_settings({"write.step.unit": unit}):
        writer = STEPControl_Writer()
        for shape in shapes:
            writer.Transfer(shape, STEPControl_StepModelType.STEPControl_AsIs)
        writer.Write(str(path))
    return path


def there_and_back(folder, parts, cables, name="scene"):
    """The tree of what is written, less its root and groups: parts and cables by name."""
    path = folder / "out.step"
    write_step(path, name, read_parts(parts), cables)
    (root,) = read_tree(path)
    assert (root.name, root.occurrence) == (name, name)
    groups = {group.occurrence: group for group in root.children}
    assert list(groups) == [group for group, members in (("parts", parts), ("cables", cables)) if members]
    for group in groups.values():
        assert group.name == group.occurrence
        np.testing.assert_array_equal(group.placement, HERE)
    return {node.occurrence: node for group in groups.values() for node in group.children}


def assert_same_tree(one, other, *, root=True):
    """Equal in everything; of the roots, occurrence and placement may differ."""
    assert one.name == other.name
    if not root:
        assert one.occurrence == other.occurrence
        np.testing.assert_allclose(one.placement, other.placement, rtol=0, atol=1e-12)
        assert_same_color(one.occurrence_color, other.occurrence_color)
    assert_same_color(one.color, other.color)
    assert one.subshape_colors.keys() == other.subshape_colors.keys()
    for place, color in one.subshape_colors.items():
        assert_same_color(color, other.subshape_colors[place])
    assert one.layers == other.layers
    assert one.volume == pytest.approx(other.volume, rel=1e-12)
    assert len(one.children) == len(other.children)
    for child, its in zip(one.children, other.children, strict=True):
        assert_same_tree(child, its, root=False)


def assert_same_color(one, other):
    assert (one is None) == (other is None)
    if one is not None:
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-6)


# --- there and back -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("source", [AS1, IO1], ids=["assembly", "single solid"])
def test_part_comes_back_as_it_was(tmp_path, source):
    part = Part("plate", source, (10.0, -20.0, 0.1), Rotation((1.0, 2.0, 3.0), 33.0))
    back = there_and_back(tmp_path, [part], [])["plate"]
    (before,) = read_tree(source)
    assert_same_tree(before, back)


def test_colours_of_occurrences_faces_and_prototypes_come_back(tmp_path):
    """A file with every kind of colour and layer, as Open Cascade writes it."""
    source = colored_file(tmp_path / "colored.stp")
    (before,) = read_tree(source)
    shown = {node.occurrence: node for node in before.walk()}
    np.testing.assert_allclose(shown["b2"].occurrence_color, (0.0, 1.0, 0.0, 0.25), atol=1e-6)
    np.testing.assert_allclose(shown["b2"].color, (0.2, 0.4, 0.5, 0.5), atol=1e-6)
    np.testing.assert_allclose(next(iter(shown["b1"].subshape_colors.values())), (0.7, 0.6, 0.1, 0.75), atol=1e-6)
    assert shown["b1"].layers == ("layer Ж",)
    back = there_and_back(tmp_path, [Part("p", source)], [])["p"]
    assert_same_tree(before, back)


def colored_file(path):
    from OCP.Quantity import Quantity_Color, Quantity_ColorRGBA, Quantity_TypeOfColor
    from OCP.STEPCAFControl import STEPCAFControl_Writer
    from OCP.TCollection import TCollection_ExtendedString
    from OCP.TDataStd import TDataStd_Name
    from OCP.TDocStd import TDocStd_Document
    from OCP.TopAbs import TopAbs_ShapeEnum
    from OCP.XCAFApp import XCAFApp_Application
    from OCP.XCAFDoc import XCAFDoc_ColorType, XCAFDoc_DocumentTool

    document = TDocStd_Document(TCollection_ExtendedString("BinXCAF"))
    XCAFApp_Application.GetApplication_s().InitDocument(document)
    shapes = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
    palette = XCAFDoc_DocumentTool.ColorTool_s(document.Main())

    def named(label, name):
        TDataStd_Name.Set_s(label, TCollection_ExtendedString(name, True))
        return label

    def paint(label, red, green, blue, alpha):
        color = Quantity_ColorRGBA(Quantity_Color(red, green, blue, Quantity_TypeOfColor.Quantity_TOC_sRGB), alpha)
        palette.SetColor(label, color, XCAFDoc_ColorType.XCAFDoc_ColorSurf)

    root, solid = named(shapes.NewShape(), "root"), box(1.0, 2.0, 3.0)
    product = named(shapes.AddShape(solid, False), "box")
    for name, x in (("b1", 0.0), ("b2", 5.0)):
        label = named(shapes.AddComponent(root, product, moved(solid, x, 0.0, 0.0).Location()), name)
    paint(label, 0.0, 1.0, 0.0, 0.25)
    paint(product, 0.2, 0.4, 0.5, 0.5)
    paint(shapes.AddSubShape(product, subshapes(solid, TopAbs_ShapeEnum.TopAbs_FACE)[4]), 0.7, 0.6, 0.1, 0.75)
    layers = XCAFDoc_DocumentTool.LayerTool_s(document.Main())
    layers.SetLayer(product, TCollection_ExtendedString("layer Ж", True))
    shapes.UpdateAssemblies()
    with silence():
        writer = STEPCAFControl_Writer()
        writer.Transfer(document)
        writer.Write(str(path))
    return path


@pytest.mark.parametrize(
    ("axis", "angle_deg"),
    [
        ((0, 0, 1), 0.0),
        ((0, 0, 1), 90.0),
        ((0, -2, 0), 180.0),
        ((1, 0, 0), -450.0),
        ((1, 2, 3), 33.3),
        ((1, 1, 0), 1e-4),
    ],
)
def test_point_x_of_a_part_goes_to_rotation_x_plus_position(tmp_path, axis, angle_deg):
    position = (1000.0 / 3.0, -0.1, 1e4 / 7.0)
    back = there_and_back(tmp_path, [Part("p", IO1, position, Rotation(axis, angle_deg))], [])["p"]
    turn = Turn.from_rotvec(np.radians(angle_deg) * np.array(axis) / np.linalg.norm(axis)).as_matrix()
    np.testing.assert_allclose(back.placement[:, :3], turn, rtol=0, atol=1e-15)
    np.testing.assert_allclose(back.placement[:, 3], position, rtol=0, atol=1e-12)
    if angle_deg % 90.0 == 0.0:
        assert set(np.abs(back.placement[:, :3]).ravel()) == {0.0, 1.0}  # quarter turns are exact


def test_cables_come_back(tmp_path):
    from OCP.BRepCheck import BRepCheck_Analyzer

    cables = [
        CableSolid("W1", cylinder(2.0, 350.0), "#2b6cb080"),
        CableSolid("W2", moved(cylinder(1.0, 10.0), 1.0, 2.0, 3.0), "#FF8000"),
        CableSolid("W3", cylinder(3.0, 10.0)),
    ]
    back = there_and_back(tmp_path, [], cables)
    assert list(back) == ["W1", "W2", "W3"]
    assert [node.name for node in back.values()] == ["W1", "W2", "W3"]
    assert_same_color(back["W1"].color, (0x2B / 255, 0x6C / 255, 0xB0 / 255, 0x80 / 255))
    assert_same_color(back["W2"].color, (1.0, 0x80 / 255, 0.0, 1.0))
    assert back["W3"].color is None
    assert [node.volume / math.pi for node in back.values()] == pytest.approx([1400.0, 10.0, 90.0], rel=1e-12)
    np.testing.assert_allclose(back["W2"].placement[:, 3], (1.0, 2.0, 3.0), rtol=0, atol=1e-15)
    for node in back.values():
        assert BRepCheck_Analyzer(node.shape).IsValid()


def test_one_solid_given_to_several_cables(tmp_path):
    solid = cylinder(1.0, 10.0)
    cables = [
        CableSolid("a", solid, "#ff0000"),
        CableSolid("b", moved(solid, 5, 0, 0), "#0000ff"),
        CableSolid("c", solid),
    ]
    back = there_and_back(tmp_path, [], cables)
    assert [(node.occurrence, node.name) for node in back.values()] == [("a", "a"), ("b", "b"), ("c", "c")]
    assert_same_color(back["a"].color, (1, 0, 0, 1))
    assert_same_color(back["b"].color, (0, 0, 1, 1))
    assert back["c"].color is None
    np.testing.assert_array_equal(back["b"].placement[:, 3], (5.0, 0.0, 0.0))


def test_splines_come_back_to_the_last_bit(tmp_path):
    from OCP.BRep import BRep_Tool
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
    from OCP.TopAbs import TopAbs_ShapeEnum

    chance = np.random.default_rng(5)
    x, y = np.meshgrid(np.arange(6.0), np.arange(5.0), indexing="ij")
    poles = np.stack([x, y, np.zeros_like(x)], axis=-1) * 1e3 + chance.normal(size=(6, 5, 3)) * 10.0 ** -np.arange(3)
    u_knots, v_knots = [0.0, 1.0 / 3.0, 0.7, 1.0], [0.0, math.pi, 10.0]
    u, v = KnotVector(3, u_knots, [4, 1, 1, 4]), KnotVector(3, v_knots, [4, 1, 4])
    surface = surface_of(spline_surface(poles, 1.0, u, v))
    back = there_and_back(tmp_path, [], [CableSolid("W1", BRepBuilderAPI_MakeFace(surface, 1e-9).Shape())])["W1"]
    (face,) = subshapes(back.shape, TopAbs_ShapeEnum.TopAbs_FACE)
    read = BRep_Tool.Surface_s(TopoDS.Face(face))
    got = [[(pole.X(), pole.Y(), pole.Z()) for pole in (read.Pole(i, j) for j in range(1, 6))] for i in range(1, 7)]
    np.testing.assert_array_equal(got, poles)
    assert [read.UKnot(i) for i in range(1, 5)] == u_knots
    assert [read.VKnot(i) for i in range(1, 4)] == v_knots


def test_part_in_inches(tmp_path):
    source = write_plain(tmp_path / "inch.step", [cylinder(25.4, 50.8)], "INCH")
    assert b"'INCH'" in source.read_bytes()
    back = there_and_back(tmp_path, [Part("p", source)], [])["p"]
    assert back.volume == pytest.approx(math.pi * 25.4**2 * 50.8, rel=1e-9)
    assert b"INCH" not in (tmp_path / "out.step").read_bytes()


def test_part_of_several_roots(tmp_path):
    source = write_plain(tmp_path / "pair é.step", [box(1, 2, 3), cylinder(1, 2)])
    parts = [Part("one", source), Part("two", source, (9.0, 0.0, 0.0))]
    back = there_and_back(tmp_path, parts, [])
    for node in back.values():
        assert node.name == "pair é"
        assert [child.volume for child in node.children] == pytest.approx([6.0, 2.0 * math.pi], rel=1e-9)
    np.testing.assert_array_equal(back["two"].placement[:, 3], (9.0, 0.0, 0.0))


def test_everything_gets_a_name(tmp_path):
    data = AS1.read_bytes()
    for name in (b"nut", b"nut_1", b"nut_2", b"nut_3", b"as1", b"plate", b"plate_1"):
        data = data.replace(b"'" + name + b"'", b"''")
    data = re.sub(rb"(NEXT_ASSEMBLY_USAGE_OCCURRENCE\()'[^']*'", rb"\1''", data)
    source = tmp_path / "nameless.stp"
    source.write_bytes(data)
    back = there_and_back(tmp_path, [Part("p", source)], [])["p"]
    names = {(node.occurrence, node.name) for node in back.walk()}
    assert ("p", "nameless") in names
    assert all(occurrence.strip() and name.strip() for occurrence, name in names)
    assert not any("=>" in occurrence or "=>" in name for occurrence, name in names)
    assert len([node for node in back.walk() if not node.children]) == 18


# --- names ----------------------------------------------------------------------------------------------------------

NAMES = [
    "W1",
    "größe",
    "Ж中",
    "😀",
    "été 😀 Ж",
    "it's",
    "''",
    "\\",
    "a\\b",
    "C:\\X2\\00E9\\X0\\",
    "\\N\\ \\S\\i \\T\\",
    "#12 = ;",
    "/* not a comment */",
    "x" * 200,
    "é" * 150,
    "a.2",
    "=>[0:1:1:1] cable",
]


def test_any_name_comes_back(tmp_path):
    cables = [CableSolid(name, box(1.0, 1.0, i + 1.0)) for i, name in enumerate(NAMES)]
    parts = [Part(f"part {name}", IO1) for name in NAMES]
    back = there_and_back(tmp_path, parts, cables, name="sce\\ne 'é' 😀")
    assert list(back) == [part.name for part in parts] + NAMES
    assert [node.name for node in back.values()] == ["io1"] * len(NAMES) + NAMES
    data = (tmp_path / "out.step").read_bytes()
    assert data.isascii()
    assert flaw(data) is None
    assert rb"'C:\\X2\\00E9\\X0\\'" in data
    assert rb"'\X2\04164E2D\X0" + b"\\'" in data
    assert rb"'\X4\0001F600\X0" + b"\\'" in data


@pytest.mark.parametrize(
    ("written", "name"),
    [
        (rb"\X2\00E9\X0" + b"\\", "é"),
        (rb"\X\E9", "é"),
        (rb"\S\i", "é"),
        ("é中😀".encode(), "é中😀"),
        ("é".encode("latin-1"), "é"),
        (rb"C:\\X2\\00E9", "C:\\X2\\00E9"),
        (b"it''s", "it's"),
        (rb"one\X2\000A\X0\two", "one\ntwo"),
    ],
)
def test_names_of_imported_parts_come_back_in_ascii(tmp_path, written, name):
    data = AS1.read_bytes().replace(b"'rod-assembly','rod-assembly'", b"'" + written + b"','" + written + b"'")
    source = tmp_path / "source.stp"
    source.write_bytes(data.replace(b"'rod-assembly_1'", b"'" + written + b"'"))
    back = there_and_back(tmp_path, [Part("p", source)], [])["p"]
    assert (back.children[0].name, back.children[0].occurrence) == (name, name)
    assert (tmp_path / "out.step").read_bytes().isascii()


# --- size, header, files --------------------------------------------------------------------------------------------


def test_ten_placements_cost_little_more_than_one():
    (placed,) = read_parts([Part("p", IO1)])
    one = step_text("scene", [placed], [])
    ten = step_text("scene", [(Part(f"p{i}", IO1, (0.0, 0.0, 9.0 * i)), placed[1]) for i in range(10)], [])
    assert ten.count(b"=MANIFOLD_SOLID_BREP(") == one.count(b"=MANIFOLD_SOLID_BREP(") == 1
    assert ten.count(b"=NEXT_ASSEMBLY_USAGE_OCCURRENCE(") == 11
    assert len(ten) < 1.2 * len(one)


def test_header(tmp_path, monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1234567890")
    folder = tmp_path / "secret folder"
    folder.mkdir()
    source = folder / "secret part.stp"
    source.write_bytes(IO1.read_bytes())
    write_step(folder / "secret.step", "Kabel é", read_parts([Part("p", source)]), [], version="1.2.3")
    data = (folder / "secret.step").read_bytes()
    match = re.search(rb"\nFILE_NAME\((.*)\);\n", data)
    fields = match[1].split(b",")
    assert fields[:4] == [rb"'Kabel \X2\00E9\X0" + b"\\'", b"'2009-02-13T23:31:30'", b"('')", b"('')"]
    assert re.fullmatch(rb"'Open Cascade [78]\.[\d.]+'", fields[4])
    assert fields[5:] == [b"'cablecad 1.2.3'", b"''"]
    assert b"FILE_SCHEMA(('AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }'));\n" in data
    assert b"secret" not in data
    assert str(tmp_path).encode() not in data


@pytest.mark.parametrize(("epoch", "stamp"), [(None, "1970-01-01T00:00:00"), ("", "1970-01-01T00:00:00")])
def test_time_without_source_date_epoch(monkeypatch, epoch, stamp):
    monkeypatch.delenv("SOURCE_DATE_EPOCH", raising=False)
    if epoch is not None:
        monkeypatch.setenv("SOURCE_DATE_EPOCH", epoch)
    assert f"'{stamp}'".encode() in step_text("s", [], [CableSolid("W1", box(1, 1, 1))])


@pytest.mark.parametrize("epoch", ["-1", "1.5", "now", "253402300800", "9" * 5000, "１２", " 1"])
def test_source_date_epoch_that_is_no_time(tmp_path, monkeypatch, epoch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", epoch)
    with pytest.raises(UsageError, match=r"SOURCE_DATE_EPOCH .* must be whole seconds since 1970 .*unset it"):
        write_step(tmp_path / "out.step", "s", [], [CableSolid("W1", box(1, 1, 1))])
    assert list(tmp_path.iterdir()) == []


def test_failed_write_leaves_the_old_file(tmp_path):
    from OCP.TopoDS import TopoDS_Solid

    path = tmp_path / "out.step"
    path.write_bytes(b"old")
    with pytest.raises(GeometryError, match="cable 'W1' has no solid to write"):
        write_step(path, "s", [], [CableSolid("W1", TopoDS_Solid())])
    assert path.read_bytes() == b"old"
    with pytest.raises(ExchangeError, match="its folder does not exist"):
        write_step(tmp_path / "missing" / "out.step", "s", [], [CableSolid("W1", box(1, 1, 1))])
    assert [path.name for path in tmp_path.iterdir()] == ["out.step"]


def test_settings_of_a_host_do_not_matter_and_stay():
    from OCP.Interface import Interface_Static

    cables = [CableSolid("W1", cylinder(1.0, 2.0))]
    plain = step_text("s", [], cables)
    values = {
        "write.step.unit": "INCH",
        "write.step.schema": "AP242DIS",
        "write.surfacecurve.mode": 0,
        "write.precision.mode": 1,
        "xstep.cascade.unit": "M",
        "write.step.product.name": "of the host",
    }
    with interface_settings(values):
        assert step_text("s", [], cables) == plain
        assert Interface_Static.CVal_s("write.step.unit") == "INCH"
        assert Interface_Static.CVal_s("write.step.schema") == "AP242DIS"
        assert Interface_Static.IVal_s("write.surfacecurve.mode") == 0


# --- the same bytes -------------------------------------------------------------------------------------------------

WRITE = """
import hashlib, sys
from pathlib import Path
from cablecad.brep.step import CableSolid, read_parts, step_text
from cablecad.model import Part, Rotation
from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox, BRepPrimAPI_MakeCylinder

sources = [Path(path) for path in sys.argv[2:]]
if sys.argv[1] == "after other work":
    for i in range(3):
        solid = BRepPrimAPI_MakeBox(1.0, 1.0, 1.0).Solid()
        step_text("other", read_parts([Part("p", sources[0])]), [CableSolid("c", solid)])
parts = [Part(f"p{i}", path, (i, 2.0 * i, 0.1), Rotation((1, 1, 1), 10.0 * i)) for i, path in enumerate(sources)]
parts += [Part("again", sources[0])]
colors = ("#2b6cb080", None, "#ff0000") * 3
cables = [CableSolid(f"W{i}", BRepPrimAPI_MakeCylinder(1.0, 9.0).Solid(), color) for i, color in enumerate(colors)]
print(hashlib.sha256(step_text("scene é", read_parts(parts), cables)).hexdigest())
"""


def test_the_same_bytes_in_any_process(tmp_path):
    # Two equal files, so that two products are equal to the last face but are not one.
    twin = tmp_path / "io1-cm-214.stp"
    twin.write_bytes(IO1.read_bytes())
    sources = [AS1, IO1, twin, colored_file(tmp_path / "colored.stp")]
    digests = set()
    for seed, before in (("0", "nothing"), ("1", "after other work"), ("12345", "nothing")):
        environment = {**os.environ, "PYTHONHASHSEED": seed, "TZ": f"UTC{seed[-1]}"}
        command = [sys.executable, "-c", WRITE, before, *map(str, sources)]
        run = subprocess.run(command, capture_output=True, text=True, check=True, env=environment, cwd=tmp_path)
        assert re.fullmatch(r"[0-9a-f]{64}\n", run.stdout)
        assert run.stderr == ""
        digests.add(run.stdout)
    assert len(digests) == 1


def test_the_same_bytes_again_and_again():
    placed = read_parts([Part("p", AS1), Part("q", IO1)])
    cables = [CableSolid("W1", cylinder(1.0, 9.0), "#2b6cb080")]
    texts = {hashlib.sha256(step_text("scene", placed, cables)).digest() for _ in range(3)}
    texts |= {hashlib.sha256(step_text("scene", read_parts([part for part, _ in placed]), cables)).digest()}
    assert len(texts) == 1


def test_document_outlives_what_is_written_from_it():
    (placed,) = read_parts([Part("p", AS1)])
    before = [(node.occurrence, node.name, node.color) for node in placed[1].tree()[0].walk()]
    step_text("scene", [placed, (Part("a\\b", AS1), placed[1])], [])
    assert [(node.occurrence, node.name, node.color) for node in placed[1].tree()[0].walk()] == before
    assert isinstance(placed[1], Document)
