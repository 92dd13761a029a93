"""Bad ends on parts and bad ports: each row gives every mistake that must be reported, by path and words."""

from __future__ import annotations

from scene_text import PORT, cable, part, ported

PORTS = {
    "a part that is not there": (
        ported(PORT, start='{ part = "plat", port = "J1" }', end='{ part = "box", near = [0, 0, 0] }'),
        {
            "cables.W1.start.part": "= 'plat': no such part; did you mean 'plate'?",
            "cables.W1.end.part": "= 'box': no such part; the scene has 'plate'",
        },
    ),
    "no parts at all": (
        cable(start='{ part = "plate", port = "J1" }'),
        {"cables.W1.start.part": "no such part; the scene has none: write [[parts]]"},
    ),
    "a port that is not there": (
        ported(PORT, start='{ part = "plate", port = "j1" }', end='{ part = "plate", port = "outlet" }'),
        {
            "cables.W1.start.port": "= 'j1': part 'plate' has no such port; did you mean 'J1'?",
            "cables.W1.end.port": "part 'plate' has no such port; it has 'J1'",
        },
    ),
    "a part without ports": (
        ported(),
        {"cables.W1.start.port": "it has none: write [[parts.ports]], or near = [x, y, z] in place of port"},
    ),
    "both port and near": (
        ported(PORT, start='{ part = "plate", port = "J1", near = [0, 0, 0] }'),
        {"cables.W1.start.near": "give either port or near, and not both"},
    ),
    "neither port nor near": (
        ported(PORT, start='{ part = "plate" }'),
        {"cables.W1.start.part": 'says nothing of the place on it: write port = "NAME" or near = [x, y, z]'},
    ),
    "no part": (
        ported(PORT, start='{ port = "J1" }', end="{ near = [0, 0, 0] }"),
        {
            "cables.W1.start.part": 'is missing; write part = "NAME"',
            "cables.W1.end.part": 'is missing; write part = "NAME"',
        },
    ),
    "part and position": (
        ported(PORT, start='{ part = "plate", port = "J1", position = [0, 0, 0], outward = [0, 0, 1] }'),
        {"cables.W1.start.part": "leave out position and outward, or part"},
    ),
    "toward and part": (
        ported(PORT, end='{ toward = [0, 0, 1], part = "plate" }'),
        {"cables.W1.end.toward": "leave out toward, or leave out part"},
    ),
    "types": (
        ported(
            'name = 5\nposition = [0, 0]\noutward = "up"',
            start='{ part = 5, near = [0, "0", 0] }',
            end='{ part = "plate", port = "J1", straight = -1 }',
        ),
        {
            "parts.plate.ports[0].name": "must be a text in quotes, such as",
            "parts.plate.ports[0].position": "must be three numbers",
            "parts.plate.ports[0].outward": "must be three numbers",
            "cables.W1.start.part": "must be a text in quotes",
            "cables.W1.start.near[1]": "must be a number",
            "cables.W1.end.straight": "must be 0 or more",
        },
    ),
    "values of a port": (
        ported('name = " "\nposition = [0, 0, 0]\noutward = [0, 0, 0]', start="{ position = [0, 0, 0] }"),
        {
            "parts.plate.ports[0].name": "must be a text that is not empty",
            "parts.plate.ports[0].outward": "an axis must not be zero",
        },
    ),
    "a port without name and place": (
        ported("outward = [0, 0, 1]", start='{ part = "plate", near = [0, 0, 0] }'),
        {
            "parts.plate.ports[0].name": "is missing; write the port's name",
            "parts.plate.ports[0].position": "is missing; write position = [x, y, z]",
        },
    ),
    "one name for two ports": (
        ported(PORT, PORT),
        {"parts.plate.ports[1].name": "is also the name of ports[0]; a port's name must be unique within its part"},
    ),
    "[parts.ports]": (
        'format = 1\n[[parts]]\nname = "plate"\nstep = "plate.step"\n[parts.ports]\nname = "J1"\nposition = [0, 0, 0]',
        {"parts.plate.ports": "in TOML each begins with [[parts.ports]], in JSON"},
    ),
    "a text among the ports": (
        part('name = "plate"\nstep = "plate.step"\nports = ["J1"]'),
        {"parts.plate.ports[0]": "= 'J1': must be an array of tables: in TOML each begins with [[parts.ports]]"},
    ),
    "straight at a port without an axis": (
        ported('name = "J1"\nposition = [0, 0, 0]', start='{ part = "plate", port = "J1", straight = 5 }'),
        {"cables.W1.start.straight": "needs an axis to run along"},
    ),
    "data of a pinned cable on a port with an axis": (
        ported(PORT, rise="30", end="{ position = [0, 120, 0] }"),
        {"cables.W1.rise": "is for a cable pinned at both ends; here an end has an axis"},
    ),
    "data of a pinned cable on a feature": (
        ported(start='{ part = "plate", near = [0, 0, 0] }', rise="30", end="{ position = [0, 120, 0] }"),
        {"cables.W1.rise": "is for a cable pinned at both ends; here an end has an axis"},
    ),
    "length and slack on a port with an axis": (
        ported(PORT, slack="1", end="{ position = [0, 120, 0] }"),
        {"cables.W1.slack": "give either length or slack, and not both"},
    ),
}
