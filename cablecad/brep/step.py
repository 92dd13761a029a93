"""STEP files in and out: names, colours, layers, assemblies and placements kept; always mm in memory.

Reading: the file is looked at before Open Cascade sees it, which would read half of a truncated file without a word
(`part21`), and once more before it makes shapes, where a damaged entity may kill the process, or a damaged unit scale
the part (`soundness`, `units`). What is then lost becomes a warning.
Writing: one AP214 assembly, plain ASCII, the same bytes for the same input in any process (`canonical`), whole or not
at all (`files`). The time in it is SOURCE_DATE_EPOCH, or 1970 where that is not set.

Not for threads: Open Cascade keeps its settings per process. Names of single faces and of the bodies within a product,
validation properties and PMI are not kept.

Measured on as1-oc-214 (0.4 MB) and 25 of it in one file (11 MB), one noisy core: 150 to 200 ms for each MB to read, of
which 10 to 15 for each of the two looks, and 80 to 95 to write, of which 14 for rewriting.
"""

from __future__ import annotations

import io
import logging
import os
from collections.abc import Iterator, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from functools import cache
from importlib.metadata import PackageNotFoundError
from importlib.metadata import version as installed_version
from os import PathLike
from pathlib import Path
from typing import cast

from cablecad.brep.kernel import OCP_VERSION, interface_settings, occ_errors, silence

# isort: split
from OCP.IFSelect import IFSelect_ReturnStatus
from OCP.STEPCAFControl import STEPCAFControl_Reader, STEPCAFControl_Writer
from OCP.STEPControl import STEPControl_StepModelType
from OCP.StepData import StepData_Protocol, StepData_StepModel, StepData_StepWriter
from OCP.StepRepr import StepRepr_NextAssemblyUsageOccurrence

from cablecad.brep.canonical import canonical
from cablecad.brep.document import CableSolid, Document, Node
from cablecad.brep.part21 import entity_name, flaw, is_utf8, quoted, with_whole_measures
from cablecad.brep.reals import REAL_FORMAT
from cablecad.brep.soundness import Failure, Findings, failures, look_at
from cablecad.errors import ExchangeError, UsageError
from cablecad.files import write_bytes
from cablecad.model import Part

_log = logging.getLogger(__name__)

# Open Cascade's own defaults but for the product's name: said here because a host may have set others.
_READ: dict[str, str | int] = {
    "xstep.cascade.unit": "MM",
    "read.precision.mode": "File",
    "read.surfacecurve.mode": "Default",
    "read.step.product.mode": "ON",
    "read.step.product.context": "all",
    "read.step.shape.repr": "All",
    "read.step.assembly.level": "all",
    "read.step.root.transformation": "ON",
    "read.step.all.shapes": "Off",
    "read.step.nonmanifold": "Off",
    "read.step.ideas": "Off",
    "read.step.tessellated": "On",
    "read.stepcaf.subshapes.name": 0,
    "step.angleunit.mode": "File",
}
_WRITE: dict[str, str | int] = {
    "xstep.cascade.unit": "MM",
    "write.step.unit": "MM",
    "write.step.schema": "AP214IS",
    "write.step.assembly": "Auto",
    "write.step.nonmanifold": "Off",
    "write.step.tessellated": "OnNoBRep",
    "write.step.vertex.mode": "Compound",
    "write.step.product.name": "cablecad",
    "write.stepcaf.subshapes.name": 0,
    "write.surfacecurve.mode": "On",
    "write.precision.mode": "Average",
}

_REEXPORT = "open it in the CAD package it came from and export it again as STEP AP214 or AP242"

_SHAPES = "check the solids; a shape that is not valid cannot be written"

_STATUS = {
    IFSelect_ReturnStatus.IFSelect_RetVoid: "nothing in it",
    IFSelect_ReturnStatus.IFSelect_RetError: "an error of its own",
    IFSelect_ReturnStatus.IFSelect_RetFail: "the text is no STEP",
}

_TRIPPED = ("Standard_NullObject",)
"""What Open Cascade raises over colours of some occurrences that it wrote itself; without them it reads the file."""

_LAST_TIME = 253402300799  # 9999-12-31T23:59:59, the last second a STEP file can tell


# --- reading --------------------------------------------------------------------------------------------------------


