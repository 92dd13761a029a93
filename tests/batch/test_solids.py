"""Solids of a batch: the bytes of `cablecad build`, parts read once, and what a failed row leaves behind."""

from __future__ import annotations

import os
import shutil

import pytest
from variants import CONNECTOR, PART, SAMPLES, STRAIGHT, assert_same, journal, write

pytest.importorskip("OCP", reason="solids need the kernel")

from cablecad.batch import WorkerPool, run_batch, table_rows
from cablecad.errors import ExchangeError, UsageError
from cablecad.pipeline import Documents


@pytest.fixture
def scene(tmp_path):
    shutil.copy(CONNECTOR, tmp_path / "connector.step")
    return write(tmp_path / "scene.toml", STRAIGHT + PART)


def diameters(scene, *values):
    """A table of diameters of a straight cable, with the ids r0, r1, ..."""
    rows = "".join(f"r{i},{value}\n" for i, value in enumerate(values))
    return table_rows(write(scene.with_name("table.csv"), f"id,cables.W1.diameter\n{rows}"), scene)


def test_bytes_are_those_of_build(tmp_path, process):
    table = table_rows(SAMPLES / "clamped.csv", SAMPLES / "clamped.toml")
    summary = run_batch(table, folder=tmp_path / "out", workers=2)
    assert summary.counts == {"done": 6}
    assert 0.0 < summary.worst_deviation[0] <= 1e-3
    run_batch(table, folder=tmp_path / "here", workers=0)
    assert_same(tmp_path / "here", tmp_path / "out")
    # As the user would have it: the row's values written into the scene, and a fresh process.
    text = (SAMPLES / "clamped.toml").read_text(encoding="utf-8")
    text = text.replace('"parts/connector.step"', f'"{CONNECTOR}"').replace("length = 350.0", "length = 400")
    fresh = write(tmp_path / "fresh.toml", text.replace("[0, 120, 0]", "[0, 100, 0]"))
    ended = process("build", fresh, "-o", tmp_path / "fresh.step")
    assert ended.wait() == 0
    assert (tmp_path / "fresh.step").read_bytes() == (tmp_path / "out" / "L400-100.step").read_bytes()


