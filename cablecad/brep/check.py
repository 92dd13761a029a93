"""What a solid is worth: validity, volume, area.

`check_solid` measures any solid by Open Cascade, `check_tube` one of ours by its splines. `all_valid` is for many, by a
thread of Open Cascade's a processor: half the time on two.

None of them sees a tube that cuts into itself: that is for `cablecad.self_gap` to find, on the centreline.
"""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from dataclasses import dataclass

from OCP.BRep import BRep_Builder
from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepGProp import BRepGProp
from OCP.GeomAbs import GeomAbs_SurfaceType
from OCP.GProp import GProp_GProps
from OCP.TopAbs import TopAbs_ShapeEnum
from OCP.TopoDS import TopoDS_Compound, TopoDS_Shape

from cablecad.brep.kernel import TopoDS, occ_errors, silence, subshapes
from cablecad.brep.measure import Measured, measure_tube
from cablecad.brep.spline import FittedCentreline
from cablecad.errors import GeometryError

_VOLUME_TOLERANCE, _CHECK_TOLERANCE = 1e-9, 1e-6
"""Relative tolerances of Open Cascade's adaptive integration: of a volume that is asked for, and of a check, which
allows more than that. Its integration without one is off by up to 17 % on sides that are not smooth around."""

ONE_THREAD = "CABLECAD_ONE_THREAD"
"""Set in the environment, to anything, where many processes share the processors: checks then take one thread each."""

_PROCESS = os.getpid()
"""A process forked from it has none of the threads that Open Cascade counts on, and would wait for them for ever."""

_REMEDY = "try another tolerance or report the scene"


@dataclass(frozen=True)
class SolidCheck:
    """The certificate of a solid.

    Attributes:
        valid: Verdict of Open Cascade's `BRepCheck_Analyzer`.
        volume: [mm^3].
        volume_error: (volume - pi r^2 L) / (pi r^2 L): by Pappus a tube around any curve has that volume.
        area: Of side and caps [mm^2].
        area_error: (area - (2 pi r L + 2 pi r^2)) / the same.
        faces: Number of faces.
    """

    valid: bool
    volume: float
    volume_error: float
    area: float
    area_error: float
    faces: int


def volume_of(shape: TopoDS_Shape, tolerance: float = _VOLUME_TOLERANCE) -> float:
    """Volume [mm^3], to a share of itself; of solids far from the origin, for their size, with fewer digits.

    Of a solid with offset surfaces, such as a shelled cable, to 1e-5 or so: Open Cascade's adaptive integration is off
    by a third on them, and its plain one is not.
    """
    properties = GProp_GProps()
    if any(_is_offset(face) for face in subshapes(shape, TopAbs_ShapeEnum.TopAbs_FACE)):
        BRepGProp.VolumeProperties_s(shape, properties)
    else:
        BRepGProp.VolumeProperties_s(shape, properties, tolerance, True, False)
    return float(properties.Mass())


def _is_offset(face: TopoDS_Shape) -> bool:
    return BRepAdaptor_Surface(TopoDS.Face(face), False).GetType() == GeomAbs_SurfaceType.GeomAbs_OffsetSurface


def all_valid(solids: Sequence[TopoDS_Shape]) -> bool:
    """Whether Open Cascade's `BRepCheck_Analyzer` finds all of some solids valid; False too where it fails at one."""
    if any(solid.IsNull() for solid in solids):
        return False  # in a compound it would kill the process
    builder, compound = BRep_Builder(), TopoDS_Compound()
    try:
        with silence(), occ_errors(GeometryError, "checking solids", "check them one by one"):
            builder.MakeCompound(compound)
            for solid in solids:
                builder.Add(compound, solid)
            threads = os.getpid() == _PROCESS and not os.environ.get(ONE_THREAD)
            return bool(BRepCheck_Analyzer(compound, True, theIsParallel=threads).IsValid())
    except GeometryError:
        return False


def check_solid(solid: TopoDS_Shape, *, radius: float, length: float, known_valid: bool = False) -> SolidCheck:
    """Measure a tube's solid against what a tube of this radius and length [mm] must be.

    With `known_valid`, from `all_valid`, Open Cascade is not asked again.

    Raises:
        GeometryError: Open Cascade failed at measuring.
    """
    with silence(), occ_errors(GeometryError, "measuring the solid", _REMEDY):
        valid = known_valid or bool(BRepCheck_Analyzer(solid).IsValid())
        volume, area_properties = volume_of(solid, _CHECK_TOLERANCE), GProp_GProps()
        BRepGProp.SurfaceProperties_s(solid, area_properties, _CHECK_TOLERANCE, False)
        faces = len(subshapes(solid, TopAbs_ShapeEnum.TopAbs_FACE))
    return _certificate(valid, faces, (volume, area_properties.Mass()), radius, length)


def check_tube(
    solid: TopoDS_Shape,
    fit: FittedCentreline,
    radius: float,
    measured: Measured | None = None,
    *,
    known_valid: bool = False,
) -> SolidCheck:
    """`check_solid` for a tube built directly around a fit, in a tenth of the time.

    Validity and faces are those of the solid; volume and area are integrated over the splines it was built from, where
    they were not `measured` before. With `known_valid`, from `all_valid`, Open Cascade is not asked again.

    Raises:
        GeometryError: Open Cascade failed at checking.
    """
    valid = known_valid
    if not valid:
        with silence(), occ_errors(GeometryError, "checking the solid", _REMEDY):
            valid = bool(BRepCheck_Analyzer(solid).IsValid())
    faces = len(subshapes(solid, TopAbs_ShapeEnum.TopAbs_FACE))
    return _certificate(valid, faces, measured or measure_tube(fit, radius), radius, fit.length)


def _certificate(valid: bool, faces: int, measured: tuple[float, float], radius: float, length: float) -> SolidCheck:
    """Volume and area beside what a tube's must be."""
    volume, area = measured
    exact_volume = math.pi * radius**2 * length
    exact_area = 2.0 * math.pi * radius * (length + radius)
    return SolidCheck(
        valid=valid,
        volume=volume,
        volume_error=(volume - exact_volume) / exact_volume,
        area=area,
        area_error=(area - exact_area) / exact_area,
        faces=faces,
    )
