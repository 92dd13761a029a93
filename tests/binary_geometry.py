"""Single records of the binary format as the objects Open Cascade makes of them."""

from __future__ import annotations

import io

from OCP.BinTools import BinTools_Curve2dSet, BinTools_CurveSet, BinTools_SurfaceSet
from OCP.Geom import Geom_Curve, Geom_Surface
from OCP.Geom2d import Geom2d_Curve


def curve2d_of(record: bytes) -> Geom2d_Curve:
    curves = BinTools_Curve2dSet()
    curves.Read(io.BytesIO(b"Curve2ds 1\n" + record))
    return curves.Curve2d(1)


def curve_of(record: bytes) -> Geom_Curve:
    curves = BinTools_CurveSet()
    curves.Read(io.BytesIO(b"Curves 1\n" + record))
    return curves.Curve(1)


def surface_of(record: bytes) -> Geom_Surface:
    surfaces = BinTools_SurfaceSet()
    surfaces.Read(io.BytesIO(b"Surfaces 1\n" + record))
    return surfaces.Surface(1)
