"""STEP files in: everything a file holds arrives in mm, and a file that is not whole is refused."""

import gzip
import logging
import math
import re
from pathlib import Path

import numpy as np
import pytest
from step_files import changed_copy, cylinder, write_plain

from cablecad.brep.kernel import interface_settings
from cablecad.brep.step import read_parts, read_step, read_tree
from cablecad.errors import ExchangeError
from cablecad.model import Part

DATA = Path(__file__).parents[1] / "data"
AS1 = DATA / "as1-oc-214.stp"
IO1 = DATA / "io1-cm-214.stp"


def box(x, y, z):
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox

    return BRepPrimAPI_MakeBox(x, y, z).Shape()


@pytest.fixture
def changed(tmp_path):
    """A copy of the AS1 assembly, or of another file, with some bytes of it changed."""

    def change(*replacements, source=AS1):
        return changed_copy(tmp_path, source, *replacements)

    return change


# --- what arrives ---------------------------------------------------------------------------------------------------


def test_assembly_with_names_colours_layers_and_placements():
    (root,) = read_tree(AS1)
    outline = [(node.occurrence, node.name) for node in root.walk()]
    bracket = [("l-bracket-assembly_1", "l-bracket-assembly")]
    for i in (1, 2, 3):
        bracket += [(f"nut-bolt-assembly_{i}", "nut-bolt-assembly"), ("bolt_1", "bolt"), ("nut_3", "nut")]
    bracket += [("l-bracket_1", "l-bracket")]
    rods = [("rod-assembly_1", "rod-assembly"), ("nut_1", "nut"), ("nut_2", "nut"), ("rod_1", "rod")]
    other = [("l-bracket-assembly_2", "l-bracket-assembly"), *bracket[1:]]
    assert outline == [("as1", "as1"), *rods, *bracket, ("plate_1", "plate"), *other]

    # The colours are told in the file: COLOUR_RGB('',...) and names.
    colors = {node.name: node.color for node in root.walk()}
    expected = {
        "nut": (1, 0, 0, 1),
        "rod": (1, 0.5, 0, 1),
        "bolt": (0, 0, 1, 1),
        "l-bracket": (0, 1, 0, 1),
        "plate": (0.8, 1, 0, 1),
    }
    for name, color in expected.items():
        np.testing.assert_allclose(colors[name], color, atol=1e-6)
    assert {name for name, color in colors.items() if color is None} == {
        "as1",
        "rod-assembly",
        "l-bracket-assembly",
        "nut-bolt-assembly",
    }
    assert {node.layers for node in root.walk() if not node.children} == {("256",)}

    nodes = {node.occurrence: node for node in root.walk()}
    np.testing.assert_allclose(nodes["rod-assembly_1"].placement[:, 3], [-10, 75, 60], atol=1e-9)
    for node in root.walk():
        np.testing.assert_allclose(node.placement[:, :3] @ node.placement[:, :3].T, np.eye(3), atol=1e-12)
    assert read_step(AS1).solids == 18
    assert nodes["rod-assembly_1"].volume == pytest.approx(
        nodes["nut_1"].volume + nodes["nut_2"].volume + nodes["rod_1"].volume, rel=1e-9
    )


def test_single_solid_with_coloured_faces():
    (root,) = read_tree(IO1)
    assert root.children == ()
    assert root.name == root.occurrence == "io1"
    np.testing.assert_allclose(root.color, (1, 1, 0, 1), atol=1e-6)
    assert {kind for kind, _ in root.subshape_colors} == {"face"}
    assert len(root.subshape_colors) == 2
    for color in root.subshape_colors.values():
        np.testing.assert_allclose(color, (1, 0, 0, 1), atol=1e-6)
    assert read_step(IO1).solids == 1


@pytest.mark.parametrize(("unit", "size"), [("MM", 1.0), ("INCH", 25.4), ("M", 1000.0)])
def test_units_arrive_in_mm(tmp_path, unit, size):
    path = tmp_path / "part.step"
    write_plain(path, [cylinder(size, 3.0 * size)], unit)
    text = path.read_text()
    assert re.search(r"CYLINDRICAL_SURFACE\('',#\d+,1\.(?:E\+00)?\)", text)  # in the file it is one unit
    (root,) = read_tree(path)
    assert root.volume == pytest.approx(math.pi * size**2 * 3.0 * size, rel=1e-9)


def test_host_settings_do_not_matter_and_stay(tmp_path):
    from OCP.Interface import Interface_Static

    with interface_settings({"xstep.cascade.unit": "M", "write.step.unit": "INCH", "read.step.shape.repr": "ABSR"}):
        (root,) = read_tree(AS1)
        assert Interface_Static.CVal_s("xstep.cascade.unit") == "M"
        assert Interface_Static.CVal_s("write.step.unit") == "INCH"
        assert Interface_Static.CVal_s("read.step.shape.repr") == "ABSR"
    assert root.volume == pytest.approx(read_tree(AS1)[0].volume, rel=1e-12)


