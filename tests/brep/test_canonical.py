"""Byte-stable rewriting: what is left to chance in a STEP text leaves no trace, and nothing else is changed."""

import io
import random
import re
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cablecad.brep.canonical import _settled, canonical
from cablecad.brep.kernel import TopoDS, silence, subshapes
from cablecad.brep.part21 import flaw, quoted, requoted, shielded
from cablecad.brep.reals import REAL_FORMAT, reals
from cablecad.errors import GeometryError

DATA = Path(__file__).parents[1] / "data"
HEADER = b"FILE_DESCRIPTION((''),'2;1');\nFILE_NAME('','1970-01-01T00:00:00',(''),(''),'','','');\n"
STRING = rb"'(?:[^']|'')*'"
ENTITY = re.compile(rb"#(\d+) *= *((?:[^';]|%s)*);" % STRING)
TOKEN = re.compile(rb"%s|#\d+" % STRING)
UNORDERED = re.compile(rb"(MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION|PRESENTATION_LAYER_ASSIGNMENT)\(")
STYLE = re.compile(
    rb"MECHANICAL_DESIGN_GEOMETRIC|PRESENTATION_|(OVER_RIDING_)?STYLED_ITEM|SURFACE_S(TYLE|IDE)|FILL_AREA|COLOUR|DRAUGHTING"
)


def occ_text(*, colors):
    """What Open Cascade writes of an assembly with coloured products, occurrences and faces, and layers."""
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox, BRepPrimAPI_MakeCylinder
    from OCP.gp import gp_Trsf, gp_Vec
    from OCP.Quantity import Quantity_Color, Quantity_ColorRGBA, Quantity_TypeOfColor
    from OCP.STEPCAFControl import STEPCAFControl_Writer
    from OCP.StepData import StepData_StepWriter
    from OCP.TCollection import TCollection_ExtendedString
    from OCP.TDataStd import TDataStd_Name
    from OCP.TDocStd import TDocStd_Document
    from OCP.TopAbs import TopAbs_ShapeEnum
    from OCP.TopLoc import TopLoc_Location
    from OCP.XCAFApp import XCAFApp_Application
    from OCP.XCAFDoc import XCAFDoc_ColorType, XCAFDoc_DocumentTool

    document = TDocStd_Document(TCollection_ExtendedString("BinXCAF"))
    XCAFApp_Application.GetApplication_s().InitDocument(document)
    shapes = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
    palette = XCAFDoc_DocumentTool.ColorTool_s(document.Main())
    layers = XCAFDoc_DocumentTool.LayerTool_s(document.Main())

    def named(label, name):
        TDataStd_Name.Set_s(label, TCollection_ExtendedString(name, True))
        return label

    def paint(label, red, green, blue, alpha):
        color = Quantity_ColorRGBA(Quantity_Color(red, green, blue, Quantity_TypeOfColor.Quantity_TOC_sRGB), alpha)
        palette.SetColor(label, color, XCAFDoc_ColorType.XCAFDoc_ColorSurf)

    def moved(x):
        transformation = gp_Trsf()
        transformation.SetTranslation(gp_Vec(x, 1.0 / 3.0, 0.1))
        return TopLoc_Location(transformation)

    root = named(shapes.NewShape(), "root #1; it's 'é'")
    sub = named(shapes.NewShape(), "sub")
    solids = [BRepPrimAPI_MakeBox(1.0, 2.0, 3.0).Shape(), BRepPrimAPI_MakeCylinder(1.0, 4.0).Shape()]
    solids += [BRepPrimAPI_MakeBox(1.0, 2.0, 3.0).Shape()]  # equal to the first, and another product of the same name
    products = [named(shapes.AddShape(solid, False), "solid") for solid in solids]
    occurrences = [named(shapes.AddComponent(sub, product, moved(i)), "here") for i, product in enumerate(products)]
    named(shapes.AddComponent(root, sub, moved(10.0)), "s1")
    named(shapes.AddComponent(root, sub, moved(20.0)), "s2")
    shapes.UpdateAssemblies()
    if colors:
        for i, (solid, product) in enumerate(zip(solids, products, strict=True)):
            paint(product, 0.2, 0.4, 0.5, 1.0 - 0.25 * i)
            layers.SetLayer(product, TCollection_ExtendedString(f"layer {i}"))
            for face in subshapes(solid, TopAbs_ShapeEnum.TopAbs_FACE)[:3]:
                paint(shapes.AddSubShape(product, face), 0.7, 0.6, 0.1, 0.5)
        paint(occurrences[0], 0.0, 1.0, 0.0, 0.25)
    with silence():
        writer = STEPCAFControl_Writer()
        assert writer.Transfer(document)
        model = writer.ChangeWriter().Model()
        text = StepData_StepWriter(model)
        text.FloatWriter().SetFormat(REAL_FORMAT, True)
        text.SendModel(model.Protocol())
        stream = io.BytesIO()
        text.Print(stream)
    return stream.getvalue()


