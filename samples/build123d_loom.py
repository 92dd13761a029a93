"""A cable between the holes of two build123d parts, exported by build123d's own exporter.

Run beside build123d 0.13:
    python samples/build123d_loom.py loom.step
"""

import sys

from build123d import Axis, Box, Color, Compound, Cylinder, GeomType, Location, Pos, RigidJoint, Rot, export_step

from cablecad.adapters.build123d import Cable

# A panel with a hole through it, and a housing, tilted, with a blind hole in its side.
panel = Box(60, 40, 8) - Cylinder(3, 8)
panel.label, panel.color = "panel", Color(0.8, 0.8, 0.75)

housing = Box(40, 30, 30) - Pos(-12.5, 0, 0) * Rot(0, 90, 0) * Cylinder(3, 15)
housing.label, housing.color = "housing", Color(0.2, 0.22, 0.25)
# A joint of the housing, as its designer would give it: the z axis points out of the hole.
RigidJoint("J1", housing, Location((-20, 0, 0), (0, -90, 0)))
housing.locate(Location((160, 0, 70), (0, -20, 0)))

# Ends are what build123d has: the rim of a hole (its centre, and its axis out of the hole), or a joint.
start = panel.edges().filter_by(GeomType.CIRCLE).sort_by(Axis.Z)[-1]
end = housing.joints["J1"]

wire = Cable(
    start,
    end,
    diameter=5,
    length=260,
    start_straight=8,
    name="W1",
    color="#2b6cb0",
    min_bend_radius=25,
    tolerance=1e-7,
)

path = sys.argv[1] if len(sys.argv) > 1 else "loom.step"
export_step(Compound(label="loom", children=[panel, housing, wire]), path)
print(path)
print(f"W1: least bend radius {wire.report['bend_radius_min']:.2f} mm")

# A longer panel: the same cable, solved again for its new start.
further = wire.moved(start=Location((-5, 0, 4)))
print(f"with the panel 5 mm further: {further.report['bend_radius_min']:.2f} mm")
