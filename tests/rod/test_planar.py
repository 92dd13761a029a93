"""The planar two-point problem: closed forms, published and high-precision figures, hard cases, invariances."""

import math

import mpmath
import numpy as np
import pytest

from cablecad.rod import planar
from cablecad.rod.follow import follow_planar
from cablecad.rod.planar import solve_planar
from cablecad.rod.trial import gauss_legendre

PI = math.pi


def random_scenes(count, seed):
    rng = np.random.default_rng(seed)
    d, chi, a, b = rng.uniform(0, 0.999, count), *(rng.uniform(-PI, PI, count) for _ in range(3))
    return a, b, d[:, None] * np.stack([np.cos(chi), np.sin(chi)], -1)


def solve_one(start, end, place, **more):
    return solve_planar([start], [end], [place], **more).equilibria


def least(found, count):
    best = np.full(count, np.inf)
    stable = found.stable_in_plane
    np.minimum.at(best, found.scene[stable], found.energy[stable])
    return best


# L = EI = 1, start at the origin. Energies found by minimisation and Taylor-series shooting at 40 digits, without
# elliptic functions; quarter circle, semicircle and ring in closed form.
ENERGIES = {
    "hook": (PI / 2, PI / 4, (0.5, 0.0), 18.09088638),
    "hairpin": (PI / 2, -PI / 2, (0.3, 0.0), 9.136720278),
    "S offset": (0.0, 0.0, (0.6, 0.3), 14.219524301),
    "coaxial": (0.0, 0.0, (0.8, 0.0), 8.322939530),
    "right angle": (0.0, PI / 2, (0.5, 0.5), 4.115276784),
    "U-turn": (0.0, PI, (0.0, 0.2), 11.6429119108856),
    "semicircle": (0.0, PI, (0.0, 2 / PI), PI**2 / 2),
    "wide U-turn": (0.0, PI, (0.0, 0.8), 6.96327646622448),
    "parallel .9": (0.0, 0.0, (0.9, 0.0), 4.05040889163451),
    "parallel .5": (0.0, 0.0, (0.5, 0.0), 22.8023670460620),
    "parallel .1": (0.0, 0.0, (0.1, 0.0), 20.1369837863150),
    "quarter circle": (0.0, PI / 2, (2 / PI, 2 / PI), PI**2 / 8),
    "opposite tangents at one point": (0.0, PI, (0.0, 0.0), 18.3331074529547),
    "ring": (0.0, 0.0, (0.0, 0.0), 2 * PI**2),
}


@pytest.mark.parametrize("name", ENERGIES)
def test_least_energy_of_known_shapes(name):
    start, end, place, energy = ENERGIES[name]
    found = solve_one(start, end, place)
    assert math.isclose(found.energy[0], energy, rel_tol=1e-9)
    assert found.stable_in_plane[0]
    assert found.residual[0] < 1e-14


@pytest.mark.parametrize(
    ("name", "kappa0", "force", "stable_out"),
    [
        ("hook", 3.622525184, (-41.03918032, -8.99004812), False),
        ("hairpin", 2.195501740, (-22.42202111, 0.0), True),
        ("S offset", 7.047453927, (-42.45511649, -21.22755824), False),
        ("coaxial", 5.849576447, (-43.92916387, 0.0), True),
        ("right angle", 2.868894137, (-16.52046035, -16.52046035), True),
    ],
)
def test_force_curvature_and_verdicts_of_five_clamped_shapes(name, kappa0, force, stable_out):
    """The coaxial shape is neutral to a turn about its axis, which is left out; its other motions are stable."""
    start, end, place, _ = ENERGIES[name]
    found = solve_one(start, end, place, torsion_ratio=0.8)
    assert math.isclose(abs(found.kappa0[0]), kappa0, rel_tol=2e-9)
    assert np.max(np.abs(found.force[0] - force)) < 2e-8
    assert bool(found.stable_out_of_plane[0]) is stable_out
    assert bool(found.free_turn[0]) is (name == "coaxial")


