"""One elastica in floats: the same as `flow` for arrays, in every regime, and Newton's method upon it."""

import math

import numpy as np
import pytest
from test_flow import states

from cablecad.rod.course import Course
from cablecad.rod.flow import Jump
from cablecad.rod.midpoint import Held, State, advance, carry, refine, unmet
from cablecad.rod.planar import solve_planar
from cablecad.rod.polish import Middle


def in_floats(psi, kappa, omega, *, tension):
    lean = math.remainder(psi - math.pi, 2 * math.pi) if tension else psi
    return State(float(lean), float(kappa), 0.7, float(omega), tension)


@pytest.mark.parametrize("tension", [False, True])
@pytest.mark.parametrize(("psi", "kappa", "omega"), list(states()))
def test_every_regime_is_that_of_the_arrays(psi, kappa, omega, tension):
    state = in_floats(psi, kappa, omega, tension=tension)
    middle = Middle(*(np.array([value]) for value in state))
    for s in (0.3, 0.5):
        want = middle.jump(np.array([-s, s]))
        for i, got in enumerate(carry(state, s)):
            for name in Jump._fields:
                scale = 1 + omega + abs(kappa)
                assert abs(getattr(got, name) - getattr(want, name)[0, i]) < 3e-14 * scale, name


def test_phase_counts_inflections_and_crests():
    """A swing of 3.2 waves: kappa = 2 k omega cn(u) has its zeros where the phase passes odd quarter turns."""
    state = State(0.0, 30.0, 0.0, 20.0, False)
    begin, finish = carry(state, 0.5)
    s = np.linspace(-0.5, 0.5, 20001)
    kappa = Course(state).at(s).kappa
    zeros = np.count_nonzero(kappa[1:] * kappa[:-1] < 0)
    assert zeros == math.ceil(finish.phase / math.pi - 0.5) - math.floor(begin.phase / math.pi - 0.5) - 1
    assert finish.phase == pytest.approx(-begin.phase, rel=1e-14)


def test_newton_restores_a_disturbed_solution():
    found = solve_planar([0.5], [-1.2], [(0.4, 0.3)]).equilibria
    for i in range(len(found)):
        row = found.take(slice(i, i + 1))
        frame = row.frame.item()
        state = State(*(getattr(row, name).item() for name in State._fields))._replace(
            direction=row.direction.item() - frame
        )
        given = Held(True, True, 0.5 - frame, -1.2 - frame, row.excess.item())
        assert max(map(abs, unmet(state, given))) < 1e-13
        again, residual = refine(advance(state, [1e-3, -5e-3, 0.03, -0.02]), given)
        assert residual < 1e-14
        assert abs(again.kappa - state.kappa) < 1e-11


def test_a_start_that_is_not_near_is_not_solved():
    """A step longer than half of the one before tells that what follows may be another equilibrium."""
    state = State(0.0, 1.0, 0.0, 5.0, False)
    assert refine(state, Held(True, True, 2.5, -2.9, 0.95))[1] > 1e-3


@pytest.mark.parametrize("tension", [False, True])
@pytest.mark.parametrize(("psi", "kappa", "omega"), list(states()))
def test_unmet_conditions_are_those_of_the_carried_ends(psi, kappa, omega, tension):
    state = in_floats(psi, kappa, omega, tension=tension)
    begin, finish = carry(state, 0.5)
    along, across = finish.along - begin.along, finish.across - begin.across
    turn = complex(math.cos(state.compression), math.sin(state.compression)) * complex(along, across)
    theta = state.direction + state.lean
    for start, end in ((True, True), (True, False), (False, True), (False, False)):
        want = [
            1.0 - turn.real - 0.3,
            turn.imag,
            math.remainder(theta + begin.turn - 0.4, 2 * math.pi) if start else begin.kappa,
            math.remainder(theta + finish.turn + 0.9, 2 * math.pi) if end else finish.kappa,
        ]
        off = np.subtract(unmet(state, Held(start, end, 0.4, -0.9, 0.3)), want)
        off[2:] = [math.remainder(x, 2 * math.pi) if held else x for x, held in zip(off[2:], (start, end), strict=True)]
        assert np.max(np.abs(off)) < 3e-14 * (1 + omega + abs(kappa))
