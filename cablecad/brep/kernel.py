"""The one place that knows Open Cascade's names and habits in OCP 7.9 and OCP 8.0.

* Names: arrays, lists and maps moved to `OCP.collections` in 8.0; here they have their 8.0 names in both.
* Errors: `occ_errors` turns Open Cascade's exceptions, which share no base in Python, into errors of ours.
* Silence: Open Cascade prints to stdout, where only results belong; `silence` stops it and puts back what it found.
* Settings: `interface_settings` sets the process-wide parameters of the STEP translator and restores them.

Neither silence nor settings are per thread: Open Cascade keeps one of each for the whole process. Threads wait for each
other where they need settings.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Protocol, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from cablecad.errors import CablecadError, MissingDependencyError

INSTALL = """Open Cascade (the Python package OCP) is needed and {problem}. Install it by one of
  pip install "cablecad[ocp]"      cablecad alone
  pip install "cablecad[novtk]"    cablecad alone, smaller: without VTK
  pip install cadquery             or build123d: cablecad uses the Open Cascade they bring
Never have both cadquery-ocp and cadquery-ocp-novtk: they own the same files, and removing one breaks the other."""

try:
    import OCP

    OCP_VERSION: str = OCP.__version__
    # mypy reads the stubs of 8.0; at run time the version decides.
    if TYPE_CHECKING or int(OCP_VERSION.split(".", maxsplit=1)[0]) >= 8:
        from OCP.collections import (
            Array1_double,
            Array1_gp_Pnt,
            Array1_int,
            HArray1_gp_Pnt,
            List_TopoDS_Shape,
            Sequence_TDF_Label,
        )
        from OCP.collections import IndexedMap_TopoDS_Shape_TopTools_ShapeMapHasher as IndexedMap_TopoDS_Shape
    else:
        from OCP.TColgp import TColgp_Array1OfPnt as Array1_gp_Pnt
        from OCP.TColgp import TColgp_HArray1OfPnt as HArray1_gp_Pnt
        from OCP.TColStd import TColStd_Array1OfInteger as Array1_int
        from OCP.TColStd import TColStd_Array1OfReal as Array1_double
        from OCP.TDF import TDF_LabelSequence as Sequence_TDF_Label
        from OCP.TopTools import TopTools_IndexedMapOfShape as IndexedMap_TopoDS_Shape
        from OCP.TopTools import TopTools_ListOfShape as List_TopoDS_Shape

    from OCP.gp import gp_Pnt
    from OCP.Interface import Interface_Static
    from OCP.Message import Message
    from OCP.STEPCAFControl import STEPCAFControl_Controller
    from OCP.STEPControl import STEPControl_Controller
    from OCP.TopAbs import TopAbs_ShapeEnum
    from OCP.TopExp import TopExp
    from OCP.TopoDS import TopoDS, TopoDS_Shape
except ModuleNotFoundError as error:
    problem = "is not installed" if error.name == "OCP" else f"lacks its part {error.name}"
    raise MissingDependencyError(INSTALL.format(problem=problem)) from error
except ImportError as error:  # a library it is linked to, or a version out of the supported range
    problem = f"could not be loaded ({error})"
    if "libGL" in str(error):  # on a bare Linux, where the flavour with VTK is linked to what desktops have
        problem += ": on Debian or Ubuntu apt-get install libgl1, on Fedora dnf install mesa-libGL, brings that library"
    raise MissingDependencyError(INSTALL.format(problem=problem)) from error

__all__ = [
    "OCP_VERSION",
    "Array1_double",
    "Array1_gp_Pnt",
    "Array1_int",
    "HArray1_gp_Pnt",
    "IndexedMap_TopoDS_Shape",
    "List_TopoDS_Shape",
    "Sequence_TDF_Label",
    "TopoDS",
    "array1_of_doubles",
    "array1_of_ints",
    "array1_of_points",
    "interface_settings",
    "items_of",
    "list_of_shapes",
    "occ_errors",
    "silence",
    "subshapes",
]


T_co = TypeVar("T_co", covariant=True)
T = TypeVar("T")


class _Sequence(Protocol[T_co]):
    def Upper(self) -> int: ...
    def __iter__(self) -> Iterator[T_co]: ...


# --- arrays: `.tolist()` first, because one numpy scalar costs more than the rest of its pole (1 us in all), and one
# --- point for all, which an array copies ---------------------------------------------------------------------------


def array1_of_doubles(values: ArrayLike) -> Array1_double:
    """Values of shape (n,) as an array that counts from 1."""
    numbers = np.asarray(values, dtype=float).tolist()
    array = Array1_double(1, len(numbers))
    for i, number in enumerate(numbers, 1):
        array.SetValue(i, number)
    return array


def array1_of_ints(values: ArrayLike) -> Array1_int:
    """Integers of shape (n,), such as multiplicities, as an array that counts from 1."""
    numbers = np.asarray(values, dtype=int).tolist()
    array = Array1_int(1, len(numbers))
    for i, number in enumerate(numbers, 1):
        array.SetValue(i, number)
    return array


def array1_of_points(points: ArrayLike) -> Array1_gp_Pnt:
    """Points of shape (n, 3) [mm] as an array that counts from 1."""
    rows = np.asarray(points, dtype=float).tolist()
    array, point = Array1_gp_Pnt(1, len(rows)), gp_Pnt()
    for i, (x, y, z) in enumerate(rows, 1):
        point.SetCoord(x, y, z)
        array.SetValue(i, point)
    return array


def list_of_shapes(shapes: Sequence[TopoDS_Shape]) -> List_TopoDS_Shape:
    """Shapes as the list Open Cascade's algorithms take."""
    shape_list = List_TopoDS_Shape()
    for shape in shapes:
        shape_list.Append(shape)
    return shape_list


