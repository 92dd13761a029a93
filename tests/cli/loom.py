"""Scenes for the tests of the command line: the text of a good cable, and of what one wants to be wrong with it."""

from __future__ import annotations

import json
from pathlib import Path

FORMAT = "format = 1\n"
PVC = "[materials.pvc]\nyoungs_modulus = 3890.0\npoissons_ratio = 0.25\n"

GOOD = {
    "diameter": "4.0",
    "length": "350.0",
    "start": "{ position = [0, 0, 0] }",
    "end": "{ position = [300, 0, 0] }",
}
"""Pinned, slack, clear of itself: 4 mm in diameter, bent to 143.3016 mm at its middle."""

TOWARD = "{ toward = [1, 0, 0] }"


def cable(name: str = "W1", **keys: object) -> str:
    """A good cable with keys changed, added, or left out (None); values as TOML writes them."""
    lines = [f"{key} = {value}" for key, value in {**GOOD, **keys}.items() if value is not None]
    return f"[[cables]]\nname = {quoted(name)}\n" + "\n".join(lines) + "\n"


def part(name: str = "plate", step: str = "plate.step", **keys: object) -> str:
    lines = [f"name = {quoted(name)}", f"step = {quoted(step)}", *(f"{key} = {value}" for key, value in keys.items())]
    return "[[parts]]\n" + "\n".join(lines) + "\n"


def quoted(text: str) -> str:
    """A text as TOML, whose escapes are those of JSON, writes it."""
    return json.dumps(text, ensure_ascii=False)


def scene(*tables: str, head: str = "") -> str:
    return "\n".join([FORMAT + head, *tables])


def write(path: Path, text: str | bytes) -> Path:
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return path


def names(folder: Path) -> list[str]:
    """All there is in a folder, dot files too."""
    return sorted(path.name for path in folder.iterdir())
