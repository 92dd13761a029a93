"""Files that cannot be read, written or meant: exit 5 or 2, a message with the path and the remedy, nothing touched."""

from __future__ import annotations

import gzip
import os
from pathlib import Path

import pytest
from loom import cable, names, part, scene, write

CONNECTOR = Path(__file__).parents[2] / "samples" / "parts" / "connector.step"


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def assert_refused(ended, code, *said):
    assert ended.code == code, ended.err
    assert ended.err.startswith("error: ")
    assert ended.err.count("\n") == 1
    assert ended.out == ""
    for words in said:
        assert words in ended.err


# --- what is read ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("command", ["solve", "build", "check"])
@pytest.mark.parametrize(
    ("path", "reason"),
    [
        ("loom.toml", "No such file or directory"),
        ("folder/loom.toml", "No such file or directory"),
        ("folder", "Is a directory"),
        (".", "Is a directory"),
        ("/", "Is a directory"),
        ("", "Is a directory"),
        ("file/loom.toml", "Not a directory"),
        ("n" * 300, "File name too long"),
        ("/proc/self/mem", "Input/output error"),  # not even root may read its first page
    ],
)
def test_scene_that_cannot_be_read(cli, here, command, path, reason):
    (here / "folder").mkdir()
    (here / "file").touch()
    assert_refused(cli(command, path), 5, f"cannot read the scene file {str(Path(path))!r}", reason)
    assert names(here) == ["file", "folder"]


BAD_PARTS = {
    "missing": (None, "does not exist; check the path"),
    "empty": (b"", "is empty"),
    "cut off": (CONNECTOR.read_bytes()[:20_000], "is cut off: END-ISO-10303-21 is missing at its end"),
    "no STEP": (b"solid cube\nfacet normal 0 0 1\n", "not with ISO-10303-21"),
    "binary": (bytes(range(256)), "not with ISO-10303-21"),
    "compressed": (gzip.compress(CONNECTOR.read_bytes()), "is compressed; unpack it first"),
}


@pytest.mark.parametrize(("data", "said"), BAD_PARTS.values(), ids=BAD_PARTS)
def test_part_that_cannot_be_read(cli, here, data, said):
    path = write(here / "scene.toml", scene(part(), cable()))
    if data is not None:
        write(here / "plate.step", data)
    before = names(here)
    assert_refused(cli("build", path, "-o", "out.step"), 5, "part plate: ", "plate.step", said)
    checked = cli("check", path)
    assert (checked.code, checked.out[:6]) == (5, "W1: ok")
    assert cli("solve", path).code == 0  # which looks at no part
    assert names(here) == before


@pytest.mark.parametrize(
    ("step", "said"), [("folder", "is a folder; give the STEP file in it"), ("/proc/self/mem", "cannot be read")]
)
def test_part_that_is_no_ordinary_file(cli, here, step, said):
    (here / "folder").mkdir()
    path = write(here / "scene.toml", scene(part(step=step), cable()))
    assert_refused(cli("build", path, "-o", "out.step"), 5, "part plate: ", step, said)
    assert names(here) == ["folder", "scene.toml"]


def test_every_bad_part_is_told_and_a_file_of_several_once(cli, here):
    write(here / "scene.toml", scene(part("a", "x.step"), part("b", "y.step"), part("c", "x.step"), cable()))
    ended = cli("build", "scene.toml", "-o", "out.step")
    assert ended.code == 5
    first, second = ended.err.splitlines()
    assert first.startswith("error: part a and c: x.step does not exist")
    assert second.startswith("error: part b: y.step does not exist")


# --- what is written -------------------------------------------------------------------------------------------------

TARGETS = {
    "folder missing": ("no/out.KIND", "its folder does not exist; create it"),
    "file for a folder": ("file/out.KIND", "a part of its path is a file, not a folder"),
    "folder": ("folder.KIND", "it is a folder; give the name of a file"),
    "name too long": ("n" * 300 + ".KIND", "its name is too long; choose a shorter one"),
    "links in a circle": ("round.KIND", "its symbolic links go round in a circle"),
}


@pytest.mark.parametrize("kind", ["step", "json"])
@pytest.mark.parametrize(("target", "said"), TARGETS.values(), ids=TARGETS)
def test_output_that_cannot_be_written(cli, here, target, said, kind):
    path = write(here / "scene.toml", scene(cable()))
    (here / "file").touch()
    (here / f"folder.{kind}").mkdir()
    (here / f"round.{kind}").symlink_to(f"round.{kind}")
    before = names(here)
    target = target.replace("KIND", kind)
    arguments = ["-o", target] if kind == "step" else ["-o", "out.step", "--report", target]
    assert_refused(cli("build", path, *arguments), 5, f"{target} cannot be written: {said}")
    assert names(here) == before