def test_several_roots(tmp_path):
    path = tmp_path / "pair.step"
    write_plain(path, [box(1, 2, 3), cylinder(1, 2)])
    roots = read_tree(path)
    assert [root.volume for root in roots] == pytest.approx([6.0, 2.0 * math.pi], rel=1e-9)
    document = read_step(path)
    assert document.solids == 2
    assert document.name == "pair"


def test_open_shell_without_a_solid_is_a_shape(tmp_path):
    from OCP.TopAbs import TopAbs_ShapeEnum

    from cablecad.brep.kernel import subshapes

    path = tmp_path / "face.step"
    write_plain(path, subshapes(box(1, 2, 3), TopAbs_ShapeEnum.TopAbs_FACE)[:1])
    document = read_step(path)
    assert document.solids == 0
    assert not document.is_empty


@pytest.mark.parametrize(
    ("old", "new"), [(b"ISO-10303-21;", b"\xef\xbb\xbfISO-10303-21;"), (b"ISO-10303-21;", b"\r\n ISO-10303-21;")]
)
def test_what_editors_leave_before_the_first_word(changed, old, new):
    assert read_step(changed((old, new))).solids == 18


def test_line_ends_of_any_kind(tmp_path):
    for i, end in enumerate((b"\r\n", b"\r", b"")):
        path = tmp_path / f"{i}.stp"
        path.write_bytes(AS1.read_bytes().replace(b"\n", end))
        assert read_step(path).solids == 18


@pytest.mark.parametrize("name", ["größe 中.stp", "a b'c\\d.stp", "😀.STEP", "no suffix"])
def test_any_file_name(tmp_path, name):
    path = tmp_path / name
    path.write_bytes(IO1.read_bytes())
    assert read_step(path).solids == 1
    assert read_step(str(path)).name == Path(name).stem


@pytest.mark.parametrize(
    ("written", "name"),
    [
        (rb"\X2\00E9\X0\t\X2\00E9\X0\ ".rstrip(), "été"),
        (rb"\X\E9t\X\E9", "été"),
        (rb"\S\it\S\i", "été"),
        ("été".encode(), "été"),
        ("été".encode("latin-1"), "été"),
        (rb"\X2\04164E2D\X0" + b"\\", "Ж中"),
        ("Ж中".encode(), "Ж中"),
        (rb"\X4\0001F600\X0" + b"\\", "😀"),
        ("😀".encode(), "😀"),
        (rb"a\\b", "a\\b"),
        (rb"C:\\X2\\00E9", "C:\\X2\\00E9"),
        (b"it''s", "it's"),
    ],
)
def test_every_way_to_write_a_name(changed, written, name):
    path = changed(
        (b"PRODUCT('rod-assembly','rod-assembly'", b"PRODUCT('" + written + b"','" + written + b"'"),
        (b"'rod-assembly_1'", b"'" + written + b"'"),
    )
    node = read_tree(path)[0].children[0]
    assert (node.name, node.occurrence) == (name, name)


def test_a_file_is_read_once_however_often_it_is_placed(tmp_path):
    link = tmp_path / "link.stp"
    link.symlink_to(IO1)
    parts = [Part("a", IO1), Part("b", AS1), Part("c", DATA / ".." / "data" / IO1.name), Part("d", link)]
    placed = read_parts(parts)
    assert [part for part, _ in placed] == parts
    documents = [document for _, document in placed]
    assert documents[0] is documents[2] is documents[3]
    assert documents[1] is not documents[0]


# --- what is refused ------------------------------------------------------------------------------------------------


def head(count):
    return lambda data: data[:count]


def instead(data):
    return lambda _: data


