"""STEP files damaged within: refused before Open Cascade acts on them, never read at a wrong size without a word.

What once killed the process is read in a process of its own.
"""

import logging
import math
import re
import subprocess
import sys
from pathlib import Path

import pytest
from step_files import changed_copy, cylinder, write_plain

from cablecad.brep.part21 import entity_name, flaw, with_whole_measures
from cablecad.brep.step import read_step, read_tree
from cablecad.errors import ExchangeError

ROOT = Path(__file__).parents[2]
BRACKET = ROOT / "samples" / "parts" / "bracket.step"
CONNECTOR = ROOT / "samples" / "parts" / "connector.step"
OCCURRENCE = ROOT / "tests" / "data" / "colored-occurrence.stp"
IO1 = ROOT / "tests" / "data" / "io1-cm-214.stp"

MILLIMETRE = b"SI_UNIT(.MILLI.,.METRE.)"
UNITS = b"GLOBAL_UNIT_ASSIGNED_CONTEXT((#1250,#1251,#1252))"


@pytest.fixture(scope="module")
def inches(tmp_path_factory):
    """By Open Cascade: a cylinder of 1 inch across and 1 inch high, in inches."""
    return written(tmp_path_factory.mktemp("inches") / "inch.step", "INCH")


def written(path, unit):
    return write_plain(path, [cylinder(12.7, 25.4)], unit)


VOLUME = math.pi * 12.7**2 * 25.4


def volume(path):
    (root,) = read_tree(path)
    return root.volume


# --- units ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "new",
    [
        b"SI_UNIT(.MILLJ.,.METRE.)",
        b"SI_UNIT(0MILLI.,.METRE.)",
        b"SI_UNIT(MILLI,.METRE.)",
        b"SI_UNIT('MILLI',.METRE.)",
        b"SI_UNIT(*,.METRE.)",
        b"SI_UNIT(.MILLI.,.METRX.)",
        b"SI_UNIT(.MILLI.,.RADIAN.)",
        b"SI_UNIT(.MILLI.,$)",
        b"SI_UNIT(.MILLI.)",
    ],
)
def test_damaged_unit_of_length_is_refused(tmp_path, new):
    with pytest.raises(ExchangeError, match=r"is damaged \(its entity #1250, SiUnitAndLengthUnit: .*export it again"):
        read_step(changed_copy(tmp_path, BRACKET, (MILLIMETRE, new)))


@pytest.mark.parametrize(
    ("old", "new", "named"),
    [
        (b"LENGTH_UNIT()", b"LENGTX_UNIT()", "#1249, GeomRepContextAndGlobUnitAssCtxAndGlobUncertaintyAssCtx: .*unit"),
        (b"LENGTH_UNIT()", b"MASS_UNIT()", "#1250, SiUnitAndMassUnit: a MassUnit is the metre"),
        (MILLIMETRE, b"SI_UNIX(.MILLI.,.METRE.)", "#1249, .*unit"),
        (b"SI_UNIT($,.RADIAN.)", b"SI_UNIT($,RADIAN)", "#1251, SiUnitAndPlaneAngleUnit: "),
        (UNITS, b"GLOBAL_UNIT_ASSIGNED_CONTEXT($)", r"#1249, .*\(units\) not a LIST"),
        (UNITS, b"GLOBAL_UNIT_ASSIGNED_CONTEXT(($,#1251))", "#1249, .*not an Entity"),
        (UNITS, b"GLOBAL_UNIT_ASSIGNED_CONTEXT((#1249,#1251))", "#1249, .*illegal type"),
        (UNITS, UNITS.replace(b"TEXT", b"TEXX"), r"AdvancedBrepShapeRepresentation: .*\(context_of_items\)"),
        (UNITS, b"", r"AdvancedBrepShapeRepresentation: .*\(context_of_items\)"),
        (b"LENGTH_MEASURE(1.E-07),#1250", b"LENGTH_MEASURE(1.E-07),#1", "#1253, UncertaintyMeasureWithUnit: "),
    ],
)
def test_damaged_context_of_units_is_refused(tmp_path, old, new, named):
    with pytest.raises(ExchangeError, match=rf"is damaged \(its entity .*{named}"):
        read_step(changed_copy(tmp_path, BRACKET, (old, new)))


