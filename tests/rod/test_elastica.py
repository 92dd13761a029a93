"""The inflexional elastica against mpmath at 50 digits, against quadrature, and against its own first integral."""

from __future__ import annotations

import math

import mpmath as mp
import numpy as np
import pytest
from oracle import PinnedOracle

from cablecad.centreline import Arc, Array, Line, Piece, Placement
from cablecad.rod.elastica import Inflexional
from cablecad.rod.elliptic import complete_k

EPS = 2.0**-52

FLAT = Placement(np.zeros(3), np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]))

PARAMETERS = [
    *((k * k, 1.0 - k * k) for k in (1e-8, 1e-3, 0.0871557, 0.342, 0.7071, 0.9, 0.99, 0.99999)),
    (1.0 - 1e-16, 1e-16),
    (1.0, 1e-17),
]
"""(m, m1) from a hair of slack to a loop whose m1 is below the rounding of m."""


def stretch(m: float, m1: float, begin: float, end: float, length: float = 350.0) -> Inflexional:
    """The stretch from begin to end in quarter periods."""
    quarter = complete_k(m, m1)
    return Inflexional(FLAT, length, (end - begin) * quarter / length, m, m1, begin * quarter)


class Exact:
    """The same stretch by mpmath: m from whichever of m and m1 holds more digits."""

    def __init__(self, rod: Inflexional) -> None:
        self.m = mp.mpf(rod.m) if rod.m < 0.5 else 1 - mp.mpf(rod.m1)
        self.k, self.omega, self.u0 = mp.sqrt(self.m), mp.mpf(rod.omega), mp.mpf(rod.u0)
        self.K, self.E = mp.ellipk(self.m), mp.ellipe(self.m)

    def epsilon(self, u: mp.mpf) -> mp.mpf:
        turns = mp.nint(u / (2 * self.K))
        inner = mp.asin(mp.ellipfun("sn", u - 2 * turns * self.K, m=self.m))
        return 2 * turns * self.E + mp.ellipe(inner, self.m)

    def position(self, s: float) -> tuple[mp.mpf, mp.mpf]:
        u = self.u0 + self.omega * mp.mpf(s)
        x = (2 * (self.epsilon(u) - self.epsilon(self.u0)) - (u - self.u0)) / self.omega
        cn, cn0 = (mp.ellipfun("cn", v, m=self.m) for v in (u, self.u0))
        return x, -2 * self.k / self.omega * (cn - cn0)

    def psi(self, s: mp.mpf) -> mp.mpf:
        return 2 * mp.asin(self.k * mp.ellipfun("sn", self.u0 + self.omega * s, m=self.m))


STRETCHES = [(-1.0, 1.0), (-5.0, 7.0), (0.37, 0.92), (-2.3, 4.1), (3.0, 5.0)]


@pytest.mark.parametrize(("m", "m1"), PARAMETERS)
@pytest.mark.parametrize(("begin", "end"), STRETCHES)
def test_position_and_tangent(m: float, m1: float, begin: float, end: float) -> None:
    rod = stretch(m, m1, begin, end)
    exact = Exact(rod)
    s = np.linspace(0.0, rod.length, 23)
    frames = rod.frames(s)
    room = EPS * (rod.length + (1.0 + abs(rod.u0)) / rod.omega)
    for i, at in enumerate(s):
        x, y = exact.position(at)
        assert abs(frames.position[i, 0] - x) <= 4 * room
        assert abs(frames.position[i, 1] - y) <= 4 * room * float(exact.k)  # a flat arch is flat to its own rounding
        psi = exact.psi(mp.mpf(at))
        assert abs(frames.tangent[i, 0] - mp.cos(psi)) <= 8 * EPS * (1.0 + abs(rod.u0) + rod.omega * at)
        assert abs(frames.tangent[i, 1] - mp.sin(psi)) <= 8 * EPS * (1.0 + abs(rod.u0) + rod.omega * at) * float(
            exact.k
        )
    assert np.all(frames.position[:, 2] == 0.0)
    assert np.array_equal(frames.binormal, np.tile([0.0, 0.0, 1.0], (23, 1)))
    # cos^2 + sin^2 is (dn^2 + m sn^2)^2 here, of sn and dn that are each good to 2 eps.
    assert np.abs(np.cross(frames.tangent, frames.normal) - frames.binormal).max() < 8 * EPS


