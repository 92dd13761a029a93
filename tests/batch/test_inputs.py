"""What a batch reads: no output may be among it, and no change of it while it runs goes unnoticed."""

from __future__ import annotations

import os
import shutil

import pytest
from variants import CONNECTOR, PART, STRAIGHT, journal, lengths, write

import cablecad as cc
from cablecad.batch import Row, run, run_batch, scene_rows, table_rows
from cablecad.errors import ExchangeError, UsageError

CHANGED = "the rows changed while they were worked on"


@pytest.fixture
def scene(tmp_path):
    shutil.copy(CONNECTOR, tmp_path / "connector.step")
    return write(tmp_path / "scene.toml", STRAIGHT + PART)


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}


def refused(rows, folder, *words, **settings):
    """A batch that ends before anything runs or is removed, naming both its output and its input."""
    before = contents(folder)
    with pytest.raises(UsageError) as caught:
        run_batch(rows, folder=folder, **settings)
    for word in words:
        assert str(word) in str(caught.value)
    assert contents(folder) == before


# --- outputs that are inputs ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("settings", [{}, {"force": True}, {"resume": True}], ids=["", "force", "resume"])
def test_a_row_writes_no_part_of_its_own_or_of_another(tmp_path, scene, settings):
    part = tmp_path / "connector.step"
    words = f"output {part} is also an input: {part}, read by row 'a'; write to another folder"
    for last in ("b,", "connector,", "connector,other.step"):
        table = write(tmp_path / "t.csv", f"id,parts.housing.step\na,\n{last}\n")
        if last != "b,":
            refused(table_rows(table, scene), tmp_path, words, **settings)
    rows = scene_rows([write(tmp_path / "a.toml", STRAIGHT + PART), write(tmp_path / "connector.toml", STRAIGHT)])
    refused(rows, tmp_path, words, **settings)
    whole = [Row("a", cc.load_scene(tmp_path / "a.toml")), Row("connector", cc.load_scene(tmp_path / "connector.toml"))]
    refused(whole, tmp_path, words, **settings)


def test_links_lead_to_the_same_file_and_a_file_need_not_be_there(tmp_path, scene):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "r0.step").symlink_to(tmp_path / "connector.step")
    table = lengths(tmp_path / "t.csv", [300])
    refused(table_rows(table, scene), tmp_path / "out", "out/r0.step", f"{tmp_path / 'connector.step'}, read by row")
    missing = write(tmp_path / "t2.csv", "id,parts.housing.step\na,out/b.step\nb,\n")
    refused(table_rows(missing, scene), tmp_path / "out", "out/b.step is also an input", "read by row 'a'")


@pytest.mark.parametrize("name", ["reports.jsonl", "results.csv"])
def test_the_batchs_own_files_are_no_inputs(tmp_path, name):
    """Whatever its name, a file may be a table, a scene, or a part."""
    out = tmp_path / "out"
    out.mkdir()
    scene = write(tmp_path / "scene.toml", STRAIGHT)
    write(out / name, "id,cables.W1.length\na,300\n" if name == "results.csv" else '{"cables.W1.length": 300}\n')
    refused(table_rows(out / name, scene), out, f"output {out / name} is also an input", "the table", force=True)
    shutil.copy(scene, out / name)
    refused(table_rows(lengths(tmp_path / "t.csv", [300]), out / name), out, name, "read by row 'r0'", force=True)
    refused(scene_rows([out / name]), out, name, "is also an input", output="none", force=True)
    write(scene, STRAIGHT + PART.replace("connector.step", f"out/{name}"))
    refused(scene_rows([scene]), out, name, "read by row 'scene'", output="none", force=True)


@pytest.mark.parametrize("settings", [{"force": True}, {"resume": True}], ids=["force", "resume"])
@pytest.mark.parametrize("output", ["step", "none"])
def test_what_an_earlier_run_wrote_and_this_one_reads_is_not_removed(tmp_path, scene, settings, output):
    pytest.importorskip("OCP", reason="solids need the kernel")
    out = tmp_path / "out"
    run_batch(table_rows(lengths(tmp_path / "t.csv", [300, 301]), scene), folder=out, workers=0)
    write(scene, STRAIGHT + PART.replace("connector.step", "out/r1.step"))
    table = table_rows(write(tmp_path / "t.csv", "id,cables.W1.length\nx,300\n"), scene)
    refused(table, out, f"{out / 'r1.step'}, which an earlier run wrote", "read by row 'x'", output=output, **settings)