@pytest.mark.parametrize("name", ["S offset", "coaxial", "opposite tangents at one point", "ring", "parallel .5"])
def test_twins_are_both_found(name):
    start, end, place, _ = ENERGIES[name]
    found = solve_one(start, end, place)
    assert math.isclose(found.energy[0], found.energy[1], rel_tol=1e-12)
    assert found.side[0] == 1
    assert found.side[1] == -1


@pytest.mark.parametrize("excess", [1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12])
def test_a_hair_of_slack_between_pins_keeps_its_digits(excess):
    """1 - d = m (1 + m/8 + ...)  and energy 8 K (E - m1 K): pi^2 excess (1 + excess/4 + excess^2/8 + ...)."""
    found = solve_one(0.0, 0.0, (1 - excess, 0.0), excess=[excess], start_clamped=False, end_clamped=False)
    assert math.isclose(found.energy[0] / (PI**2 * excess), 1 + excess / 4, rel_tol=1e-12 + excess**2)
    assert list(found.stable_in_plane) == [True, True, False, False, False, False]


@pytest.mark.parametrize("end_clamped", [True, False])
def test_scenes_near_straight(end_clamped):
    rng = np.random.default_rng(4)
    for size in (PI, None):
        excess = 10 ** rng.uniform(-10, -2, 60)
        scale = 3 * np.sqrt(excess) if size is None else size
        chi, a, b = rng.uniform(-PI, PI, 60), *(rng.uniform(-1, 1, 60) * scale for _ in range(2))
        end = (1 - excess)[:, None] * np.stack([np.cos(chi), np.sin(chi)], -1)
        found = solve_planar(a + chi, b + chi, end, excess=excess, end_clamped=end_clamped)
        assert set(found.result) == {"solved"}
        assert np.max(found.equilibria.residual) < 1e-12
        assert np.all(np.isfinite(least(found.equilibria, 60)))


@pytest.mark.parametrize(
    "kind", [{}, {"end_clamped": False}, {"start_clamped": False}, {"start_clamped": False, "end_clamped": False}]
)
def test_random_scenes_are_solved_and_none_is_above_a_wide_search(kind):
    a, b, end = random_scenes(40, 8)
    found = solve_planar(a, b, end, **kind)
    best, wide = least(found.equilibria, 40), least(solve_planar(a, b, end, search="wide", **kind).equilibria, 40)
    assert np.all(best <= wide * (1 + 1e-9))
    assert np.max(found.equilibria.residual) <= 1e-12


def test_one_by_one_is_the_same_as_all_at_once():
    a, b, end = random_scenes(25, 12)
    many = solve_planar(a, b, end, torsion_ratio=0.8).equilibria
    for i in range(25):
        one, same = solve_planar(a[i : i + 1], b[i : i + 1], end[i : i + 1], torsion_ratio=0.8).equilibria, many.of(i)
        assert len(one) == len(same)
        assert np.allclose(one.energy, same.energy, rtol=1e-11, atol=0)
        assert np.array_equal(one.winding, same.winding)
        assert np.allclose(one.force, same.force, rtol=0, atol=1e-9 * (1 + np.max(np.abs(same.force))))
        assert np.allclose(one.margin_in_plane, same.margin_in_plane, rtol=1e-7, atol=1e-6)


def test_certificates_of_the_delivered_curve():
    """Moment balance kappa^2/2 + n.t along the rod; positions as quadrature of the tangent; both independent of it."""
    a, b, end = random_scenes(60, 21)
    found = solve_planar(a, b, end).equilibria
    node, weight = gauss_legendre(60)
    panels = np.concatenate([(i + node) / 8 for i in range(8)])
    theta, kappa, _ = found.at(panels)
    tension = found.force[:, :1] * np.cos(theta) + found.force[:, 1:] * np.sin(theta)
    first = kappa**2 / 2 + tension
    size = 1 + np.hypot(found.force[:, 0], found.force[:, 1])
    assert np.max(np.ptp(first, axis=1) / size) < 1e-11
    weights = np.tile(weight / 8, 8)
    place = np.stack([np.cos(theta) @ weights, np.sin(theta) @ weights], axis=-1)
    assert np.max(np.abs(place - end[found.scene])) < 1e-11
    assert np.max(np.abs(kappa**2 @ weights / 2 / found.energy - 1)) < 1e-10
    ends, _, points = found.at(np.array([0.0, 1.0]))
    assert np.max(np.abs(points[:, 1] - end[found.scene])) < 1e-12
    assert np.max(np.abs(ends[:, 0] - a[found.scene])) < 1e-12
    assert np.max(np.abs(ends[:, 1] - b[found.scene] - 2 * PI * found.winding)) < 2e-12
    # M1 - M0 + (r1 - r0) x n = 0
    arm = end[found.scene, 0] * found.force[:, 1] - end[found.scene, 1] * found.force[:, 0]
    assert np.max(np.abs(found.kappa1 - found.kappa0 + arm) / size) < 1e-11


