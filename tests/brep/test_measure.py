"""Volume and area by the splines: closed forms, Open Cascade's own integration, and the share of the deviation."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from curves import Helix, arch, chain

from cablecad.brep import measure
from cablecad.brep.bspline import Spline
from cablecad.brep.check import check_solid, check_tube
from cablecad.brep.fit import fit_centreline
from cablecad.brep.measure import measure_tube
from cablecad.brep.spline import FittedCentreline, FittedPiece
from cablecad.brep.tube import build_tube
from cablecad.centreline import Centreline

CURVES = {
    "k=.342": arch(0.342, 350.0),
    "k=.999": arch(0.999, 350.0),
    "S": arch(0.6, 350.0, mode=2),
    "line-arc-line": chain((20.0, 0.0), (30.0, 1 / 15.0), (10.0, 0.0)),
    "helix": Centreline([Helix.of_turns(30.0, 100.0, 3.0)]),
}


def test_straight_tube() -> None:
    fit = fit_centreline(chain((40.0, 0.0)), 3.0, tolerance=1e-3)
    volume, area = measure_tube(fit, 3.0)
    assert volume == pytest.approx(math.pi * 9.0 * 40.0, rel=1e-14)
    assert area == pytest.approx(2.0 * math.pi * 3.0 * 43.0, rel=1e-14)


@pytest.mark.parametrize("tolerance", [1e-1, 1e-3, 1e-6])
@pytest.mark.parametrize("name", CURVES)
def test_open_cascade_measures_the_same(name: str, tolerance: float) -> None:
    """Its adaptive integration of the solid's faces keeps 1e-6 of volume and area, and mostly far more."""
    radius = 2.0
    fit = fit_centreline(CURVES[name], radius, tolerance=tolerance)
    solid = build_tube(fit, radius)
    ours, theirs = check_tube(solid, fit, radius), check_solid(solid, radius=radius, length=fit.length)
    assert (ours.valid, ours.faces) == (theirs.valid, theirs.faces)
    assert ours.volume == pytest.approx(theirs.volume, rel=1e-6)
    assert ours.area == pytest.approx(theirs.area, rel=1e-6)


@pytest.mark.parametrize("name", CURVES)
def test_the_error_of_a_fine_fit_is_rounding(name: str) -> None:
    """By Pappus: pi r^2 L, and 2 pi r (L + r) with the caps."""
    fit = fit_centreline(CURVES[name], 2.0, tolerance=1e-9)
    volume, area = measure_tube(fit, 2.0)
    assert volume == pytest.approx(math.pi * 4.0 * fit.length, rel=1e-9)
    assert area == pytest.approx(4.0 * math.pi * (fit.length + 2.0), rel=1e-9)


def test_it_is_the_fit_that_is_measured() -> None:
    """A piece whose normal is too long by a per cent has a wider section: the volume by as much, the area by half."""
    fit = fit_centreline(CURVES["k=.342"], 2.0, tolerance=1e-9)
    (piece,) = fit.pieces
    assert isinstance(piece, FittedPiece)
    poles = piece.poles.copy()
    poles[:, 3:6] *= 1.01
    spoilt = FittedCentreline((replace(piece, spline=Spline(piece.spline.knots, poles)),), fit.tolerance)
    sides = np.subtract(measure_tube(spoilt, 2.0), (0.0, 8.0 * math.pi))
    exact = np.subtract(measure_tube(fit, 2.0), (0.0, 8.0 * math.pi))
    assert sides[0] / exact[0] == pytest.approx(1.01, rel=1e-9)
    assert sides[1] / exact[1] == pytest.approx(1.005, rel=1e-4)


def test_many_together_are_as_each_alone() -> None:
    """More spans than are worked on at once, and straight tubes among them."""
    fits = [fit_centreline(curve, 2.0, tolerance=1e-9) for curve in CURVES.values()] * 3
    fits.insert(2, fit_centreline(chain((40.0, 0.0)), 3.0, tolerance=1e-3))
    assert sum(fit.spans for fit in fits) > 2 * measure._BLOCK
    radii = [0.5 + 0.1 * i for i in range(len(fits))]
    for fit, radius, measured in zip(fits, radii, measure.measure_tubes(fits, radii), strict=True):
        assert measured == pytest.approx(measure_tube(fit, radius), rel=1e-13)
    assert measure.measure_tubes([], []) == []
