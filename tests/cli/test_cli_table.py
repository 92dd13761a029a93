"""What `solve` prints for people: a table on a terminal, in colour there only; lines for programs elsewhere."""

from __future__ import annotations

import os
import pty
import re

import pytest
from loom import PVC, TOWARD, cable, scene, write

COLOR = re.compile(r"\x1b\[[0-9;]*m")
LOOP = cable("loop", angle_deg="150", end=TOWARD, allow_contact="true")
SCENE = scene(
    cable(material='"pvc"', min_bend_radius="150"),
    cable("line", length="300"),
    cable("short", length="200"),
    LOOP,
    head=PVC,
)


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write(tmp_path / "scene.toml", SCENE)
    return tmp_path


def on_a_terminal(process, *arguments, **environment):
    """Run a command with both streams on a terminal; its exit code and what the terminal saw."""
    terminal, side = pty.openpty()
    env = {key: value for key, value in os.environ.items() if key != "NO_COLOR"}
    one = process(*arguments, stdout=side, stderr=side, env={**env, "TERM": "xterm", "COLUMNS": "100", **environment})
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
    return one.wait(), seen.decode().replace("\r\n", "\n")


def blocks(text: str) -> dict[str, dict[str, str]]:
    """The tables by cable: its verdict under "", the rest under its labels, wrapped lines joined."""
    found: dict[str, dict[str, str]] = {}
    for line in text.splitlines():
        if line and not line.startswith(" "):
            name, _, verdict = line.partition(": ")
            rows = found[name] = {"": verdict}
            label = ""
        elif line:
            label = line[2:16].strip() or label
            rows[label] = f"{rows[label]} {line[17:]}" if label in rows and not line[2:16].strip() else line[17:]
    return found


def test_table_says_what_people_ask(cli, here):
    ended = cli("solve", "scene.toml", "--table")
    assert ended.code == 3
    assert "\x1b" not in ended.out
    found = blocks(ended.out)
    assert {name: rows[""].split(" length")[0] for name, rows in found.items()} == {
        "W1": "solved, stable",
        "line": "solved, stable",
        "short": "infeasible",
        "loop": "solved, unstable",
    }
    one = found["W1"]
    assert one["model"].startswith("planar (inflexional): pinned at both ends")
    assert one["length"] == "350 mm, chord 300 mm, slack 0.1667"
    assert one["bend radius"] == "143.3016 mm at s = 175 mm (rule: at least 150 mm)"
    assert one["at the start"] == "force 4.244 N (4.244, 0, 0), no moment"
    assert one["at the end"] == "force 4.244 N (-4.244, 0, 0), no moment"
    assert one["energy"].endswith(" N mm")
    assert re.fullmatch(
        r"margin \S+ in its plane, \S+ out of it \(EI/L², above 0 is stable\); equilibrium 0 of \d+ found",
        one["stability"],
    )
    assert one["broken rule"].startswith("min_bend_radius: the least bend radius 143.302 mm")
    assert found["line"]["bend radius"] == "no bend"
    assert found["line"]["at the start"] == "no force, no moment"
    assert "EI /mm²" in found["loop"]["at the end"]
    assert "allow_contact lets through" in found["loop"]["warning"]
    assert "length 200 mm is 100 mm less than the distance of the ends" in found["short"][""]


def test_elsewhere_a_line_a_cable_as_ever(cli, here):
    plain, lines = cli("solve", "scene.toml"), cli("solve", "scene.toml", "--lines")
    assert plain == lines
    assert [line.partition(":")[0] for line in plain.out.splitlines()] == ["W1", "line", "short", "loop"]


def test_warnings_go_to_stderr_too_where_that_is_another_place(cli, here):
    table, lines = cli("solve", "scene.toml", "--table"), cli("solve", "scene.toml")
    assert table.err == lines.err
    assert "error: cable short: " in table.err


def test_terminal_gets_the_table_once_and_in_colour(process, here):
    code, seen = on_a_terminal(process, "solve", "scene.toml")
    assert code == 3
    plain = COLOR.sub("", seen[seen.index("\x1b[1mW1") :])
    assert list(blocks(plain)) == ["W1", "line", "short", "loop"]
    assert plain.count("the ends have crossed") == plain.count("length 200 mm is 100 mm less") == 1
    assert "\x1b[1mW1\x1b[0m: \x1b[32msolved, stable\x1b[0m\n" in seen
    assert "\x1b[31msolved, unstable\x1b[0m" in seen
    assert max(map(len, plain.splitlines())) <= 100


def test_terminal_without_colour(process, here):
    _, seen = on_a_terminal(process, "solve", "scene.toml", "-q", NO_COLOR="1")
    assert "\x1b" not in seen
    assert seen.startswith("W1: solved, stable\n")


def test_narrow_terminal(process, here):
    _, seen = on_a_terminal(process, "solve", "scene.toml", "-q", NO_COLOR="1", COLUMNS="60")
    assert max(map(len, seen.splitlines())) <= 60


def test_json_stays_json_on_a_terminal(process, here):
    _, seen = on_a_terminal(process, "solve", "scene.toml", "-q", "--json")
    assert seen.startswith('{\n  "format": 1')
