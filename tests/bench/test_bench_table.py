"""Tables: what is measured is told as it is, on a terminal, in Markdown, CSV and JSON alike."""

import csv
import io
import json
import math
from dataclasses import dataclass

import pytest

from cablecad.bench.report import BenchReport, StageResult, markdown_table
from cablecad.bench.table import Plot, Table, Target, column
from cablecad.bench.terminal import show_table


@dataclass(frozen=True)
class Row:
    method: str = column("method")
    time: float | None = column("time", "ms", ".2f")
    error: float = column("error", form=".0e")
    count: int = column("count", form="d")
    right: bool = column("right")


ROWS = (
    Row("ours | theirs, too", 1.234, 1e-9, 3, True),
    Row("the other", None, math.inf, 40, False),
    Row("a third", 20.0, math.nan, 5, True),
)


def table(**more):
    return Table("speed", "Speed of things", ROWS, **more)


def report(*targets):
    found = BenchReport(quick=True, machine={"processor": "abacus", "cores": 2, "system": "Clay", "python": "3"})
    found.stages.append(StageResult("stage", 1.5, [table(targets=targets, notes=("a remark",))]))
    return found


def test_a_target_is_met_below_or_above_its_bound():
    assert Target("ratio", 0.25, 0.25).holds
    assert not Target("ratio", 0.2500001, 0.25).holds
    assert Target("share", 0.4, 0.4, ">=").holds
    assert not Target("share", 0.39, 0.4, ">=").holds


@pytest.mark.parametrize("sense", ["<=", ">="])
def test_a_figure_that_is_not_a_number_meets_no_target(sense):
    assert not Target("ratio", math.nan, 1.0, sense).holds


def test_a_missed_target_says_so_with_figure_and_bound():
    assert str(Target("time over theirs", 0.5, 0.25)) == "MISSED: time over theirs: 0.5 (<= 0.25 is aimed at)"


def test_a_terminal_shows_every_row_its_units_and_what_was_missed():
    text = show_table(table(targets=(Target("t", 2.0, 1.0),), notes=("seeds fixed",)), width=None, color=False)
    lines = text.splitlines()
    assert lines[0] == "Speed of things"
    assert lines[1].split("  ")[0] == "method"
    assert "time [ms]" in lines[1]
    assert [line.split()[-1] for line in lines[2:5]] == ["yes", "NO", "yes"]
    assert lines[3].split() == ["the", "other", "-", "-", "40", "NO"]
    assert lines[5:] == ["MISSED: t: 2 (<= 1 is aimed at)", "* seeds fixed"]
    assert "\x1b" not in text


def test_a_narrow_terminal_folds_words_and_loses_none():
    text = show_table(table(), width=48, color=False)
    assert all(len(line) <= 48 for line in text.splitlines())
    for word in ("ours", "theirs", "third", "1.23", "20.00", "1e-09", " 40 "):
        assert word in text


def test_a_terminal_too_narrow_for_the_numbers_gets_them_whole():
    text = show_table(table(), width=10, color=False)
    for word in ("1.23", "20.00", "1e-09", " 40 ", "yes"):
        assert word in text


def test_markdown_escapes_bars_and_aligns_numbers():
    lines = markdown_table(table()).splitlines()
    assert lines[1] == "|---|---:|---:|---:|---|"
    assert lines[2] == "| ours \\| theirs, too | 1.23 | 1e-09 | 3 | yes |"
    assert all(line.replace("\\|", "").count("|") == 6 for line in lines)


def test_files_hold_the_same_numbers_unrounded(tmp_path):
    report(Target("t", math.inf, 1.0)).write(tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["report.json", "speed.csv", "tables.md"]
    rows = list(csv.DictReader(io.StringIO((tmp_path / "speed.csv").read_text())))
    assert rows[0] == {
        "method": "ours | theirs, too",
        "time [ms]": "1.234",
        "error": "1e-09",
        "count": "3",
        "right": "true",
    }
    assert (rows[1]["time [ms]"], rows[1]["error"], rows[1]["right"]) == ("", "", "false")
    found = json.loads((tmp_path / "report.json").read_text())
    assert found["format"] == 1
    assert found["quick"] is True
    assert found["complete"] is False
    (stage,) = found["stages"]
    (shown,) = stage["tables"]
    assert shown["rows"][0] == {"method": "ours | theirs, too", "time": 1.234, "error": 1e-9, "count": 3, "right": True}
    assert shown["rows"][2]["error"] is None
    assert shown["targets"] == [{"text": "t", "figure": None, "sense": "<=", "bound": 1.0, "holds": False}]
    assert shown["columns"][1] == {"key": "time", "title": "time", "unit": "ms"}


def test_the_summary_has_every_target_with_its_verdict():
    lines = report(Target("a", 0.123456, 0.25), Target("b", 0.1, 0.4, ">=")).summary().splitlines()
    assert lines[2:] == ["| a | 0.123 | <= 0.25 | holds |", "| b | 0.1 | >= 0.4 | **missed** |"]


def test_a_plot_leaves_out_what_has_no_logarithm_and_joins_rows_of_one_series(tmp_path):
    pytest.importorskip("matplotlib")
    from cablecad.bench.plot import _series, write_plot

    drawn = table(plot=Plot("time", "error", lambda row: None if row.method == "a third" else "all"))
    assert _series(drawn) == {"all": [(1.234, 1e-9)]}
    write_plot(drawn, tmp_path)
    assert (tmp_path / "speed.png").read_bytes().startswith(b"\x89PNG")
