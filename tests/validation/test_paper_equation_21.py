"""Equation (21) of the paper: "Physical modeling and deformation simulation of flexible cable under the plane
constraint". With k = 0.342 and Omega = 0.724 (in whatever unit of length) the printed curve is

    y = 0.945 cos(am(0.724 s)),   z = 2.76 E(am(0.724 s)) - 1.38 F(am(0.724 s)),

where the printed x is the arclength s from mid-span and 0.342 is the modulus, k = sin 20 degrees: an end angle of 40
degrees, not the 20 of Table 1.
"""

from __future__ import annotations

import mpmath as mp
import numpy as np
import pytest

from cablecad.model import Cable, Pin, Toward
from cablecad.rod.solve import solve_rod

K_MODULUS, OMEGA = 0.342, 0.724


@pytest.fixture(scope="module")
def solution():
    """The cable of equation (21): its length is 2 K / Omega, its end angle 2 asin(k)."""
    length = float(2 * mp.ellipk(mp.mpf(K_MODULUS) ** 2) / OMEGA)
    angle = float(2 * mp.degrees(mp.asin(K_MODULUS)))
    assert length == pytest.approx(4.4752, abs=5e-5)
    assert angle == pytest.approx(40.0, abs=5e-3)
    return solve_rod(
        Cable("eq21", 0.01, Pin((0, 0, 0)), Toward((0, 0, 1)), length=length, angle_deg=angle, bulge=(0, 1, 0))
    )


def test_printed_coefficients(solution) -> None:
    """0.945, 2.76, 1.38 and 0.724 as printed, to the digits printed."""
    assert solution.rise == pytest.approx(0.945, abs=5e-4)
    omega = float(np.sqrt(np.linalg.norm(solution.equilibrium.start.force_per_EI)))
    assert omega == pytest.approx(0.724, abs=1e-12)
    assert 2 / omega == pytest.approx(2.76, abs=5e-3)
    assert 1 / omega == pytest.approx(1.38, abs=5e-3)


def test_curve(solution) -> None:
    """The curve point by point, from the middle of the cable as the paper counts it."""
    half, k = solution.length / 2, mp.mpf(K_MODULUS)
    for s in np.linspace(-half, half, 17):
        phi = mp.asin(mp.ellipfun("sn", OMEGA * mp.mpf(s), m=k**2))
        y = 2 * k / OMEGA * mp.cos(phi)
        z = (2 * mp.ellipe(phi, k**2) - mp.ellipf(phi, k**2)) / OMEGA
        x, found_y, found_z = solution.position(half + s)[0]
        assert x == pytest.approx(0.0, abs=1e-15)
        assert found_y == pytest.approx(float(y), abs=1e-14)
        assert found_z - solution.chord / 2 == pytest.approx(float(z), abs=1e-14)


def test_modulus_not_parameter(solution) -> None:
    """Read as the parameter m, 0.342 gives another curve: the rise would be 1.6 instead of 0.945."""
    wrong = 2 * np.sqrt(K_MODULUS) / OMEGA
    assert abs(wrong - solution.rise) > 0.6