@pytest.fixture(scope="module")
def colored():
    return occ_text(colors=True)


def shuffled(text, chance):
    """The same contents under other numbers and counters, with other line breaks, and its styles in another order."""
    head, _, rest = text.partition(b"DATA;\n")
    entities = ENTITY.findall(rest)
    numbers = [number for number, _ in entities]
    chance.shuffle(numbers)
    renumbered = {old: new for (old, _), new in zip(entities, numbers, strict=True)}

    def renumber(body):
        return TOKEN.sub(lambda m: b"#" + renumbered[m[0][1:]] if m[0].startswith(b"#") else m[0], body)

    def reorder(body):
        if not UNORDERED.match(body):
            return body
        members = re.findall(rb"#\d+", body[body.index(b"(#") : body.index(b")")])
        mixed = chance.sample(members, len(members))
        return body.replace(b",".join(members), b",".join(mixed))

    structure, values = [], []
    for number, body in entities:
        flat = TOKEN.sub(lambda m: m[0], re.sub(rb"\n *", b"", body))
        if flat.startswith(b"NEXT_ASSEMBLY_USAGE_OCCURRENCE"):
            flat = re.sub(rb"\('\d+'", b"('%d'" % chance.randrange(10**6), flat)
        line = b"#%s = %s;\n" % (renumbered[number], renumber(reorder(flat)))
        (values if STYLE.match(flat) else structure).append(
            line.replace(b",#", b",\n  #") if chance.random() < 0.5 else line
        )
    chance.shuffle(values)
    at = chance.randrange(len(structure))
    return head + b"DATA;\n" + b"".join(structure[:at] + values + structure[at:]) + b"ENDSEC;\nEND-ISO-10303-21;\n"


def contents(text):
    """Each root, written out with all it refers to (as digests): what a text says, whatever its numbers."""
    text = text.replace("é".encode(), b"\\X2\\00E9\\X0\\")  # the one character the two may write differently
    entities = {number: re.sub(rb"\n *", b"", body) for number, body in ENTITY.findall(text.partition(b"DATA;\n")[2])}
    known = {}

    def said(number):
        if number not in known:
            body = entities[number]
            body = re.sub(rb"^NEXT_ASSEMBLY_USAGE_OCCURRENCE\(%s" % STRING, b"NEXT_ASSEMBLY_USAGE_OCCURRENCE(", body)
            body = re.sub(rb"^PRODUCT\(%s" % STRING, b"PRODUCT(", body)
            body = re.sub(rb"-?\d+\.\d*(E[+-]\d+)?", lambda m: b"%.6g" % float(m[0]), body)
            if UNORDERED.match(body):
                before, members, after = re.fullmatch(rb"(.*?\()(#[#\d,]*)(\).*)", body).groups()
                members = sorted({said(member[1:]) for member in members.split(b",")})
                body = before + b",".join(b"<%d>" % member for member in members) + after
            body = TOKEN.sub(lambda m: b"<%d>" % said(m[0][1:]) if m[0].startswith(b"#") else m[0], body)
            known[number] = hash(body)
        return known[number]

    referred = {m[1:] for body in entities.values() for m in TOKEN.findall(body) if m.startswith(b"#")}
    return Counter((entities[number].partition(b"(")[0], said(number)) for number in entities if number not in referred)


# --- what chance decides --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(8))
def test_chance_leaves_no_trace(colored, seed):
    changed = shuffled(colored, random.Random(seed))
    assert changed != colored
    assert canonical(changed, HEADER) == canonical(colored, HEADER)


def test_each_document_of_one_process_gives_the_same(colored):
    again = occ_text(colors=True)
    assert again != colored  # the counter of occurrences goes on
    assert canonical(again, HEADER) == canonical(colored, HEADER)


