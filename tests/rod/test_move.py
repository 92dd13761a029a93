"""Moves that turn a cable far: its side goes with it; and moves that are none."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cablecad.errors import InfeasibleError, UsageError
from cablecad.model import Cable, Clamp, EquilibriumKey, Pin, Port, Toward
from cablecad.rod.solution import RodSolution
from cablecad.rod.solve import solve_rod

AXES = {"X": (1.0, 0.0, 0.0), "Y": (0.0, 1.0, 0.0), "Z": (0.0, 0.0, 1.0), "askew": (0.6, 0.0, 0.8)}


def turned(axis: tuple[float, float, float], angle: float, vector: object) -> np.ndarray:
    """A vector turned about an axis, by Rodrigues."""
    k, v = np.array(axis), np.array(vector, dtype=float)
    return v * math.cos(angle) + np.cross(k, v) * math.sin(angle) + k * (k @ v) * (1.0 - math.cos(angle))


def cables() -> dict[str, Cable]:
    return {
        "collinear clamps": Cable("c", 1.0, Clamp((0, 0, 0), (1, 0, 0)), Clamp((90, 0, 0), (1, 0, 0)), length=100.0),
        "arch": Cable("c", 1.0, Clamp((0, 0, 0), (0, 0, 1)), Clamp((60, 0, 0), (0, 0, -1)), length=150.0),
        "pinned": Cable("c", 1.0, Pin((0, 0, 0)), Pin((50, 0, 0)), length=70.0),
        "clamp and pin": Cable("c", 1.0, Clamp((0, 0, 0), (1, 0, 0)), Pin((80, 0, 0)), length=100.0),
    }


def moved(solution: RodSolution, axis: tuple[float, float, float], angle: float) -> RodSolution:
    """The whole cable turned about its start."""
    ends = {}
    for name in ("start", "end"):
        end = getattr(solution.cable, name)
        place = tuple(turned(axis, angle, end.position).tolist())
        ends[name] = Pin(place) if isinstance(end, Pin) else Clamp(place, tuple(turned(axis, angle, end.direction)))
    return solution.moved(**ends)


@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize("name", cables())
@pytest.mark.parametrize("steps", [1, 3])
@pytest.mark.parametrize("angle", [math.pi / 2.0, 2.0])
def test_a_cable_turned_as_a_whole_keeps_its_shape(name: str, axis: str, steps: int, angle: float) -> None:
    first = solve_rod(cables()[name])
    last = first
    for _ in range(steps):
        last = moved(last, AXES[axis], angle / steps)
    assert last.equilibrium.energy_per_EI == pytest.approx(first.equilibrium.energy_per_EI, rel=1e-9)
    assert last.residual < 1e-12
    s = np.linspace(0.0, first.length, 9)
    chord = np.array(first.cable.end.position)  # type: ignore[union-attr]
    along = first.position(s) @ chord
    assert np.abs(last.position(s) @ turned(AXES[axis], angle, chord) - along).max() < 1e-7 * 100.0**2


def test_a_side_turns_with_its_chord() -> None:
    """Not about the chord: the axis of the turn is across it."""
    first = solve_rod(cables()["pinned"])
    last = moved(first, AXES["Y"], -math.pi / 2.0)  # from +X to +Z, onto the side it lay on
    middle = first.length / 2.0
    want = turned(AXES["Y"], -math.pi / 2.0, first.position(middle)[0])
    assert np.abs(last.position(middle)[0] - want).max() < 1e-10


@pytest.mark.parametrize(
    ("name", "how"),
    [
        ("collinear clamps", {"length": "shortest"}),
        ("collinear clamps", {"length": True}),
        ("collinear clamps", {"end": Toward((1, 0, 0))}),
        ("collinear clamps", {"end": Pin((90, 0, 0))}),
        ("pinned", {"end": Clamp((50, 0, 0), (1, 0, 0))}),
        ("pinned", {"start": (0, 0, 0)}),
    ],
)
def test_moves_that_are_none(name: str, how: dict[str, object]) -> None:
    with pytest.raises(UsageError):
        solve_rod(cables()[name]).moved(**how)  # type: ignore[arg-type]


def leaning() -> dict[str, Cable]:
    """Cables whose clamps lean from the axis of their ends."""
    apart = Clamp((0, 0, 0), (1, 0, 2)), Clamp((120, 0, 0), (0, 0, -1))
    met = Clamp((0, 0, 0), (1, 0, 0)), Clamp((0, 0, 0), (math.cos(2.0), math.sin(2.0), 0))
    return {
        "apart": Cable("c", 1.0, *apart, length=350.0),
        "apart, another": Cable("c", 1.0, *apart, length=350.0, equilibrium=1),
        "coincident": Cable("c", 0.1, *met, length=100.0),
    }


@pytest.mark.parametrize("degrees", [30, 89, 90, 91, 120, 180, -90, -150])
@pytest.mark.parametrize("name", leaning())
def test_turned_about_the_axis_of_the_ends_at_once(name: str, degrees: float) -> None:
    first = solve_rod(leaning()[name])
    last = moved(first, AXES["X"], math.radians(degrees))
    s = np.linspace(0.0, first.length, 9)
    want = np.array([turned(AXES["X"], math.radians(degrees), point) for point in first.position(s)])
    assert np.abs(last.position(s) - want).max() < 1e-9 * first.length


def test_a_clamp_that_passes_the_chord_keeps_the_side() -> None:
    """From a lean one way to a lean the other: the plane did not turn, and the arch stays where it is."""
    start = Clamp((0, 0, 0), (1, 0, 0))
    last = solve_rod(Cable("c", 1.0, start, Clamp((90, 0, 0), (1, 0, 0.05)), length=100.0, bulge=(0, 0, 1)))
    side = last.position(50.0)[0, 2]
    for lean in (0.02, -0.02, -0.06):
        last = last.moved(end=Clamp((90, 0, 0), (1, 0, lean)))
        assert last.position(50.0)[0, 2] * side > 0.0


def test_a_pinned_cable_on_a_closed_loop_comes_back() -> None:
    """Where a bulge is given it decides; along it, where it says nothing, the side goes with the chord."""
    first = solve_rod(Cable("c", 1.0, Pin((0, 0, 0)), Pin((100, 0, 0)), length=150.0, bulge=(0, 0, 1), equilibrium=1))
    corners = np.eye(3)
    last = first
    for one, other in ((0, 1), (1, 2), (2, 0)):
        for angle in np.radians(np.arange(2, 91, 2)):
            place = 100.0 * (math.cos(angle) * corners[one] + math.sin(angle) * corners[other])
            last = last.moved(end=Pin(tuple(place)))
    s = np.linspace(0.0, 150.0, 7)
    assert np.abs(last.position(s) - first.position(s)).max() < 1e-9


@pytest.mark.parametrize("equilibrium", range(6))
def test_a_pinned_cable_that_moved_has_its_place_in_the_list(equilibrium: int) -> None:
    """Side and index are those that solving the moved cable gives to the same shape."""
    cable = Cable("c", 0.01, Pin((0, 0, 0)), Pin((100, 0, 0)), length=150.0, equilibrium=equilibrium)
    moved = solve_rod(cable).moved(end=Pin((101, 0, 0)))
    anew = solve_rod(moved.cable)
    assert (moved.index, moved.equilibrium.side) == (equilibrium, anew.equilibrium.side)
    assert np.abs(moved.points(31) - anew.points(31)).max() < 1e-9


def test_crossed_ends_are_not_taken_for_ends_that_have_not() -> None:
    """Between two positions a cable has the positive chord, which is another shape."""
    crossed = solve_rod(Cable("c", 0.01, Pin((0, 0, 0)), Toward((1, 0, 0)), length=100.0, angle_deg=140.0))
    assert crossed.chord < 0.0
    for end in (Pin(tuple(crossed.position(100.0)[0])), Pin((30, 0, 0))):
        with pytest.raises(UsageError, match=r"have crossed \(chord -10\.6.*solve the moved cable anew"):
            crossed.moved(end=end)


def test_a_clamped_cable_may_become_straight() -> None:
    ends = Clamp((0, 0, 0), (1, 0, 0)), Clamp((100, 0, 0), (1, 0, 0))
    solution = solve_rod(Cable("c", 0.01, *ends, length=120.0))
    straight = solution.moved(length=100.0)
    assert (straight.model, straight.length) == ("straight", 100.0)
    again = straight.moved(length=120.0)
    assert again.equilibrium.energy_per_EI == pytest.approx(solution.equilibrium.energy_per_EI, rel=1e-12)
    with pytest.raises(InfeasibleError):
        solution.moved(length=99.0)
    with pytest.raises(InfeasibleError):
        solution.moved(end=Clamp((100, 0, 0), (1, 0, 1)), length=100.0)


@pytest.mark.parametrize("seed", range(6))
def test_an_end_that_passes_through_the_other_takes_the_cable_along(seed: int) -> None:
    """The chord turns by 180 degrees at once: points of the cable move no farther than they answer the end's move."""
    chance = np.random.default_rng(seed)
    first, last, apart = *chance.uniform(-3.1, 3.1, 2), 10.0 ** chance.uniform(-3.5, -1.5)

    def clamps(x: float) -> tuple[Clamp, Clamp]:
        return (
            Clamp((0, 0, 0), (math.cos(first), math.sin(first), 0)),
            Clamp((x, 0, 0), (math.cos(last), math.sin(last), 0)),
        )

    solution = solve_rod(Cable("c", 1e-3, *clamps(apart), length=1.0, bulge=(0.1, 1, 0), allow_contact=True))
    moved = solution.moved(end=clamps(-apart)[1])
    s = np.linspace(0.0, 1.0, 41)
    answer = np.abs(solution.sensitivity(s).points[:, :, 4:6]).sum(axis=2).max()
    assert np.abs(moved.points(41) - solution.points(41)).max() < 2.0 * answer * 2.0 * apart + 1e-6
    assert moved.residual < 1e-12


