"""The deviation of a solid's side is measured for what it is, on tubes that are off by a known amount."""

import numpy as np
import pytest

from cablecad.bench.deviation import measure_side
from cablecad.bench.sweeps import fitted_spine, interpolated_spine, sweep_pipe, sweep_pipe_shell
from cablecad.bench.truth import arch_truths
from cablecad.bench.tubes import LENGTH, RADII, wave
from cablecad.brep.fit import fit_centreline
from cablecad.brep.tube import build_tube

TRUTHS = {truth.k: truth for truth in arch_truths(LENGTH)}


@pytest.mark.parametrize("k", RADII)
def test_the_centreline_of_the_product_is_the_truth(k):
    off = wave(k).frames(TRUTHS[k].s).position[:, :2] - TRUTHS[k].place
    assert np.abs(off).max() < 1e-11


@pytest.mark.parametrize("k", RADII)
def test_a_tube_too_thick_by_a_micrometre_is_off_by_a_micrometre(k):
    fit = fit_centreline(wave(k), RADII[k], tolerance=1e-8)
    side = measure_side(build_tube(fit, RADII[k] + 1e-3), TRUTHS[k], RADII[k])
    assert side.deviation == pytest.approx(1e-3, rel=1e-4)


@pytest.mark.parametrize("k", RADII)
@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-9])
def test_a_tube_of_ours_keeps_its_tolerance_and_its_report_is_true(k, tolerance):
    fit = fit_centreline(wave(k), RADII[k], tolerance=tolerance)
    side = measure_side(build_tube(fit, RADII[k]), TRUTHS[k], RADII[k])
    assert side.deviation <= tolerance
    # The report's is between points of equal parameters, which bounds the distance of surfaces from above.
    assert 0.2 * fit.deviation < side.deviation <= fit.deviation * 1.01 + 1e-11
    assert side.poles == 8 * (fit.spans + 9)


def test_the_sweeps_of_open_cascade_are_measured_alike():
    k, radius = 0.8, RADII[0.8]
    at = wave(k).frames(np.linspace(0.0, LENGTH, 256))
    pipe = sweep_pipe(interpolated_spine(at.position), at.position[0], at.tangent[0], radius)
    assert 1e-7 < measure_side(pipe, TRUTHS[k], radius).deviation < 1e-3
    fit = fit_centreline(wave(k), radius, tolerance=1e-6)
    shell = sweep_pipe_shell(fitted_spine(fit), at.position[0], at.tangent[0], radius, tolerance=1e-6)
    assert measure_side(shell, TRUTHS[k], radius).deviation < 1e-5