def test_twice_is_once(colored):
    once = canonical(colored, HEADER)
    assert canonical(once, HEADER) == once


# --- what must not change -------------------------------------------------------------------------------------------


def test_contents_stay(colored):
    before, after = contents(colored), contents(canonical(colored, HEADER))
    assert set(before) == set(after)  # equal styles are merged, nothing else is


def test_nothing_is_merged_without_styles():
    plain = occ_text(colors=False)
    assert contents(plain) == contents(canonical(plain, HEADER))


def test_layers_and_styles_are_merged_not_lost(colored):
    text = canonical(colored, HEADER)
    assert text.count(b"PRESENTATION_LAYER_ASSIGNMENT(") == 3
    assert text.count(b"COLOUR_RGB(") == 2  # but for green, which has a name of its own
    assert text.count(b"'overriding color'") == 9 + 1  # three faces of each product; the occurrence, once


def test_text_is_well_formed(colored):
    text = canonical(colored, HEADER)
    assert text.isascii()
    assert flaw(text) is None
    head, _, rest = text.partition(b"DATA;\n")
    assert head == b"ISO-10303-21;\nHEADER;\n" + HEADER + (
        b"FILE_SCHEMA(('AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }'));\nENDSEC;\n"
    )
    lines = rest.split(b"\n")
    assert lines[-3:] == [b"ENDSEC;", b"END-ISO-10303-21;", b""]
    numbers = [int(re.match(rb"#(\d+)=", line)[1]) for line in lines[:-3]]
    assert numbers == list(range(1, len(lines) - 2))
    value = rb"(?:%s|#\d+|-?\d+|[+-]?\d+\.\d*(?:E[+-]?\d+)?|\.[A-Z0-9_]+\.|\$|\*|[A-Z0-9_]+)" % STRING
    for line in lines[:-3]:
        body = line.partition(b"=")[2]
        assert re.fullmatch(rb"(?:%s|[(), ])+;" % value, body), body


def test_ids_are_unique_and_say_the_name(colored):
    text = canonical(colored, HEADER)
    for kind, count in ((rb"PRODUCT", 5), (rb"NEXT_ASSEMBLY_USAGE_OCCURRENCE", 5)):
        pairs = re.findall(rb"=%s\((%s),(%s)" % (kind, STRING, STRING), text)
        assert len({identifier for identifier, _ in pairs}) == len(pairs) == count
        for identifier, name in pairs:
            assert re.fullmatch(re.escape(name[:-1]) + rb"(\.\d+)?'", identifier)
    assert rb"=PRODUCT('root #1; it''s ''\X2\00E9\X0\''','root #1; it''s ''\X2\00E9\X0\''','',(#" in text


# --- reals ----------------------------------------------------------------------------------------------------------


@settings(deadline=None)
@given(st.floats(allow_nan=False, allow_infinity=False))
def test_every_real_is_kept_to_the_last_bit(value):
    text = b"ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\n#7 = VECTOR('',(%s,1));\nENDSEC;\nEND-ISO-10303-21;\n"
    found = re.search(rb"#1=VECTOR\(''\,\((.*),1\)\);", canonical(text % (REAL_FORMAT % value).encode(), HEADER))[1]
    assert re.fullmatch(rb"-?\d+\.\d*(E[+-]?\d+)?", found)  # REAL of ISO 10303-21
    assert float(found) == value
    assert len(found) <= len(repr(value)) + 1


def test_tokens_that_look_like_reals_in_strings_are_left():
    line = b"#1 = PRODUCT('x','1.0000000000000000E+00 #2 ;','',$);\n"
    text = b"ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\n" + line + b"ENDSEC;\nEND-ISO-10303-21;\n"
    assert b"'1.0000000000000000E+00 #2 ;'" in canonical(text, HEADER)


def data(*lines):
    """A text of a few entities."""
    return b"ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\n" + b"".join(lines) + b"ENDSEC;\nEND-ISO-10303-21;\n"


def test_reals_of_every_length_stand_side_by_side():
    values = [0.0, 1.0, -0.5, 1e22, 1e-5, 12345678.9, 1.0 / 3.0, 5e-324, 1.7976931348623157e308, 1e100, 1e-100]
    line = b"#1 = VECTOR('',(%s));\n" % b",\n    ".join((REAL_FORMAT % value).encode() for value in values)
    found = re.search(rb"#1=VECTOR\('',\((.*)\)\);\n", canonical(data(line), HEADER))[1].split(b",")
    assert [float(real) for real in found] == values
    assert all(b"." in real and len(real) <= len(repr(value)) + 1 for real, value in zip(found, values, strict=True))


