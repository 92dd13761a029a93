"""Open Cascade's own format out: the exact shapes as text, for FreeCAD, CadQuery, build123d and Gmsh.

It has no names and no colours. The shapes are a compound of the parts, then the cables, each at its place.
"""

from __future__ import annotations

import io
from collections.abc import Sequence

from cablecad.brep.document import CableSolid, Document, part_frame
from cablecad.brep.kernel import occ_errors, silence

# isort: split
from OCP.BRep import BRep_Builder
from OCP.BRepTools import BRepTools
from OCP.TopoDS import TopoDS_Compound
from OCP.TopTools import TopTools_FormatVersion

from cablecad.errors import ExchangeError
from cablecad.model import Part


def brep_bytes(parts: Sequence[tuple[Part, Document]], cables: Sequence[CableSolid]) -> bytes:
    """Parts and cables as one compound in Open Cascade's text format.

    Raises:
        ExchangeError: Open Cascade failed.
    """
    with silence(), occ_errors(ExchangeError, "writing shapes", "write .step instead"):
        compound, builder = TopoDS_Compound(), BRep_Builder()
        builder.MakeCompound(compound)
        for part, document in parts:
            builder.Add(compound, document.shape.Moved(part_frame(part)))
        for cable in cables:
            builder.Add(compound, cable.solid)
        stream = io.BytesIO()
        # Version 1, which every reader knows; no triangles, which only pictures have made.
        version = TopTools_FormatVersion.TopTools_FormatVersion_VERSION_1
        BRepTools.Write_s(compound, stream, False, False, version)
    return stream.getvalue()
