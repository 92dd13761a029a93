"""The elastica by series and the non-inflexional closed form, against mpmath's Taylor integration of the equation."""

from __future__ import annotations

import mpmath as mp
import numpy as np
import pytest

from cablecad.centreline import Placement
from cablecad.rod.elliptic import argument
from cablecad.rod.noninflexional import NonInflexional
from cablecad.rod.series import SeriesElastica

PLANE = Placement(np.zeros(3), np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]))


def integrate(psi: float, kappa: float, force: float, s: np.ndarray) -> np.ndarray:
    """Angle, curvature and position after each s by mpmath's odefun at 22 digits, shape (n, 4)."""
    with mp.workdps(22):
        system = lambda _, y: [y[1], -mp.mpf(force) * mp.sin(y[0]), mp.cos(y[0]), mp.sin(y[0])]
        solution = mp.odefun(system, 0, [mp.mpf(psi), mp.mpf(kappa), mp.mpf(0), mp.mpf(0)])
        return np.array([[float(v) for v in solution(mp.mpf(float(value)))] for value in s])


STATES = [
    (0.3, 0.0, 0.0),  # a line
    (0.3, 2.0, 0.0),  # a circle
    (-1.0, 6.2, 1e-12),
    (2.0, -9.0, 0.2),
    (3.0, 12.0, 4.0),
    (0.5, 0.1, 0.25),
    (1.5, 25.0, 20.0),
]


@pytest.mark.parametrize(("psi", "kappa", "force"), STATES)
def test_series_against_integration(psi: float, kappa: float, force: float) -> None:
    s = np.array([0.0, 0.4, 1.0])
    exact = integrate(psi, kappa, force, s)
    whole = SeriesElastica(PLANE, 1.0, force, 0.0, psi, kappa)
    # Known in the middle as well as at the start: series are walked to both sides.
    middle = SeriesElastica(PLANE, 1.0, force, 0.4, *exact[1, :2])
    room = 2e-15 * (1 + abs(kappa))
    for piece in (whole, middle):
        frames = piece.frames(s)
        np.testing.assert_allclose(frames.position[:, :2], exact[:, 2:], atol=room)
        np.testing.assert_allclose(frames.tangent[:, 0], np.cos(exact[:, 0]), atol=room)
        np.testing.assert_allclose(frames.tangent[:, 1], np.sin(exact[:, 0]), atol=room)
        np.testing.assert_allclose(piece.bishop(s, 0)[0, :, 0], exact[:, 1], rtol=2e-15, atol=room)


def test_greatest_curvature_of_series() -> None:
    piece = SeriesElastica(PLANE, 2.0, 3.0, 0.0, -1.0, 1.0)
    greatest, at = piece.greatest_curvature()
    dense = np.abs(piece.bishop(np.linspace(0, 2, 20001), 0)[0, :, 0])
    assert greatest >= dense.max()
    assert greatest == pytest.approx(dense.max(), rel=1e-7)
    # kappa^2/2 - P cos(psi) is constant, and the crest is at psi = 0.
    assert greatest == pytest.approx(np.sqrt(1.0 + 2 * 3.0 * (1 - np.cos(1.0))), rel=1e-14)
    assert 0 < at < 2


@pytest.mark.parametrize("q", [0.05, 0.3, 0.9, 1 - 1e-6, 1 - 1e-12])
@pytest.mark.parametrize("sense", [1, -1])
@pytest.mark.parametrize("v0", [-3.1, 0.0, 0.8, 5.0])
def test_noninflexional_against_quadrature(q: float, sense: int, v0: float) -> None:
    """The tangent from mpmath's sn and cn, the position by integrating it."""
    w = 2.5
    piece = NonInflexional(PLANE, 1.0, w, q, 1.0 - q, v0, sense)
    s = np.array([0.0, 0.3, 1.0])
    frames, bend = piece.frames(s), piece.bishop(s, 0)[0, :, 0]

    def tangent(value):
        sn, cn = (mp.ellipfun(name, v0 + w * value, m=mp.mpf(q)) for name in ("sn", "cn"))
        return cn**2 - sn**2, 2 * sense * sn * cn

    with mp.workdps(25):
        for i, value in enumerate(s):
            x, y = (float(mp.quad(lambda t, axis=axis: tangent(t)[axis], [0, value])) for axis in (0, 1))
            np.testing.assert_allclose(frames.position[i, :2], [x, y], atol=6e-16 * (4 + abs(v0)) / q)
            np.testing.assert_allclose(frames.tangent[i, :2], np.array(tangent(value), dtype=float), atol=4e-14)
            curvature = 2 * sense * w * mp.ellipfun("dn", v0 + w * value, m=mp.mpf(q))
            assert bend[i] == pytest.approx(float(curvature), rel=1e-13)
    greatest, _ = piece.greatest_curvature()
    assert greatest == pytest.approx(np.abs(piece.bishop(np.linspace(0, 1, 4001), 0)).max(), rel=1e-6)


def test_series_and_closed_form_agree_where_they_meet() -> None:
    q, w, psi = 0.05, 3.0, 0.7
    v0 = argument(np.sin(psi / 2), np.cos(psi / 2), q, 1 - q)
    closed = NonInflexional(PLANE, 1.0, w, q, 1 - q, v0, 1)
    kappa = float(closed.bishop(np.array([0.0]), 0)[0, 0, 0])
    series = SeriesElastica(PLANE, 1.0, q * w**2, 0.0, psi, kappa)
    s = np.linspace(0, 1, 21)
    np.testing.assert_allclose(series.frames(s).position, closed.frames(s).position, atol=4e-14)
