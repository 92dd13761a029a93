"""The self-gap: closed forms, an oracle on a dense grid, and the cases that hide a pair or make it degenerate."""

from __future__ import annotations

import math
from dataclasses import dataclass

import mpmath as mp
import numpy as np
import pytest
from curves import Helix, arch, chain, u_turn
from numpy.typing import ArrayLike
from oracle import PinnedOracle
from scipy.optimize import brentq, least_squares

from cablecad.brep.fit import fit_centreline
from cablecad.centreline import Array, Centreline, Curve, Frames, Placement, Side
from cablecad.model import Cable, Port
from cablecad.pipeline import solve
from cablecad.rod.elastica import Inflexional
from cablecad.rod.elliptic import complete_k
from cablecad.self_gap import TOLERANCE, _Cells, _OneCurve, _Search, self_gap

EPS = 2.0**-52


def found(curve: Curve, radius: float) -> float:
    gap = self_gap(curve, radius)
    assert gap is not None
    return gap


# --- closed forms -----------------------------------------------------------------------------------------------------


def test_straight_cable_has_only_its_ends() -> None:
    assert found(chain((100.0, 0.0)), 3.0) == pytest.approx(94.0, abs=1e-12)
    assert found(chain((40.0, 0.0), (60.0, 0.0)), 3.0) == pytest.approx(94.0, abs=1e-12)


def test_no_gap_where_no_points_are_half_a_turn_apart() -> None:
    assert self_gap(chain((math.pi * 3.0, 0.0)), 3.0) is None
    assert self_gap(chain((math.pi * 3.0 * (1 + 1e-12), 0.0)), 3.0) is not None
    assert self_gap(chain((9.0, 1 / 3.1)), 3.0) is None


@pytest.mark.parametrize("radius", [5.0, 5.001, 40.0])
def test_no_gap_of_a_tube_that_its_bend_forbids(radius: float) -> None:
    """From kappa r = 1 on the tube is refused for its bend; just below, the gap is judged."""
    curve = chain((200.0, 0.0), (5.0 * math.pi, 0.2), (200.0, 0.0))
    assert self_gap(curve, radius) is None
    assert found(curve, 4.999) == pytest.approx(0.002, abs=1e-11)


def test_no_gap_of_a_curve_of_a_hundred_thousand_turns() -> None:
    assert self_gap(chain((1e6, 1.0)), 0.5) is None


@pytest.mark.parametrize("degrees", [30.0, 100.0, 179.0, 181.0, 270.0, 330.0, 359.0, 359.999])
def test_circular_arc(degrees: float) -> None:
    """The nearest are the ends, for all inner pairs that face each other are a diameter apart."""
    angle = math.radians(degrees)
    gap = found(chain((20.0 * angle, 0.05)), 1.0)
    assert gap == pytest.approx(40.0 * math.sin(angle / 2.0) - 2.0, abs=1e-12)


@pytest.mark.parametrize("degrees", [360.0, 361.0, 400.0, 720.0, 1234.5])
def test_arc_of_more_than_a_turn_lies_on_itself(degrees: float) -> None:
    assert found(chain((20.0 * math.radians(degrees), 0.05)), 1.0) == pytest.approx(-2.0, abs=1e-6)


@pytest.mark.parametrize("leg", [0.5, 30.0, 500.0, 20_000.0])
@pytest.mark.parametrize("bend", [3.001, 10.0, 77.0])
def test_parallel_legs(leg: float, bend: float) -> None:
    """All along the legs the distance is the same: Newton's matrix is singular everywhere."""
    assert found(u_turn(leg, bend), 3.0) == pytest.approx(2.0 * bend - 6.0, abs=1e-12 * (leg + bend))