@pytest.mark.parametrize("angle", [1.0, 20.0, 90.0, 130.7099, 170.0])
def test_pinned_arch_of_the_oracle(angle: float) -> None:
    """The oracle starts at (0, 0) and arches towards +y; the stretch from -K to K does so towards -y."""
    m, m1 = math.sin(math.radians(angle / 2)) ** 2, math.cos(math.radians(angle / 2)) ** 2
    rod = stretch(m, m1, -1.0, 1.0)
    s = np.linspace(0.0, 350.0, 29)
    expected = PinnedOracle(350.0, angle_deg=angle).points(s) * [1.0, -1.0]
    assert np.abs(rod.frames(s).position[:, :2] - expected).max() < 350.0 * 4 * EPS


@pytest.mark.parametrize(("m", "m1"), PARAMETERS)
@pytest.mark.parametrize(("begin", "end"), [(-5.0, 7.0), (0.37, 0.92)])
def test_curvature_derivatives(m: float, m1: float, begin: float, end: float) -> None:
    """Against mpmath's differences of the tangent's angle, each on the scale of its own amplitude."""
    rod = stretch(m, m1, begin, end)
    exact = Exact(rod)
    s = np.linspace(0.0, rod.length, 7)
    values = rod.bishop(s, 5)
    assert values.shape == (6, 7, 2)
    assert np.all(values[:, :, 1] == 0.0)
    for i, at in enumerate(s):
        for order in range(6):
            expected = mp.diff(exact.psi, mp.mpf(at), order + 1)
            scale = 2.0 * rod.k * rod.omega ** (order + 1)
            # The argument u0 + omega s is itself rounded; a derivative's own greatest value grows with its order.
            room = 4.0 * EPS * (1.0 + abs(rod.u0) + rod.omega * at) * (order + 1)
            assert abs(values[order, i, 0] - expected) <= room * scale, (order, at)


@pytest.mark.parametrize(("m", "m1"), PARAMETERS)
def test_first_integral(m: float, m1: float) -> None:
    """kappa^2 / 2 + n . t is the same all along, with n = -P e1; its value is P (2 m - 1)."""
    rod = stretch(m, m1, -5.0, 7.0)
    s = np.linspace(0.0, rod.length, 1001)
    kappa = rod.bishop(s, 0)[0, :, 0]
    energy = kappa**2 / 2.0 - rod.force * rod.frames(s).tangent[:, 0]
    assert np.abs(energy - rod.force * (rod.m - rod.m1)).max() < 8 * EPS * rod.force
    assert rod.force == rod.omega**2


@pytest.mark.parametrize(("m", "m1"), PARAMETERS)
@pytest.mark.parametrize(("begin", "end"), STRETCHES)
def test_position_is_the_integral_of_the_tangent(m: float, m1: float, begin: float, end: float) -> None:
    rod = stretch(m, m1, begin, end)
    panels = np.linspace(0.0, rod.length, 401)
    nodes, weights = np.polynomial.legendre.leggauss(12)
    middle, half = (panels[1:] + panels[:-1]) / 2.0, np.diff(panels)[:, None] / 2.0
    tangent = rod.frames((middle[:, None] + half * nodes).ravel()).tangent.reshape(400, 12, 3)
    integral = np.cumsum(np.einsum("pni,n->pi", tangent, weights) * half, axis=0)
    error = np.abs(integral - rod.frames(panels[1:]).position).max()
    # The tangent is off by eps (1 + |u|) and the sum of 400 panels by as many roundings.
    assert error < 16 * EPS * rod.length * (1.0 + abs(rod.u0) + rod.omega * rod.length)


@pytest.mark.parametrize(("m", "m1"), PARAMETERS)
def test_a_stretch_is_a_stretch_of_any_longer_one(m: float, m1: float) -> None:
    whole = stretch(m, m1, -3.0, 5.0)
    cut = 0.2371 * whole.length
    rest = Inflexional(FLAT, whole.length - cut, whole.omega, m, m1, whole.u0 + whole.omega * cut)
    at = whole.frames(np.array([cut]))
    moved = Inflexional(FLAT, rest.length, rest.omega, m, m1, rest.u0).frames(np.array([0.0, rest.length]))
    # Both lie with e1 along the compression, so the later part is the same curve but for a shift.
    shifted = moved.position + at.position
    room = 8 * EPS * (whole.length + (1.0 + abs(whole.u0)) / whole.omega)
    assert np.abs(shifted[1] - whole.frames(np.array([whole.length])).position[0]).max() < room
    assert np.abs(moved.tangent[0] - at.tangent[0]).max() < 16 * EPS * (1.0 + abs(whole.u0))


