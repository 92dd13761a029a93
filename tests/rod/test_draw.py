"""Shapes drawn together are those of each drawn alone, and so is what is evaluated of their pieces together."""

from __future__ import annotations

import numpy as np
import pytest
from test_outline import special
from test_room import cables

from cablecad.bundle import OneByOne, bundled
from cablecad.rod.draw import draw_together
from cablecad.rod.elasticas import Elasticas
from cablecad.rod.pieces import Elastica
from cablecad.rod.solution import Equilibrium, RodSolution
from cablecad.rod.solve import solve_many


def equilibria(seed: int) -> list[Equilibrium]:
    solved = solve_many([*cables(40, seed), *special()], search="wide" if seed % 2 else "answer")
    return [one for solution in solved if isinstance(solution, RodSolution) for one in solution.equilibria]


@pytest.mark.parametrize("seed", [3, 4])
def test_shapes_are_those_of_each_alone(seed: int) -> None:
    together, alone = equilibria(seed), equilibria(seed)
    draw_together(together)
    drawn = [i for i, one in enumerate(together) if "shape" in one.__dict__]
    assert len(drawn) > 50
    assert any(len(together[i].centreline.pieces) == 3 for i in drawn)
    for i in drawn:
        one, other = together[i], alone[i]
        size = one.centreline.length
        reach = size + float(np.abs(other.start.position).max())
        assert np.array_equal(one.centreline.breaks, other.centreline.breaks)
        s = np.linspace(0.0, size, 33)
        sizes = (reach, 1.0, 1.0, 1.0)
        for got, want, unit in zip(one.centreline.frames(s), other.centreline.frames(s), sizes, strict=True):
            assert np.abs(got - want).max() < 1e-13 * unit
        for end in ("start", "end"):
            got_end, want_end = getattr(one, end), getattr(other, end)
            assert np.abs(got_end.position - want_end.position).max() < 1e-13 * reach
            assert np.abs(got_end.direction - want_end.direction).max() < 1e-13
            assert np.array_equal(got_end.force_per_EI, want_end.force_per_EI)
            assert (
                np.abs(got_end.moment_per_EI - want_end.moment_per_EI).max()
                <= 1e-12 * np.abs(want_end.moment_per_EI).max() + 1e-13 * reach * np.abs(want_end.force_per_EI).max()
            )
        kappa, at = one.greatest_curvature
        assert kappa == pytest.approx(other.greatest_curvature[0], rel=1e-11, abs=1e-14 / size)
        assert at == pytest.approx(other.greatest_curvature[1], abs=1e-9 * size)


def test_taut_shapes_and_a_few_are_left_to_themselves() -> None:
    some = equilibria(4)
    draw_together(some[:2])
    assert not any("shape" in one.__dict__ for one in some)
    draw_together(some)
    assert {one.trace.is_taut for one in some if one.trace is not None and "shape" not in one.__dict__} == {True}


@pytest.mark.parametrize("seed", [3, 4])
def test_pieces_evaluated_together(seed: int) -> None:
    pieces = [piece for one in equilibria(seed) for piece in one.centreline.pieces if isinstance(piece, Elastica)]
    bundle, each = bundled(pieces), OneByOne(pieces)
    assert isinstance(bundle, Elasticas)
    length = np.array([[piece.length] for piece in pieces])
    reach = length[:, 0] + np.array([np.abs(piece.placement.origin).max() for piece in pieces])
    s = length * np.linspace(0.0, 1.0, 23)
    for got, want, size in zip(bundle.frames(s), each.frames(s), (reach, 1.0, 1.0, 1.0), strict=True):
        assert got.shape == (len(pieces), 23, 3)
        assert (np.abs(got - want).max(axis=(1, 2)) / size).max() < 1e-13
    got_turns, want_turns = bundle.turns(s, 6), each.turns(s, 6)
    assert got_turns is not None
    assert want_turns is not None
    size = np.abs(want_turns).max(axis=2, keepdims=True) + 1e-300
    assert (np.abs(got_turns - want_turns) / size).max() < 1e-9


def test_one_piece_is_asked_itself() -> None:
    piece = next(piece for one in equilibria(4) for piece in one.centreline.pieces if isinstance(piece, Elastica))
    bundle = bundled([piece])
    s = np.linspace(0.0, piece.length, 7)
    for got, want in zip(bundle.frames(s[None]), piece.frames(s), strict=True):
        assert np.array_equal(got[0], want)
