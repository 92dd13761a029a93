"""Batches from Python: what is written, what is kept, and that neither processes nor blocks make a difference."""

from __future__ import annotations

import json
import math
from concurrent.futures import Future, ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context

import pytest
from variants import CLAMPED, STRAIGHT, assert_same, journal, lengths, make_fifo, results, timeless, write

import cablecad as cc
from cablecad.batch import Row, grid_rows, run, run_batch, scene_rows, table_rows
from cablecad.errors import ExchangeError, SceneError, UsageError


@pytest.fixture
def scene(tmp_path):
    return write(tmp_path / "scene.toml", CLAMPED)


@pytest.fixture
def table(tmp_path, scene):
    """Ten rows: one too short, one below 0, one that breaks its rule; three of them bent, the others take no time."""
    values = [300, 120, 100, 310, 120, -1, 120, 320, 120, 120]
    path = write(
        tmp_path / "table.csv",
        "id,cables.W1.length,cables.W1.min_bend_radius,cables.W1.start.outward,cables.W1.end.outward\n"
        + "".join(
            f"r{i},{value},{60 if i == 7 else ''}" + (',"[0, 1, 0]","[0, -1, 0]"\n' if value == 120 else ",,\n")
            for i, value in enumerate(values)
        ),
    )
    return table_rows(path, scene)


def test_every_row_has_a_line_and_the_failed_their_reasons(table, tmp_path):
    seen = []
    summary = run_batch(
        table, folder=tmp_path / "out", output="none", progress=lambda now: seen.append((now.done, now.failed))
    )
    assert (summary.total, summary.failed, summary.exit_code) == (10, 2, 6)
    assert seen == [(10, 2)]
    lines = journal(tmp_path / "out")
    assert {line["id"]: line["status"] for line in lines.values()} == {
        f"r{i}": "failed" if i in (2, 5) else "done" for i in range(10)
    }
    assert (lines["r2"]["exit_code"], lines["r5"]["exit_code"]) == (3, 2)
    assert lines["r2"]["cables"][0]["result"] == "infeasible"
    assert lines["r5"]["error"] == "cables.W1.length = -1.0: must be greater than 0"
    assert lines["r0"]["overrides"] == {"cables.W1.length": 300}
    assert (summary.broken_rules, summary.breakers) == (1, ["r7"])


def test_a_line_holds_the_report_of_solve(table, tmp_path):
    """Solved with others along, numbers differ in their last digits."""
    run_batch(table, folder=tmp_path / "out", output="none")
    line = timeless(journal(tmp_path / "out")["r0"])
    from cablecad.pipeline import solve_scene

    report = timeless(solve_scene(next(iter(table)).resolve()).report())
    assert line.keys() - report.keys() == {"id", "status", "exit_code", "hash", "overrides", "error", "size"}
    one, other = line["cables"][0], report["cables"][0]
    assert one.keys() == other.keys()
    for key in ("length", "bend_radius_min", "rise", "energy", "self_gap"):
        assert one[key] == pytest.approx(other[key], rel=1e-11)


def test_results_are_a_line_a_row(table, tmp_path):
    run_batch(table, folder=tmp_path / "out", output="none")
    lines = results(tmp_path / "out")
    assert [line["id"] for line in lines] == [f"r{i}" for i in range(10)]
    reports = journal(tmp_path / "out")
    assert float(lines[0]["W1.bend_radius_min"]) == reports["r0"]["cables"][0]["bend_radius_min"]
    assert float(lines[0]["W1.start.moment.x"]) == reports["r0"]["cables"][0]["start"]["moment"][0]
    assert lines[0]["W1.stable_in_plane"] == "true"
    assert lines[0]["cables.W1.length"] == "300"
    assert (lines[2]["status"], lines[2]["W1.result"], lines[2]["W1.start.moment.x"]) == ("failed", "infeasible", "")
    assert "below the rule of 60 mm" in lines[7]["W1.violations"]
    assert lines[5]["error"] == "cables.W1.length = -1.0: must be greater than 0"


def test_strict_fails_what_breaks_a_rule(table, tmp_path):
    summary = run_batch(table, folder=tmp_path / "out", output="none", strict=True)
    line = journal(tmp_path / "out")["r7"]
    assert summary.failed == 3
    assert (line["status"], line["exit_code"]) == ("failed", 4)
    assert "min_bend_radius" in line["error"]