@pytest.mark.parametrize("units", [b"(())", b"((#1251,#1252))"])
def test_without_a_unit_of_length_mm_is_assumed_and_told(tmp_path, caplog, units):
    path = changed_copy(tmp_path, BRACKET, (UNITS, b"GLOBAL_UNIT_ASSIGNED_CONTEXT" + units))
    with caplog.at_level(logging.WARNING):
        document = read_step(path)
    (warning,) = document.warnings
    assert warning.startswith("it does not say what its lengths are in: mm is assumed; ")
    assert [record.getMessage() for record in caplog.records] == [f"{path}: {warning}"]
    assert document.tree()[0].volume == pytest.approx(volume(BRACKET), rel=1e-12)


def references(path):
    """Of an inch: the conversion, its measure and the millimetre it rests on, and the unit of angles."""
    text = path.read_bytes()
    inch, measure = re.search(rb"(#\d+) = \( CONVERSION_BASED_UNIT\('INCH',(#\d+)\)", text).groups()
    millimetre = re.search(rb"LENGTH_MEASURE_WITH_UNIT\(25.4,(#\d+)\)", text)[1]
    angle = re.search(rb"(#\d+) = \( NAMED_UNIT\(\*\) PLANE_ANGLE_UNIT", text)[1]
    return {b"INCH": inch, b"MEASURE": measure, b"MM": millimetre, b"ANGLE": angle}


@pytest.mark.parametrize(
    ("old", "new", "named"),
    [
        (b"LENGTH_MEASURE_WITH_UNIT", b"LENGTH_MEASURX_WITH_UNIT", "its factor (is no measure|or its name)"),
        (b"LENGTH_MEASURE_WITH_UNIT", b"LENGTH_MEASURE_WITH_UNIX", "its factor (is no measure|or its name)"),
        (b"(25.4,MM)", b"(25X4,MM)", "its factor is no measure that can be read"),
        (b"(25.4,MM)", b"(25.4,$)", "its factor is no measure that can be read"),
        (b"(25.4,MM)", b"($,MM)", "its factor is 0, not above 0"),
        (b"(25.4,MM)", b"(-25.4,MM)", "its factor is -25.4, not above 0"),
        (b"(25.4,MM)", b"(1.E400,MM)", "its factor is inf, not above 0"),
        (b"(25.4,MM)", b"(LENGTX_MEASURE(25.4),MM)", "its factor is 0, not above 0"),
        (b"(25.4,MM)", b"(25.4,ANGLE)", "its factor is in PlaneAngleUnit, not in LengthUnit"),
        (b"(25.4,MM)", b"(25.4,INCH)", "its factor leads back to itself"),
        (b"'INCH',MEASURE", b"'INCH',MM", "its factor (is no measure|or its name)"),
        (b"'INCH',MEASURE", b"'INCH',$", r"\(conversion_factor\) not an Entity|its factor or its name cannot be read"),
        (b".MILLI.", b".MLLLI.", "SiUnitAndLengthUnit: its prefix or its name cannot be read"),
        (b"CONVERSION_BASED_UNIT", b"CONVERSION_BASED_UNIX", r"\(unit\) : Entity has illegal type"),
    ],
)
def test_damaged_conversion_of_a_unit_is_refused(tmp_path, inches, old, new, named):
    for name, reference in references(inches).items():
        old, new = old.replace(b"," + name, b"," + reference), new.replace(b"," + name, b"," + reference)
    path = changed_copy(tmp_path, inches, (old, new))
    assert volume(inches) == pytest.approx(VOLUME, rel=1e-9)
    with pytest.raises(ExchangeError, match=rf"is damaged \(its entity #\d+, .*({named})"):
        read_step(path)


@pytest.mark.parametrize("unit", ["MM", "INCH", "M", "FT", "KM", "UM", "MIL"])
def test_sound_units_are_read(tmp_path, unit):
    path = written(tmp_path / "sound.step", unit)
    assert volume(path) == pytest.approx(VOLUME, rel=1e-8)
    assert read_step(path).warnings == ()


def test_conversion_that_rests_on_another(tmp_path, inches):
    """Open Cascade follows the first alone: an inch of 2.54 times 10 mm would be taken for 1 mm."""
    millimetre = references(inches)[b"MM"]
    ten = (
        rb"(2.54,#9001);#9001 = ( CONVERSION_BASED_UNIT('CM',#9002) LENGTH_UNIT() NAMED_UNIT(#9003) );"
        rb"#9003 = DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.);"
        rb"#9002 = LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(10.)," + millimetre + rb")"
    )
    path = changed_copy(tmp_path, inches, (b"(25.4," + millimetre + b")", ten))
    assert volume(path) == pytest.approx(VOLUME, rel=1e-9)


