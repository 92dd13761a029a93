"""What goes where: the result on stdout and nothing else, all else on stderr, and what becomes of broken streams."""

from __future__ import annotations

import json
import os
import pty
import re
import subprocess
import sys
from pathlib import Path

import pytest
from loom import FORMAT, PVC, TOWARD, cable, names, part, scene, write

import cablecad

CONNECTOR = Path(__file__).parents[2] / "samples" / "parts" / "connector.step"
AS1 = Path(__file__).parents[1] / "data" / "as1-oc-214.stp"
COMMANDS = ["build", "solve", "check", "batch", "render", "plot", "schema", "new"]
LOOP = cable("loop", angle_deg="150", end=TOWARD, allow_contact="true")


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def good(here):
    """A scene of a part and two cables, of which one is worth three warnings."""
    write(here / "connector.step", CONNECTOR.read_bytes())
    return write(here / "scene.toml", scene(part("housing", "connector.step"), cable(), LOOP, head=PVC))


# --- the result and nothing else -------------------------------------------------------------------------------------


def test_build_prints_paths(cli, good):
    """Of Open Cascade nothing is heard, at the level of file descriptors."""
    ended = cli("build", good, "-o", "out.step", "--report", "out.json")
    assert (ended.code, ended.out) == (0, "out.step\nout.json\n")
    assert [line[:20] for line in ended.err.splitlines()] == ["warning: cable loop:"] * 3
    quiet = cli("build", good, "-o", "out.step", "-q")
    assert (quiet.code, quiet.out, quiet.err) == (0, "out.step\n", "")


def test_solve_prints_a_line_a_cable(cli, here):
    path = write(here / "scene.toml", scene(cable(material='"pvc"'), cable("line", length="300"), LOOP, head=PVC))
    ended = cli("solve", path)
    assert ended.code == 0
    assert ended.out.splitlines() == [
        "W1: solved, planar (inflexional), length 350 mm, chord 300 mm, least bend radius 143.3016 mm at s = 175 mm, "
        "end force 4.24441 N, stable",
        "line: solved, straight (line), length 300 mm, chord 300 mm, no bend, stable",
        "loop: solved, planar (inflexional), length 350 mm, chord -77.79393 mm, least bend radius 32.72565 mm at "
        "s = 175 mm, unstable",
    ]


def test_check_prints_a_line_a_cable(cli, good):
    ended = cli("check", good)
    assert ended.code == 0
    assert [line.partition(", deviation ")[0] for line in ended.out.splitlines()] == ["W1: ok", "loop: ok"]
    assert all(line.endswith(" mm of 0.001 mm allowed") for line in ended.out.splitlines())


@pytest.mark.parametrize("command", ["solve", "check"])
def test_json_is_all_there_is_on_stdout(cli, good, command):
    ended = cli(command, good, "--json")
    assert [one["name"] for one in json.loads(ended.out)["cables"]] == ["W1", "loop"]
    assert ended.err.count("warning: ") == 3


def test_points_without_json_go_nowhere_and_that_is_said(cli, good):
    ended = cli("solve", good, "--points", "5")
    assert ended.code == 0
    assert ended.err.startswith("warning: --points goes into the report: add --json to see it\n")
    assert ended.out == cli("solve", good).out


def test_what_a_part_lost_is_a_warning(cli, here):
    """A face without an edge: the rest of the part is read."""
    write(here / "as1.stp", re.sub(rb"(EDGE_LOOP\('',\()[^)]*", rb"\g<1>", AS1.read_bytes(), count=1))
    path = write(here / "scene.toml", scene(part("assembly", "as1.stp"), cable()))
    ended = cli("build", path, "-o", "out.step")
    assert (ended.code, ended.out) == (0, "out.step\n")
    (told,) = ended.err.splitlines()
    assert told.startswith(f"warning: {here / 'as1.stp'}: 1 of its entities ")
    assert cli("build", path, "-o", "out.step", "-q").err == ""


# --- verbosity -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "code"), [(cable(rise="50"), 2), (cable(length="200"), 3), (cable(diameter="290"), 4)]
)
def test_quiet_says_errors_and_verbose_where_they_come_from(cli, here, text, code):
    path = write(here / "scene.toml", scene(text))
    plain, quiet, verbose = (cli("check", path, *option) for option in ([], ["-q"], ["-v"]))
    assert plain.code == quiet.code == verbose.code == code
    assert quiet.err == plain.err
    assert plain.out == quiet.out == verbose.out
    assert verbose.err.startswith(plain.err)
    assert "Traceback (most recent call last)" in verbose.err
    assert "NoneType" not in verbose.err


