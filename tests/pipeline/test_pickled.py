"""Solutions, built cables and errors go to other processes and come back whole."""

from __future__ import annotations

import copy
import gc
import pickle
import re
import weakref
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pytest

import cablecad as cc

UP, ALONG, BACK = (0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (0.0, -1.0, 0.0)
FAR = (0.0, 120.0, 0.0)

NUMBER = re.compile(rb"-?\d+\.\d*(?:E[+-]\d+)?")

CABLES = {
    "ports": cc.Cable("W", 4.0, cc.Port((0, 0, 0), UP, 10.0), cc.Port(FAR, UP), length=350.0),
    "pin and port": cc.Cable("W", 4.0, cc.Pin((0, 0, 0)), cc.Port(FAR, UP), length=350.0, color="#2b6cb0"),
    "pins": cc.Cable("W", 4.0, cc.Pin((0, 0, 0)), cc.Pin(FAR), length=150.0),
    "straight": cc.Cable("W", 4.0, cc.Port((0, 0, 0), ALONG), cc.Port(FAR, BACK), length=120.0),
}


@pytest.mark.parametrize("kind", CABLES)
def test_a_solution_there_and_back(kind: str) -> None:
    solution = cc.solve(CABLES[kind])
    for back in (pickle.loads(pickle.dumps(solution)), copy.deepcopy(solution)):
        assert str(back) == str(solution)
        assert np.array_equal(back.points(9), solution.points(9))
        for name in ("residual", "rise", "end_angle_deg", "self_gap", "bend_radius_min", "warnings", "violations"):
            assert getattr(back, name) == getattr(solution, name)
        assert len(back.equilibria) == len(solution.equilibria)
        for one, other in zip(back.equilibria, solution.equilibria, strict=True):
            assert one.stability.out_of_plane == other.stability.out_of_plane


@pytest.mark.parametrize("kind", ["ports", "pin and port", "pins"])
def test_what_came_back_can_be_moved(kind: str) -> None:
    solution = cc.solve(CABLES[kind])
    moved = pickle.loads(pickle.dumps(solution)).moved(length=solution.length + 1.0)
    assert np.array_equal(moved.points(9), solution.moved(length=solution.length + 1.0).points(9))
    again = pickle.loads(pickle.dumps(moved))
    assert again.warnings == moved.warnings
    assert np.array_equal(again.sensitivity([1.0]).points, moved.sensitivity([1.0]).points)


def test_a_solution_goes_without_the_others_it_was_found_with() -> None:
    alone, many = cc.solve(CABLES["ports"]), cc.solve_many([CABLES["ports"]] * 100, measured=False)
    assert len(pickle.dumps(many[0])) < 2 * len(pickle.dumps(alone))


def test_a_moved_solution_does_not_keep_all_before_it() -> None:
    first = cc.solve(CABLES["ports"])
    last, gone = first, weakref.ref(first)
    for step in range(1, 4):
        last = last.moved(length=350.0 + step)
    del first
    gc.collect()
    assert gone() is None
    assert last.warnings == ()


@pytest.mark.parametrize("kind", CABLES)
def test_a_built_cable_there_and_back(kind: str, tmp_path: Path) -> None:
    built = cc.build(CABLES[kind])
    cc.write_step([built], tmp_path / "one.step")
    text = (tmp_path / "one.step").read_bytes()
    for back in (pickle.loads(pickle.dumps(built)), copy.deepcopy(built)):
        assert back.report["solid"] == built.report["solid"]
        cc.write_step([back], tmp_path / "one.step")
        again = (tmp_path / "one.step").read_bytes()
        # Open Cascade makes directions of length one again, which may change their last digit.
        assert NUMBER.sub(b"", again) == NUMBER.sub(b"", text)
        one, other = ([float(number) for number in NUMBER.findall(each)] for each in (again, text))
        assert one == pytest.approx(other, rel=1e-14, abs=1e-14)


def test_errors_there_and_back() -> None:
    with pytest.raises(cc.SceneError) as caught:
        cc.Cable("W", -4.0, cc.Pin((0, 0, 0)), cc.Pin(FAR))
    caught.value.add_note("seen on the way")
    for back in (pickle.loads(pickle.dumps(caught.value)), copy.copy(caught.value)):
        assert type(back) is cc.SceneError
        assert str(back) == str(caught.value)
        assert back.mistakes == caught.value.mistakes
        assert back.__notes__ == ["seen on the way"]


def test_pools_of_processes_solve_cables() -> None:
    too_short = cc.Cable("W", 4.0, cc.Port((0, 0, 0), UP), cc.Port(FAR, UP), length=100.0)
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        (found,) = pool.map(cc.solve, [CABLES["ports"]])
        failed = pool.submit(cc.solve, too_short).exception()
    assert np.array_equal(found.points(9), cc.solve(CABLES["ports"]).points(9))
    with pytest.raises(cc.InfeasibleError) as caught:
        cc.solve(too_short)
    assert str(failed) == str(caught.value)
