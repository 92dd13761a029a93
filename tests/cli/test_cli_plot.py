"""`plot`: which files there are, and what is said where there are none."""

from __future__ import annotations

import subprocess
import sys

import pytest
from loom import cable, names, scene, write
from test_cli_render import WITHOUT

pytest.importorskip("matplotlib")

PINNED = cable(end="{ toward = [1, 0, 0] }", angle_deg="20")


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write(tmp_path / "scene.toml", scene(cable(), cable("W 2/b", start="{ position = [0, 50, 0] }", length="310")))
    return tmp_path


def test_three_files_a_cable(cli, here):
    ended = cli("plot", "scene.toml", "-o", "new/plots")
    kinds = ("shape", "curvature", "equilibria")
    expected = [f"{stem}-{kind}.png" for stem in ("W1", "W_2_b") for kind in kinds]
    assert (ended.code, ended.err) == (0, "")
    assert ended.out.splitlines() == [f"new/plots/{name}" for name in expected]
    assert names(here / "new" / "plots") == sorted(expected)


def test_one_cable_as_svg_beside_the_scene(cli, here):
    ended = cli("plot", "scene.toml", "--cable", "W1", "--format", "svg")
    assert ended.code == 0
    assert names(here / "scene-plots") == ["W1-curvature.svg", "W1-equilibria.svg", "W1-shape.svg"]


def test_family(cli, here):
    write(here / "scene.toml", scene(PINNED))
    ended = cli("plot", "scene.toml", "-o", "plots", "--family", "cables.W1.angle_deg=20:150:6")
    assert (ended.code, ended.out, ended.err) == (0, "plots/W1-angle_deg-family.png\n", "")


def test_members_without_a_solution_are_named_and_the_others_drawn(cli, here):
    ended = cli("plot", "scene.toml", "-o", "plots", "--family", "cables.W1.length=290:320:4")
    assert (ended.code, ended.out) == (6, "plots/W1-length-family.png\n")
    (told,) = ended.err.splitlines()
    assert told.startswith(
        "warning: cables.W1.length = 290: cable W1: length 290 mm is 10 mm less than the distance of the ends"
    )


def test_values_no_scene_may_have_are_named_too(cli, here):
    ended = cli("plot", "scene.toml", "-o", "plots", "--family", "cables.W1.length=-5,350,360")
    assert ended.code == 6
    assert "warning: cables.W1.length = -5: " in ended.err


def test_family_of_nothing(cli, here):
    ended = cli("plot", "scene.toml", "-o", "plots", "--family", "cables.W1.length=100:200:3")
    assert (ended.code, ended.out) == (3, "")
    assert ended.err.count("warning: ") == 3
    assert "error: cable W1: length 100 mm is 200 mm less" in ended.err
    assert names(here) == ["scene.toml"]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--family", "cables.W1.length"], "write it as NAME=START:STOP:COUNT or NAME=VALUE,VALUE,..."),
        (["--family", "cables.W9.length=1:2:2"], "W9"),
        (["--family", "tolerance.shape=1:2:2"], "a family changes one cable: begin with cables.NAME., NAME one of W1"),
        (["--family", "cables.W1.end.position.1=1,2"], "--family: 1 mistake"),
        (["--family", "format=1,1"], "a family changes one cable: begin with cables.NAME., NAME one of W1, W 2/b"),
        (["--family", "cables.W1.lenght=300:400:3"], "length"),
        (["--family", "cables.W1.material=pvc,pur"], "a family is drawn over numbers"),
        (
            ["--family", "cables.W1.length=300:400:3", "--cable", "W1"],
            "--family names its cable and is a plot of its own",
        ),
        (["--cable", "W9"], "there is no such cable in the scene; it has W1, W 2/b"),
        (["--format", "gif"], "'gif' is not one of 'png', 'svg', 'pdf'"),
    ],
)
def test_what_cannot_be_meant(cli, here, arguments, said):
    ended = cli("plot", "scene.toml", "-o", "plots", *arguments)
    assert (ended.code, ended.out) == (2, "")
    assert said in ended.err
    assert names(here) == ["scene.toml"]


def test_no_plots_of_half_a_scene(cli, here):
    write(here / "scene.toml", scene(cable(), cable("W2", length="200")))
    ended = cli("plot", "scene.toml", "-o", "plots")
    assert (ended.code, ended.out) == (3, "")
    assert ended.err.startswith("error: cable W2: ")
    assert names(here) == ["scene.toml"]


def test_folder_that_is_a_file(cli, here):
    write(here / "plots", b"")
    ended = cli("plot", "scene.toml", "-o", "plots")
    assert (ended.code, ended.out) == (5, "")
    assert "the folder plots cannot be made" in ended.err


def test_without_matplotlib(here):
    one = subprocess.run(
        [sys.executable, "-c", WITHOUT.format(package="matplotlib"), "plot", "scene.toml", "-o", "plots"],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert (one.returncode, one.stdout) == (5, "")
    assert (
        one.stderr
        == 'error: plots need matplotlib and it is not installed. Install it by\n  pip install "cablecad[plot]"\n'
    )
    assert names(here) == ["scene.toml"]


def test_no_open_cascade_is_loaded(here):
    code = "import sys; sys.modules['OCP'] = None; from cablecad.cli import main; main()"
    one = subprocess.run([sys.executable, "-c", code, "plot", "scene.toml", "--cable", "W1"], check=False)
    assert one.returncode == 0


def test_some_kinds_only(cli, here):
    ended = cli("plot", "scene.toml", "-o", "plots", "--cable", "W1", "--kind", "shape", "--kind", "curvature")
    assert (ended.code, ended.err) == (0, "")
    assert names(here / "plots") == ["W1-curvature.png", "W1-shape.png"]
    ended = cli("plot", "scene.toml", "--family", "cables.W1.length=340:350:2", "--kind", "shape")
    assert ended.code == 2


def test_what_is_done_is_there_before_the_next_is_drawn(cli, here, monkeypatch):
    from cablecad.picture import plot

    def stopped(*_arguments, **_named):
        raise KeyboardInterrupt

    monkeypatch.setattr(plot, "plot_equilibria", stopped)
    ended = cli("plot", "scene.toml", "-o", "plots", "--cable", "W1")
    assert ended.code == 130
    assert ended.out.splitlines() == ["plots/W1-shape.png", "plots/W1-curvature.png"]
    assert names(here / "plots") == ["W1-curvature.png", "W1-shape.png"]


def test_a_scene_without_cables_is_said_to_be_one(cli, here):
    write(here / "parts.toml", 'format = 1\n[[parts]]\nname = "P"\nstep = "p.step"\n')
    ended = cli("plot", "parts.toml", "-o", "plots")
    assert "the scene has no cables to plot" in ended.err