def test_a_plane_that_turned_half_round_is_said() -> None:
    """A U between ports that stand side by side: what is asked is the same as if all had been turned round."""
    up = (0, 0, 1)
    solution = solve_rod(Cable("c", 0.1, Port((0, 0, 0), up), Port((0, 5, 0), up), length=350.0))
    near, past = (solution.moved(end=Port((0, y, 0), up)) for y in (1, -5))
    assert not any("turned half round" in said for said in near.warnings)
    assert any("turned half round" in said for said in past.warnings)


@pytest.mark.parametrize(("d", "energy"), [(0.7154, 0.633800), (0.716, 0.635118), (0.72, 0.644049), (0.73, 0.667547)])
def test_a_tight_loop_is_met_and_followed(d: float, energy: float) -> None:
    """Newton's method brings it little in one step and much in the next; energies by a continuation of its own."""
    first, last = -0.9584052473220972, 0.06733911635512335

    def loop(chord: float) -> Cable:
        ends = (
            Clamp((0, 0, 0), (math.cos(first), math.sin(first), 0)),
            Clamp((chord, 0, 0), (math.cos(last), math.sin(last), 0)),
        )
        return Cable("c", 0.1, *ends, length=100.0, equilibrium=EquilibriumKey(1, -1), allow_contact=True)

    met, followed = solve_rod(loop(100.0 * d)), solve_rod(loop(71.49)).moved(end=loop(100.0 * d).end)
    for solution in (met, followed):
        assert solution.equilibrium.energy_per_EI == pytest.approx(energy, abs=2e-6)
        assert solution.residual < 1e-12
