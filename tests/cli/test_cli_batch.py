"""`cablecad batch`: what it takes, what it prints and what it ends with."""

from __future__ import annotations

import builtins
import os
import pty
import sys
from pathlib import Path

import pytest
from loom import FORMAT, cable, names, scene, write

LINE = {"length": "300"}
"""A straight cable, which takes no time."""


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write(tmp_path / "scene.toml", scene(cable(**LINE)))
    write(tmp_path / "table.csv", "id,cables.W1.diameter\na,3\nb,4\n")
    return tmp_path


def test_a_table_prints_paths_and_sums_up(cli, here):
    ended = cli("batch", "table.csv", "--scene", "scene.toml", "-o", "out", "--output", "none")
    assert (ended.code, ended.out) == (0, "out/reports.jsonl\nout/results.csv\n")
    first, second = ended.err.splitlines()
    assert first.startswith("2 rows: 2 done; ")
    assert second.startswith("slowest rows: ")
    assert names(here / "out") == ["reports.jsonl", "results.csv"]


def test_quiet(cli):
    ended = cli("batch", "table.csv", "--scene", "scene.toml", "-o", "out", "--output", "none", "-q")
    assert (ended.code, ended.err) == (0, "")


def test_failed_rows_are_told_and_end_with_6(cli, here):
    write(here / "table.csv", "cables.W1.diameter\n" + "-1\n" * 12 + "3\n")
    ended = cli("batch", "table.csv", "--scene", "scene.toml", "-o", "out", "--output", "none")
    assert ended.code == 6
    errors = [line for line in ended.err.splitlines() if line.startswith("error: ")]
    assert errors[0] == "error: row 1 failed: cables.W1.diameter = -1.0: must be greater than 0"
    assert errors[10:] == [
        "error: more rows fail; results.csv will tell of all of them",
        "error: 12 of 13 rows have no result; out/results.csv says why",
    ]
    assert "13 rows: 1 done, 12 failed; " in ended.err


def test_a_grid(cli, here):
    options = ("--grid", "cables.W1.diameter=3:5:3", "--grid", "cables.W1.allow_contact=true,false")
    for arguments in (("--scene", "scene.toml"), ("scene.toml",)):
        ended = cli("batch", *arguments, *options, "-o", "out", "--output", "none", "--force")
        assert ended.code == 0
        assert "6 rows: 6 done" in ended.err


def test_scene_files(cli, here):
    write(here / "other.toml", scene(cable(**LINE)))
    ended = cli("batch", "scene.toml", "other.toml", "none.toml", "-o", "out", "--output", "none")
    assert ended.code == 6
    assert "error: row none failed: cannot read the scene file 'none.toml'" in ended.err


def test_solids(cli, here):
    pytest.importorskip("OCP", reason="solids need the kernel")
    assert cli("batch", "table.csv", "--scene", "scene.toml", "-o", "out").code == 0
    assert cli("build", "scene.toml", "-o", "b.step").code == 0
    assert names(here / "out") == ["a.step", "b.step", "reports.jsonl", "results.csv"]
    assert (here / "out" / "b.step").read_bytes() == (here / "b.step").read_bytes()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((), "nothing to do"),
        (("table.csv",), "table.csv is a table: give --scene SCENE"),
        (("--scene", "scene.toml"), "--scene needs the one table"),
        (("table.csv", "table.csv", "--scene", "scene.toml"), "given are 2 files"),
        (("table.csv", "--scene", "scene.toml", "--grid", "name=a"), "--grid sweeps values of one scene"),
        (("--grid", "name=a"), "--grid sweeps values of one scene"),
        (("table.csv", "--scene", "scene.toml", "--resume", "--force"), "give one of them"),
        (("table.csv", "--scene", "scene.toml", "-j", "0", "--timeout", "3"), "--timeout needs worker processes"),
        (("table.csv", "--scene", "scene.toml", "-j", "2", "--dask", "tcp://x:1"), "leave out -j"),
        (("table.csv", "--scene", "scene.toml", "-j", "-1"), "-1 is not in the range"),
        (("table.csv", "--scene", "scene.toml", "--timeout", "0"), "0.0 is not in the range"),
        (("table.csv", "--scene", "scene.toml", "--timeout", "nan"), "the timeout is nan s"),
        (("table.csv", "--scene", "scene.toml", "--timeout", "inf"), "the timeout is inf s"),
    ],
)
def test_usage(cli, here, arguments, words):
    ended = cli("batch", *arguments, "-o", "out")
    assert (ended.code, ended.out) == (2, "")
    assert words in ended.err
    assert not (here / "out").exists()


