"""`render`: a picture where it was asked for, and plain words where there can be none."""

from __future__ import annotations

import os
import struct
import subprocess
import sys

import pytest
from loom import PVC, TOWARD, cable, names, part, quoted, scene, write

WITHOUT = (
    "import sys; from importlib.abc import MetaPathFinder\n"
    "class Gone(MetaPathFinder):\n"
    "    def find_spec(self, name, path, target=None):\n"
    "        if name.partition('.')[0] == {package!r}:\n"
    "            raise ModuleNotFoundError(f'No module named {{name!r}}', name=name)\n"
    "sys.meta_path.insert(0, Gone())\n"
    "from cablecad.cli import main; main()"
)
"""The command line on a machine that lacks a package."""


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write(tmp_path / "scene.toml", scene(cable(), cable("W2", start="{ position = [0, 50, 0] }", length="310")))
    return tmp_path


def size_of(path) -> tuple[int, int]:
    data = path.read_bytes()
    assert data.startswith(b"\x89PNG\r\n\x1a\n")
    assert data.endswith(b"IEND\xaeB`\x82")
    return struct.unpack(">II", data[16:24])


@pytest.mark.usefixtures("draws")
def test_picture_without_a_display(process, here):
    """As a process of its own, with no display, and with one that is not there."""
    for display in (None, ":77"):
        environment = {key: value for key, value in os.environ.items() if key not in ("DISPLAY", "WAYLAND_DISPLAY")}
        if display is not None:
            environment["DISPLAY"] = display
        one = process("render", "scene.toml", "--size", "320x200", env=environment)
        out, err = one.communicate()
        assert (one.returncode, out, err) == (0, "scene.png\n", "")
        assert size_of(here / "scene.png") == (320, 200)
        (here / "scene.png").unlink()


@pytest.mark.usefixtures("draws")
def test_options(cli, here):
    ended = cli(
        "render", "scene.toml", "-o", "a.PNG", "--view", "1,2,3", "--size", "333x222", "--cable", "W2", "--curvature"
    )
    assert (ended.code, ended.out, ended.err) == (0, "a.PNG\n", "")
    assert size_of(here / "a.PNG") == (333, 222)


@pytest.mark.usefixtures("draws")
def test_warnings_are_told_and_quiet_keeps_them(cli, here):
    write(here / "scene.toml", scene(cable("loop", angle_deg="150", end=TOWARD, allow_contact="true")))
    assert cli("render", "scene.toml", "--size", "200x200").err.count("warning: cable loop: ") == 3
    assert cli("render", "scene.toml", "--size", "200x200", "-q").err == ""


@pytest.mark.usefixtures("draws")
def test_a_tube_that_cuts_itself_can_be_looked_at(cli, here):
    """`build` refuses it; the picture shows why."""
    write(here / "scene.toml", scene(cable(diameter="290")))
    ended = cli("render", "scene.toml", "--size", "200x200")
    assert ended.code == 0
    assert "warning: cable W1: " in ended.err
    assert cli("build", "scene.toml", "-o", "out.step").code == 4


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["-o", "out.jpg"], "output out.jpg: its name must end in .png"),
        (["--view", "0,0,0"], "view '0,0,0': give one of iso, front"),
        (["--size", "1600"], "size '1600': give width and height in pixels, such as 1600x1000"),
        (["--size", "100x5000"], "size 100x5000: both sides must have 200 to 8192 pixels"),
        (["--cable", "W3"], "cable 'W3': there is no such cable in the scene; it has W1, W2"),
    ],
)
def test_what_cannot_be_meant(cli, here, arguments, said):
    ended = cli("render", "scene.toml", *arguments)
    assert (ended.code, ended.out) == (2, "")
    assert said in ended.err
    assert names(here) == ["scene.toml"]


@pytest.mark.parametrize(("text", "code"), [(cable(length="200"), 3), (part() + cable(), 5)])
def test_no_picture_of_half_a_scene(cli, here, text, code):
    write(here / "scene.toml", scene(text, cable("W2"), head=PVC))
    write(here / "out.png", b"old")
    ended = cli("render", "scene.toml", "-o", "out.png")
    assert (ended.code, ended.out) == (code, "")
    assert ended.err.startswith("error: ")
    assert (here / "out.png").read_bytes() == b"old"
    assert names(here) == ["out.png", "scene.toml"]


def test_folder_that_is_not_there(cli, here):
    ended = cli("render", "scene.toml", "-o", "no/out.png")
    assert (ended.code, ended.out) == (5, "")
    assert "no/out.png cannot be written: its folder does not exist" in ended.err


def test_without_vtk(here):
    """As with the flavour of Open Cascade that leaves it out."""
    one = subprocess.run(
        [sys.executable, "-c", WITHOUT.format(package="vtkmodules"), "render", "scene.toml"],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert (one.returncode, one.stdout) == (5, "")
    assert one.stderr.startswith("error: pictures need VTK and it is not installed. Install it by one of\n")
    assert 'pip install "cablecad[ocp]"' in one.stderr
    assert 'pip install "cablecad[novtk,render]"' in one.stderr
    assert names(here) == ["scene.toml"]


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="elsewhere OpenGL is part of the system")
def test_without_opengl(process, here):
    """Its libraries are there by name only: VTK alone would end with a segmentation fault."""
    broken = here / "lib"
    broken.mkdir()
    for library in ("libEGL.so.1", "libEGL.so", "libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so"):
        (broken / library).touch()
    environment = {key: value for key, value in os.environ.items() if key != "DISPLAY"}
    one = process("render", "scene.toml", env={**environment, "LD_LIBRARY_PATH": str(broken)})
    out, err = one.communicate()
    assert (one.returncode, out) == (5, "")
    assert err.startswith("error: pictures need OpenGL and this machine has none that works without a display")
    assert "apt-get install libegl1 libgl1-mesa-dri" in err
    assert names(here) == ["lib", "scene.toml"]


@pytest.mark.usefixtures("draws")
def test_name_no_type_has_letters_for(cli, here):
    write(here / "scene.toml", scene(cable("电缆"), cable("$x_1", color=quoted("#11223380"))))
    assert cli("render", "scene.toml", "--curvature", "--size", "200x200").code == 0
