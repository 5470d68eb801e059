"""The hot loops of predicting views from beside a place: the same numbers as written out in numpy, in one pass."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from topomap.core.arrays import Float32Array, FloatArray


@njit(cache=True)
def between(values: FloatArray, angles: FloatArray) -> FloatArray:
    """Return values (D, n), given evenly all round from angle 0, at angles (D, n) [rad], linearly."""
    views, count = values.shape
    scale = count / (2.0 * math.pi)
    result = np.empty((views, count))
    for d in range(views):
        for c in range(count):
            place = angles[d, c] * scale
            low = np.floor(place)
            left = int(low) % count
            right = left + 1 if left + 1 < count else 0
            here = values[d, left]
            result[d, c] = here + (place - low) * (values[d, right] - here)
    return result


@njit(cache=True)
def pixel_maps(across: FloatArray, growth: FloatArray, rows: int, horizon: float) -> tuple[Float32Array, Float32Array]:
    """Return where pixels (D rows, C) come from, columns and rows: a column (D, C) keeps its, the distance from the
    horizon grows (D, C).
    """
    views, columns = across.shape
    x, y = np.empty((views * rows, columns), np.float32), np.empty((views * rows, columns), np.float32)
    for d in range(views):
        for r in range(rows):
            below = r - horizon
            for c in range(columns):
                x[d * rows + r, c] = across[d, c]
                y[d * rows + r, c] = horizon + below * growth[d, c]
    return x, y