@pytest.mark.parametrize(
    "measure",
    [
        b"( LENGTH_MEASURE_WITH_UNIT() MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),MM) )",
        b"(LENGTH_MEASURE_WITH_UNIT()\nMEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),MM))",
        b"MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),MM)",
        b"LENGTH_MEASURE_WITH_UNIT(POSITIVE_LENGTH_MEASURE(25.4),MM)",
    ],
)
def test_measure_in_every_form(tmp_path, inches, measure):
    """Of the first, which has two parts, Open Cascade makes nothing, and of the inch 1 mm."""
    millimetre = references(inches)[b"MM"]
    whole = b"LENGTH_MEASURE_WITH_UNIT(25.4," + millimetre + b")"
    path = changed_copy(tmp_path, inches, (whole, measure.replace(b"MM", millimetre)))
    assert volume(path) == pytest.approx(VOLUME, rel=1e-9)


def test_measures_of_two_parts_are_made_one():
    angle = b"#7=(MEASURE_WITH_UNIT(PLANE_ANGLE_MEASURE(0.01),#2) PLANE_ANGLE_MEASURE_WITH_UNIT());"
    assert with_whole_measures(angle) == b"#7=MEASURE_WITH_UNIT(PLANE_ANGLE_MEASURE(0.01),#2);"
    more = b"#7=(LENGTH_MEASURE_WITH_UNIT() MEASURE_REPRESENTATION_ITEM() MEASURE_WITH_UNIT(L(1.),#2) R(''));"
    assert with_whole_measures(more) == more


# --- what killed the process ----------------------------------------------------------------------------------------

LAYER = rb"#234=PRESENTATION_LAYER_ASSIGNMENT('\X2\00E9\X0\.1'"
READ_EACH = """
import sys
from cablecad.brep.step import read_step
from cablecad.errors import ExchangeError
for path in sys.argv[1:]:
    try:
        document = read_step(path)
        print(document.solids, *document.warnings, flush=True)
    except ExchangeError as error:
        print("refused", error, flush=True)
"""


LETHAL = [
    (BRACKET, b"DEFINITIONAL_REPRESENTATION('',(#1181)", b"DEFINITIONAL_REPRESENTATION('',(X1181)", "#1180, Def"),
    (BRACKET, b"('',(#1069),#1073)", b"('',.T.,#1073)", "#1068, DefinitionalRepresentation: its items are not one"),
    (CONNECTOR, b"REPRESENTATION('',(#716)", b"REPRESENTATION('',(#717)", "#715, DefinitionalRepresentation: its"),
    (CONNECTOR, b"REPRESENTATION('',(#716)", b"REPRESENTATION('',(#7)", "#715, DefinitionalRepresentation: its"),
    (CONNECTOR, b"REPRESENTATION('',(#716)", b"REPRESENTATION('',()", "#715, DefinitionalRepresentation: its"),
    (OCCURRENCE, b"REPRESENTATION('',(#98)", b"REPRESENTATION('',(#246)", "#97, DefinitionalRepresentation: its"),
    (OCCURRENCE, b"#98=LINE(", b"#98=FOO(", "#97, DefinitionalRepresentation: its items are not one curve"),
    (OCCURRENCE, b"'','',#40,#10)", b"'','',#40,())", "RelationshipWithTransformation: "),
    (OCCURRENCE, b"#10=SHAPE_REPRESENTATION(", b"#10=SHAPX_REPRESENTATION(", "used_representation) : Entity has"),
    (OCCURRENCE, LAYER, b"#234=PRESENTATION_LAYER_ASSIGNMENT(()", "2 its colours could not be read; "),
    (OCCURRENCE, b"STYLE_BY_CONTEXT((#250)", b"STYLE_BY_CONTEXT((''),", "#249 are no entities"),
    (OCCURRENCE, b"STYLE_BY_CONTEXT((#250),", b"STYLE_BY_CONTEXT((''),", "#249 are no entities"),
    (OCCURRENCE, b"STYLE_BY_CONTEXT((#250),", b"STYLE_BY_CONTEXT(($),", "#249 are no entities"),
    (OCCURRENCE, b"STYLE_BY_CONTEXT((#250),", b"STYLE_BY_CONTEXT((()),", "#249 are no entities"),
    (OCCURRENCE, b"STYLE_BY_CONTEXT((#250),", b"STYLE_BY_CONTEXT($,", "2 its colours could not be read; "),
    (CONNECTOR, b"#290 = CARTESIAN_POINT('',(0.,8.,-8.)", b"#290 = CARTESIAN_POINT('',()", "#289, VertexPoint: its"),
    (CONNECTOR, b"#290 = CARTESIAN_POINT('',(0.,8.,", b"#290 = CARTESIAN_POINT('',(0.8,", "#289, VertexPoint: its"),
    (CONNECTOR, b"#12 = CARTESIAN_POINT('',(0.,0.,0.)", b"#12 = CARTESIAN_POINT('',()", "#11, Axis2Placement3d: its"),
    (CONNECTOR, b"('',(-3.,0.,0.))", b"('',(1.E300,0.,0.))", "holds 1.E300, and no coordinate or size is beyond"),
    (IO1, b"#3760=CIRCLE('',#3750,31.)", b"#3760=CIRCLE('',#3750,1.E300)", "its entity #3760 holds 1.E300, and no"),
]