def test_the_time_stamp_is_that_of_whoever_started_the_batch(tmp_path, scene, monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")
    table = diameters(scene, 3)
    with WorkerPool(1) as pool:
        # As a process that was there before.
        assert pool.submit(eval, "__import__('os').environ.pop('SOURCE_DATE_EPOCH')").result() == "1700000000"
        run_batch(table, folder=tmp_path / "out", executor=pool)
        assert pool.submit(os.getenv, "SOURCE_DATE_EPOCH").result() is None
    assert b"'2023-11-14T22:13:20'" in (tmp_path / "out" / "r0.step").read_bytes()


def test_a_part_is_read_once_until_it_changes(tmp_path, scene, monkeypatch):
    from cablecad.brep import step

    read = []
    real = step.read_step
    monkeypatch.setattr(step, "read_step", lambda path: read.append(path) or real(path))
    table = diameters(scene, 3, 4, 5)
    run_batch(table, folder=tmp_path / "out", workers=0)
    assert len(read) == 1
    content = (tmp_path / "connector.step").read_bytes()
    (tmp_path / "connector.step").write_bytes(content.replace(b"ENDSEC;", b"ENDSEC; ", 1))
    summary = run_batch(table, folder=tmp_path / "out", workers=0, force=True)
    assert (len(read), summary.failed) == (2, 0)


def test_documents_kept_are_bounded(tmp_path, monkeypatch):
    documents = Documents()
    monkeypatch.setattr("cablecad.pipeline.documents._MOST", 2)
    for name in ("a", "b", "a", "c"):
        shutil.copy(CONNECTOR, tmp_path / f"{name}.step")
        os.utime(tmp_path / f"{name}.step", ns=(0, 0))
        documents.read(tmp_path / f"{name}.step")
    assert [path for path, _, _ in documents._kept] == [str(tmp_path / "a.step"), str(tmp_path / "c.step")]


def test_ends_on_parts_follow_what_is_overridden_and_their_part_is_read_once(tmp_path, scene, monkeypatch):
    from cablecad.brep import step

    read = []
    real = step.read_step
    monkeypatch.setattr(step, "read_step", lambda path: read.append(path) or real(path))
    on_part = STRAIGHT.replace("start = { position = [0, 0, 0] }", 'start = { part = "housing", port = "J1" }')
    ports = '[[parts.ports]]\nname = "J1"\nposition = [0, 0, 0]\n'
    write(scene, (on_part + PART + ports).replace("length = 300.0", "slack = 1e-3"))
    name = "parts.housing.ports.J1.position[0]"
    table = table_rows(write(tmp_path / "t.csv", f"id,{name}\na,-10\nb,-20\n"), scene)
    assert run_batch(table, folder=tmp_path / "out", workers=0).counts == {"done": 2}
    lines = journal(tmp_path / "out")
    assert [lines[key]["cables"][0]["chord"] for key in ("a", "b")] == [310.0, 320.0]
    assert len(read) == 1


def test_a_part_with_other_contents_is_another_input(tmp_path, scene):
    table = diameters(scene, 3)
    run_batch(table, folder=tmp_path / "out", workers=0)
    assert run_batch(table, folder=tmp_path / "out", workers=0, resume=True).kept == 1
    content = (tmp_path / "connector.step").read_bytes()
    (tmp_path / "connector.step").write_bytes(content.replace(b"ENDSEC;", b"ENDSEC; ", 1))
    assert run_batch(table, folder=tmp_path / "out", workers=0, resume=True).kept == 0


def test_a_row_whose_file_is_gone_is_not_finished(tmp_path, scene):
    table = diameters(scene, 3, 4)
    run_batch(table, folder=tmp_path / "out", workers=0)
    before = (tmp_path / "out" / "r1.step").read_bytes()
    (tmp_path / "out" / "r1.step").unlink()
    assert run_batch(table, folder=tmp_path / "out", workers=0, resume=True).kept == 1
    assert (tmp_path / "out" / "r1.step").read_bytes() == before


def test_what_is_forgotten_leaves_no_file_but_what_is_not_ours_stays(tmp_path, scene):
    (tmp_path / "out").mkdir()
    write(tmp_path / "out" / "r2.step", "not ours")
    run_batch(diameters(scene, 3, 4), folder=tmp_path / "out", workers=0)
    run_batch(diameters(scene, 5), folder=tmp_path / "out", workers=0, force=True)
    assert sorted(path.name for path in (tmp_path / "out").glob("*.step")) == ["r0.step", "r2.step"]
    run_batch(diameters(scene, 5, 4), folder=tmp_path / "out", workers=0, resume=True)
    run_batch(diameters(scene, 5), folder=tmp_path / "out", workers=0, resume=True)
    assert sorted(path.name for path in (tmp_path / "out").glob("*.step")) == ["r0.step", "r2.step"]


def test_a_failed_row_leaves_no_file_not_even_of_an_earlier_run(tmp_path, scene):
    run_batch(diameters(scene, 3, 4), folder=tmp_path / "out", workers=0)
    table = diameters(scene, 3, -1)
    summary = run_batch(table, folder=tmp_path / "out", workers=0, resume=True)
    assert summary.counts == {"done": 1, "failed": 1}
    assert [path.name for path in (tmp_path / "out").glob("*.step")] == ["r0.step"]


def test_a_part_that_cannot_be_read_fails_its_row(tmp_path, scene):
    table = write(tmp_path / "t.csv", "id,parts.housing.step\na,none.step\nb,connector.step\n")
    run_batch(table_rows(table, scene), folder=tmp_path / "out", workers=0)
    lines = journal(tmp_path / "out")
    assert (lines["a"]["status"], lines["a"]["exit_code"], lines["b"]["status"]) == ("failed", 5, "done")
    assert "part housing" in lines["a"]["error"]


def test_a_failed_row_leaves_no_file_whoever_wrote_it(tmp_path, scene):
    """A killed run's, whose line was not written any more, or another's."""
    (tmp_path / "out").mkdir()
    write(tmp_path / "out" / "r0.step", "not of this row")
    summary = run_batch(diameters(scene, -1, 3), folder=tmp_path / "out", workers=0)
    assert summary.counts == {"done": 1, "failed": 1}
    assert [path.name for path in (tmp_path / "out").glob("*.step")] == ["r1.step"]
    write(tmp_path / "out" / "r0.step", "not of this row")
    assert run_batch(diameters(scene, -1, 3), folder=tmp_path / "out", workers=0, resume=True).kept == 1
    assert [path.name for path in (tmp_path / "out").glob("*.step")] == ["r1.step"]


def test_a_changed_row_leaves_no_file_of_the_old_one_without_solids_either(tmp_path, scene):
    run_batch(diameters(scene, 3, 4), folder=tmp_path / "out", workers=0)
    write(tmp_path / "out" / "other.step", "not ours")
    run_batch(diameters(scene, 5, 4), folder=tmp_path / "out", output="none", resume=True)
    assert [path.name for path in (tmp_path / "out").glob("*.step")] == ["other.step"]


def test_results_only_tell_of_no_file_so_that_none_is_removed(tmp_path, scene):
    run_batch(diameters(scene, 3, 4), folder=tmp_path / "out", output="none")
    write(tmp_path / "out" / "r0.step", "not ours")
    for settings in ({"resume": True}, {"force": True}):
        run_batch(diameters(scene, 5, 4), folder=tmp_path / "out", output="none", **settings)
        assert (tmp_path / "out" / "r0.step").read_text() == "not ours"


@pytest.mark.parametrize("settings", [{"force": True}, {"resume": True}], ids=["force", "resume"])
def test_a_file_that_cannot_be_removed_is_named(tmp_path, scene, settings):
    run_batch(diameters(scene, 3, 4), folder=tmp_path / "out", workers=0)
    (tmp_path / "out" / "r1.step").unlink()
    (tmp_path / "out" / "r1.step").mkdir()
    with pytest.raises(ExchangeError, match=r"r1\.step cannot be written: it is a folder"):
        run_batch(diameters(scene, 5), folder=tmp_path / "out", workers=0, **settings)


@pytest.mark.parametrize("size", [0, 1000])
def test_a_row_whose_file_is_not_whole_is_not_finished(tmp_path, scene, size):
    table = diameters(scene, 3, 4)
    run_batch(table, folder=tmp_path / "out", workers=0)
    before = (tmp_path / "out" / "r1.step").read_bytes()
    os.truncate(tmp_path / "out" / "r1.step", size)
    assert run_batch(table, folder=tmp_path / "out", workers=0, resume=True).kept == 1
    assert (tmp_path / "out" / "r1.step").read_bytes() == before


def test_a_time_stamp_that_is_none_ends_the_batch(tmp_path, scene, monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "yesterday")
    table = diameters(scene, 3, 4)
    with pytest.raises(UsageError, match="SOURCE_DATE_EPOCH is 'yesterday'"):
        run_batch(table, folder=tmp_path / "out", workers=1)


def test_what_a_part_lost_is_told_once(tmp_path, scene, caplog):
    caplog.set_level("WARNING", logger="cablecad")
    import re

    text = (tmp_path / "connector.step").read_bytes()
    (tmp_path / "connector.step").write_bytes(re.sub(rb"(EDGE_LOOP\('',\()[^)]*", rb"\g<1>", text, count=1))
    table = diameters(scene, 3, 4, 5)
    run_batch(table, folder=tmp_path / "out", workers=2)
    assert sum("connector.step: 1 of its entities" in message for message in caplog.messages) == 1
