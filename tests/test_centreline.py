"""The centreline: pieces, joints, frames and one-sided curvature against closed forms; in a plane and in space."""

from __future__ import annotations

import math

import mpmath as mp
import numpy as np
import pytest
from curves import Helix, arch, chain, u_turn

from cablecad.centreline import Arc, Centreline, Frames, Line, Placement
from cablecad.errors import GeometryError

EPS = 2.0**-52
X, Y, Z = np.eye(3)

ARC_RADIUS, ARC_LENGTH, LEG = 15.0, 30.0, 20.0


@pytest.fixture
def bent() -> Centreline:
    """A line, an arc to the left and a line: what a cable with two straight lead-outs is made of."""
    return chain((LEG, 0.0), (ARC_LENGTH, 1.0 / ARC_RADIUS), (LEG, 0.0))


def test_line_arc_line_against_closed_form(bent: Centreline) -> None:
    turn = ARC_LENGTH / ARC_RADIUS
    assert bent.length == 2 * LEG + ARC_LENGTH
    assert np.array_equal(bent.breaks, [0.0, LEG, LEG + ARC_LENGTH, 2 * LEG + ARC_LENGTH])
    s = np.linspace(0.0, bent.length, 1001)
    angle = np.clip((s - LEG) / ARC_RADIUS, 0.0, turn)
    after = np.maximum(s - LEG - ARC_LENGTH, 0.0)
    x = np.minimum(s, LEG) + ARC_RADIUS * np.sin(angle) + after * math.cos(turn)
    y = ARC_RADIUS * (1.0 - np.cos(angle)) + after * math.sin(turn)
    frames = bent.frames(s)
    assert np.abs(frames.position - np.stack([x, y, 0.0 * x], axis=1)).max() < 8 * EPS * bent.length
    assert np.abs(frames.tangent - np.stack([np.cos(angle), np.sin(angle), 0.0 * x], axis=1)).max() < 4 * EPS
    assert np.abs(frames.normal - np.stack([-np.sin(angle), np.cos(angle), 0.0 * x], axis=1)).max() < 4 * EPS
    assert np.array_equal(frames.binormal, np.tile(Z, (1001, 1)))


def test_curvature_is_one_sided_at_breaks(bent: Centreline) -> None:
    inner = bent.breaks[1:-1]
    assert np.array_equal(bent.curvature(inner, side="left"), [0.0, 1.0 / ARC_RADIUS])
    assert np.array_equal(bent.curvature(inner, side="right"), [1.0 / ARC_RADIUS, 0.0])
    assert np.array_equal(bent.curvature(inner), bent.curvature(inner, side="right"))
    # The ends have one side only, and either name for it is right.
    ends = [0.0, bent.length]
    assert np.array_equal(bent.curvature(ends, side="left"), bent.curvature(ends, side="right"))
    assert np.array_equal(bent.curvature(np.linspace(21.0, 49.0, 9)), np.full(9, 1.0 / ARC_RADIUS))
    assert np.array_equal(bent.curvature(bent.breaks, derivative=3), np.zeros(4))


def test_frames_are_continuous_at_breaks(bent: Centreline) -> None:
    for left, right in zip(bent.frames(bent.breaks, "left"), bent.frames(bent.breaks, "right"), strict=True):
        assert np.abs(left - right).max() <= 4 * EPS * bent.length


def test_accessors_are_the_columns_of_frames(bent: Centreline) -> None:
    s = np.linspace(0.0, bent.length, 7)
    frames = bent.frames(s)
    assert np.array_equal(bent.position(s), frames.position)
    assert np.array_equal(bent.tangent(s), frames.tangent)
    assert np.array_equal(bent.normal(s), frames.normal)
    assert np.array_equal(bent.binormal(s), frames.binormal)
    assert np.array_equal(bent.points(7), frames.position)
    assert bent.position(3.0).shape == (1, 3)
    assert bent.bishop(s, 4).shape == (5, 7, 2)


def test_points_need_both_ends(bent: Centreline) -> None:
    with pytest.raises(ValueError, match="at least 2; got 1"):
        bent.points(1)


def test_greatest_curvature_is_that_of_the_tightest_piece() -> None:
    curve = chain((10.0, 0.0), (20.0, 0.05), (12.0, -0.2), (8.0, 0.1))
    assert curve.greatest_curvature() == (0.2, 36.0)
    assert chain((10.0, 0.0)).greatest_curvature() == (0.0, 0.0)


# --- joints that are refused ---------------------------------------------------------------------------------------


def line(origin: np.ndarray, e1: np.ndarray, e2: np.ndarray, length: float = 10.0) -> Line:
    return Line(Placement(origin, e1, e2), length)


