"""How alike two pictures are: in structure, not pixel by pixel."""

from __future__ import annotations

from pathlib import Path

import numpy as np


def load(path: Path) -> np.ndarray:
    """Red, green and blue from 0 to 1, shape (height, width, 3)."""
    from matplotlib.image import imread

    return np.asarray(imread(path), dtype=float)[:, :, :3]


def reduced(pixels: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """The means of fields, `size` wide and high, into which the picture must divide."""
    (height, width), (columns, rows) = pixels.shape[:2], size
    assert width % columns == height % rows == 0
    return pixels.reshape(rows, height // rows, columns, width // columns, 3).mean(axis=(1, 3))


def likeness(one: np.ndarray, other: np.ndarray, size: tuple[int, int] = (80, 50)) -> float:
    """Correlation of the two, made small: of how they differ from their ground, in all colours; 1 for equal ones."""
    a, b = (reduced(pixels, size) for pixels in (one, other))
    a, b = (small - np.median(small, axis=(0, 1)) for small in (a, b))
    return float((a * b).sum() / np.sqrt((a**2).sum() * (b**2).sum()))


def near(pixels: np.ndarray, color: str, within: float = 0.06) -> np.ndarray:
    """Where a picture has a colour ``#rrggbb``, shape (height, width)."""
    wanted = np.array(list(bytes.fromhex(color[1:7]))) / 255.0
    return np.abs(pixels - wanted).max(axis=2) < within