def test_mirror_and_reversal():
    a, b, end = random_scenes(30, 5)
    given = least(solve_planar(a, b, end).equilibria, 30)
    mirrored = least(solve_planar(-a, -b, end * [1, -1]).equilibria, 30)
    reversed_ = least(solve_planar(b + PI, a + PI, -end).equilibria, 30)
    turned = least(
        solve_planar(
            a + 1, b + 1, end @ np.array([[math.cos(1), math.sin(1)], [-math.sin(1), math.cos(1)]])
        ).equilibria,
        30,
    )
    for other in (mirrored, reversed_, turned):
        assert np.allclose(other, given, rtol=1e-10, atol=0)


@pytest.mark.parametrize(
    ("start", "end", "place", "result"),
    [
        (0.0, 0.0, (1.0, 0.0), "straight"),
        (0.1, 0.0, (1.0, 0.0), "infeasible"),
        (0.0, 0.0, (1.1, 0.0), "infeasible"),
        (0.0, math.nan, (0.5, 0.0), "infeasible"),
    ],
)
def test_what_has_no_shape_is_refused_beside_good_scenes(start, end, place, result):
    found = solve_planar([0.0, start], [1.0, end], [(0.5, 0.2), place])
    assert found.result == ["solved", result]
    assert set(found.equilibria.scene) == {0}


@pytest.mark.parametrize("gap", [1e-3, 1e-6, 1e-9, 1e-12, 1e-15, 0.0])
def test_ring_with_a_gap(gap):
    for place in ((gap, 0.0), (0.0, gap)):
        found = solve_one(0.0, 0.0, place)
        assert math.isclose(found.energy[0], 2 * PI**2, rel_tol=3 * gap**2 + 1e-12) or gap == 1e-3
        assert found.stable_in_plane[0]


def test_pins_at_one_point_make_the_figure_eight():
    """2 E = K: energy 8 K (E - m1 K), here from mpmath at 30 digits."""
    with mpmath.workdps(30):
        m = mpmath.findroot(lambda m: 2 * mpmath.ellipe(m) - mpmath.ellipk(m), mpmath.mpf("0.826"))
        energy = mpmath.re(8 * mpmath.ellipk(m) * (mpmath.ellipe(m) - (1 - m) * mpmath.ellipk(m)))
    found = solve_one(0.0, 0.0, (0.0, 0.0), start_clamped=False, end_clamped=False)
    assert math.isclose(found.energy[0], float(energy), rel_tol=1e-13)
    assert found.stable_in_plane[0]
    assert abs(found.kappa0[0]) < 1e-12


def test_following_finds_what_a_new_search_finds():
    a, b, end = random_scenes(30, 33)
    rng = np.random.default_rng(1)
    first = solve_planar(a, b, end).equilibria
    da, db, shift = rng.normal(size=30) * 0.01, rng.normal(size=30) * 0.01, rng.normal(size=(30, 2)) * 0.003
    goal = end * 0.99 + shift
    again = solve_planar(a + da, b + db, goal).equilibria
    for i in range(30):
        moved = follow_planar(first.of(i).take(np.array([0])), a[i] + da[i], b[i] + db[i], goal[i])
        assert moved is not None
        assert np.min(np.abs(again.of(i).energy - moved.energy[0])) < 1e-9 * moved.energy[0]
        assert moved.residual[0] <= 1e-12