def test_a_gap_is_refused() -> None:
    with pytest.raises(GeometryError, match=r"pieces 0 and 1 .* s = 10 mm: gap 1e-06 mm"):
        Centreline([line(0 * X, X, Y), line((10.0 + 1e-6) * X, X, Y)])


def test_a_corner_is_refused() -> None:
    turned = math.cos(1e-6) * X + math.sin(1e-6) * Y, math.cos(1e-6) * Y - math.sin(1e-6) * X
    with pytest.raises(GeometryError, match="frames turned by 1e-06 rad"):
        Centreline([line(0 * X, X, Y), line(10 * X, *turned)])


def test_a_frame_turned_about_the_tangent_is_refused() -> None:
    turned = math.cos(0.1) * Y + math.sin(0.1) * Z
    with pytest.raises(GeometryError, match=r"frames turned by 0\.1 rad"):
        Centreline([line(0 * X, X, Y), line(10 * X, X, turned)])


def test_rounding_is_not_refused() -> None:
    """Far from the origin positions round by more than 1e-9 mm; that is no gap."""
    far = np.array([1e9, -1e9, 1e9])
    curve = Centreline([line(far, X, Y, 1e3), line(far + (1e3 + 1e-7) * X, X, Y, 1e3)])
    assert curve.length == 2e3


def test_a_piece_that_is_not_a_number_does_not_join() -> None:
    with pytest.raises(GeometryError, match="do not join"):
        Centreline([line(0 * X, X, Y), line(math.nan * X, X, Y)])


def test_no_pieces_and_no_length_are_refused() -> None:
    with pytest.raises(GeometryError, match="at least one piece"):
        Centreline([])
    for length in (0.0, -1.0, math.nan, math.inf):
        with pytest.raises(GeometryError, match="positive length"):
            Centreline([line(0 * X, X, Y, length)])


# --- arclengths -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("bad", [-1e-6, 70.0 + 1e-6, math.nan, math.inf, -math.inf])
def test_arclengths_out_of_range(bent: Centreline, bad: float) -> None:
    for call in (bent.frames, bent.bishop, bent.position, bent.curvature):
        with pytest.raises(ValueError, match="within 0 and 70"):
            call([1.0, bad])


def test_arclengths_out_by_rounding_are_clipped(bent: Centreline) -> None:
    assert np.array_equal(bent.position([-1e-13, 70.0 + 1e-12]), bent.position([0.0, 70.0]))
    assert np.array_equal(bent.curvature([-1e-13], side="left"), [0.0])


# --- single pieces -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kappa", [0.0, 1e-300, 1e-12, -1e-4, 0.3, -7.0])
def test_arc_against_mpmath(kappa: float) -> None:
    """Right from no curvature at all to fifty turns."""
    piece = Arc(Placement(np.zeros(3), X, Y), 45.0, kappa)
    s = np.linspace(0.0, 45.0, 13)
    position = piece.frames(s).position
    k = mp.mpf(kappa)
    for at, (x, y, z) in zip(s, position, strict=True):
        exact_x = mp.sin(k * at) / k if kappa else mp.mpf(at)
        exact_y = 2 * mp.sin(k * at / 2) ** 2 / k if kappa else mp.mpf(0)
        assert abs(x - exact_x) < 4 * EPS * 45.0
        assert abs(y - exact_y) <= 4 * EPS * max(float(abs(exact_y)), 45.0 if abs(kappa) > 0.1 else 0.0)
        assert z == 0.0
    assert np.array_equal(piece.bishop(s, 2)[0, :, 0], np.full(13, kappa))
    assert not piece.bishop(s, 2)[1:].any()


CURVES = {
    "arch": arch(0.8, 350.0),
    "loop": arch(1.0, 350.0, m1=1e-17),
    "arc": chain((100.0, 0.05)),
    "helix": Centreline([Helix.of_turns(30.0, 100.0, 1.3)]),
}


@pytest.mark.parametrize("name", CURVES)
def test_frames_obey_their_equations(name: str) -> None:
    """T' = k1 N + k2 B, N' = -k1 T, B' = -k2 T, r' = T by differences of the frames."""
    curve = CURVES[name]
    kappa = curve.greatest_curvature()[0]
    step = 1e-4 / kappa
    s = np.linspace(2 * step, curve.length - 2 * step, 61)
    at, k = curve.frames(s), curve.bishop(s)[0]

    def slope(which: int) -> np.ndarray:
        """The central difference of fourth order."""
        wide, near = (
            curve.frames(s + 2 * step)[which] - curve.frames(s - 2 * step)[which] for step in (step, step / 2)
        )
        return (4.0 * near / (2 * step) - wide / (4 * step)) / 3.0

    k1, k2 = k[:, :1], k[:, 1:]
    # Rounding of the positions over the step, and (kappa step)^4.
    assert np.abs(slope(0) - at.tangent).max() < 1e-9
    assert np.abs(slope(1) - k1 * at.normal - k2 * at.binormal).max() < 1e-9 * kappa
    assert np.abs(slope(2) + k1 * at.tangent).max() < 1e-9 * kappa
    assert np.abs(slope(3) + k2 * at.tangent).max() < 1e-9 * kappa