@pytest.mark.parametrize("name", ["results.csv", "reports.jsonl"])
@pytest.mark.parametrize("more", [(), ("--force",), ("--resume",)])
def test_a_table_is_not_written_over(cli, here, name, more):
    (here / "out").mkdir()
    text = "id,cables.W1.diameter\na,3\n" if name == "results.csv" else '{"cables.W1.diameter": 3}\n'
    write(here / "out" / name, text)
    ended = cli("batch", f"out/{name}", "--scene", "scene.toml", "-o", "out", "--output", "none", *more)
    assert (ended.code, ended.out) == (2, "")
    assert ended.err == f"error: output out/{name} is also an input: out/{name}, the table; write to another folder\n"
    assert (names(here / "out"), (here / "out" / name).read_text()) == ([name], text)


def test_a_timeout_longer_than_a_thread_can_wait(cli):
    arguments = ("--scene", "scene.toml", "-o", "out", "--output", "none", "--timeout", "1e10")
    ended = cli("batch", "table.csv", *arguments)
    assert (ended.code, ended.err.count("Error")) == (0, 0)


def test_a_folder_in_the_place_of_the_results(cli, here):
    (here / "out" / "results.csv").mkdir(parents=True)
    ended = cli("batch", "table.csv", "--scene", "scene.toml", "-o", "out", "--output", "none")
    assert (ended.code, ended.out) == (5, "")
    assert ended.err.startswith("error: out/results.csv cannot be written: it is a folder, a pipe or a device; move it")


def test_all_mistakes_of_a_table_before_anything_runs(cli, here):
    write(here / "table.csv", "id,cables.W1.diametre,cables.W1.length\na,3,x\nb,4,300\n")
    ended = cli("batch", "table.csv", "--scene", "scene.toml", "-o", "out")
    assert ended.code == 2
    assert ended.err.startswith("error: table.csv: 2 mistakes\n  line 2, cables.W1.diametre: ")
    assert not (here / "out").exists()


def test_mistakes_of_the_scene_are_the_scenes(cli, here):
    write(here / "scene.toml", FORMAT + cable(diametre="4"))
    ended = cli("batch", "table.csv", "--scene", "scene.toml", "-o", "out")
    assert (ended.code, ended.err.splitlines()[0]) == (2, "error: scene.toml: 1 mistake")


def test_without_dask(cli, monkeypatch):
    real = builtins.__import__

    def refuse(name, *arguments, **options):
        if name.partition(".")[0] == "distributed":
            raise ImportError(name)
        return real(name, *arguments, **options)

    monkeypatch.setattr(builtins, "__import__", refuse)
    ended = cli("batch", "table.csv", "--scene", "scene.toml", "-o", "out", "--dask", "tcp://127.0.0.1:9")
    assert (ended.code, ended.err) == (5, 'error: --dask needs Dask: pip install "cablecad[dask]"\n')


def test_progress_is_for_terminals(here, process):
    leader, follower = pty.openpty()
    arguments = ("batch", "table.csv", "--scene", "scene.toml", "-o", "out", "--output", "none")
    batch = process(*arguments, stderr=follower, env={**os.environ, "TERM": "xterm", "COLUMNS": "120"})
    os.close(follower)
    out, _ = batch.communicate()
    shown = b""
    try:
        while piece := os.read(leader, 65536):
            shown += piece
    except OSError:  # the other side is closed
        pass
    finally:
        os.close(leader)
    assert out == "out/reports.jsonl\nout/results.csv\n"
    assert b"2/2" in shown
    assert b"0 failed" in shown
    assert b"rows/s" in shown


def test_results_only_load_no_open_cascade(here):
    import subprocess

    code = (
        "import sys\nfrom cablecad.cli.group import cablecad\n"
        "cablecad(['batch', 'table.csv', '--scene', 'scene.toml', '-o', 'out', '--output', 'none'],"
        " standalone_mode=False)\nassert not any(name.split('.')[0] == 'OCP' for name in sys.modules)\n"
    )
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert ended.returncode == 0, ended.stderr


def test_help_has_examples_that_parse(cli):
    ended = cli("batch", "--help")
    assert ended.code == 0
    assert "cablecad batch --scene loom.toml --grid cables.W1.length=300:400:11" in ended.out
    assert Path("scene.toml").exists()
