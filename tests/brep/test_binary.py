"""Shapes by way of the binary format: all that was given is there, and what is no shape is an error."""

from __future__ import annotations

import math

import numpy as np
import pytest
from binary_geometry import curve2d_of, curve_of, surface_of
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.Geom import Geom_BSplineCurve, Geom_BSplineSurface, Geom_Circle, Geom_CylindricalSurface, Geom_Line, Geom_Plane
from OCP.Geom2d import Geom2d_BSplineCurve, Geom2d_Circle, Geom2d_Line
from OCP.TopAbs import TopAbs_Orientation, TopAbs_ShapeEnum
from OCP.TopoDS import TopoDS_Shape

from cablecad.brep import binary
from cablecad.brep.binary import Axes, KnotVector, Topology
from cablecad.brep.check import volume_of
from cablecad.brep.kernel import TopoDS, occ_errors, silence, subshapes
from cablecad.errors import GeometryError

U, V = KnotVector(2, [0.0, 1.0 / 3.0, 1.0], [3, 2, 3]), KnotVector(3, [0.0, math.pi, 4.0, 1e3], [4, 1, 2, 4])
ROWS, COLUMNS = 5, 7

ORIGIN = (1.0, -2.0, 3e5)
SLANTED = Axes(ORIGIN, (0.48, 0.6, 0.64), (0.8, 0.0, -0.6))
"""Its third direction is (-0.36, 0.8, -0.48)."""


def poles_and_weights() -> tuple[np.ndarray, np.ndarray]:
    chance = np.random.default_rng(3)
    size = 10.0 ** chance.integers(-30, 30, (ROWS, COLUMNS, 1))
    return size * chance.normal(size=(ROWS, COLUMNS, 3)), chance.uniform(0.1, 3.0, (ROWS, 1))


def xyz(thing: object) -> list[float]:
    return [thing.X(), thing.Y(), thing.Z()]  # type: ignore[attr-defined]


# --- geometry -------------------------------------------------------------------------------------------------------


def test_a_spline_surface_holds_what_was_given() -> None:
    poles, weights = poles_and_weights()
    surface = surface_of(binary.spline_surface(poles, weights, U, V))
    assert isinstance(surface, Geom_BSplineSurface)
    assert (surface.UDegree(), surface.VDegree()) == (2, 3)
    assert (surface.NbUPoles(), surface.NbVPoles()) == (ROWS, COLUMNS)
    assert not surface.IsUPeriodic()
    assert not surface.IsVPeriodic()
    for i, j in np.ndindex(ROWS, COLUMNS):
        assert xyz(surface.Pole(i + 1, j + 1)) == poles[i, j].tolist()
        assert surface.Weight(i + 1, j + 1) == weights[i, 0]
    assert [surface.UKnot(i) for i in (1, 2, 3)] == U.knots
    assert [surface.VKnot(i) for i in (1, 2, 3, 4)] == V.knots
    assert [surface.UMultiplicity(i) for i in (1, 2, 3)] == U.multiplicities
    assert [surface.VMultiplicity(i) for i in (1, 2, 3, 4)] == V.multiplicities


def test_equal_weights_are_no_weights() -> None:
    surface = surface_of(binary.spline_surface(poles_and_weights()[0], 1.0, U, V))
    assert isinstance(surface, Geom_BSplineSurface)
    assert not surface.IsURational()
    assert not surface.IsVRational()


@pytest.mark.parametrize(
    "v",
    [
        KnotVector(3, [0.0, 2.0, 1.0, 3.0], [4, 1, 2, 4]),
        KnotVector(3, [0.0, 1.0, 2.0, 3.0], [4, 1, 1, 4]),
        KnotVector(40, [0.0, 1.0, 2.0, 3.0], [4, 1, 2, 4]),
    ],
    ids=["knots that fall", "too few for the poles", "too high a degree"],
)
def test_no_surface_is_an_error(v: KnotVector) -> None:
    with silence(), pytest.raises(GeometryError), occ_errors(GeometryError, "making a surface", "report it"):
        surface_of(binary.spline_surface(poles_and_weights()[0], 1.0, U, v))


