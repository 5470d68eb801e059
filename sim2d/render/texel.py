"""Colours out of the atlas and into the image: all channels at once in one packed number, scaled by integer weights."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim2d.render.atlas import LEVELS
from sim2d.render.canvas import TEXELS
from sim2d.render.kernel import kernel

ONE = 4096  # the weight that leaves a colour as it is; of brighter texels (up to twice white) 21 bits are just filled
LANE = np.uint64((1 << 21) - 1)  # a channel of a packed colour
THIN = np.uint64(0x7FFF | 0x7FFF << 21 | 0x7FFF << 42)  # three channels of 15 bits
TONES = 4096  # entries of a tone curve: eighths of a grey level


@kernel
def level_at(footprint: float) -> int:
    """Return the resolution level at which a texel is about as big as a pixel's footprint [m]."""
    level, size = 0, footprint * TEXELS
    while size > 1.5 and level < LEVELS - 1:
        size *= 0.5
        level += 1
    return level


@kernel
def blend(texels: NDArray[np.uint64], a: int, b: int, q: int, wu: int, weight: int) -> np.uint64:
    """Return the packed bilinear colour times `weight` (of 4096), at q/64 texels along two columns of a tile.

    Entries a and b begin the columns; wu in 0..64 is b's share.
    """
    j, wv = q >> 6, q & 63
    right = (weight * wu) >> 6
    left = weight - right
    right_high, left_high = (right * wv) >> 6, (left * wv) >> 6
    mixed: np.uint64 = (
        texels[np.uint64(a + j)] * np.uint64(left - left_high)
        + texels[np.uint64(a + j + 1)] * np.uint64(left_high)
        + texels[np.uint64(b + j)] * np.uint64(right - right_high)
        + texels[np.uint64(b + j + 1)] * np.uint64(right_high)
    )
    return mixed


@kernel
def along_v(v: float, nv: int) -> int:
    """Return row v of a tile in 64ths, held within it, so that the next row is there as well."""
    return min(max(int(v * 64.0), 0), (nv - 1) * 64 - 1)


@kernel
def ground_colour(texels: NDArray[np.uint64], base: int, n: int, x: float, y: float, weight: int) -> np.uint64:
    """Return the packed colour of a floor or ceiling at x, y [tiles] times `weight`; n texels to a tile."""
    u = int((x - np.floor(x)) * (n * 64)) + n * 64 - 32
    i = u >> 6
    i = i - n if i >= n else i
    k = i + 1 if i + 1 < n else 0
    q = along_v((y - np.floor(y)) * n - 0.5, n)
    mixed: np.uint64 = blend(texels, base + n * i, base + n * k, q, u & 63, weight)
    return mixed


@kernel
def put(pixels: NDArray[np.uint8], p: int, colour: np.uint64, tones: NDArray[np.uint8]) -> None:
    """Store a packed weighted colour at entry p, through the tone curves (3 x 4096,)."""
    low = np.uint64(9)
    pixels[np.uint64(p)] = tones[(colour & LANE) >> low]
    pixels[np.uint64(p + 1)] = tones[np.uint64(TONES) + ((colour >> np.uint64(21) & LANE) >> low)]
    pixels[np.uint64(p + 2)] = tones[np.uint64(2 * TONES) + ((colour >> np.uint64(42) & LANE) >> low)]
