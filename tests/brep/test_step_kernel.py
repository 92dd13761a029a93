"""The kernel's names, errors, silence and settings, in whichever version is installed."""

import os
import subprocess
import sys
import threading

import numpy as np
import pytest

from cablecad.brep import kernel
from cablecad.brep.kernel import interface_settings, occ_errors, silence, subshapes
from cablecad.errors import ExchangeError, GeometryError

# --- arrays ---------------------------------------------------------------------------------------------------------


def test_arrays_hold_what_was_given():
    numbers, points = np.array([0.1, -2.0, 3e300]), np.arange(24.0).reshape(2, 4, 3) / 7.0
    array = kernel.array1_of_doubles(numbers)
    assert [array.Value(i) for i in range(array.Lower(), array.Upper() + 1)] == numbers.tolist()
    integers = kernel.array1_of_ints(np.array([4, 1, 4]))
    assert [integers.Value(i) for i in (1, 2, 3)] == [4, 1, 4]
    row = kernel.array1_of_points(points[1])
    assert [row.Value(j + 1).Y() for j in range(4)] == points[1, :, 1].tolist()


def test_items_of_a_sequence():
    from OCP.TDF import TDF_Data

    labels = kernel.Sequence_TDF_Label()
    assert kernel.items_of(labels) == []
    data = TDF_Data()  # its labels live as long as it does
    root = data.Root()
    for tag in (3, 1, 2):
        labels.Append(root.FindChild(tag))
    assert [label.Tag() for label in kernel.items_of(labels)] == [3, 1, 2]


def test_subshapes_and_lists():
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox
    from OCP.TopAbs import TopAbs_ShapeEnum

    box = BRepPrimAPI_MakeBox(1.0, 2.0, 3.0).Shape()
    counts = [len(subshapes(box, kind)) for kind in (TopAbs_ShapeEnum.TopAbs_FACE, TopAbs_ShapeEnum.TopAbs_EDGE)]
    assert counts == [6, 12]
    faces = subshapes(box, TopAbs_ShapeEnum.TopAbs_FACE)
    assert kernel.list_of_shapes(faces).Extent() == 6
    assert kernel.TopoDS.Face(faces[0]).ShapeType() == TopAbs_ShapeEnum.TopAbs_FACE


# --- errors ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", [GeometryError, ExchangeError])
def test_exceptions_of_open_cascade_become_ours(kind):
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge
    from OCP.gp import gp_Dir, gp_Pnt

    said = r"^Open Cascade failed while sweeping W1 \(%s.*\); give a longer cable$"
    with (
        pytest.raises(kind, match=said % "Standard_ConstructionError: gp_Dir"),
        occ_errors(kind, "sweeping W1", "give a longer cable"),
    ):
        gp_Dir(0.0, 0.0, 0.0)
    with (
        pytest.raises(kind, match=said % "StdFail_NotDone"),
        occ_errors(kind, "sweeping W1", "give a longer cable"),
    ):
        BRepBuilderAPI_MakeEdge(gp_Pnt(0, 0, 0), gp_Pnt(0, 0, 0)).Edge()


@pytest.mark.parametrize("failure", [ZeroDivisionError("mine"), KeyboardInterrupt(), ExchangeError("mine")])
def test_other_exceptions_pass_unchanged(failure):
    with pytest.raises(type(failure)) as caught, occ_errors(GeometryError, "sweeping W1", "give a longer cable"):
        raise failure
    assert caught.value is failure


MISSING = """
import sys
import threading
class Refuse:
    def find_spec(self, name, path=None, target=None):
        if name == "OCP" or name.startswith("OCP."):
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)
sys.meta_path.insert(0, Refuse())
from cablecad.errors import MissingDependencyError
for module in ("kernel", "document", "step"):
    try:
        __import__(f"cablecad.brep.{module}")
    except MissingDependencyError as error:
        print(error)
"""


def test_without_open_cascade_every_way_to_install_it_is_told():
    said = subprocess.run([sys.executable, "-c", MISSING], capture_output=True, text=True, check=True).stdout
    assert said.count("is needed and is not installed") == 3
    for line in ('pip install "cablecad[ocp]"', 'pip install "cablecad[novtk]"', "pip install cadquery"):
        assert said.count(line) == 3


# --- silence --------------------------------------------------------------------------------------------------------

SPEAK = """
import sys
import threading
from pathlib import Path
from cablecad.brep.kernel import silence
from cablecad.brep.step import CableSolid, read_parts, read_step, write_step
from cablecad.errors import ExchangeError
from cablecad.model import Part
from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox
from OCP.STEPControl import STEPControl_Reader, STEPControl_StepModelType, STEPControl_Writer

folder, whole = Path(sys.argv[1]), Path(sys.argv[2])
data = whole.read_bytes()
(folder / "damaged.stp").write_bytes(data.replace(b"VERTEX_POINT('',", b"VERTEX_POINT(',"))
(folder / "lossy.stp").write_bytes(data.replace(b"DIRECTION('',(1.,0.,0.))", b"DIRECTION('',(0.,0.,0.))"))
(folder / "bad.stp").write_bytes(b"ISO-10303-21;HEADER;ENDSEC;DATA;(('\\nENDSEC;\\nEND-ISO-10303-21;\\n")
box = BRepPrimAPI_MakeBox(1.0, 2.0, 3.0).Solid()
if sys.argv[3] == "ours":
    parts = read_parts([Part("a", whole)])
    for name in ("damaged.stp", "lossy.stp", "bad.stp"):
        try:
            read_step(folder / name)
        except ExchangeError:
            pass
    write_step(folder / "out.stp", "scene", parts, [CableSolid("W1", box)])
else:
    with silence():
        pass
    reader = STEPControl_Reader()
    reader.ReadFile(str(folder / "bad.stp"))
    writer = STEPControl_Writer()
    writer.Transfer(box, STEPControl_StepModelType.STEPControl_AsIs)
"""


