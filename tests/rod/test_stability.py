"""Stability of planar elastica, against an independent boundary value problem integrated by DOP853."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import ellipj, ellipk

from cablecad.rod.stability import stability, stability_at_nodes
from cablecad.rod.trial import refine, trial_space

FREE, HELD = False, True


def pinned(end_angle_deg):
    """First mode of a cable pinned at both ends: psi = 2 asin(k sn u), u = K + 2 K s, n along -x."""
    m = math.sin(math.radians(end_angle_deg) / 2.0) ** 2
    quarter = ellipk(m)

    def theta(s):
        return 2.0 * np.arcsin(math.sqrt(m) * ellipj(quarter + 2.0 * quarter * np.asarray(s), m)[0])

    def kappa(s):
        return 4.0 * quarter * math.sqrt(m) * ellipj(quarter + 2.0 * quarter * np.asarray(s), m)[1]

    return theta, kappa, np.array([-4.0 * quarter**2, 0.0])


def shot(theta0, kappa0, n):
    """Any elastica as functions of arclength, from a dense integration."""
    path = solve_ivp(
        lambda _, y: [y[1], n[0] * math.sin(y[0]) - n[1] * math.cos(y[0])],
        (0.0, 1.0),
        [theta0, kappa0],
        method="DOP853",
        rtol=1e-13,
        atol=1e-13,
        dense_output=True,
    )
    return lambda s: path.sol(s)[0], lambda s: path.sol(s)[1]


def characteristic(lam, theta, kappa, n, start, end, *, plane, torsion=0.0):
    """Determinant of the boundary value problem of the second variation at eigenvalue `lam`: zero at eigenvalues.

    In the plane u'' = (n.t - lam) u + a sin + b cos, int u sin = int u cos = 0; out of it
    u'' = (n.t - kappa^2 - lam) u + a kappa + b, with a = torsion int kappa u and int u = 0.
    """

    def slope(_, y):
        sine, cosine, ka = math.sin(y[12]), math.cos(y[12]), y[13]
        c1, c2 = (sine, cosine) if plane else (ka, 1.0)
        stiff = n[0] * cosine + n[1] * sine - lam - (0.0 if plane else ka * ka)
        return [
            y[1], stiff * y[0], c1 * y[0], c2 * y[0],
            y[5], stiff * y[4] + c1, c1 * y[4], c2 * y[4],
            y[9], stiff * y[8] + c2, c1 * y[8], c2 * y[8],
            ka, n[0] * sine - n[1] * cosine,
        ]  # fmt: skip

    first = np.zeros(14)
    first[1 if start else 0] = 1.0
    first[12:] = float(theta(0.0)), float(kappa(0.0))
    y = solve_ivp(slope, (0.0, 1.0), first, method="DOP853", rtol=1e-11, atol=1e-12).y[:12, -1].reshape(3, 4).T
    sums = y[2] if plane else torsion * y[2] - np.array([0.0, 1.0, 0.0])
    return float(np.linalg.det(np.stack([y[0] if end else y[1], sums, y[3]])))


def assert_least(margin, value, low, *, zero_mode=False):
    """The determinant `value` changes sign at `margin`, and nowhere else from `low` on but at a zero mode."""
    step = 1e-6 * max(1.0, abs(margin))
    assert value(margin - step) * value(margin + step) < 0
    signs = np.sign([value(lam) for lam in np.linspace(low, margin - 10 * step, 16)])
    assert int(np.count_nonzero(signs[1:] != signs[:-1])) == (1 if zero_mode and margin > 0 else 0)


def negative_conjugate_points(theta, kappa, n):
    """Sign changes in (0, 1] of the conjugate-point determinant of an elastica clamped at both ends."""

    def slope(s, y):
        th = float(theta(s))
        z = y.reshape(4, 3)  # d(theta, kappa, x, y) by (kappa0, n_x, n_y)
        sine, cosine = math.sin(th), math.cos(th)
        moment = (n[0] * cosine + n[1] * sine) * z[0] + np.array([0.0, sine, -cosine])
        return np.concatenate([z[1], moment, -sine * z[0], cosine * z[0]])

    first = np.zeros(12)
    first[3] = 1.0
    grid = np.linspace(0.02, 1.0, 400)
    path = solve_ivp(slope, (0.0, 1.0), first, method="DOP853", rtol=1e-12, atol=1e-14, t_eval=grid).y
    determinant = [np.linalg.det(path[:, i].reshape(4, 3)[[0, 2, 3]]) for i in range(len(grid))]
    signs = np.sign(determinant)
    return int(np.count_nonzero(signs[1:] != signs[:-1]))


@pytest.mark.parametrize(("end_angle", "margin"), [(130.0, 0.18), (132.0, -0.30), (160.0, -1.12)])
def test_margin_of_the_pinned_first_mode(end_angle, margin):
    """The figures known for it, to the digits given."""
    found = stability(*pinned(end_angle), start_clamped=False, end_clamped=False)
    assert abs(found.in_plane - margin) < 0.005
    assert bool(found.stable_in_plane) is (margin > 0)


def test_pinned_first_mode_turns_unstable_where_its_ends_meet():
    """2 E = K there, beta_0 = 130.70991070789999 degrees: the ends coincide and the turn costs nothing."""
    below, above = (
        float(stability(*pinned(130.70991070789999 + da), start_clamped=False, end_clamped=False).in_plane)
        for da in (-1e-4, 1e-4)
    )
    assert below > 0 > above
    assert abs(below + above) < 1e-3 * abs(below)


def test_pins_at_one_point_leave_the_turn_out():
    """The figure eight: rigid turns, one in the plane and two out of it, are no instability."""
    found = stability(*pinned(130.70991070789999), start_clamped=False, end_clamped=False)
    near = stability(*pinned(130.7), start_clamped=False, end_clamped=False)
    assert found.stable_in_plane
    assert found.stable_out_of_plane
    assert found.free_turn
    assert float(near.in_plane) < 0.01
    assert float(found.in_plane) > 10.0


def test_straight_pinned_cable_under_compression():
    """Rows of the constraint vanish with sin(theta); phi = cos(j pi s), j >= 1: (j pi)^2 - P, j = 1 the least."""
    for load in (0.0, 5.0, 9.0, 12.0):
        found = stability(np.zeros_like, np.zeros_like, np.array([-load, 0.0]), start_clamped=False, end_clamped=False)
        assert math.isclose(found.in_plane, math.pi**2 - load, rel_tol=0.0, abs_tol=1e-8)
        assert bool(found.stable_in_plane) is (load < math.pi**2)


def test_straight_clamped_cable_under_compression():
    """phi = sin(2 pi s): 4 pi^2 - P, the clamped Euler load."""
    for load in (0.0, 30.0, 45.0):
        found = stability(np.zeros_like, np.zeros_like, np.array([-load, 0.0]), start_clamped=True, end_clamped=True)
        assert math.isclose(found.in_plane, 4.0 * math.pi**2 - load, rel_tol=0.0, abs_tol=1e-8)
        # Rounding: eps times the largest eigenvalue, 4e5 for 44 functions, and some of that for each operation.
        assert math.isclose(found.out_of_plane, found.in_plane, rel_tol=0.0, abs_tol=1e-9)


CASES = [
    (0.4, 2.0, (-9.0, 3.0)),
    (-1.2, 5.0, (-20.0, -6.0)),
    (2.0, -7.0, (4.0, 25.0)),
    (0.1, 9.0, (-45.0, 10.0)),
    (1.0, 0.5, (-30.0, 30.0)),
]


@pytest.mark.parametrize(("theta0", "kappa0", "n"), CASES)
@pytest.mark.parametrize(("start", "end"), [(HELD, HELD), (HELD, FREE), (FREE, HELD)])
def test_margins_are_the_least_eigenvalues_of_the_boundary_value_problem(theta0, kappa0, n, start, end):
    theta, kappa = shot(theta0, kappa0, n)
    torsion = 0.8 if start and end else None
    found = stability(theta, kappa, np.array(n), start_clamped=start, end_clamped=end, torsion_ratio=torsion)
    low = -math.hypot(*n) - float(np.max(kappa(np.linspace(0, 1, 50)) ** 2)) - 1.0
    for plane, margin in ((True, float(found.in_plane)), (False, float(found.out_of_plane))):
        assert_least(
            margin,
            lambda lam, plane=plane: characteristic(
                lam, theta, kappa, n, start, end, plane=plane, torsion=torsion or 0.0
            ),
            low,
        )


@pytest.mark.parametrize("end_angle", [30.0, 110.0, 150.0])
def test_pinned_margins_are_the_least_eigenvalues_but_for_the_turn_about_the_chord(end_angle):
    theta, kappa, n = pinned(end_angle)
    found = stability(theta, kappa, n, start_clamped=False, end_clamped=False)
    low = float(n[0]) - float(np.max(kappa(np.linspace(0, 1, 50)) ** 2)) - 1.0
    for plane, margin in ((True, float(found.in_plane)), (False, float(found.out_of_plane))):
        assert_least(
            margin,
            lambda lam, plane=plane: characteristic(lam, theta, kappa, tuple(n), FREE, FREE, plane=plane),
            low,
            zero_mode=not plane,
        )


@pytest.mark.parametrize(("theta0", "kappa0", "n"), CASES)
def test_verdict_agrees_with_conjugate_points(theta0, kappa0, n):
    theta, kappa = shot(theta0, kappa0, n)
    found = stability(theta, kappa, np.array(n), start_clamped=True, end_clamped=True)
    assert bool(found.stable_in_plane) is (negative_conjugate_points(theta, kappa, n) == 0)


def test_full_ring_under_no_force():
    """n = 0, kappa = 2 pi: a ring cut and clamped; the turn about its tangent at the cut is no instability."""
    found = stability(
        lambda s: 2 * math.pi * np.asarray(s),
        lambda s: np.full_like(s, 2 * math.pi),
        np.zeros(2),
        start_clamped=True,
        end_clamped=True,
        torsion_ratio=0.8,
    )
    assert_least(
        float(found.in_plane),
        lambda lam: characteristic(
            lam, lambda s: 2 * math.pi * s, lambda _: 2 * math.pi, (0, 0), HELD, HELD, plane=True
        ),
        0.0,
    )
    assert found.free_turn  # both clamps on one axis through the one point


def test_panels_and_one_polynomial_agree():
    """Two discretisations of the same form; theirs is the only error."""
    theta, kappa, n = pinned(120.0)
    ends = theta(np.array([0.0, 1.0]))
    found = []
    for breaks, modes in (((0.0, 1.0), 44), ((0.0, 0.2, 0.5, 0.7, 1.0), 14)):
        space = trial_space(False, False, breaks, modes)
        args = space, theta(space.s), kappa(space.s), n, ends
        found.append(stability_at_nodes(*args, start_clamped=False, end_clamped=False))
    assert math.isclose(found[0].in_plane, found[1].in_plane, rel_tol=1e-9)
    assert math.isclose(found[0].out_of_plane, found[1].out_of_plane, rel_tol=1e-9)


def test_many_at_once_are_the_same_as_one_by_one():
    space = trial_space(True, True)
    paths = [shot(*case) for case in CASES]
    theta, kappa = (np.stack([path[i](space.s) for path in paths]) for i in (0, 1))
    n = np.array([case[2] for case in CASES])
    ends = np.stack([path[0](np.array([0.0, 1.0])) for path in paths])
    kinds = {"start_clamped": True, "end_clamped": True, "torsion_ratio": 0.8}
    many = stability_at_nodes(space, theta, kappa, n, ends, **kinds)
    for i in range(len(CASES)):
        one = stability_at_nodes(space, theta[i], kappa[i], n[i], ends[i], **kinds)
        assert math.isclose(one.in_plane, many.in_plane[i], rel_tol=1e-9, abs_tol=1e-8)
        assert math.isclose(one.out_of_plane, many.out_of_plane[i], rel_tol=1e-9, abs_tol=1e-8)


def test_taut_layer_has_the_margin_of_its_closed_form():
    """psi = 4 atan(tan(a/4) e^(-omega s)), a = 2.8 at the start only, omega = 300: out of the plane Poeschl-Teller.

    Potential omega^2 (1 - 6 sech^2(omega s + c)), tan(a/4) = e^-c; the bound state that vanishes at s = 0 has
    lambda = omega^2 (1 - p^2), p = (sqrt(4 - 3 T^2) - 3 T)/2, T = tanh c. Orthogonality to 1 shifts it by O(1/omega).
    """
    omega, a = 300.0, 2.8
    shift = -math.log(math.tan(a / 4.0))
    found = stability(
        lambda s: 4.0 * np.arctan(math.tan(a / 4.0) * np.exp(-omega * np.asarray(s))),
        lambda s: -2.0 * omega / np.cosh(omega * np.asarray(s) + shift),
        np.array([omega**2, 0.0]),
        start_clamped=True,
        end_clamped=True,
    )
    t = math.tanh(shift)
    p = (math.sqrt(4.0 - 3.0 * t * t) - 3.0 * t) / 2.0
    assert found.stable_in_plane
    assert abs(found.out_of_plane / omega**2 - (1.0 - p * p)) < 3.0 / omega
    assert len(refine(lambda s: 2.0 * omega / np.cosh(omega * s + shift), omega=omega)) < 20