@pytest.mark.parametrize("name", CURVES)
@pytest.mark.parametrize("order", [1, 2, 3, 4, 5, 6, 7])
def test_bishop_derivatives_are_slopes_of_the_lower_ones(name: str, order: int) -> None:
    """On Chebyshev points of a short interval the derivative of an interpolating polynomial is exact to rounding."""
    curve = CURVES[name]
    half = 0.25 / curve.greatest_curvature()[0]
    middle = np.linspace(half, curve.length - half, 11)
    nodes = np.cos(np.pi * (np.arange(12) + 0.5) / 12)
    s = middle[:, None] + half * nodes
    below = curve.bishop(s.ravel(), order)[order - 1].reshape(11, 12, 2)
    here = curve.bishop(middle, order)[order]
    for i in range(11):
        fitted = np.polynomial.chebyshev.chebfit(nodes, below[i], 11)
        slope = np.polynomial.chebyshev.chebval(0.0, np.polynomial.chebyshev.chebder(fitted)) / half
        assert np.abs(slope - here[i]).max() < 1e-9 * max(np.abs(below[i]).max() / half, 1e-300)


# --- a space curve: what the centreline, the fit and the tube are made to carry ---------------------------------------


def test_helix_is_a_helix() -> None:
    """The piece the tests build in space is what it says: its length, radius, curvature, and a frame without twist."""
    helix = Helix.of_turns(30.0, 100.0, 3.0)
    s = np.linspace(0.0, helix.length, 401)
    frames, k = helix.frames(s), helix.bishop(s, 1)
    assert np.abs(np.hypot(frames.position[:, 0], frames.position[:, 1]) - 30.0).max() < 1e-13 * 30
    assert frames.position[-1] == pytest.approx([30.0, 0.0, 300.0], abs=1e-12)
    assert np.abs(np.linalg.norm(k[0], axis=1) - 30.0 / (30.0**2 + helix.rise**2)).max() < 4 * EPS * helix.curvature
    assert np.abs(k[0]).min(axis=0).max() < 0.05 * helix.curvature  # both components pass through zero ...
    assert np.abs(k[0]).max(axis=0).min() > 0.99 * helix.curvature  # ... and neither of them stays there
    for name in Frames._fields[1:]:
        assert np.abs(np.linalg.norm(getattr(frames, name), axis=1) - 1.0).max() < 4 * EPS
    assert np.abs(np.cross(frames.tangent, frames.normal) - frames.binormal).max() < 4 * EPS


def test_space_curve_joins_a_plane_one() -> None:
    """A lead-out before a helix: the line takes the helix' first frame, and the joint holds in space too."""
    helix = Helix.of_turns(30.0, 20.0, 1.0)
    first = helix.frames(np.zeros(1))
    place = Placement(first.position[0] - 15.0 * first.tangent[0], first.tangent[0], first.normal[0])
    curve = Centreline([Line(place, 15.0), helix])
    assert curve.length == 15.0 + helix.length
    for left, right in zip(curve.frames(curve.breaks, "left"), curve.frames(curve.breaks, "right"), strict=True):
        assert np.abs(left - right).max() < 1e-13
    assert curve.bishop([15.0], side="left")[0] == pytest.approx(np.zeros((1, 2)), abs=0.0)
    assert curve.bishop([15.0], side="right")[0, 0] == pytest.approx([helix.curvature, 0.0], rel=1e-15)
    assert curve.greatest_curvature()[0] == helix.curvature


def test_a_left_turn_and_a_right_turn_close_a_rectangle_with_round_corners() -> None:
    corner = (math.pi / 2 * 5.0, 1 / 5.0)
    curve = chain((40.0, 0.0), corner, (20.0, 0.0), corner, (40.0, 0.0), corner, (20.0, 0.0), corner)
    ends = curve.frames([0.0, curve.length])
    for field in ends:
        assert np.abs(field[0] - field[1]).max() < 1e-14 * curve.length
    mirrored = chain(*((length, -kappa) for length, kappa in [(40.0, 0.0), corner, (20.0, 0.0)]))
    s = np.linspace(0.0, mirrored.length, 31)
    assert np.abs(mirrored.position(s) - curve.position(s) * [1.0, -1.0, 1.0]).max() < 1e-13


def test_u_turn_ends_beside_its_start() -> None:
    assert u_turn(100.0, 10.0).position([0.0, 200.0 + 10.0 * math.pi])[1] == pytest.approx([0.0, 20.0, 0.0], abs=1e-13)
