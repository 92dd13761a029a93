"""Parts of the stages at a small size: what a figure says is what was done."""

import dataclasses

import numpy as np
import pytest

from cablecad.bench import growth, hard_tubes, methods, solving, whole
from cablecad.bench.clock import take_turns
from cablecad.bench.hard_functions import function_rows
from cablecad.bench.scenes import random_scenes
from cablecad.bench.stage import STAGES
from cablecad.bench.truth import arch_truths
from cablecad.bench.tubes import OURS, RADII, TubeRow, _targets, _timed, _try


def test_rivals_take_turns_after_one_call_that_does_not_count():
    calls = []
    times = take_turns({"a": lambda: calls.append("a"), "b": lambda: calls.append("b")}, 3)
    assert calls == list("abababab")
    assert set(times) == {"a", "b"}
    assert all(taken >= 0.0 for taken in times.values())


def test_stages_have_names_of_their_own_and_modules_that_run():
    assert len({stage.name for stage in STAGES}) == len(STAGES) == 6


@pytest.mark.parametrize("method", whole.METHODS)
def test_the_stages_of_a_cable_add_up_to_its_total(method, tmp_path):
    row = whole._build(method, whole.loom(2), tmp_path / "loom.step")
    parts = ("solve", "tube", "check", "document", "translate", "free", "rewrite", "rest")
    assert sum(getattr(row, part) for part in parts) == pytest.approx(row.total, rel=1e-9)
    assert all(getattr(row, part) > 0.0 for part in parts[:-1])
    assert row.rest > -0.05 * row.total
    assert row.bytes == (tmp_path / "loom.step").stat().st_size // 2
    assert row.share == pytest.approx(100.0 * row.translate / row.total)


def test_the_rivals_sweep_and_leave_the_pipeline_as_it_was(tmp_path):
    from cablecad.brep import tube
    from cablecad.brep.document import Document
    from cablecad.pipeline import solid

    before = tube.build_tube, solid.make_solid, Document.__dict__["assembled"]
    rows = [whole._build(method, whole.loom(1), tmp_path / "loom.step") for method in (*whole.METHODS, whole.OURS)]
    assert (tube.build_tube, solid.make_solid, Document.__dict__["assembled"]) == before
    sizes = [row.bytes for row in rows]
    assert sizes[0] == sizes[-1]
    assert len(set(sizes)) == 3


def test_targets_of_cables_compare_each_turn_with_itself_and_take_the_median():
    def build(method, total, share):
        return whole.CableRow(method, 100, *[0.0] * 8, total, share, 20_000)

    slow_in_turn = [1.0, 1.0, 5.0]
    builds = {
        name: [build(name, each * total, 40.0 + turn) for turn, each in enumerate(slow_in_turn)]
        for name, total in zip(whole.METHODS, (3.0, 12.0, 6.0), strict=True)
    }
    builds[whole.OURS][0] = build(whole.OURS, 30.0, 90.0)  # disturbed alone
    assert [target.figure for target in whole._targets(builds)] == pytest.approx([0.25, 0.5, 0.42])
    assert [target.bound for target in whole._targets(builds)] == pytest.approx([1 / 3, 1 / 3, 0.4])
    assert whole._middle(builds[whole.OURS]).total == 15.0


def test_functions_are_right_where_those_of_scipy_are_not():
    rows = function_rows()
    assert all(row.right for row in rows)
    assert any("not a number" in row.theirs for row in rows)


@pytest.mark.parametrize("name", ["kappa r = 1.001", "below what numbers can keep"])
def test_tubes_that_cannot_be_are_refused_and_one_that_is_not_refused_is_wrong(name):
    case = next(case for case in hard_tubes.CASES if case.name == name)
    assert hard_tubes._row(case).right
    assert not hard_tubes._row(dataclasses.replace(case, refusal=None)).right


def test_our_ways_to_solve_agree_with_the_references_and_with_each_other():
    scenes = random_scenes(3, 7)
    cases = methods.cases_of(scenes)
    found, times = methods.in_turn(cases, {"cold": methods.cold, "warm": methods.warm})
    energies = np.array([[one.energy for one in found[name]] for name in ("cold", "warm")])
    assert np.isfinite(energies[0]).all()
    assert (energies[1] >= energies[0] * (1.0 - 1e-9)).all()
    assert [len(times[name]) for name in times] == [3, 3]


def test_shares_count_what_is_solved_and_what_is_at_the_least_energy():
    energy = np.array([1.0, 1.005, 1.5, np.inf])
    assert solving._shares(energy, np.ones(4)) == (75.0, 50.0)


def row(method, time, deviation, size, k=0.8):
    return TubeRow(k, method, "1e-06 mm", time, deviation, 10, size, True, 0.0, "")


def test_targets_of_tubes_are_the_worst_over_the_curves_but_for_time_and_the_bytes_in_all():
    from cablecad.bench.tubes import SHELL, SHELL_256

    rows = [row(OURS, 1.0, 1e-7, 100), row(OURS, 3.0, 1e-7, 100)]
    rows += [row(SHELL, 8.0, 2e-7, 400), row(SHELL, 8.0, 5e-8, 250)]
    rows += [row(SHELL_256, 2.0, 1e-7, 100), row(SHELL_256, 2.0, 1e-7, 50)]
    assert [target.figure for target in _targets(rows)] == [0.25, 2.0, 200 / 650, 0.4, 1.0, 1.0, 200 / 150, 2.0]


def test_a_rival_that_fails_gets_a_row_that_says_so():
    def fail():
        raise RuntimeError("it broke")

    (found,) = _timed([_try(arch_truths(1000.0)[0], "a sweep", "64 points", fail, 1.0)], 1)
    assert (found.time, found.deviation, found.valid, found.remark) == (None, None, None, "it broke")
    assert found.k in RADII


def test_exponents_are_fitted_over_the_upper_half_and_the_order_by_tolerances():
    rows = [growth.GrowthRow("a", n, 5.0 + n**2 / 100.0, None, None, "") for n in (1, 10, 100, 1000)]
    law = growth._law(rows, "a", "time")
    assert law.exponent == pytest.approx(2.0, abs=0.05)
    assert law.sizes == "100 to 1000"
    fits = [growth.GrowthRow("b", 10.0**-n, 1.0, round(100 * 10.0 ** (n / 6.0)), None, "") for n in range(1, 9)]
    assert growth._law(fits, "b", "spans", order=True).exponent == pytest.approx(6.0, rel=1e-2)