@pytest.mark.parametrize("workers", [1, 2])
def test_processes_make_no_difference(table, tmp_path, monkeypatch, workers):
    monkeypatch.setattr(run, "BLOCK", 4)
    run_batch(table, folder=tmp_path / "here", output="none", workers=0)
    run_batch(table, folder=tmp_path / "there", output="none", workers=workers)
    assert_same(tmp_path / "here", tmp_path / "there")


def test_executors_of_others_make_no_difference(table, tmp_path, monkeypatch):
    monkeypatch.setattr(run, "BLOCK", 4)
    run_batch(table, folder=tmp_path / "here", output="none", workers=0)
    with ThreadPoolExecutor(2) as threads:
        run_batch(table, folder=tmp_path / "threads", output="none", executor=threads)
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as processes:
        run_batch(table, folder=tmp_path / "processes", output="none", executor=processes)
    assert_same(tmp_path / "here", tmp_path / "threads")
    assert_same(tmp_path / "here", tmp_path / "processes")


def test_resuming_a_finished_batch_does_nothing(table, tmp_path):
    first = run_batch(table, folder=tmp_path / "out", output="none")
    before = (tmp_path / "out" / "reports.jsonl").read_bytes()
    told = []
    second = run_batch(table, folder=tmp_path / "out", output="none", resume=True, progress=told.append)
    assert (tmp_path / "out" / "reports.jsonl").read_bytes() == before
    assert (told, second.kept) == ([], 10)
    assert (second.counts, second.exit_code) == (first.counts, 6)