@settings(deadline=None)
@given(st.lists(st.floats(min_value=0.0, allow_infinity=False), min_size=1, max_size=30))
def test_reals_have_the_fewest_digits(values):
    texts = reals(values)
    for text, value in zip(texts, values, strict=True):
        digits, _, exponent = repr(value).upper().partition("E")
        assert text.decode().partition("E")[::2] == (
            digits.removesuffix("0") if digits[-2:] == ".0" else digits if "." in digits else digits + ".",
            exponent,
        )


def many_entities(count, strings):
    """Poles and what refers to them, with names that break a line where an entity might end."""
    lines = [b"#1 = SHAPE_DEFINITION_REPRESENTATION(%s);\n" % b",".join(b"#%d" % i for i in range(2, count + 2))]
    for i in range(2, count + 2):
        name = strings[i % len(strings)]
        lines.append(b"#%d = CARTESIAN_POINT('%s',(%s));\n" % (i, name, reals_of(i / 3.0, 1.0, i % 7 / 10.0)))
    return data(*lines)


@pytest.mark.parametrize("block", [1, 100, 1000, 10**6])
def test_blocks_are_cut_between_entities_only(block, monkeypatch):
    text = many_entities(60, [b"", b"it''s;\n#4 = ''not'';\n", b"a;\n#5", b"'';\n"])
    whole = canonical(text, HEADER)
    monkeypatch.setattr("cablecad.brep.entities._BLOCK", block)
    assert canonical(text, HEADER) == whole
    assert whole.count(b"CARTESIAN_POINT(") == 60
    assert whole.count(b"(0.6666666666666666,1.,0.2)") == 1


def test_a_text_of_many_blocks_keeps_everything():
    text = many_entities(20000, [b"pole"])
    found = re.findall(rb"CARTESIAN_POINT\('pole',\(([^,]*),1\.,([^,]*)\)\)", canonical(text, HEADER))
    assert [(float(x), float(z)) for x, z in found] == [(i / 3.0, i % 7 / 10.0) for i in range(2, 20002)]


def test_poles_are_numbered_as_they_are_met():
    poles = [b"#%d = CARTESIAN_POINT('',(%d.0,0.,0.));\n" % (i, i) for i in range(10, 15)]
    surface = b"#3 = SHAPE_DEFINITION_REPRESENTATION(#10,#11,#12,#13,#14);\n"
    one = canonical(data(surface, *poles), HEADER)
    assert canonical(data(*poles[::-1], surface), HEADER) == one
    # One of them is met before its row is.
    early = surface.replace(b"#10,", b"#4,#10,")
    met = canonical(data(early, b"#4 = VERTEX_POINT('',#12);\n", *poles), HEADER)
    assert re.findall(rb"#(\d)=CARTESIAN_POINT\('',\((\d+)", met) == [
        (b"3", b"12"),
        (b"4", b"10"),
        (b"5", b"11"),
        (b"6", b"13"),
        (b"7", b"14"),
    ]
    assert b"#1=SHAPE_DEFINITION_REPRESENTATION(#2,#4,#5,#3,#6,#7);" in met


@st.composite
def graphs(draw):
    """References of some entities, most to those behind, and what of the others are roots of the structure."""
    count = draw(st.integers(1, 12))
    ahead = draw(st.booleans())
    references = [
        draw(st.lists(st.integers(min(i + 1, count - 1) if ahead else 0, count - 1), max_size=4)) for i in range(count)
    ]
    if draw(st.booleans()):  # as they are numbered by a walk
        order = walk(references, sorted(set(range(count)) - {r for own in references for r in own}))
        order += sorted(set(range(count)) - set(order))
        place = {entity: i for i, entity in enumerate(order)}
        references = [[place[r] for r in references[entity]] for entity in order]
    free = sorted(set(range(count)) - {r for own in references for r in own})
    return references, [root for root in free if draw(st.integers(0, 4))]


def walk(references, roots):
    order = []
    waiting = roots[::-1]
    while waiting:
        entity = waiting.pop()
        if entity not in order:
            order.append(entity)
            waiting += references[entity][::-1]
    return order