@pytest.mark.parametrize("bow", [1e4, 1e5, 1e6, 1e7, 1e9])
def test_nearly_parallel_legs(bow: float) -> None:
    """Legs that bow towards each other ever so little: the valley falls by less than the tolerance, and still the
    pair at its bottom is found."""
    theta = 600.0 / bow
    curve = chain((600.0, -1.0 / bow), (10.0 * (math.pi + theta), 0.1), (600.0, -1.0 / bow))
    waist = float(np.linalg.norm(np.diff(curve.position([300.0, curve.length - 300.0]), axis=0)))
    assert waist < 20.0
    assert found(curve, 2.0) == pytest.approx(waist - 4.0, abs=1e-11)


@pytest.mark.parametrize("bow", [1e5, 3e6, 3e7, 1e8])
@pytest.mark.parametrize("before_bend", [41.3, 137.0, 311.7, 455.5])
def test_waist_anywhere_on_nearly_parallel_legs(bow: float, before_bend: float) -> None:
    """The bend turns by a little more than half a turn, so that the legs are parallel at a given way from it."""
    phi = before_bend / bow
    curve = chain((600.0, -1.0 / bow), (10.0 * (math.pi + 2.0 * phi), 0.1), (600.0, -1.0 / bow))
    pair = curve.frames([600.0 - before_bend, curve.length - 600.0 + before_bend])
    chord = pair.position[1] - pair.position[0]
    assert np.abs(pair.tangent @ chord).max() < 1e-10 * 20.0
    ends = float(np.linalg.norm(np.diff(curve.position([0.0, curve.length]), axis=0)))
    assert found(curve, 2.0) == pytest.approx(min(float(np.linalg.norm(chord)), ends) - 4.0, abs=1e-11)


@pytest.mark.parametrize("room", [1.0, 1e-3, 1e-6, 1e-9, 0.0, -1e-9, -1e-3])
def test_nearly_touching_hairpin(room: float) -> None:
    """A bulb on two legs, like a capital omega: with arcs of radius R turned by a, the neck is 2 R (2 cos a - 1)."""
    bulb, radius = 30.0, 2.0
    a = math.acos((1.0 + (2.0 * radius + room) / (2.0 * bulb)) / 2.0)
    curve = chain(
        (80.0, 0.0), (bulb * a, -1 / bulb), (bulb * (math.pi + 2 * a), 1 / bulb), (bulb * a, -1 / bulb), (80.0, 0.0)
    )
    assert found(curve, radius) == pytest.approx(room, abs=1e-12)


@pytest.mark.parametrize("distance", [5.0, 1e-3, 1e-5])
def test_loop_that_dips_towards_its_own_leg(distance: float) -> None:
    """An isolated near contact in one plane: the second arc comes down to `distance` above the leg and rises again."""
    loop = 10.0
    dip = loop - distance
    curve = chain((60.0, 0.0), (1.5 * math.pi * loop, 1 / loop), (math.pi * dip, -1 / dip))
    assert found(curve, 0.5) == pytest.approx(distance - 1.0, abs=1e-12)


def test_tangential_contact() -> None:
    """Distance zero where the two tangents are parallel: a double zero, found to the size that counts as touching."""
    curve = chain((60.0, 0.0), (15.0 * math.pi, 0.1), (10.0 * math.pi, -0.1))
    assert found(curve, 0.5) == pytest.approx(-1.0, abs=1e-6)


@pytest.mark.parametrize("angle", [130.70991070789999, 131.0, 140.0, 170.0, 179.99])
def test_crossing_arch(angle: float) -> None:
    """Past the figure eight the arch crosses itself: distance zero, whatever the radius."""
    k = math.sin(math.radians(angle / 2.0))
    for radius in (1e-3, 0.5):
        # The size that counts as touching is a millionth of the radius.
        assert found(arch(k, 350.0), radius) == pytest.approx(-2.0 * radius, rel=1e-6, abs=1e-12)


@pytest.mark.parametrize("angle", [5.0, 45.0, 70.0, 90.0, 91.0, 110.0])
def test_open_arch_has_only_its_ends(angle: float) -> None:
    """At 90 degrees the ends are a critical pair of the third order: the chord there is normal to both tangents."""
    chord = float(PinnedOracle(350.0, angle_deg=angle).data["chord"])
    gap = found(arch(math.sin(math.radians(angle / 2.0)), 350.0), 0.5)
    assert gap == pytest.approx(chord - 1.0, abs=1e-11)


