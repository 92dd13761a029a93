"""A cable between the holes of two CadQuery parts, exported by CadQuery's own exporter.

Run beside CadQuery 2.8:
    python samples/cadquery_loom.py loom.step
"""

import sys

import cadquery as cq

from cablecad.adapters.cadquery import add_to, cable, port

# A panel with a hole through it, and a housing, tilted, with a blind hole in its side.
panel = cq.Workplane().box(60, 40, 8).faces(">Z").workplane().hole(6)
housing = cq.Workplane().box(40, 30, 30).faces("<X").workplane().hole(6, 15)
tilted = cq.Location((160, 0, 70), (0, 1, 0), -20)

# The rims of the holes are ends: the centre, and the axis out of the hole. That of a placed part is placed with it.
start = panel.faces(">Z").edges("%CIRCLE")
end = port(housing.faces("<X").edges("%CIRCLE"), tilted)

wire = cable(
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

loom = cq.Assembly(name="loom")
loom.add(panel, name="panel", color=cq.Color(0.8, 0.8, 0.75))
loom.add(housing, name="housing", loc=tilted, color=cq.Color(0.2, 0.22, 0.25))
add_to(loom, wire)

path = sys.argv[1] if len(sys.argv) > 1 else "loom.step"
loom.export(path)
print(path)
print(f"W1: least bend radius {wire.report['bend_radius_min']:.2f} mm")

# A longer panel: the same cable, solved again for its new start.
further = wire.moved(start=cq.Location((-5, 0, 4)))
print(f"with the panel 5 mm further: {further.report['bend_radius_min']:.2f} mm")
