"""PNG files: read by another program they are the picture."""

from __future__ import annotations

import io

import numpy as np
import pytest

from cablecad.picture.palette import OKABE_ITO, bend_color, paled, rgb
from cablecad.picture.png import png_bytes
from cablecad.picture.round_number import round_below, significant

image = pytest.importorskip("matplotlib.image")


@pytest.mark.parametrize("shape", [(1, 1), (7, 5), (40, 61)])
def test_there_and_back(shape):
    pixels = np.random.default_rng(7).integers(0, 256, (*shape, 3), dtype=np.uint8)
    pixels[: shape[0] // 2] = np.arange(shape[1])[None, :, None]  # also something a filter can make small
    found = image.imread(io.BytesIO(png_bytes(pixels)))
    np.testing.assert_array_equal(np.rint(found[:, :, :3] * 255.0).astype(np.uint8), pixels)


def test_filters_make_it_small():
    slope = np.broadcast_to(np.arange(256, dtype=np.uint8)[None, :, None], (256, 256, 3))
    assert len(png_bytes(slope)) < 1500


def test_bend_colours_are_viridis_from_light_to_dark():
    colormaps = pytest.importorskip("matplotlib").colormaps
    share = np.linspace(0.0, 1.0, 101)
    np.testing.assert_allclose(
        bend_color(share), colormaps["viridis"](1.0 - share)[:, :3], atol=0.06
    )  # eleven of its colours, straight between them
    brightness = bend_color(share) @ [0.2126, 0.7152, 0.0722]
    assert (np.diff(brightness) < 0.0).all()  # readable in grey


def test_cable_colours_differ_for_the_colour_blind():
    """Seen without red or without green cones: Machado, Oliveira, Fernandes 2009, severity 1, linear light."""
    protan = [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]]
    deutan = [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]
    linear = np.array([rgb(color) for color in OKABE_ITO]) ** 2.2
    for kind in (np.eye(3), np.array(protan), np.array(deutan)):
        seen = np.clip(linear @ np.asarray(kind).T, 0.0, 1.0) ** (1.0 / 2.2)
        apart = np.linalg.norm(seen[:, None] - seen[None], axis=2) + 9.0 * np.eye(len(seen))
        assert apart.min() > 0.12


def test_paled_goes_towards_the_ground():
    assert paled((0.0, 0.0, 0.0), 0.0) == (0.0, 0.0, 0.0)
    assert paled((0.2, 0.4, 0.6), 1.0) == pytest.approx(rgb("#f6f7f9"))


@pytest.mark.parametrize(
    ("value", "below"), [(1.0, 1.0), (0.99, 0.5), (49.999, 20.0), (50.0, 50.0), (3e-7, 2e-7), (7e8, 5e8)]
)
def test_round_lengths(value, below):
    assert round_below(value) == pytest.approx(below, rel=1e-12)


@pytest.mark.parametrize(
    ("value", "words"), [(12961.7, "12960"), (1.0, "1"), (0.00164, "0.00164"), (2.5e-9, "2.5e-09")]
)
def test_measured_numbers(value, words):
    assert significant(value) == words