@settings(deadline=None, max_examples=500)
@given(graphs())
def test_what_the_walk_would_leave_is_left_without_it(graph):
    references, roots = graph
    order = walk(references, roots)
    kept = [
        k
        for k in range(len(order) + 1)
        if order[:k] == list(range(k)) and all(r < k for own in references[:k] for r in own)
    ]
    targets = np.array([r for own in references for r in own], np.intp)
    starts = np.cumsum([0, *map(len, references)])
    settled = _settled(targets, starts, roots)
    assert settled in kept
    # Who refers to one twice is taken to refer to it there where he does so last.
    assert settled == max(kept) or any(len(set(own)) < len(own) for own in references)


def test_a_reference_to_nothing_is_refused():
    with pytest.raises(GeometryError, match="did not write"):
        canonical(data(b"#1 = PLANE('',#3);\n", b"#4 = PLANE('',$);\n"), HEADER)


def test_texts_of_one_sum_are_told_apart(monkeypatch):
    monkeypatch.setattr("cablecad.brep.reals._MIXING", np.zeros(3, np.uint64))
    assert b"(1.,2.,1.,3.)" in canonical(data(b"#1 = VECTOR('',(%s));\n" % reals_of(1.0, 2.0, 1.0, 3.0)), HEADER)


def reals_of(*values):
    return b",".join((REAL_FORMAT % value).encode() for value in values)


def test_not_a_number_is_refused():
    from binary_geometry import surface_of
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace

    from cablecad.brep.binary import KnotVector, spline_surface
    from cablecad.brep.document import CableSolid
    from cablecad.brep.step import step_text

    poles = [[[float(i), float(j), 0.0] for j in range(4)] for i in range(4)]
    poles[1][2][2] = float("nan")
    knots = KnotVector(3, [0.0, 1.0], [4, 4])
    surface = surface_of(spline_surface(np.array(poles), 1.0, knots, knots))
    face = TopoDS.Face(BRepBuilderAPI_MakeFace(surface, 1e-6).Shape())
    with pytest.raises(GeometryError, match="coordinates that are not finite numbers"):
        step_text("scene", [], [CableSolid("W1", face)])


# --- strings --------------------------------------------------------------------------------------------------------


def decoded(string):
    """ISO 10303-21, 6.4.3, without the directives nothing here writes: an independent reading of a string."""
    text, i, out = string.decode("ascii"), 1, []
    while i < len(text) - 1:
        if text.startswith("''", i) or text.startswith("\\\\", i):
            out.append(text[i])
            i += 2
        elif text.startswith(("\\X2\\", "\\X4\\"), i):
            width, end = (4, 8)[text[i + 2] == "4"], text.index("\\X0\\", i)
            digits = text[i + 4 : end]
            assert len(digits) % width == 0
            out += [chr(int(digits[k : k + width], 16)) for k in range(0, len(digits), width)]
            i = end + 4
        else:
            assert 32 <= ord(text[i]) < 127
            assert text[i] not in "\\'"
            out.append(text[i])
            i += 1
    return "".join(out)


characters = st.characters(exclude_categories=["Cs"], exclude_characters="\0").filter(
    lambda c: not 0xFDD0 <= ord(c) < 0xFDF0
)
awkward = st.sampled_from(
    ["\\", "'", "''", "\\X2\\", "00E9", "\\X0\\", "\\N\\", "\\S\\i", "é", "😀", "\n", "#12", ";\n"]
)
texts = st.lists(characters | awkward).map("".join)


@settings(deadline=None)
@given(texts)
def test_quoted_reads_back(text):
    assert decoded(quoted(text)) == text


@settings(deadline=None)
@given(texts, st.randoms(use_true_random=False))
def test_requoted_is_quoted_whatever_the_line_breaks(text, chance):
    raw = b"'" + shielded(text).replace("'", "''").encode() + b"'"
    for _ in range(3):  # Open Cascade breaks lines by bytes, within a character too
        at = chance.randrange(1, len(raw))
        raw = raw[:at] + b"\n" + raw[at:]
    assert requoted(raw) == quoted(text)


def test_what_is_no_character_becomes_the_replacement_character():
    assert shielded("a\ud800b\ufdd0") == "a\ufffdb\ufffd"
    assert shielded("\ud83d\ude00") == "😀"
    assert quoted("a\ud800") == rb"'a\X2\FFFD\X0\'"
