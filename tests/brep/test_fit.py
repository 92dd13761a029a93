"""The fit keeps its tolerance against independent measurement, with the knots the formula foresees, at any scale."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import pytest
from curves import Helix, arch, chain
from oracle import PinnedOracle
from scipy.interpolate import BSpline

from cablecad.brep import fit as fitting
from cablecad.brep.fit import fit_centreline, fit_centrelines
from cablecad.brep.knots import DEGREE, KnotCount
from cablecad.brep.spline import FittedPiece
from cablecad.centreline import Arc, Array, Centreline, Line, Placement
from cablecad.errors import GeometryError, UsageError
from cablecad.model import Cable, Clamp, tolerance_floor
from cablecad.rod.solve import solve_rod

EPS = 2.0**-52

CURVES = {
    "k=.342": arch(0.342, 350.0),
    "k=.8": arch(0.8, 350.0),
    "k=.999": arch(0.999, 350.0),
    "line-arc-line": chain((20.0, 0.0), (30.0, 1 / 15.0), (10.0, 0.0)),
    "arcs": chain((20.0, 1 / 9.0), (30.0, -1 / 15.0), (10.0, 1 / 4.0)),
    "helix": Centreline([Helix.of_turns(30.0, 100.0, 3.0)]),
}
TOLERANCES = [10.0**-n for n in range(1, 10)]


def as_built(piece: FittedPiece) -> BSpline:
    """The spline from its poles and knots alone, as CAD will evaluate it."""
    return BSpline(np.concatenate([np.zeros(DEGREE), piece.knots, np.ones(DEGREE)]), piece.poles, DEGREE)


def side(piece: FittedPiece, exact: Centreline, radius: float, samples: int) -> Iterator[tuple[Array, Array]]:
    """Points of the fitted side and the exact ones of the same parameters, at `samples` a span, around at 25 angles."""
    built = as_built(piece)
    shares = (np.arange(samples) + 0.5) / samples
    at = np.append((piece.knots[:-1, None] + np.diff(piece.knots)[:, None] * shares).ravel(), [0.0, 1.0])
    frames, values = exact.frames(at * exact.length), built(at)
    for u in np.linspace(0.0, 2.0 * math.pi, 25) + 0.1:
        cos, sin = radius * math.cos(u), radius * math.sin(u)
        fitted = values[:, :3] + cos * values[:, 3:6] + sin * values[:, 6:9]
        yield fitted, frames.position + cos * frames.normal + sin * frames.binormal


def distance_to_tube(points: Array, exact: Centreline, radius: float, start: Array) -> Array:
    """How far points are off the exact tube's side: each is projected onto the exact centreline by Newton's method."""
    s = start.copy()
    for _ in range(6):
        frames = exact.frames(s)
        k = exact.bishop(s)[0]
        off = points - frames.position
        bend = k[:, :1] * frames.normal + k[:, 1:] * frames.binormal
        slope = 1.0 - np.einsum("ni,ni->n", off, bend)
        s = np.clip(s + np.einsum("ni,ni->n", off, frames.tangent) / slope, 0.0, exact.length)
    return np.abs(np.linalg.norm(points - exact.position(s), axis=1) - radius)


@pytest.fixture
def fits_made(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """The number of spans of every spline that is interpolated."""
    made: list[int] = []
    interpolate = fitting._interpolate

    def counted(curved: Sequence[Any], spans: int, wanted: Sequence[KnotCount]) -> list[FittedPiece]:
        made.extend([spans] * len(curved))
        return interpolate(curved, spans, wanted)

    monkeypatch.setattr(fitting, "_interpolate", counted)
    return made


@pytest.mark.parametrize("tolerance", TOLERANCES)
@pytest.mark.parametrize("name", CURVES)
def test_tolerance_is_kept(name: str, tolerance: float, fits_made: list[int]) -> None:
    curve, radius = CURVES[name], 2.0
    fit = fit_centreline(curve, radius, tolerance=tolerance)
    curved = [piece for piece in curve.pieces if not isinstance(piece, Line)]
    assert len(fits_made) == len(curved), "the first fit should have been the last"
    assert fit.deviation <= tolerance
    fitted = [piece for piece in fit.pieces if isinstance(piece, FittedPiece)]
    for exact_piece, piece in zip(curved, fitted, strict=True):
        exact = Centreline([exact_piece])
        greatest = max(float(np.linalg.norm(a - b, axis=1).max()) for a, b in side(piece, exact, radius, 97))
        assert greatest <= tolerance
        # Dense sampling finds no more than what the fit says of itself, but for the crest between its samples.
        assert greatest <= piece.deviation * 1.015 + 8 * EPS * 350.0
        assert piece.deviation <= greatest * 1.01 + 8 * EPS * 350.0


@pytest.mark.parametrize("tolerance", [1e-2, 1e-5, 1e-9])
@pytest.mark.parametrize("name", CURVES)
def test_distance_of_the_surfaces(name: str, tolerance: float) -> None:
    """By projection onto the exact centreline: the deviation at equal parameters bounds it, and it is not far below."""
    curve, radius = CURVES[name], 2.0
    fit = fit_centreline(curve, radius, tolerance=tolerance)
    for exact_piece, piece in zip(curve.pieces, fit.pieces, strict=True):
        if isinstance(piece, Line):
            continue
        exact = Centreline([exact_piece])
        start = np.append(
            (piece.knots[:-1, None] + np.diff(piece.knots)[:, None] * (np.arange(31) + 0.5) / 31).ravel(), [0.0, 1.0]
        )
        greatest = max(
            float(distance_to_tube(points, exact, radius, start * exact.length).max())
            for points, _ in side(piece, exact, radius, 31)
        )
        assert greatest <= piece.deviation * 1.015 + 8 * EPS * 350.0
        assert greatest >= 0.3 * piece.deviation


@pytest.mark.parametrize("angle", [20.0, 90.0, 125.0, 170.0])
def test_centreline_against_mpmath(angle: float) -> None:
    fit = fit_centreline(arch(math.sin(math.radians(angle / 2.0)), 350.0), 2.0, tolerance=1e-9)
    s = np.linspace(0.0, 350.0, 47)
    expected = PinnedOracle(350.0, angle_deg=angle).points(s) * [1.0, -1.0]
    assert np.abs(fit.frames(s).position[:, :2] - expected).max() <= 1e-9


@pytest.mark.parametrize("k", [0.2, 0.342, 0.6, 0.8, 0.95, 0.999, 0.99999])
def test_knots_are_no_more_than_needed(k: float) -> None:
    """Far below the coarsest fits the deviation comes out near the share of the tolerance aimed at, 0.1."""
    for tolerance in (1e-6, 1e-7, 1e-8, 1e-9):
        fit = fit_centreline(arch(k, 350.0), 2.0, tolerance=tolerance)
        # With few spans the round number is more than the one computed, by up to one: ((n - 1) / n)^q; beside the ends
        # the error is up to twice as large.
        rounded = ((fit.spans - 1) / fit.spans) ** (DEGREE + 1)
        assert 0.06 * rounded < fit.deviation / tolerance < 0.3


def test_coarse_tolerances_take_few_fits(fits_made: list[int]) -> None:
    fits = 0
    for k in (0.1, 0.2, 0.342, 0.6, 0.8, 0.95, 0.999, 0.99999):
        for tolerance in (0.1, 0.03, 0.01, 3e-3, 1e-3, 3e-4, 1e-4):
            fit = fit_centreline(arch(k, 350.0), 2.0, tolerance=tolerance)
            assert fit.deviation <= 0.985 * tolerance  # room for the crests between the samples
            fits += 1
    assert len(fits_made) <= fits + 3


def test_sharp_loop_in_a_long_cable() -> None:
    """The loop takes a hundredth of the length: found, resolved, and its tails are not drowned in knots."""
    for m1 in (1e-17, 1e-100, 1e-300):
        curve = arch(1.0, 350.0, m1=m1)
        fit = fit_centreline(curve, 0.05, tolerance=1e-3)
        (piece,) = fit.pieces
        assert isinstance(piece, FittedPiece)
        greatest = max(float(np.linalg.norm(a - b, axis=1).max()) for a, b in side(piece, curve, 0.05, 97))
        assert greatest <= 1e-3
        assert neighbours(piece) < 1.5
        assert piece.spans < 150


def neighbours(piece: FittedPiece) -> float:
    """How many times as long as the one beside it a span is at most."""
    spans = np.diff(piece.knots)
    return float(np.maximum(spans[1:] / spans[:-1], spans[:-1] / spans[1:]).max())


@pytest.mark.parametrize("slack", [1e-4, 1e-5, 1e-6, 1e-7])
def test_the_straight_middle_of_a_taut_cable_takes_few_spans(slack: float, fits_made: list[int]) -> None:
    """The bends at its ends shrink with the slack; spans grow away from them, and their number like a logarithm."""
    lean = math.cos(0.6), math.sin(0.6)
    ends = Clamp((0, 0, 0), (*lean, 0)), Clamp((1000, 0, 0), (lean[0], -lean[1], 0))
    curve = solve_rod(Cable("c", 1e-4, *ends, slack=slack)).centreline
    radius = 0.5 / curve.greatest_curvature()[0]
    fit = fit_centreline(curve, radius, tolerance=radius / 20.0)
    (piece,) = fit.pieces
    assert isinstance(piece, FittedPiece)
    assert len(fits_made) == 1
    greatest = max(float(np.linalg.norm(a - b, axis=1).max()) for a, b in side(piece, curve, radius, 97))
    assert greatest <= fit.tolerance
    assert neighbours(piece) < 2.5
    assert piece.spans < 25.0 * math.log(1000.0 / radius)


def test_deviation_of_any_error() -> None:
    """Errors of position, normal and binormal in any relation: the greatest around the circle, by a fine sweep."""
    rng = np.random.default_rng(8)
    radius = 2.0
    u = np.linspace(0.0, 2.0 * math.pi, 7201)
    for _ in range(200):
        error = rng.normal(size=(1, 9)) * np.repeat(10.0 ** rng.uniform(-3.0, 0.0, 3), 3)
        p, n, b = np.split(error[0], 3)
        swept = np.linalg.norm(p + radius * (np.cos(u)[:, None] * n + np.sin(u)[:, None] * b), axis=1).max()
        (measured,) = fitting._deviation(error[None], np.array([radius]))
        assert 0.9975 * swept <= measured <= swept * (1.0 + 1e-6)


# --- what the spline is made of --------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["k=.8", "arcs", "helix"])
def test_ends_are_exact(name: str) -> None:
    """Position, frame and first derivative at both ends, so that pieces and caps meet to rounding."""
    curve = CURVES[name]
    fit = fit_centreline(curve, 2.0, tolerance=1e-2)
    for piece, exact in zip(fit.pieces, curve.pieces, strict=True):
        assert isinstance(piece, FittedPiece)
        ends = np.array([0.0, exact.length])
        frames, k = exact.frames(ends), exact.bishop(ends, 0)[0]
        built = as_built(piece)
        values, slopes = built([0.0, 1.0]), built([0.0, 1.0], nu=1) / exact.length
        assert np.abs(values - np.hstack([frames.position, frames.normal, frames.binormal])).max() < 4 * EPS * 350.0
        turning = np.hstack([frames.tangent, -k[:, :1] * frames.tangent, -k[:, 1:] * frames.tangent])
        assert np.abs(slopes - turning).max() < 1e-12
        assert np.abs(piece.ends[:, 0] - frames.position).max() < 4 * EPS * 350.0
        assert np.abs(piece.ends[:, 1] - frames.tangent).max() < 4 * EPS
        assert np.abs(piece.ends[:, 2] - frames.normal).max() < 4 * EPS
        assert np.array_equal(piece.ends[:, 0], piece.poles[[0, -1], :3])


def test_derivatives_are_continuous_but_for_the_highest() -> None:
    fit = fit_centreline(CURVES["k=.8"], 2.0, tolerance=1e-3)
    (piece,) = fit.pieces
    assert isinstance(piece, FittedPiece)
    assert piece.poles.shape == (fit.spans + DEGREE, 9)
    assert np.all(np.diff(piece.knots) > 0.0)
    inner, hair, everywhere = piece.knots[1:-1], 1e-9, np.linspace(0.0, 1.0, 999)
    built = as_built(piece)
    for derivative in range(DEGREE + 1):
        jump = np.abs(built(inner + hair, nu=derivative) - built(inner - hair, nu=derivative)).max()
        size = np.abs(built(everywhere, nu=derivative)).max()
        assert jump > 1e-2 * size if derivative == DEGREE else jump < 1e-6 * size


def test_plane_curve_stays_in_its_plane() -> None:
    (piece,) = fit_centreline(CURVES["k=.999"], 2.0, tolerance=1e-6).pieces
    assert isinstance(piece, FittedPiece)
    assert np.all(piece.poles[:, [2, 5, 6, 7]] == 0.0)
    assert np.all(piece.poles[:, 8] == 1.0)


def test_straight_pieces_stay_lines() -> None:
    curve = CURVES["line-arc-line"]
    fit = fit_centreline(curve, 2.0, tolerance=1e-3)
    assert fit.pieces[0] is curve.pieces[0]
    assert fit.pieces[2] is curve.pieces[2]
    assert fit.spans == 2 + fit.pieces[1].spans  # type: ignore[union-attr]
    straight = fit_centreline(chain((50.0, 0.0)), 2.0, tolerance=1e-3)
    assert (straight.deviation, straight.spans, straight.greatest_curvature()) == (0.0, 1, (0.0, 0.0))


@pytest.mark.parametrize("kappa", [0.0, 1e-80, 1e-30, 1e-9])
def test_arc_of_next_to_no_curvature(kappa: float) -> None:
    place = Placement(np.zeros(3), np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]))
    fit = fit_centreline(Centreline([Arc(place, 80.0, kappa)]), 2.0, tolerance=1e-9)
    assert fit.spans == 2
    assert fit.deviation < 16 * EPS * 80.0


# --- the fit as a curve -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", CURVES)
def test_fit_is_a_curve_like_the_exact_one(name: str) -> None:
    curve = CURVES[name]
    fit = fit_centreline(curve, 2.0, tolerance=1e-6)
    assert fit.length == curve.length
    assert np.array_equal(fit.breaks, curve.breaks)
    s = np.linspace(0.0, curve.length, 301)
    for which in ("left", "right"):
        fitted, exact = fit.frames(s, which), curve.frames(s, which)
        assert np.abs(fitted.position - exact.position).max() <= 1e-6
        axes = np.stack(fitted[1:], axis=1)
        assert np.abs(axes @ axes.transpose(0, 2, 1) - np.eye(3)).max() < 16 * EPS
        # A spline's derivatives follow at one order of the span less each.
        assert np.abs(np.stack(exact[1:], axis=1) - axes).max() < 1e-5
        assert np.abs(fit.bishop(s, 0, which) - curve.bishop(s, 0, which)).max() < 1e-4 * curve.greatest_curvature()[0]
    assert fit.bishop(s).shape == (1, 301, 2)


def test_curvature_of_a_fit_is_one_sided_at_breaks() -> None:
    fit = fit_centreline(CURVES["line-arc-line"], 2.0, tolerance=1e-6)
    inner = fit.breaks[1:-1]
    assert fit.bishop(inner, side="left")[0, :, 0] == pytest.approx([0.0, 1 / 15.0], rel=1e-5)
    assert fit.bishop(inner, side="right")[0, :, 0] == pytest.approx([1 / 15.0, 0.0], rel=1e-5)


def test_fit_refuses_what_it_has_not() -> None:
    fit = fit_centreline(CURVES["k=.8"], 2.0, tolerance=1e-3)
    with pytest.raises(ValueError, match="not derivatives of it"):
        fit.bishop([1.0], 1)
    for bad in (-1.0, 351.0, math.nan):
        with pytest.raises(ValueError, match="within 0 and 350"):
            fit.frames([bad])


@pytest.mark.parametrize("tolerance", [1e-2, 1e-4, 1e-6, 1e-8])
@pytest.mark.parametrize("name", CURVES)
def test_least_bend_radius_of_the_fit(name: str, tolerance: float) -> None:
    """Curvature loses two orders of the span: an error e of position means about e w^2 / (w h)^2 in it."""
    curve = CURVES[name]
    fit = fit_centreline(curve, 2.0, tolerance=tolerance)
    (found, at), (exact, exact_at) = fit.greatest_curvature(), curve.greatest_curvature()
    spans = [np.diff(piece.knots).min() * piece.length for piece in fit.pieces if isinstance(piece, FittedPiece)]
    assert abs(found - exact) < 40.0 * tolerance / min(spans) ** 2
    if name.startswith("k="):
        assert at == pytest.approx(exact_at, abs=2.0 * min(spans))


@pytest.mark.parametrize("tolerance", [1.0, 1e-2, 1e-4, 1e-7])
@pytest.mark.parametrize("name", CURVES)
def test_the_tightest_bend_is_not_missed_between_samples(name: str, tolerance: float) -> None:
    """Against two thousand points a span, by scipy."""
    fit = fit_centreline(CURVES[name], 2.0, tolerance=tolerance)
    greatest = 0.0
    for piece in fit.pieces:
        if isinstance(piece, FittedPiece):
            spline = BSpline(clamped(piece.knots), piece.poles[:, :3], DEGREE)
            x = np.unique([np.linspace(a, b, 2001) for a, b in itertools.pairwise(piece.knots)])
            first, second = spline(x, 1), spline(x, 2)
            bends = np.linalg.norm(np.cross(first, second), axis=1) / np.linalg.norm(first, axis=1) ** 3
            greatest = max(greatest, float(bends.max()))
    assert fit.greatest_curvature()[0] == pytest.approx(greatest, rel=3e-8)


def clamped(knots: Array) -> Array:
    return np.concatenate([knots[:1].repeat(DEGREE), knots, knots[-1:].repeat(DEGREE)])


@pytest.mark.parametrize("tolerance", [1e-2, 1e-6])
@pytest.mark.parametrize("name", CURVES)
def test_the_least_stretch_of_a_side(name: str, tolerance: float) -> None:
    """1 - kappa r, as far as the normals follow; and that of the side itself, by differences of its points."""
    curve = CURVES[name]
    radius = 0.5 / curve.greatest_curvature()[0]
    fit = fit_centreline(curve, radius, tolerance=tolerance)
    stretch, _where = fit.least_stretch(radius)
    assert stretch == pytest.approx(0.5, abs=0.02 if tolerance > 1e-3 else 1e-4)
    shortest = math.inf
    for piece in fit.pieces:
        if isinstance(piece, FittedPiece):
            columns = piece.evaluate(np.linspace(0.0, piece.length, 6001))[0]
            along = np.linalg.norm(np.diff(columns[:, :3], axis=0), axis=1)
            for u in np.linspace(0.0, 2.0 * math.pi, 72, endpoint=False):
                side = columns[:, :3] + radius * (math.cos(u) * columns[:, 3:6] + math.sin(u) * columns[:, 6:])
                shortest = min(shortest, float((np.linalg.norm(np.diff(side, axis=0), axis=1) / along).min()))
    assert shortest == pytest.approx(stretch, abs=2e-3)


# --- scale, place and refusals ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", CURVES)
def test_scale_invariance(name: str) -> None:
    """From a hundredth of a millimetre to a kilometre: the same knots, and poles in proportion."""

    def scaled(scale: float) -> Centreline:
        if name.startswith("k="):
            return arch(float(name[2:]), 350.0 * scale)
        if name == "helix":
            return Centreline([Helix.of_turns(30.0 * scale, 100.0 * scale, 3.0)])
        stretches = {
            "line-arc-line": [(20.0, 0.0), (30.0, 1 / 15.0), (10.0, 0.0)],
            "arcs": [(20.0, 1 / 9.0), (30.0, -1 / 15.0), (10.0, 1 / 4.0)],
        }[name]
        return chain(*((length * scale, kappa / scale) for length, kappa in stretches))

    base = fit_centreline(scaled(1.0), 2.0, tolerance=1e-4)
    for length in (1e-2, 1.0, 1e3, 1e6):
        scale = length / scaled(1.0).length
        fit = fit_centreline(scaled(scale), 2.0 * scale, tolerance=1e-4 * scale)
        assert fit.spans == base.spans
        assert fit.deviation == pytest.approx(base.deviation * scale, rel=1e-6, abs=16 * EPS * length)
        for mine, other in zip(base.pieces, fit.pieces, strict=True):
            if isinstance(mine, FittedPiece) and isinstance(other, FittedPiece):
                assert np.abs(mine.poles[:, :3] * scale - other.poles[:, :3]).max() < 1e-12 * length
                assert np.abs(mine.poles[:, 3:] - other.poles[:, 3:]).max() < 1e-12


@pytest.mark.parametrize("length", [1e-90, 1e-27, 1e-9, 1e12, 1e90])
def test_no_size_is_too_small_or_too_large(length: float) -> None:
    """Tenth derivatives by arclength would leave the range of numbers; those by the share of the length do not."""
    for curve, like in ((arch(0.8, length), arch(0.8, 1.0)), (chain((length, 3.0 / length)), chain((1.0, 3.0)))):
        fit = fit_centreline(curve, 0.01 * length, tolerance=1e-6 * length)
        base = fit_centreline(like, 0.01, tolerance=1e-6)
        assert fit.spans == base.spans
        assert fit.deviation == pytest.approx(base.deviation * length, rel=1e-6)


@pytest.mark.parametrize("length", [1e-2, 1.0, 350.0, 1e6])
@pytest.mark.parametrize("k", [0.342, 0.8, 0.999])
def test_finest_tolerance_is_reached(length: float, k: float) -> None:
    """`tolerance_floor` promises what double precision can keep; the fit keeps it, here and far from the origin."""
    for origin in ((0.0, 0.0, 0.0), (1e5, -1e5, 1e5)):
        tolerance = tolerance_floor(max(map(abs, origin)) + length)
        if tolerance > length / 1000.0:
            continue
        curve, radius = arch(k, length, origin=origin), length / 100.0
        fit = fit_centreline(curve, radius, tolerance=tolerance)
        (piece,) = fit.pieces
        assert isinstance(piece, FittedPiece)
        greatest = max(float(np.linalg.norm(a - b, axis=1).max()) for a, b in side(piece, curve, radius, 97))
        assert greatest <= tolerance


@pytest.mark.parametrize("name", CURVES)
def test_below_rounding_is_refused(name: str) -> None:
    with pytest.raises(GeometryError, match=r"cannot be fitted to 1e-15 mm: rounding leaves \d"):
        fit_centreline(CURVES[name], 2.0, tolerance=1e-15)


def test_refusal_names_the_piece() -> None:
    with pytest.raises(GeometryError, match="the piece of the centreline at s = 20 mm"):
        fit_centreline(CURVES["line-arc-line"], 2.0, tolerance=1e-16)


def test_endless_cable_is_refused_before_it_is_fitted(fits_made: list[int]) -> None:
    with pytest.raises(GeometryError, match=r"needs more than 100000 spans to keep 0\.001 mm"):
        fit_centreline(chain((1e8, 0.1)), 2.0, tolerance=1e-3)
    assert not fits_made


def test_many_together_are_as_each_alone() -> None:
    """Of several kinds, sizes and tolerances, more of one kind than go through at once; failures cost no other."""
    asked = [(curve, 2.0, tolerance) for tolerance in (1e-2, 1e-5) for curve in CURVES.values()]
    asked += [(arch(0.342 + 0.004 * i, 350.0 + i), 1.0 + 0.02 * i, 1e-3) for i in range(60)]
    asked.insert(3, (CURVES["k=.8"], 2.0, 1e-15))
    asked.insert(7, (chain((1e8, 0.1)), 2.0, 1e-3))
    asked.append((chain((50.0, 0.0)), 2.0, 1e-3))
    together = fit_centrelines(*map(list, zip(*asked, strict=True)))  # type: ignore[arg-type]
    failed = [i for i, fit in enumerate(together) if isinstance(fit, GeometryError)]
    assert failed == [3, 7]
    assert "cannot be fitted to 1e-15 mm" in str(together[3])
    assert "more than 100000 spans" in str(together[7])
    for (curve, radius, tolerance), fit in zip(asked, together, strict=True):
        if isinstance(fit, GeometryError):
            continue
        alone = fit_centreline(curve, radius, tolerance=tolerance)
        assert (fit.tolerance, fit.spans, len(fit.pieces)) == (tolerance, alone.spans, len(alone.pieces))
        assert fit.deviation == pytest.approx(alone.deviation, rel=1e-3, abs=1e-12)
        for got, want in zip(fit.pieces, alone.pieces, strict=True):
            if isinstance(want, FittedPiece):
                assert isinstance(got, FittedPiece)
                assert np.abs(got.poles - want.poles).max() < 1e-10
                assert np.abs(got.ends - want.ends).max() < 1e-11
                assert got.greatest_curvature() == pytest.approx(want.greatest_curvature(), rel=1e-9)
            else:
                assert got is want


@pytest.mark.parametrize("bad", [0.0, -1e-3, math.nan, math.inf])
def test_senseless_calls(bad: float) -> None:
    with pytest.raises(UsageError, match="positive radius and tolerance"):
        fit_centreline(CURVES["k=.8"], 2.0, tolerance=bad)
    with pytest.raises(UsageError, match="positive radius and tolerance"):
        fit_centreline(CURVES["k=.8"], bad, tolerance=1e-3)


def test_hundred_turns_of_a_helix() -> None:
    """Thirty metres to a nanometre: thousands of spans, measured block by block."""
    curve = Centreline([Helix.of_turns(50.0, 12.0, 100.0)])
    fit = fit_centreline(curve, 5.0, tolerance=1e-6)
    (piece,) = fit.pieces
    assert isinstance(piece, FittedPiece)
    greatest = max(float(np.linalg.norm(a - b, axis=1).max()) for a, b in side(piece, curve, 5.0, 7))
    assert 0.05e-6 < greatest <= 0.3e-6
    assert 900 < fit.spans < 1600