@pytest.mark.parametrize("who", ["ours", "host"])
def test_open_cascade_prints_nothing_for_us_and_all_for_its_host(tmp_path, who):
    whole = os.path.join(os.path.dirname(__file__), "..", "data", "io1-cm-214.stp")  # noqa: PTH118, PTH120
    process = subprocess.run(
        [sys.executable, "-c", SPEAK, tmp_path, whole, who], capture_output=True, text=True, check=True
    )
    if who == "ours":
        assert process.stdout == ""
        assert all(line.startswith(str(tmp_path)) for line in process.stderr.splitlines())  # the log's own warnings
        assert (tmp_path / "out.stp").exists()
    else:
        assert "Statistics on Transfer" in process.stdout


def test_printers_are_as_they_were():
    from OCP.Message import Message, Message_PrinterOStream

    messenger = Message.DefaultMessenger_s()

    before = list(messenger.Printers())
    with silence():
        assert list(messenger.Printers()) == []
        with silence():
            pass
        assert list(messenger.Printers()) == []
    assert list(messenger.Printers()) == before

    # Blocks that overlap, as generators and tasks make them, and a printer that comes in the middle.
    one, two = silence(), silence()
    one.__enter__()
    two.__enter__()
    one.__exit__(None, None, None)
    two.__exit__(None, None, None)
    assert list(messenger.Printers()) == before
    with silence():
        added = Message_PrinterOStream()
        messenger.AddPrinter(added)
    assert set(messenger.Printers()) == {*before, added}
    messenger.RemovePrinter(added)


# --- settings -------------------------------------------------------------------------------------------------------


def test_settings_are_set_and_put_back():
    from OCP.Interface import Interface_Static

    def found():
        return (
            Interface_Static.CVal_s("write.step.unit"),
            Interface_Static.IVal_s("write.surfacecurve.mode"),
            Interface_Static.RVal_s("read.precision.val"),
        )

    with interface_settings({}):
        before = found()
    values = {"write.step.unit": "INCH", "write.surfacecurve.mode": 0, "read.precision.val": 0.25}
    with interface_settings(values):
        assert found() == tuple(values.values())
        with interface_settings({"write.step.unit": "M"}):
            assert found() == ("M", 0, 0.25)
        assert found() == tuple(values.values())
    assert found() == before
    with pytest.raises(ZeroDivisionError), interface_settings(values):
        raise ZeroDivisionError
    assert found() == before


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"write.step.unit": "INCH", "no.such.name": 1}, "has no parameter no.such.name"),
        ({"write.step.unit": "INCH", "write.step.schema": "AP1"}, "refuses 'AP1' for its parameter write.step.schema"),
    ],
)
def test_settings_that_do_not_exist_change_nothing(values, said):
    from OCP.Interface import Interface_Static

    with interface_settings({}):
        before = Interface_Static.CVal_s("write.step.unit")
    with pytest.raises(ValueError, match=said), interface_settings(values):
        pass
    assert Interface_Static.CVal_s("write.step.unit") == before


def unit():
    from OCP.Interface import Interface_Static

    return Interface_Static.CVal_s("write.step.unit")


def test_threads_take_turns_with_settings():
    with interface_settings({}):
        before = unit()
    seen = []

    def other():
        with interface_settings({"write.step.unit": "INCH"}):
            seen.append(unit())

    with interface_settings({"write.step.unit": "M"}):
        thread = threading.Thread(target=other)
        thread.start()
        thread.join(0.2)
        assert (seen, unit()) == ([], "M")
    thread.join(10.0)
    assert (seen, unit()) == (["INCH"], before)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_a_forked_child_does_not_wait_for_a_thread_it_has_not():
    """Forked while another thread is at its settings."""
    code = """
import os, sys, threading
from cablecad.brep.kernel import interface_settings
held, done = threading.Event(), threading.Event()
def hold():
    with interface_settings({"write.step.unit": "M"}):
        held.set()
        done.wait()
thread = threading.Thread(target=hold)
thread.start()
held.wait()
child = os.fork()
if not child:
    with interface_settings({"write.step.unit": "INCH"}):
        os._exit(7)
status = os.waitpid(child, 0)[1]
done.set()
thread.join()
sys.exit(os.waitstatus_to_exitcode(status))
"""
    done = subprocess.run([sys.executable, "-W", "ignore", "-c", code], timeout=60, check=False)
    assert done.returncode == 7
