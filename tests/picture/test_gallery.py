"""The gallery: its pictures were looked at, and its commands still draw them."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest
from seen import likeness, load

ROOT = Path(__file__).parents[2]
GALLERY = ROOT / "samples" / "gallery"
TEXT = (GALLERY / "README.md").read_text(encoding="utf-8")
COMMANDS = [shlex.split(line) for line in TEXT.splitlines() if line.startswith("cablecad ")]
PICTURES = sorted(path.name for path in GALLERY.glob("*.png"))


@pytest.fixture(autouse=True)
def top(monkeypatch):
    monkeypatch.chdir(ROOT)


def run(cli, command: list[str], folder: Path, *more: str) -> list[Path]:
    """Run a command of the gallery's with its output elsewhere."""
    program, *arguments = command
    assert program == "cablecad"
    place = arguments.index("-o") + 1
    arguments[place] = str(folder / Path(arguments[place]).relative_to("samples/gallery"))
    ended = cli(*arguments, *more)
    assert ended.code == 0
    return [Path(line) for line in ended.out.splitlines()]


@pytest.mark.usefixtures("draws")
@pytest.mark.parametrize("command", [c for c in COMMANDS if c[1] == "render"], ids=lambda c: Path(c[4]).stem)
def test_pictures(cli, tmp_path, command):
    # Smaller, but of the same shape: all there is in a picture follows its size.
    (path,) = run(cli, command, tmp_path, "--size", "640x400")
    pixels, stored = load(path), load(GALLERY / path.name)
    size = (80, 50)
    assert likeness(pixels, stored, size) > 0.95
    # And no other picture is, nor its mirror image: the measure tells pictures apart.
    others = [load(GALLERY / Path(other[4]).name) for other in COMMANDS if other[1] == "render" and other != command]
    assert max(likeness(pixels, other, size) for other in [*others, stored[:, ::-1]]) < 0.7


@pytest.mark.parametrize("command", [c for c in COMMANDS if c[1] == "plot"], ids=["cable", "family"])
def test_plots(cli, tmp_path, command):
    pytest.importorskip("matplotlib")
    for path in run(cli, command, tmp_path):
        pixels, stored = load(path), load(GALLERY / path.name)
        # Another version of matplotlib may make the sheet a few pixels larger or smaller.
        assert pixels.shape == pytest.approx(stored.shape, rel=0.02)
        height, width = (min(a, b) // 10 * 10 for a, b in zip(pixels.shape[:2], stored.shape[:2], strict=True))
        small = (width // 10, height // 10)
        pixels, stored = pixels[:height, :width], stored[:height, :width]
        assert likeness(pixels, stored, small) > 0.9
        assert likeness(pixels, stored[:, ::-1], small) < 0.8


def test_every_picture_has_a_command_and_is_shown():
    made = {Path(command[4]).name for command in COMMANDS if command[1] == "render"}
    plots = {name for name in PICTURES if name not in made}
    assert made <= set(PICTURES)
    benchmark = {"tube.png"}
    assert plots - benchmark == {"W3-shape.png", "W3-curvature.png", "W3-equilibria.png", "cable-angle_deg-family.png"}
    assert sorted(re.findall(r"\]\((.*?\.png)\)", TEXT)) == PICTURES


def test_gallery_is_small():
    assert sum(path.stat().st_size for path in GALLERY.iterdir()) < 700_000


def test_readme_opens_with_a_picture_and_its_command():
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    shown = re.findall(r"\]\((samples/gallery/.*?)\)", readme)
    assert shown
    assert all((ROOT / path).is_file() for path in shown)
    assert readme.index(shown[0]) < 1500
    (command,) = (line for line in readme.splitlines() if line.endswith(f"-o {shown[0]} --view 2,-3,1.6"))
    assert command.removeprefix("$ ") in TEXT