def test_output_where_there_are_no_files(cli, here):
    path = write(here / "scene.toml", scene(cable()))
    assert_refused(cli("build", path, "-o", "/proc/out.step"), 5, "/proc/out.step cannot be written: ")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["-o", "out.txt"], "output out.txt: its name must end in .step, .stp, .glb, .stl or .brep"),
        (["-o", "out"], "output out: its name must end in .step, .stp, .glb, .stl or .brep"),
        (["-o", "out.step.gz"], "its name must end in .step, .stp"),
        (["-o", ""], "its name must end in .step, .stp"),
        (["-o", "out.step", "--report", "out.txt"], "output out.txt: its name must end in .json"),
        (["-o", "out.step", "--report", "out.step"], "output out.step: its name must end in .json"),
    ],
)
def test_output_by_the_wrong_name(cli, here, arguments, said):
    path = write(here / "scene.toml", scene(cable()))
    assert_refused(cli("build", path, *arguments), 2, said)
    assert names(here) == ["scene.toml"]


@pytest.mark.parametrize("suffix", [".step", ".stp", ".STEP", ".Stp"])
def test_output_by_any_of_its_names(cli, here, suffix):
    path = write(here / "scene.toml", scene(cable()))
    assert cli("build", path, "-o", f"out{suffix}").out == f"out{suffix}\n"


def test_without_an_output_it_is_called_like_the_scene(cli, here, monkeypatch):
    (here / "deep").mkdir()
    write(here / "deep" / "my.loom.toml", scene(cable()))
    ended = cli("build", "deep/my.loom.toml")
    assert (ended.code, ended.out) == (0, "deep/my.loom.step\n")
    assert names(here / "deep") == ["my.loom.step", "my.loom.toml"]


# --- an output that is an input --------------------------------------------------------------------------------------


def linked(kind, name, target):
    """Another name of a file: itself, spelt otherwise, or by a link."""
    if kind == "spelt otherwise":
        return Path("..") / name.absolute().parent.name / target
    if kind == "symbolic link":
        name.symlink_to(target)
    elif kind == "hard link":
        name.hardlink_to(target)
    elif kind == "link of a link":
        Path("between").symlink_to(target)
        name.symlink_to("between")
    return name if kind != "itself" else Path(target)


@pytest.mark.parametrize("kind", ["itself", "spelt otherwise", "symbolic link", "hard link", "link of a link"])
@pytest.mark.parametrize("what", ["part", "scene", "scene by its report"])
def test_output_that_is_an_input(cli, here, kind, what):
    if what == "scene by its report":
        text = (
            '{"format": 1, "cables": [{"name": "W1", "diameter": 4, "length": 350, "start": {"position": [0, 0, 0]}, '
        )
        path = write(here / "loom.json", text + '"end": {"position": [300, 0, 0]}}]}')
        target = linked(kind, here / "other.json", "loom.json")
        arguments = ["-o", "out.step", "--report", target]
    else:
        path = write(here / "loom.step", scene(part("housing", "connector.step"), cable()))
        write(here / "connector.step", CONNECTOR.read_bytes())
        target = linked(kind, here / "other.step", "connector.step" if what == "part" else "loom.step")
        arguments = ["-o", target]
    before = {name: (here / name).read_bytes() for name in names(here)}
    assert_refused(cli("build", path, *arguments), 2, f"output {target} is also an input of the scene", "another file")
    assert {name: (here / name).read_bytes() for name in names(here)} == before


def test_default_output_that_is_the_scene(cli, here):
    path = write(here / "loom.step", scene(cable()))
    assert_refused(cli("build", path), 2, "is also an input of the scene")


def test_output_and_report_in_one_file(cli, here):
    path = write(here / "scene.toml", scene(cable()))
    (here / "out.step").symlink_to("out.json")
    for old in (None, b"old"):
        if old is not None:
            write(here / "out.json", old)
        ended = cli("build", path, "-o", "out.step", "--report", "out.json")
        assert_refused(ended, 2, "output out.step and report out.json lead to one file")
    assert (here / "out.json").read_bytes() == b"old"


def test_output_that_would_be_a_missing_part(cli, here):
    """It does not exist, so nothing is lost; but the next run would read what this one wrote."""
    path = write(here / "scene.toml", scene(part(step="out.step"), cable()))
    assert_refused(cli("build", path, "-o", "./out.step"), 2, "is also an input of the scene")


# --- whole or not at all ---------------------------------------------------------------------------------------------


def test_failure_leaves_what_was_there(cli, here):
    write(here / "out.step", b"old")
    write(here / "out.json", b"old")
    for text, code in (
        (scene(cable(rise="50")), 2),
        (scene(cable(length="200")), 3),
        (scene(cable(diameter="290")), 4),
        (scene(part(), cable()), 5),
    ):
        path = write(here / "scene.toml", text)
        assert cli("build", path, "-o", "out.step").code == code
        assert [(here / name).read_bytes() for name in ("out.step", "out.json")] == [b"old", b"old"]
    assert names(here) == ["out.json", "out.step", "scene.toml"]


def test_link_stays_a_link_and_permissions_stay(cli, here):
    path = write(here / "scene.toml", scene(cable()))
    write(here / "real.step", b"old").chmod(0o640)
    (here / "out.step").symlink_to("real.step")
    assert cli("build", path, "-o", "out.step").out == "out.step\n"
    assert os.readlink(here / "out.step") == "real.step"  # noqa: PTH115 - the text of the link, not a Path
    assert (here / "real.step").read_bytes().startswith(b"ISO-10303-21;")
    assert (here / "real.step").stat().st_mode & 0o777 == 0o640
