"""PNG files out: small, and the same bytes for the same picture.

Source: PNG (Portable Network Graphics) Specification, 3rd edition, W3C.
"""

from __future__ import annotations

import struct
import zlib

import numpy as np
from numpy.typing import NDArray

Pixels = NDArray[np.uint8]

_BAND = 128
"""Rows worked on at once."""


def png_bytes(pixels: Pixels) -> bytes:
    """A picture of shape (height, width, 3), row by row from the top, as a PNG file."""
    height, width, _ = pixels.shape
    packer, parts = zlib.compressobj(9), []
    above = np.zeros((1, width * 3), dtype=np.int16)
    for first in range(0, height, _BAND):  # of a large picture all differences at once would take gigabytes
        rows = pixels[first : first + _BAND].reshape(-1, width * 3).astype(np.int16)
        parts.append(packer.compress(_filtered(rows, above).tobytes()))
        above = rows[-1:]
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    data = b"".join((*parts, packer.flush()))
    chunks = ((b"IHDR", header), (b"sRGB", b"\0"), (b"IDAT", data), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(_chunk(kind, body) for kind, body in chunks)


def _filtered(flat: NDArray[np.int16], before: NDArray[np.int16]) -> NDArray[np.uint8]:
    """Rows as differences, each with the number of its filter first; `before` is the row before them."""
    height, width = flat.shape
    left, corner = np.zeros_like(flat), np.zeros_like(flat)
    above = np.concatenate([before, flat[:-1]])
    left[:, 3:], corner[:, 3:] = flat[:, :-3], above[:, :-3]
    guess = left + above - corner
    far = np.stack([np.abs(guess - near) for near in (left, above, corner)])
    nearest = np.argmin(far, axis=0)  # the first of equals, as the standard wants it
    paeth = np.where(nearest == 0, left, np.where(nearest == 1, above, corner))
    rows = np.stack([(flat - by) & 255 for by in (np.zeros_like(flat), left, above, (left + above) >> 1, paeth)])
    # The usual guess at what compresses best: the filter whose differences are smallest.
    costs = np.minimum(rows, 256 - rows).sum(axis=2, dtype=np.int64)
    chosen = np.argmin(costs, axis=0)
    filtered = np.empty((height, 1 + width), dtype=np.uint8)
    filtered[:, 0] = chosen
    filtered[:, 1:] = rows[chosen, np.arange(height)]
    return filtered


def _chunk(kind: bytes, body: bytes) -> bytes:
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