def test_resuming_does_what_is_missing_and_no_more(table, tmp_path, monkeypatch):
    """Blocks are done whole, so that the numbers are those of an undisturbed run, and no line is written twice."""
    monkeypatch.setattr(run, "BLOCK", 4)
    run_batch(table, folder=tmp_path / "whole", output="none")
    run_batch(table, folder=tmp_path / "torn", output="none")
    path = tmp_path / "torn" / "reports.jsonl"
    lines = path.read_bytes().splitlines(keepends=True)
    path.write_bytes(b"".join(lines[:6]) + b"no line of ours\n" + lines[6][: len(lines[6]) // 2])
    summary = run_batch(table, folder=tmp_path / "torn", output="none", resume=True)
    assert (summary.kept, summary.total) == (6, 10)
    assert_same(tmp_path / "whole", tmp_path / "torn")


def test_rows_with_another_input_are_done_anew(tmp_path, scene):
    out = tmp_path / "out"
    run_batch(table_rows(lengths(tmp_path / "a.csv", [300, 310, 320]), scene), folder=out, output="none")
    changed = table_rows(lengths(tmp_path / "b.csv", [300, 315]), scene)
    summary = run_batch(changed, folder=out, output="none", resume=True)
    assert (summary.kept, summary.total) == (1, 2)
    assert {key: line["overrides"]["cables.W1.length"] for key, line in journal(out).items()} == {"r0": 300, "r1": 315}
    assert [line["id"] for line in results(out)] == ["r0", "r1"]


def test_an_earlier_run_is_not_overwritten_unasked(table, tmp_path):
    run_batch(table, folder=tmp_path / "out", output="none")
    before = (tmp_path / "out" / "reports.jsonl").read_bytes()
    with pytest.raises(UsageError, match="is of an earlier run: --resume goes on with it, --force forgets it"):
        run_batch(table, folder=tmp_path / "out", output="none")
    assert (tmp_path / "out" / "reports.jsonl").read_bytes() == before
    assert run_batch(table, folder=tmp_path / "out", output="none", force=True).kept == 0
    assert len(journal(tmp_path / "out")) == 10


@pytest.mark.parametrize(
    ("ids", "words"),
    [(["a", "b", "a"], "= 'a': is the id of rows 1, 3"), (["a", "A"], "= 'a': is the id of rows 1, 2")],
)
def test_duplicate_ids_are_refused_before_anything_is_done(tmp_path, ids, words):
    cable = cc.Cable("W1", 4.0, cc.Pin((0, 0, 0)), cc.Pin((300, 0, 0)), length=300.0)
    rows = [Row(row_id, cc.Scene(cables=(cable,))) for row_id in ids]
    with pytest.raises(SceneError) as caught:
        run_batch(rows, folder=tmp_path / "out", output="none")
    assert words in str(caught.value)
    assert list((tmp_path / "out").iterdir()) == []


def test_scenes_made_in_python_and_a_generator_of_them(tmp_path):
    def rows():
        for i in range(3):
            cable = cc.Cable("W1", 4.0, cc.Pin((0, 0, 0)), cc.Pin((300, 0, 0)), length=300.0 + i)
            yield Row(f"p{i}", cc.Scene(cables=(cable,)))

    summary = run_batch(rows(), folder=tmp_path / "out", output="none")
    assert summary.counts == {"done": 3}
    assert [journal(tmp_path / "out")[f"p{i}"]["cables"][0]["length"] for i in range(3)] == [300.0, 301.0, 302.0]
    assert run_batch(rows(), folder=tmp_path / "out", output="none", resume=True).kept == 3


def test_overrides_are_a_remark_and_may_be_anything(tmp_path):
    cable = cc.Cable("W1", 4.0, cc.Pin((0, 0, 0)), cc.Pin((300, 0, 0)), length=300.0)
    row = Row("a", cc.Scene(cables=(cable,)), {"margin": math.nan, "of": {1}})
    run_batch([row], folder=tmp_path / "out", output="none")
    assert journal(tmp_path / "out")["a"]["overrides"] == {"margin": "nan", "of": "{1}"}


def test_scene_files(tmp_path):
    good, bad = write(tmp_path / "good.toml", STRAIGHT), write(tmp_path / "bad.toml", "format = 2\n")
    summary = run_batch(scene_rows([good, bad, tmp_path / "none.toml"]), folder=tmp_path / "out", output="none")
    lines = journal(tmp_path / "out")
    assert summary.counts == {"done": 1, "failed": 2}
    assert [lines[key]["exit_code"] for key in ("good", "bad", "none")] == [0, 2, 5]
    assert "No such file" in lines["none"]["error"]


def test_a_bug_in_one_row_costs_no_other(table, tmp_path, monkeypatch):
    from cablecad.pipeline import scene as module

    def solve_many(cables, **options):
        if any(cable.length == 310 for cable in cables):
            raise ZeroDivisionError("float division by zero")
        return real(cables, **options)

    real = module.solve_many
    monkeypatch.setattr(module, "solve_many", solve_many)
    run_batch(table, folder=tmp_path / "out", output="none", workers=0)
    lines = journal(tmp_path / "out")
    assert (lines["r3"]["status"], lines["r3"]["exit_code"]) == ("failed", 1)
    assert lines["r3"]["error"] == "this is a bug in cablecad: ZeroDivisionError: float division by zero"
    assert sum(line["status"] == "done" for line in lines.values()) == 7


def test_rows_that_change_while_they_are_worked_on_are_noticed(tmp_path, scene):
    table = table_rows(lengths(tmp_path / "t.csv", range(300, 306)), scene)

    class Changing:
        def __init__(self):
            self.times = 0

        def __iter__(self):
            self.times += 1
            if self.times == 2:
                lengths(tmp_path / "t.csv", range(300, 304))
            return iter(table)

    with pytest.raises(ExchangeError, match="the rows changed while they were worked on: 4 are left of 6"):
        run_batch(Changing(), folder=tmp_path / "out", output="none")


def test_an_executor_that_gives_up_its_tasks_ends_the_batch(table, tmp_path):
    class Gone(ThreadPoolExecutor):
        def submit(self, *_arguments):
            future = Future()
            future.cancel()
            future.set_running_or_notify_cancel()
            return future

    with Gone(1) as executor, pytest.raises(ExchangeError, match="the executor gave up its tasks"):
        run_batch(table, folder=tmp_path / "out", output="none", executor=executor)


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"workers": -1}, "the number of workers is -1"),
        ({"timeout": 0.0}, "the timeout is 0 s"),
        ({"timeout": math.nan}, "the timeout is nan s"),
        ({"timeout": math.inf}, "the timeout is inf s, but must be more than 0 and finite"),
        ({"timeout": 1.0, "workers": 0}, "a timeout needs worker processes"),
        ({"resume": True, "force": True}, "give one of them"),
        ({"executor": ThreadPoolExecutor(1), "workers": 1}, "either an executor or a number of workers"),
    ],
)
def test_settings_that_make_no_sense(table, tmp_path, settings, words):
    with pytest.raises(UsageError, match=words):
        run_batch(table, folder=tmp_path / "out", **settings)
    assert not (tmp_path / "out").exists()


