"""Colours out of the atlas and into the image: all channels at once in one packed number."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim2d.atlas import LEVELS
from sim2d.canvas import TEXELS

SHIFT = np.uint64(21)  # between the channels of a packed colour
LANE = np.uint64((1 << 21) - 1)
WHITE = np.int64(255)
HALF = 1 << 23  # a half, for rounding


@njit(cache=True, error_model="numpy")
def level_at(footprint: float) -> int:
    """Return the resolution level at which a texel is about as big as a pixel's footprint [m]."""
    level, size = 0, footprint * TEXELS
    while size > 1.5 and level < LEVELS - 1:
        size *= 0.5
        level += 1
    return level


@njit(cache=True, error_model="numpy")
def blend(texels: NDArray[np.uint64], a: int, b: int, v: float, nv: int, wu: int) -> np.uint64:
    """Return the packed bilinear colour, times 4096, at row v of a tile, between its columns that begin at a and b;
    wu in 0..64 is b's share."""
    q = min(max(int(v * 64.0), 0), (nv - 1) * 64 - 1) if nv > 1 else 0
    j, wv = q >> 6, q & 63
    k = j + 1 if nv > 1 else j
    mixed: np.uint64 = (
        texels[a + j] * np.uint64((64 - wu) * (64 - wv))
        + texels[a + k] * np.uint64((64 - wu) * wv)
        + texels[b + j] * np.uint64(wu * (64 - wv))
        + texels[b + k] * np.uint64(wu * wv)
    )
    return mixed


@njit(cache=True, error_model="numpy")
def ground_colour(texels: NDArray[np.uint64], base: int, n: int, x: float, y: float) -> np.uint64:
    """Return the packed colour of a floor or ceiling at x, y [tiles]; n texels to a tile."""
    fine = n * 64
    u = int((x - np.floor(x)) * fine) + fine - 32
    i = u >> 6
    i = i - n if i >= n else i
    k = i + 1 if i + 1 < n else 0
    mixed: np.uint64 = blend(texels, base + n * i, base + n * k, (y - np.floor(y)) * n - 0.5, n, u & 63)
    return mixed


@njit(cache=True, error_model="numpy")
def put(pixels: NDArray[np.uint8], p: int, colour: np.uint64, factor: float) -> None:
    """Store a packed colour times a factor at entry p."""
    f = int(factor * 4096.0)
    for c in range(3):
        pixels[p + c] = np.uint8(min(WHITE, (np.int64(colour & LANE) * f + HALF) >> 24))
        colour >>= SHIFT


@njit(cache=True, error_model="numpy")
def put_both(
    pixels: NDArray[np.uint8], p: int, colour: np.uint64, factor: float, other: np.uint64, share: float
) -> None:
    """Store the sum of two packed colours, each times its factor, at entry p."""
    f, g = int(factor * 4096.0), int(share * 4096.0)
    for c in range(3):
        level = np.int64(colour & LANE) * f + np.int64(other & LANE) * g + HALF
        pixels[p + c] = np.uint8(min(WHITE, level >> 24))
        colour >>= SHIFT
        other >>= SHIFT