def test_end_that_faces_the_other_leg() -> None:
    """Just below 90 degrees the distance from one end has its least not at the other end but a little inside of it."""
    curve = arch(math.sin(math.radians(44.5)), 350.0)
    end = curve.position([350.0])[0]
    s = np.linspace(0.0, 10.0, 100_001)
    nearest = np.linalg.norm(curve.position(s) - end, axis=1).min()
    assert 0.01 < curve.position([350.0])[0, 0] - nearest < 0.1
    # The samples are 1e-4 mm apart; about its least the distance grows as the square over twice 160 mm.
    assert found(curve, 0.5) == pytest.approx(nearest - 1.0, abs=1e-10)


@pytest.mark.parametrize("angle", [115.0, 122.0, 128.0, 130.7])
def test_necked_arch(angle: float) -> None:
    """Where the ends have come close the neck may be narrower than the chord: it is the least of both."""
    exact = PinnedOracle(350.0, angle_deg=angle)
    # By symmetry the neck is where the tangent is normal to the chord: psi = 90 degrees.
    s = brentq(lambda s: tangent_x(exact, s), 0.0, 175.0, xtol=1e-13)
    x, _ = exact.point(s)
    neck = float(exact.data["chord"] - 2 * x)
    gap = found(arch(math.sin(math.radians(angle / 2.0)), 350.0), 0.5)
    assert gap == pytest.approx(min(neck, float(exact.data["chord"])) - 1.0, abs=1e-10)


def tangent_x(exact: PinnedOracle, s: float) -> float:
    return float(1 - 2 * exact.m * mp.ellipfun("sn", exact.omega * mp.mpf(s) - exact.K, m=exact.m) ** 2)


def helix_distance(radius: float, pitch: float) -> float:
    """The distance of neighbouring turns: D^2 = 2 R^2 (1 - cos a) + (b a)^2 is least where R^2 sin a + b^2 a = 0."""
    b = pitch / (2.0 * math.pi)
    a = brentq(lambda a: radius**2 * math.sin(a) + b**2 * a, 1.5 * math.pi, 2.0 * math.pi, xtol=1e-15)
    return math.sqrt(2.0 * radius**2 * (1.0 - math.cos(a)) + (b * a) ** 2)


@pytest.mark.parametrize(("radius", "pitch"), [(50.0, 12.0), (10.0, 12.0), (50.0, 1.0)])
@pytest.mark.parametrize("turns", [1.2, 3.0, 10.0])
def test_helix(radius: float, pitch: float, turns: float) -> None:
    gap = found(Centreline([Helix.of_turns(radius, pitch, turns)]), 0.45)
    assert gap == pytest.approx(helix_distance(radius, pitch) - 0.9, abs=1e-11)


# --- cost: never so coarse that a pair is lost, never so fine that a user waits ---------------------------------------


@dataclass
class Counted:
    """A curve that counts the points it is asked for."""

    curve: Centreline
    points: int = 0

    @property
    def length(self) -> float:
        return self.curve.length

    @property
    def breaks(self) -> Array:
        return self.curve.breaks

    def frames(self, s: ArrayLike, side: Side = "right") -> Frames:
        self.points += np.size(s)
        return self.curve.frames(s, side)

    def states(self, s: ArrayLike, side: Side = "right") -> tuple[Frames, Array]:
        self.points += np.size(s)
        return self.curve.states(s, side)

    def bishop(self, s: ArrayLike, order: int = 0, side: Side = "right") -> Array:
        self.points += np.size(s)
        return self.curve.bishop(s, order, side)

    def greatest_curvature(self) -> tuple[float, float]:
        return self.curve.greatest_curvature()


def test_helix_of_a_hundred_turns() -> None:
    counted = Counted(Centreline([Helix.of_turns(50.0, 12.0, 100.0)]))
    assert found(counted, 5.0) == pytest.approx(helix_distance(50.0, 12.0) - 10.0, abs=1e-10)
    assert counted.points < 500_000  # 0.3 s; all pairs at this resolution would be four thousand million