def test_spline_curves_hold_what_was_given() -> None:
    poles = poles_and_weights()[0][0]
    curve, flat = curve_of(binary.spline(poles, V)), curve2d_of(binary.spline(poles[:, :2], V))
    assert isinstance(curve, Geom_BSplineCurve)
    assert isinstance(flat, Geom2d_BSplineCurve)
    assert [xyz(curve.Pole(i + 1)) for i in range(COLUMNS)] == poles.tolist()
    assert [[flat.Pole(i + 1).X(), flat.Pole(i + 1).Y()] for i in range(COLUMNS)] == poles[:, :2].tolist()
    for one in (curve, flat):
        assert (one.Degree(), one.NbPoles()) == (3, COLUMNS)
        assert not one.IsRational()
        assert not one.IsPeriodic()
        assert [one.Knot(i) for i in (1, 2, 3, 4)] == V.knots
        assert [one.Multiplicity(i) for i in (1, 2, 3, 4)] == V.multiplicities


def test_lines_hold_what_was_given() -> None:
    line, flat = curve_of(binary.line(ORIGIN, (0.6, 0.0, -0.8))), curve2d_of(binary.line2d(1.0, -2.0, 0.0, -1.0))
    assert isinstance(line, Geom_Line)
    assert isinstance(flat, Geom2d_Line)
    assert xyz(line.Position().Location()) == list(ORIGIN)
    assert xyz(line.Position().Direction()) == pytest.approx([0.6, 0.0, -0.8], abs=1e-15)
    point = flat.Value(3.0)
    assert (point.X(), point.Y()) == (1.0, -5.0)


def test_circles_run_from_x_to_y() -> None:
    circle, flat = curve_of(binary.circle(SLANTED, 10.0)), curve2d_of(binary.circle2d(2.5))
    assert isinstance(circle, Geom_Circle)
    assert isinstance(flat, Geom2d_Circle)
    assert xyz(circle.Value(0.0)) == pytest.approx([9.0, -2.0, 3e5 - 6.0])
    assert xyz(circle.Value(math.pi / 2.0)) == pytest.approx([1.0 - 3.6, -2.0 + 8.0, 3e5 - 4.8])
    first, quarter = flat.Value(0.0), flat.Value(math.pi / 2.0)
    assert [first.X(), first.Y(), quarter.X(), quarter.Y()] == pytest.approx([2.5, 0.0, 0.0, 2.5], abs=1e-15)


def test_planes_and_cylinders_have_their_axes() -> None:
    plane, cylinder = surface_of(binary.plane(SLANTED)), surface_of(binary.cylinder(SLANTED, 10.0))
    assert isinstance(plane, Geom_Plane)
    assert isinstance(cylinder, Geom_CylindricalSurface)
    assert cylinder.Radius() == 10.0
    for surface in (plane, cylinder):
        position = surface.Position()
        assert position.Direct()
        assert xyz(position.Location()) == list(ORIGIN)
        assert xyz(position.Direction()) == pytest.approx(list(SLANTED.main), abs=1e-15)
        assert xyz(position.XDirection()) == pytest.approx(list(SLANTED.x), abs=1e-15)
        assert xyz(position.YDirection()) == pytest.approx([-0.36, 0.8, -0.48], abs=1e-15)


# --- topology -------------------------------------------------------------------------------------------------------

RADIUS, HEIGHT, TOLERANCE = 2.0, 5.0, 1e-6