def read_step(path: str | PathLike[str]) -> Document:
    """Read a STEP file of any unit.

    Args:
        path: Of the file; in any script.

    Returns:
        The file's products, in mm; its `warnings` say what Open Cascade could not make of the file.

    Raises:
        ExchangeError: The file cannot be opened, is no STEP file, is cut off, or holds no shape.
    """
    path = Path(path)
    data = _contents(path)
    wrong = flaw(data)
    if wrong:
        raise ExchangeError(f"{path} {wrong}; {_REEXPORT}, or fetch it again")
    try:
        document = _read(path, data, colored=True)
    except ExchangeError as error:
        if type(error.__cause__).__name__ not in _TRIPPED:
            raise
        document = _read(path, data, colored=False)
    for warning in document.warnings:
        _log.warning("%s: %s", path, warning)
    return document


def _read(path: Path, data: bytes, *, colored: bool) -> Document:
    """What Open Cascade makes of a file, where wanted and possible with its colours."""
    settings = _READ | {"read.step.codepage": "UTF8" if is_utf8(data) else "CP1252"}
    with silence(), occ_errors(ExchangeError, f"reading {path}", _REEXPORT), interface_settings(settings):
        reader = STEPCAFControl_Reader()
        reader.SetNameMode(True)
        reader.SetPropsMode(False)
        reader.SetGDTMode(False)
        reader.SetMatMode(False)
        status = reader.ReadStream(path.name, io.BytesIO(with_whole_measures(data[data.index(b"ISO-10303-21") :])))
        if status != IFSelect_ReturnStatus.IFSelect_RetDone:
            raise ExchangeError(f"Open Cascade cannot read {path}: {_STATUS.get(status, 'stopped')}; {_REEXPORT}")
        if OCP_VERSION.startswith("7.") and (b"\\" in data or not data.isascii()):
            _name_by_id(reader.ChangeReader().StepModel())
        found = look_at(reader.ChangeReader().WS())
        if found.damage:
            shown = f"its entity {entity_name(data, found.damage.place)}, {found.damage}"
            raise ExchangeError(f"{path} is damaged ({shown}); {_REEXPORT}, or fetch it again")
        found = replace(found, colors=colored and found.colors)
        reader.SetColorMode(found.colors)
        reader.SetLayerMode(found.layers)
        document = Document(path.stem)
        if not reader.Transfer(document.handle) or document.is_empty:
            raise ExchangeError(f"{path} holds no shape; {_REEXPORT}, with its solids")
        lost = failures(reader.ChangeReader().WS().TransferReader().TransientProcess().CheckList(False))
    document.warnings = tuple(_warnings(data, found, lost, document))
    return document


def read_parts(parts: Sequence[Part]) -> list[tuple[Part, Document]]:
    """Read the files of rigid parts, each file once however many parts it serves.

    Raises:
        ExchangeError: As `read_step`.
    """
    documents: dict[str, Document] = {}
    placed = []
    for part in parts:
        key = os.path.realpath(part.step)
        if key not in documents:
            documents[key] = read_step(part.step)
        placed.append((part, documents[key]))
    return placed


def read_tree(path: str | PathLike[str]) -> tuple[Node, ...]:
    """The roots of a STEP file as plain nodes, to look at or to compare.

    Raises:
        ExchangeError: As `read_step`.
    """
    return read_step(path).tree()