def test_verbose_does_not_outlive_its_command(cli, here):
    path = write(here / "scene.toml", scene(cable(length="200")))
    assert "Traceback" in cli("solve", path, "-v").err
    assert "Traceback" not in cli("solve", path).err


def test_bug_is_called_one(cli, good, monkeypatch):
    def fail(*_arguments, **_options):
        raise ZeroDivisionError("float division by zero")

    monkeypatch.setattr("cablecad.pipeline.scene.solve_many", fail)
    ended = cli("build", good, "-o", "out.step", "--report", "out.json")
    said = "this is a bug in cablecad: ZeroDivisionError: float division by zero (run with -v for the traceback)"
    assert (ended.code, ended.out, ended.err) == (1, "", f"error: {said}\n")
    assert names(good.parent) == ["connector.step", "scene.toml"]
    assert "in fail" in cli("solve", good, "-v").err


def test_no_kernel(here):
    write(here / "scene.toml", scene(cable()))
    code = "import sys; sys.modules['OCP'] = None; from cablecad.cli import main; main()"
    one = subprocess.run(
        [sys.executable, "-c", code, "build", "scene.toml", "-o", "out.step"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert (one.returncode, one.stdout) == (5, "")
    assert 'pip install "cablecad[ocp]"' in one.stderr
    assert "Traceback" not in one.stderr
    assert names(here) == ["scene.toml"]


# --- usage -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ([], "Usage: cablecad"),
        (["biuld"], "No such command 'biuld'"),
        (["build"], "Missing argument 'SCENE'"),
        (["build", "scene.toml", "--ouput", "out.step"], "--output"),
        (["build", "scene.toml", "extra.toml"], "unexpected extra argument"),
        (["build", "scene.toml", "-o"], "requires an argument"),
        (["build", "scene.toml", "--tolerance", "fine"], "'fine' is not a valid float"),
        (["solve", "scene.toml", "--points", "1"], "1 is not in the range 2<=x<=10000000"),
        (["solve", "scene.toml", "--points", "2.5"], "'2.5' is not a valid integer"),
        (["solve", "--strict", "scene.toml"], "--strict"),
        (["check"], "Missing argument 'SCENE'"),
        (["new"], "Missing argument 'FILE'"),
        (["schema", "loom.toml"], "unexpected extra argument"),
    ],
)
def test_wrong_usage(cli, here, good, arguments, said):
    ended = cli(*arguments)
    assert (ended.code, ended.out) == (2, "")
    assert said in ended.err
    assert names(here) == ["connector.step", "scene.toml"]


@pytest.mark.parametrize("option", ["-h", "--help"])
def test_help_of_the_program(cli, option):
    ended = cli(option)
    assert (ended.code, ended.err) == (0, "")
    for words in (*COMMANDS, "cablecad build loom.toml -o loom.step", "Exit codes: 0 done, 1 a bug"):
        assert words in ended.out


@pytest.mark.parametrize(
    ("command", "said"),
    [
        ("build", ["-o, --output", "--report", "--strict", "min_bend_radius", "--tolerance MM", "[mm]", "-q", "-v"]),
        ("solve", ["--json", "--points N", "equal arclengths", "--equilibria", "mm, forces in N"]),
        ("check", ["--json", "exit 4"]),
        ("schema", ["JSON Schema", "unit"]),
        ("new", ["FILE", ".toml", "--force"]),
    ],
)
def test_help_of_a_command(cli, command, said):
    ended = cli(command, "--help")
    assert (ended.code, ended.err) == (0, "")
    assert ended.out.startswith(f"Usage: cablecad {command} ")
    assert f"\n    cablecad {command}" in ended.out  # an example
    for words in said:
        assert words in ended.out


def test_version(cli):
    assert cli("--version").out == f"cablecad, version {cablecad.__version__}\n"


# --- streams that are not as usual -----------------------------------------------------------------------------------