def test_spiral_of_half_circles() -> None:
    """Every turn is 8 mm from the next all along: the worst that a chain of arcs can ask."""
    counted = Counted(chain(*((math.pi * bend, 1.0 / bend) for bend in range(20, 100, 4))))
    assert found(counted, 2.0) == pytest.approx(4.0, abs=1e-11)
    assert counted.points < 100_000


def test_plain_arch_costs_next_to_nothing() -> None:
    counted = Counted(arch(0.5, 350.0))
    assert found(counted, 2.0) == pytest.approx(float(PinnedOracle(350.0, m="0.25").data["chord"]) - 4.0, abs=1e-11)
    assert counted.points < 1000


def test_one_short_pair_in_a_long_cable() -> None:
    """Ten metres of cable and one dip of a millimetre's radius: far below any uniform grid."""
    dip = 1.0
    curve = chain(
        (5000.0, 0.0),
        (100.0 * math.pi, 0.01),
        (2500.0, 0.0),
        (0.5 * math.pi * 1.0, 1.0),
        (197.0 - dip, 0.0),
        (math.pi * dip, -1.0 / dip),
        (197.0 - dip, 0.0),
        (0.5 * math.pi * 1.0, 1.0),
        (2400.0, 0.0),
    )
    # Down from y = 200 by 1, then 196, then the dip's 1: its lowest point is at y = 2 over the first leg.
    assert found(curve, 0.3) == pytest.approx(2.0 * dip - 0.6, abs=1e-9)
    assert found(curve, 0.9) == pytest.approx(0.2, abs=1e-9)


@pytest.mark.parametrize("degrees", [100.0, 135.0, 179.0])
@pytest.mark.parametrize("bend", [0.02, 0.05, 0.08])
def test_a_tiny_hook_faces_nothing(bend: float, degrees: float) -> None:
    """Less than half a turn, far smaller than the tolerance of the only distances there are: those from the far end."""
    angle, leg, radius = math.radians(degrees), 100.0, 0.3 * bend
    start = (-bend * math.sin(angle), bend * (1.0 - math.cos(angle)))  # from where the leg begins
    across = math.hypot(leg, bend) + bend  # to the far side of the hook's circle
    expected = min(math.dist(start, (leg, 0.0)), across) - 2.0 * radius
    assert found(chain((bend * angle, 1.0 / bend), (leg, 0.0)), radius) == pytest.approx(expected, abs=1e-9)


# --- the grid's oracle ------------------------------------------------------------------------------------------------


def oracle(curve: Centreline, apart: float, cells: int = 900) -> float:
    """The least critical distance by brute force: every cell of a dense grid in which both cosines change sign."""
    length = curve.length
    s = np.unique(np.concatenate([np.linspace(0.0, length, cells + 1), curve.breaks]))
    frames = curve.frames(s)
    along = np.einsum("ni,ni->n", frames.position, frames.tangent)
    cross = frames.tangent @ frames.position.T
    f, g = along[:, None] - cross, cross.T - along[None, :]

    def changes(values: Array) -> Array:
        corners = np.stack([values[1:, 1:], values[:-1, 1:], values[1:, :-1], values[:-1, :-1]])
        return (corners.max(axis=0) >= 0.0) & (corners.min(axis=0) <= 0.0)

    def equations(pair: Array) -> Array:
        at = curve.frames(np.clip(pair, 0.0, length))
        return at.tangent @ (at.position[0] - at.position[1])

    distances = [float(np.linalg.norm(frames.position[-1] - frames.position[0]))]
    for end in (0.0, length):
        tip = curve.position([end])[0]

        def lean(x: float, tip: Array = tip) -> float:
            at = curve.frames([x])
            return float((at.position[0] - tip) @ at.tangent[0])

        values = np.einsum("ni,ni->n", frames.position - tip, frames.tangent)
        for i in np.nonzero(values[1:] * values[:-1] < 0.0)[0]:
            x = brentq(lean, s[i], s[i + 1], xtol=1e-13 * length)
            if abs(x - end) >= apart:
                distances.append(float(np.linalg.norm(curve.position([x])[0] - tip)))
    step = length / cells
    later, earlier = np.nonzero(np.tril(changes(f) & changes(g)))
    far = s[later + 1] - s[earlier] >= apart
    later, earlier = later[far], earlier[far]
    rough = np.linalg.norm(frames.position[later] - frames.position[earlier], axis=1)
    for n in np.argsort(rough):
        if rough[n] - 2.0 * step > min(distances):
            break
        low, high = np.array([s[later[n]], s[earlier[n]]]), np.array([s[later[n] + 1], s[earlier[n] + 1]])
        bounds = np.maximum(low - step, -1e-9), np.minimum(high + step, length + 1e-9)
        root = least_squares(equations, (low + high) / 2.0, bounds=bounds, xtol=1e-15, ftol=1e-15, gtol=1e-15).x
        distance = float(np.linalg.norm(np.subtract(*curve.position(np.clip(root, 0.0, length)))))
        if np.abs(equations(root)).max() <= 1e-7 * distance + 1e-11 * length and root[0] - root[1] >= apart:
            distances.append(distance)
    return min(distances)


