"""A journal that is not as it was written: what is damaged is done anew, and nothing else."""

from __future__ import annotations

import json

import pytest
from variants import STRAIGHT, assert_same, journal, lengths, write

from cablecad.batch import run_batch, table_rows
from cablecad.errors import UsageError


@pytest.fixture
def table(tmp_path):
    scene = write(tmp_path / "scene.toml", STRAIGHT)
    return table_rows(lengths(tmp_path / "t.csv", [300, 300, 300]), scene)


@pytest.fixture
def lines(table, tmp_path):
    """The lines of a journal of three rows; the same is kept in `whole`."""
    for name in ("out", "whole"):
        run_batch(table, folder=tmp_path / name, output="none")
    return (tmp_path / "out" / "reports.jsonl").read_bytes().splitlines(keepends=True)


def without(line, key):
    data = json.loads(line)
    del data[key]
    return json.dumps(data).encode() + b"\n"


@pytest.mark.parametrize(
    "damage",
    [
        lambda line: line.replace(b'"done"', b'"failed"'),
        lambda line: line.replace(b"300.0", b"301.0", 1),
        lambda line: line.replace(b'"r1"', b'"r2"'),
        lambda line: line.replace(b'"r1"', rb'"\ud800"'),
        lambda line: line.replace(b'"checksum": "', b'"checksum": "0'),
        lambda line: line[:-20] + b"\n",
        lambda _: b"[" * 200_000 + b"\n",
        lambda _: b'{"id": "r1", "status": "done", "hash": ' + b"9" * 10_000 + b"}\n",
        lambda line: b"\xff\x00" + line,
        lambda _: b"",
        *(lambda line, key=key: without(line, key) for key in ("overrides", "error", "cables", "size")),
        lambda line: without(line, "checksum"),
    ],
)
def test_a_damaged_line_is_done_anew(table, lines, tmp_path, damage):
    assert damage(lines[1]) != lines[1]
    (tmp_path / "out" / "reports.jsonl").write_bytes(lines[0] + damage(lines[1]) + lines[2])
    summary = run_batch(table, folder=tmp_path / "out", output="none", resume=True)
    assert (summary.kept, summary.counts) == (2, {"done": 3})
    assert_same(tmp_path / "whole", tmp_path / "out")


def test_a_line_that_stands_twice_is_kept_once(table, lines, tmp_path):
    (tmp_path / "out" / "reports.jsonl").write_bytes(b"".join([*lines, lines[0]]))
    assert run_batch(table, folder=tmp_path / "out", output="none", resume=True).kept == 3
    assert_same(tmp_path / "whole", tmp_path / "out")


def test_a_journal_of_a_version_without_checksums_is_refused_and_can_be_forgotten(table, lines, tmp_path):
    old = b"".join(without(without(line, "checksum"), "size") for line in lines)
    (tmp_path / "out" / "reports.jsonl").write_bytes(old)
    with pytest.raises(UsageError, match=r"is of an earlier version of cablecad.*--force forgets it"):
        run_batch(table, folder=tmp_path / "out", output="none", resume=True)
    assert (tmp_path / "out" / "reports.jsonl").read_bytes() == old
    write(tmp_path / "out" / "r0.step", "of that run")
    assert run_batch(table, folder=tmp_path / "out", output="none", force=True).counts == {"done": 3}
    assert not (tmp_path / "out" / "r0.step").exists()
    assert len(journal(tmp_path / "out")) == 3


def test_a_journal_without_any_line_is_begun_anew(table, lines, tmp_path):
    (tmp_path / "out" / "reports.jsonl").write_bytes(b"no line\n")
    assert run_batch(table, folder=tmp_path / "out", output="none", resume=True).kept == 0
    assert_same(tmp_path / "whole", tmp_path / "out")