def test_following_tells_when_the_branch_ended():
    """A rod cannot be followed beyond its length, and a pulled-out loop of a ring is no ring any more."""
    coaxial = solve_one(0.0, 0.0, (0.8, 0.0)).take(np.array([0]))
    assert follow_planar(coaxial, 0.0, 0.0, (1.01, 0.0)) is None


def test_least_where_descents_end_late_and_branches_meet():
    """Clamps across the chord, one way of travel: the S is reached late, and its twins meet at chord = 0.4566."""
    rng = np.random.default_rng(0)
    lean = np.radians(rng.uniform(-3.0, 3.0, (2, 120)) * (np.arange(120) % 2))
    chord = np.linspace(0.4550, 0.4820, 120)
    place = np.stack([chord, np.zeros(120)], axis=-1)
    answer = solve_planar(-PI / 2 + lean[0], -PI / 2 + lean[1], place)
    wide = solve_planar(-PI / 2 + lean[0], -PI / 2 + lean[1], place, search="wide")
    assert np.all(least(answer.equilibria, 120) <= least(wide.equilibria, 120) * (1.0 + 1e-9))
    # By shooting with DOP853, without any of this: 24.155057 at 0.475, the loop of one turn has 30.601.
    assert solve_one(-PI / 2, -PI / 2, (0.475, 0.0)).energy[0] == pytest.approx(24.155057, rel=1e-6)


@pytest.mark.parametrize("excess", [1e-20, 1e-25, 1e-40, 1e-60])
@pytest.mark.parametrize(("end_clamped", "load"), [(True, 4.0 * PI**2), (False, 4.493409457909064**2)])
def test_a_hair_of_excess_is_no_line(excess, end_clamped, load):
    """Euler's buckling: the energy is the load times the excess, however small that is."""
    found = solve_planar([0.0], [0.0], [(1.0 - excess, 0.0)], excess=[excess], end_clamped=end_clamped).equilibria
    assert np.allclose(found.energy[:2] / excess, load, rtol=1e-12)
    assert found.kappa_max[0] > 0.0


@pytest.mark.parametrize("held", [(True, True), (True, False), (False, True)])
def test_a_sketch_leads_to_all_that_all_modes_lead_to(held, monkeypatch):
    """Few modes serve where omega is up to 11; what they led to others or nowhere would be missing here."""
    a, b, end = random_scenes(300, 11)

    def found():
        return solve_planar(a, b, end, start_clamped=held[0], end_clamped=held[1]).equilibria

    sketched = found()
    monkeypatch.setattr(planar, "_BENT", math.inf)
    full = found()
    below = full.take(np.flatnonzero(full.omega < 11.0))
    assert len(below) > 300
    for scene, energy, theta, kappa in zip(below.scene, below.energy, below.theta, below.kappa, strict=True):
        own = sketched.scene == scene
        turned = (sketched.theta[own] - theta + np.pi) % (2.0 * np.pi) - np.pi
        off = np.abs(sketched.energy[own] / energy - 1.0) + np.abs(turned) + np.abs(sketched.kappa[own] - kappa)
        assert off.min() < 1e-8
    assert np.isnan(sketched.z).any()
    assert not np.isnan(sketched.modes).any()


def test_steep_shapes_found_together_are_those_found_alone():
    """Alone they are polished in floats, with derivatives of their own."""
    rng = np.random.default_rng(217)
    a, b = rng.uniform(-1.2, 1.2, (2, 120))
    end = np.stack([1.0 - rng.uniform(0.02, 0.3, 120), np.zeros(120)], axis=1)
    many = solve_planar(a, b, end).equilibria
    for i in range(120):
        one = solve_planar(a[i : i + 1], b[i : i + 1], end[i : i + 1]).equilibria
        own = many.energy[many.scene == i]
        lost = [energy for energy in one.energy if np.abs(own / energy - 1.0).min(initial=1.0) > 1e-9]
        assert not lost
    steep = many.omega > 14.0
    assert np.count_nonzero(steep) > 40