def items_of(sequence: _Sequence[T]) -> list[T]:
    """What a sequence of Open Cascade's holds.

    Counted, because to run into the end of one is an exception in C++ that takes half a millisecond.
    """
    return [item for _, item in zip(range(sequence.Upper()), sequence, strict=False)]


def subshapes(shape: TopoDS_Shape, kind: TopAbs_ShapeEnum) -> list[TopoDS_Shape]:
    """Every subshape of a kind once, in the order met; placed as it is in `shape`."""
    found = IndexedMap_TopoDS_Shape()
    TopExp.MapShapes_s(shape, kind, found)
    return [found.FindKey(i) for i in range(1, found.Extent() + 1)]


# --- errors, silence, settings --------------------------------------------------------------------------------------


@contextmanager
def occ_errors(kind: type[CablecadError], doing: str, remedy: str) -> Iterator[None]:
    """Turn an exception of Open Cascade's in this block into an error of ours.

    Args:
        kind: The class raised, `GeometryError` or `ExchangeError` as a rule.
        doing: What was going on, after "while": "writing loom.step".
        remedy: What the user can do about it, a clause.

    Raises:
        kind: Open Cascade raised; every other exception passes unchanged.
    """
    try:
        yield
    except Exception as error:
        # pybind11 registers Standard_Failure and its C++ heirs as unrelated classes: only their module is common.
        if not type(error).__module__.startswith("OCP."):
            raise
        said = f"{type(error).__name__}: {error}".rstrip(": ")
        raise kind(f"Open Cascade failed while {doing} ({said}); {remedy}") from error


@contextmanager
def silence() -> Iterator[None]:
    """Keep Open Cascade from printing in this block; afterwards its printers are as they were.

    Only what was taken away is put back, so blocks that overlap, in whatever order they end, lose no printer of a host.
    """
    messenger = Message.DefaultMessenger_s()
    printers = items_of(messenger.Printers())
    try:
        messenger.ChangePrinters().Clear()
        yield
    finally:
        for printer in printers:
            messenger.AddPrinter(printer)


@contextmanager
def interface_settings(values: Mapping[str, str | int | float]) -> Iterator[None]:
    """Set parameters of the STEP translator in this block, and put back the values found.

    They are the process's own: another thread that comes to such a block waits until this one has ended.

    Args:
        values: Name such as ``write.step.unit`` to a value of the parameter's own type; an enumeration takes the
            name of its value or its number.

    Raises:
        ValueError: Open Cascade knows no such parameter, or refuses the value.
    """
    with _locks["settings"]:
        # These define the parameters; before that they are neither found nor settable.
        STEPControl_Controller.Init_s()
        STEPCAFControl_Controller.Init_s()
        found: dict[str, str | int | float] = {}
        try:
            for name, value in values.items():
                if not Interface_Static.IsPresent_s(name):
                    raise ValueError(f"Open Cascade {OCP_VERSION} has no parameter {name}")
                found[name] = _setting(name, type(value))
                _set(name, value)
            yield
        finally:
            for name, value in found.items():
                _set(name, value)


_locks = {"settings": threading.RLock()}
if hasattr(os, "register_at_fork"):
    # In a forked child the thread that may have held it is gone.
    os.register_at_fork(after_in_child=lambda: _locks.update(settings=threading.RLock()))


def _setting(name: str, kind: type) -> str | int | float:
    if kind is int:
        return Interface_Static.IVal_s(name)
    return Interface_Static.RVal_s(name) if kind is float else Interface_Static.CVal_s(name)


def _set(name: str, value: str | int | float) -> None:
    if isinstance(value, str):
        taken = Interface_Static.SetCVal_s(name, value)
    elif isinstance(value, int):
        taken = Interface_Static.SetIVal_s(name, value)
    else:
        taken = Interface_Static.SetRVal_s(name, value)
    if not taken:
        raise ValueError(f"Open Cascade {OCP_VERSION} refuses {value!r} for its parameter {name}")
