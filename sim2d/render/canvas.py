"""A picture under construction: float rows from the top down, drawn in metres."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from sim2d.shapes import Colour

Canvas = NDArray[np.float32]
TEXELS = 50.0  # per metre: 2 cm each


def blank(length: float, height: float, colour: Colour) -> Canvas:
    """Return a canvas (V, U, 3) of length x height [m] in one colour."""
    shape = (max(2, round(height * TEXELS)), max(2, round(length * TEXELS)))
    return np.tile(np.asarray(colour, dtype=np.float32), (*shape, 1))


def clouds(rng: np.random.Generator, canvas: Canvas, size: float) -> NDArray[np.float32]:
    """Return smooth noise (V, U, 1) of about unit range, with blotches of `size` [m], closed along u."""
    v, u = canvas.shape[:2]
    cells = max(2, round(u / TEXELS / size)), max(2, round(v / TEXELS / size) + 1)
    grid = rng.uniform(-1, 1, (cells[1], cells[0])).astype(np.float32)
    ring = np.concatenate([grid[:, -1:], grid, grid[:, :1]], axis=1)
    pad = max(1, round(u / cells[0]))
    wide = cv2.resize(ring, (u + 2 * pad, v), interpolation=cv2.INTER_CUBIC)
    return np.asarray(wide, dtype=np.float32)[:, pad : pad + u, None]


def rectangle(canvas: Canvas, x: tuple[float, float], z: tuple[float, float], colour: Colour) -> None:
    """Fill x[0]..x[1], z[0]..z[1] [m, z up from the canvas's foot] with a colour."""
    v, u = canvas.shape[:2]
    i0, i1 = (min(max(round(value * TEXELS), 0), u) for value in x)
    j1, j0 = (min(max(v - round(value * TEXELS), 0), v) for value in z)
    canvas[j0:j1, i0:i1] = np.asarray(colour, dtype=np.float32)


def disc(canvas: Canvas, x: float, z: float, radius: float, colour: Colour) -> None:
    """Fill a disc [m]."""
    centre = round((x * TEXELS - 0.5) * 16), round((canvas.shape[0] - z * TEXELS - 0.5) * 16)
    cv2.circle(canvas, centre, round(radius * TEXELS * 16), colour, cv2.FILLED, shift=4)


def shade(colour: Colour, factor: float) -> Colour:
    """Return a colour made darker or brighter."""
    r, g, b = (min(1.0, c * factor) for c in colour)
    return r, g, b


def hue(rng: np.random.Generator, low: float = 0.1, high: float = 0.9) -> Colour:
    """Return a random colour with channels in [low, high]."""
    r, g, b = rng.uniform(low, high, 3)
    return float(r), float(g), float(b)