def drum(*, height: float = HEIGHT) -> TopoDS_Shape:
    """A cylinder by hand: one side with a seam, two planes, of which the lower is reversed."""
    shapes, turn = Topology(TOLERANCE), 2.0 * math.pi
    vertices, circles = [shapes.vertex(), shapes.vertex()], []
    for i, z in enumerate((0.0, height)):
        around = shapes.add_parameters(binary.line2d(0.0, z, 1.0, 0.0))
        flat = shapes.add_parameters(binary.circle2d(RADIUS))
        circles.append(shapes.edge(i + 1, (0.0, turn), (vertices[i], vertices[i]), [(1, around), (i + 2, flat)]))
    forward, back = (shapes.add_parameters(binary.line2d(u, 0.0, 0.0, 1.0)) for u in (turn, 0.0))
    seam = shapes.edge(3, (0.0, height), (vertices[0], vertices[1]), seam=(1, forward, back))
    side = shapes.face(1, shapes.wire(circles[0], seam, -circles[1], -seam))
    low, high = (shapes.face(i + 2, shapes.wire(edge)) for i, edge in enumerate(circles))
    shapes.solid(shapes.shell(side, -low, high))
    ends = [Axes((0.0, 0.0, z), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)) for z in (0.0, height)]
    points = [(RADIUS, 0.0, z) for z in (0.0, height)]
    curves = [*(binary.circle(end, RADIUS) for end in ends), binary.line(points[0], ends[0].main)]
    return shapes.with_geometry(points, curves, [binary.cylinder(ends[0], RADIUS), *map(binary.plane, ends)])


def test_a_solid_of_records_is_valid() -> None:
    solid = drum()
    assert solid.ShapeType() == TopAbs_ShapeEnum.TopAbs_SOLID
    assert BRepCheck_Analyzer(solid).IsValid()
    assert volume_of(solid) == pytest.approx(math.pi * RADIUS**2 * HEIGHT, rel=1e-9)  # positive: faces look outward
    kinds = (TopAbs_ShapeEnum.TopAbs_FACE, TopAbs_ShapeEnum.TopAbs_EDGE, TopAbs_ShapeEnum.TopAbs_VERTEX)
    assert [len(subshapes(solid, kind)) for kind in kinds] == [3, 3, 2]
    orientations = [face.Orientation() for face in subshapes(solid, kinds[0])]
    forward, reverse = TopAbs_Orientation.TopAbs_FORWARD, TopAbs_Orientation.TopAbs_REVERSED
    assert orientations == [forward, reverse, forward]


def test_tolerances_and_points_are_those_given() -> None:
    from OCP.BRep import BRep_Tool

    solid = drum()
    vertices = [TopoDS.Vertex(one) for one in subshapes(solid, TopAbs_ShapeEnum.TopAbs_VERTEX)]
    assert [xyz(BRep_Tool.Pnt_s(vertex)) for vertex in vertices] == [[RADIUS, 0.0, 0.0], [RADIUS, 0.0, HEIGHT]]
    assert {BRep_Tool.Tolerance_s(vertex) for vertex in vertices} == {TOLERANCE}
    for shape in subshapes(solid, TopAbs_ShapeEnum.TopAbs_EDGE):
        edge = TopoDS.Edge(shape)
        assert BRep_Tool.Tolerance_s(edge) == TOLERANCE
        assert BRep_Tool.SameParameter_s(edge)
        assert BRep_Tool.SameRange_s(edge)
    faces = [TopoDS.Face(one) for one in subshapes(solid, TopAbs_ShapeEnum.TopAbs_FACE)]
    assert {BRep_Tool.Tolerance_s(face) for face in faces} == {TOLERANCE}


def test_shapes_can_be_added_to() -> None:
    """The solid is free, as one made by Open Cascade's own builder: hosts add attributes and parts to shapes."""
    solid = drum()
    assert solid.Free()
    assert not any(face.Free() for face in subshapes(solid, TopAbs_ShapeEnum.TopAbs_FACE))


def test_a_stream_that_is_cut_off_is_an_error() -> None:
    with silence(), pytest.raises(GeometryError), occ_errors(GeometryError, "making a solid", "report it"):
        Topology(TOLERANCE).with_geometry([], [b"\x02"], [])