def test_placement_in_space() -> None:
    """e1 and e2 anywhere: the local curve comes back along them."""
    rng = np.random.default_rng(5)
    axes = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    place = Placement(rng.normal(size=3) * 100.0, axes[:, 0], axes[:, 1])
    flat = stretch(0.4, 0.6, -0.7, 2.1)
    placed = Inflexional(place, flat.length, flat.omega, flat.m, flat.m1, flat.u0)
    s = np.linspace(0.0, 350.0, 17)
    local, found = flat.frames(s), placed.frames(s)
    frame = np.stack([place.e1, place.e2, place.e3])
    assert np.abs(found.position - (place.origin + local.position @ frame)).max() < 1e-12 * 350.0
    for name in ("tangent", "normal", "binormal"):
        assert np.abs(getattr(found, name) - getattr(local, name) @ frame).max() < 8 * EPS


def sampled(rod: Inflexional) -> Array:
    return np.abs(rod.bishop(np.linspace(0.0, rod.length, 20_001), 0)[0, :, 0])


@pytest.mark.parametrize("seed", range(40))
def test_greatest_curvature_of_any_stretch(seed: int) -> None:
    rng = np.random.default_rng(seed)
    m, m1 = PARAMETERS[seed % len(PARAMETERS)]
    begin = rng.uniform(-6.0, 6.0)
    rod = stretch(m, m1, begin, begin + rng.uniform(0.05, 4.0))
    kappa, at = rod.greatest_curvature()
    assert 0.0 <= at <= rod.length
    assert abs(rod.bishop(np.array([at]), 0)[0, 0, 0]) == pytest.approx(kappa, rel=1e-13)
    dense = sampled(rod).max()
    # cn falls off a crest by (omega ds)^2 / 2 at most, ds half a step of the sampling.
    fall = (rod.omega * rod.length / 40_000) ** 2
    assert dense <= kappa * (1.0 + 8 * EPS)
    assert dense >= kappa * (1.0 - fall) - 1e-13 * kappa


@pytest.mark.parametrize("crest", [-4.0, -2.0, 0.0, 2.0, 6.0])
@pytest.mark.parametrize(("m", "m1"), PARAMETERS)
def test_greatest_curvature_at_an_end(m: float, m1: float, crest: float) -> None:
    """Crests that rounding may put just outside the stretch still count, and are said to stand at its end."""
    for begin, end, where in ((crest, crest + 1.5, 0.0), (crest - 1.5, crest, 350.0)):
        rod = stretch(m, m1, begin, end)
        kappa, at = rod.greatest_curvature()
        assert kappa == pytest.approx(2.0 * rod.k * rod.omega, rel=1e-12)
        assert at == pytest.approx(where, abs=1e-9)


@pytest.mark.parametrize("order", [1, 4, 12])
def test_turns_are_derivatives_of_the_tangent(order: int) -> None:
    """By the frame's equation z' = i kappa z, from the derivatives of the curvature."""
    s = np.linspace(0.0, 5.0, 7)
    pieces: list[Piece] = [Inflexional(FLAT, 5.0, 0.7, 0.6, 0.4, -1.1), Arc(FLAT, 5.0, -0.3), Line(FLAT, 5.0)]
    for piece in pieces:
        turns = piece.turns(s, order)
        kappa = piece.bishop(s, order)[:, :, 0] * 5.0 ** np.arange(1.0, order + 2)[:, None]
        assert turns is not None
        assert turns.shape == (order + 1, 7)
        assert np.abs(turns[0] - 1.0).max() < 4 * EPS
        for n in range(order):
            expected = 1j * sum(math.comb(n, j) * kappa[j] * turns[n - j] for j in range(n + 1))
            assert np.abs(turns[n + 1] - expected).max() <= 1e-13 * max(1.0, float(np.abs(expected).max()))