@pytest.mark.parametrize(
    ("spoil", "reason"),
    [
        (head(0), "is empty"),
        (instead(b" \n"), "is empty"),
        (instead(b"solid cube\nfacet"), "it begins with 'solid cube\\nfacet', not with ISO-10303-21"),
        (gzip.compress, "is compressed; unpack it first"),
        (lambda data: b"PK\x03\x04" + data, "is compressed; unpack it first"),
        (head(len("ISO-10303-21;")), "is cut off: END-ISO-10303-21 is missing at its end"),
        (head(1000), "is cut off: END-ISO-10303-21 is missing at its end"),
        (head(200_000), "is cut off: END-ISO-10303-21 is missing at its end"),
        (head(-20), "is cut off: END-ISO-10303-21 is missing at its end"),
        (lambda data: data.replace(b"\nDATA;", b"\n"), "has no DATA section"),
        (
            lambda data: data[:200_000].rpartition(b";")[0] + b";\nENDSEC;\nEND-ISO-10303-21;\n",
            "which it does not define: a piece of it is missing",
        ),
        (lambda data: re.sub(rb"\n#100 = [^;]*;", b"", data), "refers to #100, which it does not"),
        (lambda data: data[: data.index(b"DATA;") + 6] + b"ENDSEC;\nEND-ISO-10303-21;\n", "holds no shape"),
        (lambda data: re.sub(rb"MANIFOLD_SOLID_BREP\(", b"UNHEARD_OF(", data), "holds no shape"),
        (lambda data: data.replace(b"VERTEX_POINT('',", b"VERTEX_POINT(',", 1), "is damaged (its entity "),
        (
            lambda data: data.replace(b"CARTESIAN_POINT('',(", b"CARTESIAN_POINT('',(.T.,", 1),
            "CartesianPoint: Parameter n0.1 (coordinates) not a Real",
        ),
        (lambda data: data.replace(b"ADVANCED_FACE(", b"UNHEARD_OF(", 1), "ClosedShell: Parameter n0.1 (face)"),
        (instead(b"ISO-10303-21;HEADER;ENDSEC;DATA;(('\nENDSEC;\nEND-ISO-10303-21;\n"), "holds no shape"),
    ],
)
def test_broken_file_is_refused_with_its_name_the_reason_and_a_remedy(tmp_path, spoil, reason):
    path = tmp_path / "part.stp"
    path.write_bytes(spoil(AS1.read_bytes()))
    with pytest.raises(ExchangeError) as caught:
        read_step(path)
    message = str(caught.value)
    assert str(path) in message
    assert reason in message
    assert "export it again" in message


def test_hashes_in_strings_and_comments_are_no_references(changed):
    path = changed((b"PRODUCT('as1','as1','',", b"PRODUCT('as1','as1','see #999999; it''s #88',/* #777777 ' */"))
    assert read_step(path).solids == 18


@pytest.mark.parametrize(
    ("path", "reason"),
    [
        ("missing.stp", r"missing\.stp does not exist; check the path, it is relative to /"),
        (".", r"is a folder; give the STEP file in it"),
        ("a\0b", r"cannot be read: .*; check the path"),
        ("n" * 300, r"cannot be read: .*too long"),
    ],
)
def test_path_that_cannot_be_read(tmp_path, monkeypatch, path, reason):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ExchangeError, match=reason):
        read_step(path)


# --- what is missing, and said --------------------------------------------------------------------------------------


def test_whole_file_has_no_warnings(caplog):
    assert read_step(AS1).warnings == ()
    assert read_step(IO1).warnings == ()
    assert caplog.records == []


def test_entities_that_were_lost_are_told(tmp_path, caplog):
    path = tmp_path / "lossy.stp"
    path.write_bytes(re.sub(rb"(EDGE_LOOP\('',\()[^)]*", rb"\g<1>", AS1.read_bytes(), count=1))
    with caplog.at_level(logging.WARNING):
        document = read_step(path)
    assert document.solids == 10  # of the nut, which there is eight times, a shell is left
    (warning,) = document.warnings
    assert warning.startswith("1 of its entities could not be made into shapes, and are missing; the first is entity ")
    assert "EdgeLoop" in warning
    assert [record.getMessage() for record in caplog.records] == [f"{path}: {warning}"]


def test_products_without_a_shape_are_told(tmp_path):
    path = tmp_path / "hollow.stp"
    path.write_bytes(re.sub(rb"(CLOSED_SHELL\('',\()[^)]*", rb"\g<1>", AS1.read_bytes(), count=1))
    document = read_step(path)
    assert any("1 without a shape (nut); if it refers to other STEP files" in text for text in document.warnings)


@pytest.mark.parametrize(
    ("old", "new"), [(b"FILL_AREA_STYLE('',", b"FILL_AREA_STYLE(',"), (b"COLOUR_RGB('',", b"COLOUR_RGB('',$,")]
)
def test_broken_colours_are_left_out_and_told(changed, old, new):
    """Open Cascade follows such an entity into the void; the process would be gone."""
    path = changed((old, new))
    document = read_step(path)
    assert document.solids == 18
    assert document.warnings[0].startswith("its colours could not be read; ")
    assert all(node.color is None for node in document.tree()[0].walk())


def test_colours_that_open_cascade_trips_over_are_left_out_and_told():
    """Of an occurrence coloured over: it wrote the file, and raises on reading its colours."""
    document = read_step(DATA / "colored-occurrence.stp")
    assert document.warnings[0].startswith("its colours could not be read; ")
    (root,) = document.tree()
    assert [node.volume for node in root.walk() if not node.children] == pytest.approx([5.215704, 10.0 * math.pi**2])
