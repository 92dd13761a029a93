"""Surfaces by way of the binary format: all that was given is there, and what is no surface is an error."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cablecad.brep.kernel import occ_errors, silence
from cablecad.brep.surface import KnotVector, bspline_surface
from cablecad.errors import GeometryError

U, V = KnotVector(2, [0.0, 1.0 / 3.0, 1.0], [3, 2, 3]), KnotVector(3, [0.0, math.pi, 4.0, 1e3], [4, 1, 2, 4])
ROWS, COLUMNS = 5, 7


def poles_and_weights() -> tuple[np.ndarray, np.ndarray]:
    chance = np.random.default_rng(3)
    size = 10.0 ** chance.integers(-30, 30, (ROWS, COLUMNS, 1))
    return size * chance.normal(size=(ROWS, COLUMNS, 3)), chance.uniform(0.1, 3.0, (ROWS, 1))


def test_holds_what_was_given() -> None:
    poles, weights = poles_and_weights()
    surface = bspline_surface(poles, weights, U, V)
    assert (surface.UDegree(), surface.VDegree()) == (2, 3)
    assert (surface.NbUPoles(), surface.NbVPoles()) == (ROWS, COLUMNS)
    assert not surface.IsUPeriodic()
    assert not surface.IsVPeriodic()
    for i, j in np.ndindex(ROWS, COLUMNS):
        pole = surface.Pole(i + 1, j + 1)
        assert [pole.X(), pole.Y(), pole.Z()] == poles[i, j].tolist()
        assert surface.Weight(i + 1, j + 1) == weights[i, 0]
    assert [surface.UKnot(i) for i in (1, 2, 3)] == U.knots
    assert [surface.VKnot(i) for i in (1, 2, 3, 4)] == V.knots
    assert [surface.UMultiplicity(i) for i in (1, 2, 3)] == U.multiplicities
    assert [surface.VMultiplicity(i) for i in (1, 2, 3, 4)] == V.multiplicities


def test_equal_weights_are_no_weights() -> None:
    surface = bspline_surface(poles_and_weights()[0], 1.0, U, V)
    assert not surface.IsURational()
    assert not surface.IsVRational()


@pytest.mark.parametrize(
    "v",
    [
        KnotVector(3, [0.0, 2.0, 1.0, 3.0], [4, 1, 2, 4]),
        KnotVector(3, [0.0, 1.0, 2.0, 3.0], [4, 1, 1, 4]),
        KnotVector(40, [0.0, 1.0, 2.0, 3.0], [4, 1, 2, 4]),
    ],
    ids=["knots that fall", "too few for the poles", "too high a degree"],
)
def test_no_surface_is_an_error(v: KnotVector) -> None:
    with silence(), pytest.raises(GeometryError), occ_errors(GeometryError, "making a surface", "report it"):
        bspline_surface(poles_and_weights()[0], 1.0, U, v)