# --- inputs that change -----------------------------------------------------------------------------------------------


LONG = ["300.00000000000000000"] * 500
"""Lengths that do not all go into the buffer of a file that is read."""


def test_a_table_edited_while_it_is_worked_on(tmp_path, monkeypatch):
    monkeypatch.setattr(run, "BLOCK", 50)
    scene = write(tmp_path / "scene.toml", STRAIGHT)
    table = table_rows(lengths(tmp_path / "t.csv", LONG), scene)

    def edit(standing):
        if standing.done == 50:
            lengths(tmp_path / "t.csv", [*LONG[1:], LONG[0].replace("300", "301")])

    with pytest.raises(ExchangeError, match=f"{CHANGED}: row 500, 'r499', has other values"):
        run_batch(table, folder=tmp_path / "out", output="none", workers=0, progress=edit)
    lines = journal(tmp_path / "out")
    assert len(lines) == 450
    summary = run_batch(table, folder=tmp_path / "out", output="none", workers=0, resume=True)
    assert (summary.kept, summary.counts) == (450, {"done": 500})


def test_a_table_that_is_mistaken_now(tmp_path, monkeypatch):
    monkeypatch.setattr(run, "BLOCK", 50)
    scene = write(tmp_path / "scene.toml", STRAIGHT)
    table = table_rows(lengths(tmp_path / "t.csv", LONG), scene)

    def edit(standing):
        if standing.done == 50:
            lengths(tmp_path / "t.csv", [*LONG[1:], "300,3"])

    with pytest.raises(ExchangeError, match=CHANGED):
        run_batch(table, folder=tmp_path / "out", output="none", workers=0, progress=edit)


def test_a_table_that_was_only_touched_or_written_elsewhere_is_none(tmp_path, monkeypatch):
    """Most editors write a new file, and the one that is read stays."""
    monkeypatch.setattr(run, "BLOCK", 2)
    scene = write(tmp_path / "scene.toml", STRAIGHT)
    table = table_rows(lengths(tmp_path / "t.csv", [300] * 6), scene)

    def edit(standing):
        if standing.done == 2:
            os.utime(tmp_path / "t.csv", ns=(0, 0))
        else:
            lengths(tmp_path / "new.csv", [301]).replace(tmp_path / "t.csv")

    summary = run_batch(table, folder=tmp_path / "out", output="none", workers=0, progress=edit)
    assert summary.counts == {"done": 6}


@pytest.mark.parametrize("kind", ["scene", "part"])
def test_a_scene_or_a_part_edited_while_it_is_worked_on(tmp_path, scene, kind):
    pytest.importorskip("OCP", reason="solids need the kernel")
    rows = scene_rows([shutil.copy(scene, tmp_path / f"{name}.toml") for name in "abc"])
    edited = tmp_path / "c.toml" if kind == "scene" else tmp_path / "connector.step"

    def edit(standing):
        if standing.done == 2:
            edited.write_text(edited.read_text().replace("300", "301").replace("ENDSEC;", "ENDSEC; ", 1))
        else:
            os.utime(edited)  # which changes nothing

    with pytest.raises(ExchangeError, match=f"{CHANGED}: row 3, 'c'"):
        run_batch(rows, folder=tmp_path / "out", workers=0, progress=edit)
    assert list(journal(tmp_path / "out")) == ["a", "b"]
    assert not (tmp_path / "out" / "c.step").exists()
    summary = run_batch(rows, folder=tmp_path / "out", workers=0, resume=True)
    assert (summary.kept, summary.total) == (2 if kind == "scene" else 0, 3)


def test_rows_made_in_python_that_are_others_the_second_time(tmp_path):
    class Growing:
        length = 300.0

        def __iter__(self):
            self.length += 1.0
            cable = cc.Cable("W1", 4.0, cc.Pin((0, 0, 0)), cc.Pin((300, 0, 0)), length=self.length)
            yield Row("a", cc.Scene(cables=(cable,)))

    with pytest.raises(ExchangeError, match=f"{CHANGED}: row 1, 'a'"):
        run_batch(Growing(), folder=tmp_path / "out", output="none", workers=0)