def random_elastica(rng: np.random.Generator) -> Centreline:
    m = rng.uniform(0.02, 0.999)
    quarter = complete_k(m, 1.0 - m)
    turns = rng.uniform(1.5, 6.0) * quarter
    place = Placement(rng.normal(size=3), np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]))
    return Centreline([Inflexional(place, 100.0, turns / 100.0, m, 1.0 - m, rng.uniform(-5.0, 5.0) * quarter)])


def random_chain(rng: np.random.Generator) -> Centreline:
    stretches = []
    for _ in range(rng.integers(3, 9)):
        straight = rng.random() < 0.35
        stretches.append(
            (rng.uniform(3.0, 40.0), 0.0 if straight else rng.choice([-1.0, 1.0]) / rng.uniform(3.0, 20.0))
        )
    return chain(*stretches)


def compare_with_oracle(seed: int) -> None:
    rng = np.random.default_rng(seed)
    curve = random_chain(rng) if seed % 2 else random_elastica(rng)
    radius = rng.uniform(0.2, 1.5)  # thinner, and the grid's cells on the diagonal take long
    expected = oracle(curve, math.pi * radius)
    assert found(curve, radius) + 2.0 * radius == pytest.approx(expected, abs=1e-6 * radius)


@pytest.mark.parametrize("seed", [*range(24), 93])  # 93: two critical pairs in one cell, alike to 1e-3
def test_against_dense_grid(seed: int) -> None:
    compare_with_oracle(seed)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(24, 1000))
def test_against_dense_grid_at_length(seed: int) -> None:
    compare_with_oracle(seed)


def critical_pairs(curve: Centreline, rng: np.random.Generator) -> list[tuple[float, float]]:
    """Some pairs whose chord is normal to both tangents, by least squares from random starts."""

    def equations(pair: Array) -> Array:
        at = curve.frames(np.clip(pair, 0.0, curve.length))
        return at.tangent @ (at.position[0] - at.position[1])

    pairs = []
    for _ in range(40):
        root = least_squares(equations, rng.uniform(0.0, curve.length, 2), xtol=1e-15, ftol=1e-15, gtol=1e-15).x
        inside = root.min() > 0.0 and root.max() < curve.length and abs(root[0] - root[1]) > 1.0
        if inside and np.abs(equations(root)).max() < 1e-10:
            pairs.append((max(root), min(root)))
    return pairs


