"""The scene `cablecad new` writes: one cable that builds, and every other key with its unit in a comment.

A comment that is a key to uncomment has no space after its ``#``; a remark has one.
"""

_STARTER = """\
# A scene of cablecad. Lengths in mm, forces in N, angles in degrees; a position or axis is [x, y, z].
#   cablecad solve FILE                   the shape and its numbers
#   cablecad build FILE -o loom.step      the solids
# The keys behind a # without a space are the others there are: take the # away to use them.

format = 1                              # version of this file format; always needed
name = "first cable"                    # of the assembly in the STEP file

#[tolerance]
#shape = 0.001                          # mm: bound on the distance between the solid's side and the exact tube

# Materials are optional: the shape needs none; forces, moments, energies and twist do.
[materials.pvc]
youngs_modulus = 3890.0                 # MPa, of the solid circle of the cable's diameter
poissons_ratio = 0.25                   # gives the torsional stiffness
#mass_per_length = 0.02                 # kg/m: only to judge whether gravity may be left out

# Or as measured on the cable itself: a stranded cable is far softer than a solid rod.
#[materials.stranded]
#bending_stiffness = 2500.0             # N mm^2
#torsional_stiffness = 1800.0           # N mm^2

# Rigid parts beside the cables, each with a header of its own.
#[[parts]]
#name = "plate"                         # unique among parts and cables
#step = "parts/plate.step"              # relative to this file
#position = [0.0, 0.0, 0.0]             # mm: a point x of the part goes to rotation * x + position
#rotation = { axis = [0, 0, 1], angle_deg = 90.0 }
# Places on it where cables end, in the part's own coordinates: they move with it.
#[[parts.ports]]
#name = "J1"                            # unique within the part
#position = [0.0, 0.0, 12.5]            # mm
#outward = [0, 0, 1]                    # out of the part; without it the cable is pinned there

# One header for each cable. This one is pinned: its ends hold their positions and are free to turn.
[[cables]]
name = "W1"                             # unique among parts and cables
diameter = 4.0                          # mm
start = { position = [0.0, 0.0, 0.0] }
end = { position = [308.42, 0.0, 0.0] }
length = 350.0                          # mm; or "shortest": the least that keeps min_bend_radius
material = "pvc"                        # one of the materials above
color = "#2b6cb0"                       # #rrggbb or #rrggbbaa
min_bend_radius = 20.0                  # mm: a rule to check, never an input of the shape
#bulge = [0, 0, 1]                      # the side to bend to, where the ends leave it open
#equilibrium = 1                        # which of the equilibria found, 0 the first; or { winding = 0, side = -1 }
#allow_contact = true                   # lets a cable through that touches itself

# Instead of length:
#slack = 0.1348                         # (length - distance of the ends) / distance of the ends
# or, where both ends are pinned:
#force = 4.189                          # N, compressive along the line between the ends; needs a material
#angle_deg = 40.0                       # degrees between the cable and that line at its ends
#rise = 73.89                           # mm: greatest distance from that line
#bend_radius = 157.9                    # mm: the least bend radius, exactly

# An end in a connector has an axis: outward (out of the connector, towards the free cable) or direction (the way of
# travel from start to end). Its straight is the length in mm that the connector holds straight, part of the length.
#start = { position = [0, 0, 0], outward = [0, 0, 1] }
#end = { position = [0, 120, 0], direction = [0, 0, -1], straight = 15.0 }

# An end on a part, which moves with it: at one of its ports, or at the circular edge, cylindrical or plane face that is
# nearest to a point in the part's own coordinates (mm): at its centre, with its axis out of the material.
# `cablecad resolve FILE` prints what becomes of it.
# start = { part = "plate", port = "J1" }
# end = { part = "plate", near = [0.0, 0.0, 12.5], straight = 15.0 }

# Two pinned ends of which only the line is known: two of the data above then give the distance, or chord (mm) itself.
#end = { toward = [1, 0, 0] }
#chord = 308.42                         # mm, signed along toward
"""


def starter_scene() -> str:
    """The TOML text of a scene to begin with; it builds as it stands and needs no other file."""
    return _STARTER