def _contents(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except FileNotFoundError as error:
        raise ExchangeError(f"{path} does not exist; check the path, it is relative to {Path.cwd()}") from error
    except IsADirectoryError as error:
        raise ExchangeError(f"{path} is a folder; give the STEP file in it") from error
    except PermissionError as error:
        raise ExchangeError(f"{path} may not be read; check its permissions") from error
    except (OSError, ValueError) as error:  # ValueError: a path with a null character
        raise ExchangeError(f"{path} cannot be read: {error}; check the path") from error


def _warnings(data: bytes, found: Findings, lost: list[Failure], document: Document) -> Iterator[str]:
    """What of a file is not there, which Open Cascade only says when asked."""
    if not found.lengths:
        yield f"it does not say what its lengths are in: mm is assumed; if the size is wrong, {_REEXPORT}"
    if lost:
        first = min(lost, key=lambda failure: failure.place)
        yield (
            f"{len(lost)} of its entities could not be made into shapes, and are missing; the first is entity "
            f"{entity_name(data, first.place)}, {first}; {_REEXPORT}"
        )
    if not found.colors:
        yield f"its colours could not be read; {_REEXPORT}"
    if not found.layers:
        yield f"its layers could not be read; {_REEXPORT}"
    hollow = document.hollow_products()
    if hollow:
        shown = ", ".join(hollow[:5]) + (", ..." if len(hollow) > 5 else "")
        yield f"{len(hollow)} without a shape ({shown}); if it refers to other STEP files, export it as one file"


def _name_by_id(model: StepData_StepModel) -> None:
    """Let ids of occurrences be their names.

    Open Cascade 7.9 takes a name without any ASCII letter for none, and the occurrence's id instead.
    """
    for i in range(1, model.NbEntities() + 1):
        entity = model.Entity(i)
        if isinstance(entity, StepRepr_NextAssemblyUsageOccurrence):
            name = entity.Name()
            if name is not None and name.Length():
                entity.SetId(name)


# --- writing --------------------------------------------------------------------------------------------------------


def write_step(
    path: str | PathLike[str],
    name: str,
    parts: Sequence[tuple[Part, Document]],
    cables: Sequence[CableSolid],
    *,
    version: str | None = None,
) -> None:
    """Write parts and cables as one assembly, ``name / parts / ...`` and ``name / cables / ...``.

    Args:
        path: Of the file to write; it appears whole or not at all.
        name: Of the scene.
        parts: Each with what `read_parts` read for it; parts of one document share its geometry.
        cables: At their places in the scene.
        version: Of cablecad, as the file is to tell it; by default that of the installed package.

    Raises:
        ExchangeError: The file cannot be written.
        GeometryError: A cable has no solid, or one with coordinates that are not finite.
        UsageError: SOURCE_DATE_EPOCH is not a time.
    """
    write_bytes(path, step_text(name, parts, cables, version=version))


def step_text(
    name: str,
    parts: Sequence[tuple[Part, Document]],
    cables: Sequence[CableSolid],
    *,
    version: str | None = None,
) -> bytes:
    """What `write_step` writes, as bytes."""
    header = _header(name, version)
    with silence(), occ_errors(ExchangeError, f"writing {name!r}", _SHAPES), interface_settings(_WRITE):
        text = translated(Document.assembled(name, parts, cables))
    return canonical(text, header)


def translated(document: Document) -> bytes:
    """What Open Cascade writes of a document, under the settings that hold.

    Raises:
        ExchangeError: A shape could not be translated, or memory ran out.
    """
    writer = STEPCAFControl_Writer()
    writer.SetColorMode(True)
    writer.SetNameMode(True)
    writer.SetLayerMode(True)
    writer.SetPropsMode(False)
    writer.SetDimTolMode(False)
    writer.SetMaterialMode(False)
    if not writer.Transfer(document.handle, STEPControl_StepModelType.STEPControl_AsIs):
        raise ExchangeError(
            f"Open Cascade cannot write {document.name!r}: a shape of it could not be translated; {_SHAPES}"
        )
    model = writer.ChangeWriter().Model()
    # Not the writer's own WriteStream: that keeps 13 digits of each real.
    text = StepData_StepWriter(model)
    text.FloatWriter().SetFormat(REAL_FORMAT, True)
    text.SendModel(cast(StepData_Protocol, model.Protocol()))
    stream = io.BytesIO()
    if not text.Print(stream):
        raise ExchangeError(f"Open Cascade cannot put {document.name!r} into text; is there enough memory?")
    return stream.getvalue()


def _header(name: str, version: str | None) -> bytes:
    """FILE_DESCRIPTION and FILE_NAME; no person, organisation or path in them."""
    fields = (
        quoted(name),
        quoted(_time_stamp()),
        b"('')",
        b"('')",
        quoted(f"Open Cascade {OCP_VERSION}"),
        quoted(f"cablecad {version or _installed_version()}".strip()),
        quoted(""),
    )
    return b"FILE_DESCRIPTION((''),'2;1');\nFILE_NAME(" + b",".join(fields) + b");\n"


@cache
def _installed_version() -> str:
    """Looked up once: it means reading the metadata of packages, which takes as long as a cable's text."""
    try:
        return installed_version("cablecad")
    except PackageNotFoundError:  # run from its sources
        return ""


def _time_stamp() -> str:
    """SOURCE_DATE_EPOCH (https://reproducible-builds.org/specs/source-date-epoch/) in UTC; the year 1970 without it."""
    text = os.environ.get("SOURCE_DATE_EPOCH") or "0"
    if not (text.isascii() and text.isdigit() and len(text) <= 12 and int(text) <= _LAST_TIME):
        raise UsageError(
            f"SOURCE_DATE_EPOCH is {text!r}, but must be whole seconds since 1970 from 0 to {_LAST_TIME}; "
            "set it so, or unset it"
        )
    return datetime.fromtimestamp(int(text), UTC).strftime("%Y-%m-%dT%H:%M:%S")