@pytest.fixture(scope="module")
def ended(tmp_path_factory):
    """What became of each: the lines of one process that read them in turn, as far as it lived."""
    paths = []
    for source, old, new, _ in LETHAL:
        paths.append(changed_copy(tmp_path_factory.mktemp("lethal"), source, (old, new)))
    child = subprocess.run(
        [sys.executable, "-c", READ_EACH, *paths], capture_output=True, text=True, cwd=ROOT, timeout=300, check=False
    )
    return dict(zip(paths, child.stdout.splitlines(), strict=False)), paths


@pytest.mark.parametrize("number", range(len(LETHAL)))
def test_damage_does_not_kill_the_process(ended, number):
    lines, paths = ended
    path, said = paths[number], LETHAL[number][-1]
    assert path in lines
    assert said in lines[path]
    if lines[path].startswith("refused"):
        assert f"refused {path} is damaged" in lines[path]
        assert "export it again" in lines[path]


def test_broken_layers_are_left_out_and_told(tmp_path):
    path = changed_copy(tmp_path, OCCURRENCE, (LAYER, b"#234=PRESENTATION_LAYER_ASSIGNMENT(()"))
    document = read_step(path)
    assert any(warning.startswith("its layers could not be read; ") for warning in document.warnings)
    assert all(node.layers == () for node in document.tree()[0].walk())


# --- the look before reading ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (b"1.E-07", b"1.E-300"),
        (b"LENGTH_MEASURE(1.E-07)", b"LENGTH_MEASURE(1.E+300)"),  # of a property: no geometry
        (b"'distance_accuracy_value'", b"'EN 1.4301E235, 1.E300'"),
        (b"'distance_accuracy_value'", b"'PRESENTATION_STYLE_BY_CONTEXT((1.))'"),
        (b"#1250 = ", b"/* 1.E300 */#1250 = "),
    ],
)
def test_what_is_no_size_in_geometry_may_be_large(old, new):
    data = BRACKET.read_bytes()
    assert old in data
    assert flaw(data.replace(old, new, 1)) is None


@pytest.mark.parametrize("real", [b"1.E101", b"-1.e+300", b"1E0400", b"12.5E+99999999"])
def test_reals_of_absurd_size_are_refused(real):
    data = CONNECTOR.read_bytes().replace(b"('',(-3.,0.,0.))", b"('',(" + real + b",0.,0.))", 1)
    assert f"holds {real.decode().lstrip('-')}, and no coordinate or size is beyond 1E100" in flaw(data)


@pytest.mark.parametrize("real", [b"2.E+100", b"1.E+099", b"1.E-300"])
def test_reals_that_open_cascade_writes_are_kept(real):
    assert flaw(CONNECTOR.read_bytes().replace(b"('',(-3.,0.,0.))", b"('',(" + real + b",0.,0.))", 1)) is None


def test_entities_are_called_as_in_the_file():
    data = b"ISO-10303-21;DATA;\n#10=A('#7=');/* #8= */#20 = B(#10);#5\n=C();"
    assert [entity_name(data, i) for i in (1, 2, 3)] == ["#10", "#20", "#5"]
    assert entity_name(data, 0) == entity_name(data, 4) == "of no name"