def test_no_cell_with_a_critical_pair_is_left_out() -> None:
    """Every known critical pair is in a cell that is kept, at every size, and whose bound is not above its distance."""
    rng = np.random.default_rng(20)
    seen = 0
    for number in range(12):
        curve = random_chain(rng) if number % 2 else random_elastica(rng)
        search = _Search(_OneCurve(curve), np.array([1.0]), np.array([1e-6]))
        search.distance[:] = math.inf  # no nearer pair is known
        for s, t in critical_pairs(curve, rng):
            distance = float(np.linalg.norm(np.subtract(*curve.position([s, t]))))
            for parts in 2 ** np.arange(1, 15):
                where = np.floor(np.array([[s], [t]]) / curve.length * parts).astype(np.intp)
                cells, pairs = search._critical(_Cells(int(parts), np.zeros(1, dtype=np.intp), *where))
                assert len(cells.s) == 1, (number, parts, s, t)
                assert pairs.least[0] <= distance * (1.0 + 1e-12) + 1e-12
                seen += 1
    assert seen > 500


# --- invariances ------------------------------------------------------------------------------------------------------


def scenes() -> list[tuple[tuple[float, float], ...]]:
    rng = np.random.default_rng(11)
    return [
        tuple((rng.uniform(5.0, 60.0), rng.choice([-1.0, 0.0, 1.0]) / rng.uniform(4.0, 20.0)) for _ in range(7))
        for _ in range(12)
    ]


@pytest.mark.parametrize("stretches", scenes())
def test_moved_mirrored_reversed_scaled(stretches: tuple[tuple[float, float], ...]) -> None:
    gap = found(chain(*stretches), 0.7)
    axes = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    moved = chain(*stretches, origin=(-120.0, 40.0, 900.0), e1=axes[:, 0], e2=axes[:, 1])
    mirrored = chain(*((length, -kappa) for length, kappa in stretches))
    reverse = chain(*((length, -kappa) for length, kappa in reversed(stretches)))
    # A distance that counts as none is a millionth of the radius.
    for other in (moved, mirrored, reverse):
        assert found(other, 0.7) == pytest.approx(gap, abs=1e-6)
    for scale in (1e-4, 1e3):
        scaled = chain(*((length * scale, kappa / scale) for length, kappa in stretches))
        assert found(scaled, 0.7 * scale) == pytest.approx(gap * scale, abs=1e-6 * scale)


def test_far_from_the_origin() -> None:
    near = found(u_turn(100.0, 10.0), 3.0)
    far = chain((100.0, 0.0), (10.0 * math.pi, 0.1), (100.0, 0.0), origin=(1e5, -2e5, 3e5))
    assert found(far, 3.0) == pytest.approx(near, abs=1e-9)


@pytest.mark.parametrize("tolerance", [1e-2, 1e-4, 1e-8])
def test_of_a_fit_is_that_of_the_curve(tolerance: float) -> None:
    """A fit's own gap differs by what it deviates on both sides."""
    for curve in (arch(0.906, 350.0), chain((30.0, 0.0), (55.0, 0.08), (30.0, 0.0)), arch(0.95, 200.0)):
        fit = fit_centreline(curve, 1.0, tolerance=tolerance)
        # Touching counts as none within a millionth of the radius.
        assert found(fit, 1.0) == pytest.approx(found(curve, 1.0), abs=2.0 * fit.deviation + 1e-6)


def test_tolerance_is_what_the_docstring_says() -> None:
    assert TOLERANCE == 1e-3


def test_a_chord_along_the_tangent_is_no_warning() -> None:
    """Its cosine may round to more than one, of which there is no angle; warnings are errors here."""
    end = Port((0.0, 0.0, 0.0), outward=(math.sqrt(0.5), -math.sqrt(0.5), 0.0), straight=0.1)
    start = Port((1.0, 0.0, 0.0), outward=(0.4894951630885852, -0.8720060121999615, 0.0))
    bulge = (-0.40089783003826945, 0.6308471062827826, -0.28144242950779164)
    cable = Cable("W", 0.001, start, end, length=1.1045334039860828, bulge=bulge, allow_contact=True)
    third = solve(cable, search="wide").equilibria[2]
    assert third.self_gap is not None
    assert third.self_gap + cable.diameter == pytest.approx(oracle(third.centreline, 0.02, cells=300), abs=1e-9)