@pytest.mark.parametrize("arguments", [["schema"], ["--help"], ["solve", "scene.toml", "--json", "-q"]])
def test_reader_that_never_was(process, good, arguments):
    """As with `| true`."""
    reading, writing = os.pipe()
    os.close(reading)
    one = process(*arguments, stdout=writing)
    os.close(writing)
    assert one.communicate()[1] == ""
    assert one.returncode == 0


def test_reader_that_goes_away(here):
    shell = "\"$0\" -c 'from cablecad.cli import main; main()' schema | head -1; echo ${PIPESTATUS[0]}"
    one = subprocess.run(["bash", "-c", shell, sys.executable], capture_output=True, text=True, check=True)
    assert (one.stdout, one.stderr) == ("{\n0\n", "")


@pytest.mark.parametrize("arguments", [["solve", "scene.toml", "-q"], ["schema"], ["--version"], ["new", "new.toml"]])
def test_full_disk_behind_stdout(process, good, arguments):
    with Path("/dev/full").open("w") as full:
        one = process(*arguments, stdout=full)
        err = one.communicate()[1]
    assert (one.returncode, err) == (5, "error: stdout cannot be written: No space left on device; send it elsewhere\n")


def test_closed_streams(process, good):
    for closed in (1, 2):
        one = process("solve", "scene.toml", preexec_fn=lambda closed=closed: os.close(closed))
        out, err = one.communicate()
        assert one.returncode == 0
        assert (out == "") == (closed == 1)
        assert (err == "") == (closed == 2)


@pytest.mark.parametrize(
    "environment",
    [{"LC_ALL": "C"}, {"LC_ALL": "C", "PYTHONCOERCECLOCALE": "0", "PYTHONUTF8": "0"}, {"PYTHONIOENCODING": "cp1252"}],
)
def test_names_of_any_script_in_any_locale(process, here, environment):
    name = "Käbel 电缆 🧵"
    write(here / "scene.toml", FORMAT + cable(name))
    for arguments in ((), ("--json",)):
        one = process("solve", "scene.toml", *arguments, env={**os.environ, **environment}, text=False)
        out, err = one.communicate()
        assert (one.returncode, err) == (0, b"")
        found = json.loads(out)["cables"][0]["name"] if arguments else out.decode().partition(":")[0]
        assert found == name


def test_path_that_is_no_text(process, here):
    """A file name of Linux is bytes, of any kind."""
    write(here / "scene.toml", scene(cable()))
    code = "from cablecad.cli import main; import os; main(['new', os.fsdecode(b'b\\xff.toml')])"
    one = subprocess.run([sys.executable, "-c", code], capture_output=True, check=False)
    assert (one.returncode, one.stdout, one.stderr) == (0, b"b\xff.toml\n", b"")


# --- progress --------------------------------------------------------------------------------------------------------


def on_a_terminal(process, *arguments):
    """Run a command with stderr on a terminal; its exit code, its stdout and what the terminal saw."""
    terminal, side = pty.openpty()
    one = process(*arguments, stderr=side, env={**os.environ, "TERM": "xterm"})
    os.close(side)
    seen = b""
    while True:
        try:
            piece = os.read(terminal, 65536)
        except OSError:  # the other side is closed
            break
        if not piece:
            break
        seen += piece
    os.close(terminal)
    return one.wait(), one.communicate()[0], seen.decode()


def test_progress_is_drawn_on_a_terminal_only(process, here):
    write(here / "scene.toml", scene(*(cable(f"W{i}", length="310") for i in range(50))))
    code, out, seen = on_a_terminal(process, "solve", "scene.toml")
    assert code == 0
    assert [line.partition(":")[0] for line in out.splitlines()] == [f"W{i}" for i in range(50)]
    assert "/50" in seen
    assert "\x1b[2K" in seen  # it is wiped away at the end
    code, quiet, seen = on_a_terminal(process, "solve", "scene.toml", "-q")
    assert (code, quiet, seen) == (0, out, "")
    one = process("solve", "scene.toml")
    assert one.communicate() == (out, "")


def test_errors_are_red_on_a_terminal_only(process, here):
    write(here / "scene.toml", scene(cable(length="200")))
    assert on_a_terminal(process, "solve", "scene.toml")[2].startswith("\x1b[31m\x1b[1merror: \x1b[0mcable W1: ")
    assert process("solve", "scene.toml").communicate()[1].startswith("error: cable W1: ")
