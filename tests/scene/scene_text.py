"""The text of good scenes, and of what one wants to be wrong with them."""

from __future__ import annotations

GOOD = {
    "name": '"W1"',
    "diameter": "4.0",
    "length": "350.0",
    "start": "{ position = [0, 0, 0], outward = [0, 0, 1] }",
    "end": "{ position = [0, 120, 0], outward = [0, 0, 1] }",
}
PINS = {"start": "{ position = [0, 0, 0] }", "end": "{ position = [0, 120, 0] }"}
PVC = "[materials.pvc]\nyoungs_modulus = 3890\n"


def cable(*, head: str = "", **keys: str | None) -> str:
    """A scene of one good cable, some of its keys changed, added, or left out (None)."""
    lines = [f"{key} = {value}" for key, value in {**GOOD, **keys}.items() if value is not None]
    return f"format = 1\n{head}\n[[cables]]\n" + "\n".join(lines) + "\n"


def pinned(*, head: str = "", **keys: str | None) -> str:
    return cable(head=head, **{**PINS, **keys})


def part(text: str) -> str:
    return f"format = 1\n[[parts]]\n{text}\n"


PORT = 'name = "J1"\nposition = [0, 0, 0]\noutward = [0, 0, 1]'


def ported(*ports: str, start: str = '{ part = "plate", port = "J1" }', **keys: str | None) -> str:
    """A scene of a part with ports and a cable that starts on it."""
    tables = "\n".join(f"[[parts.ports]]\n{port}" for port in ports)
    return cable(head=f'[[parts]]\nname = "plate"\nstep = "plate.step"\n{tables}', start=start, **keys)


def material(text: str) -> str:
    return cable(head=f"[materials.pvc]\n{text}\n", material='"pvc"')