def test_a_row_of_another_id_is_another_row(tmp_path, scene):
    """Even where the two would name one file on some systems."""
    for ids, kept in ((["l300"], 0), (["L300"], 0), (["L300"], 1)):
        table = write(tmp_path / "t.csv", "id,cables.W1.length\n" + "".join(f"{row_id},300\n" for row_id in ids))
        summary = run_batch(table_rows(table, scene), folder=tmp_path / "out", output="none", resume=True)
        assert (summary.kept, list(journal(tmp_path / "out"))) == (kept, ids)


def test_numbers_in_lists_and_tables_come_out_as_they_were_written(tmp_path, scene):
    text = '{"id": "a", "cables.W1.end.position": [0, 120.50, 0], "cables.W1.equilibrium": {"winding": 0}}\n'
    text += '{"id": "b", "name": "3.0, \\"quoted\\"\\nand more"}\n'
    table = write(tmp_path / "t.jsonl", text)
    run_batch(table_rows(table, scene), folder=tmp_path / "out", output="none")
    a, b = results(tmp_path / "out")
    assert (a["cables.W1.end.position"], a["cables.W1.equilibrium"]) == ("[0, 120.5, 0]", '{"winding": 0}')
    assert (b["name"], b["cables.W1.end.position"]) == ('3.0, "quoted"\nand more', "")


def test_a_text_of_any_length_is_in_the_results(tmp_path, scene):
    """`csv` reads no cell of more than 131072 letters, by itself."""
    name = 'x"' * 70_000
    table = write(
        tmp_path / "t.jsonl", json.dumps({"id": "a", "name": name}) + '\n{"id": "b", "cables.W1.length": 300}\n'
    )
    assert run_batch(table_rows(table, scene), folder=tmp_path / "out", output="none").counts == {"done": 2}
    text = (tmp_path / "out" / "results.csv").read_text(encoding="utf-8")
    doubled = name.replace('"', '""')
    assert f'a,done,"{doubled}",' in text


@pytest.mark.parametrize("name", ["reports.jsonl", "results.csv"])
@pytest.mark.parametrize("make", [lambda path: path.mkdir(), make_fifo], ids=["folder", "pipe"])
@pytest.mark.parametrize("settings", [{}, {"force": True}, {"resume": True}], ids=["", "force", "resume"])
def test_what_is_no_file_is_not_written_over(table, tmp_path, name, make, settings):
    (tmp_path / "out").mkdir()
    make(tmp_path / "out" / name)
    with pytest.raises(ExchangeError, match=f"{name} cannot be written: it is a folder, a pipe or a device"):
        run_batch(table, folder=tmp_path / "out", output="none", **settings)
    assert [path.name for path in (tmp_path / "out").iterdir()] == [name]


def test_results_without_a_journal_are_not_an_earlier_runs(table, tmp_path):
    (tmp_path / "out").mkdir()
    theirs = write(tmp_path / "out" / "results.csv", "mine\n")
    for resume in (False, True):
        with pytest.raises(UsageError, match=r"results\.csv is there without reports\.jsonl.*--force overwrites it"):
            run_batch(table, folder=tmp_path / "out", output="none", resume=resume)
        assert theirs.read_text() == "mine\n"
    assert run_batch(table, folder=tmp_path / "out", output="none", force=True).total == 10
    theirs.unlink()
    (tmp_path / "out" / "reports.jsonl").unlink()
    assert run_batch(table, folder=tmp_path / "out", output="none", resume=True).kept == 0


def test_the_journal_is_plain_json_lines(tmp_path, scene):
    run_batch(grid_rows(scene, ["cables.W1.length=300,350"]), folder=tmp_path / "out", output="none")
    for line in (tmp_path / "out" / "reports.jsonl").read_text(encoding="utf-8").splitlines():
        data = json.loads(line, parse_constant=pytest.fail)
        assert (data["format"], data["cablecad"]) == (1, cc.__version__)
