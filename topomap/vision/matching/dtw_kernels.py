"""Dynamic time warping of two sequences, compiled: the same input gives the same bits."""

from __future__ import annotations

import numpy as np
from numba import njit

from topomap.core.arrays import Float32Array, FloatArray, Int8Array, IntArray


@njit(cache=True)
def _dtw_table(home: Float32Array, current: Float32Array, band: int) -> tuple[Int8Array, float]:
    """Return which step led to each cell, (L, 2 band + 1), 0 both on, 1 home on, 2 current on, and the last cell's
    summed difference.
    """
    features, length = home.shape
    width = 2 * band + 1
    step = np.zeros((length, width), np.int8)
    before = np.full(width + 1, np.inf, np.float32)
    local = np.empty(width, np.float32)
    least = np.empty(width, np.float32)
    for i in range(length):
        low, high = max(0, band - i), min(width, length - i + band)
        local[:] = 0.0
        for f in range(features):
            value = home[f, i]
            ahead = current[f, i + low - band : i + high - band]
            near = local[low:high]
            for o in range(len(ahead)):
                near[o] += abs(value - ahead[o])
        for o in range(low, high):
            least[o] = before[o + 1] if before[o + 1] < before[o] else before[o]
            step[i, o] = 1 if before[o + 1] < before[o] else 0
        if i == 0:
            least[band] = 0.0
            step[0, band] = 0
        left = np.float32(np.inf)
        before[:] = np.inf
        for o in range(low, high):
            step[i, o] = 2 if left < least[o] else step[i, o]
            left = (left if left < least[o] else least[o]) + local[o]
            before[o] = left
    return step, float(before[band])


@njit(cache=True)
def dtw_path(home: Float32Array, current: Float32Array, band: int) -> tuple[FloatArray, float]:
    """Match two sequences (F, L) by dynamic time warping within |i - j| <= band (Sakoe, Chiba 1978).

    Returns for each home index the mean of the matched current indices minus itself (L,), and the path's
    cost: the sum of absolute differences along it per step and feature.
    """
    step, total = _dtw_table(home, current, band)
    rows, offsets = _walked_back(step, band)
    shift, count = np.zeros(len(step)), np.zeros(len(step))
    for k in range(len(rows)):
        shift[rows[k]] += offsets[k]
        count[rows[k]] += 1.0
    return shift / count, total / home.shape[0] / len(rows)


@njit(cache=True)
def dtw_pairs(home: Float32Array, current: Float32Array, band: int) -> tuple[IntArray, IntArray, FloatArray, float]:
    """Match as `dtw_path` does; return every matched pair, home and current indices (M,), from the end, their
    difference (M,) per feature, and the path's cost.
    """
    step, total = _dtw_table(home, current, band)
    rows, offsets = _walked_back(step, band)
    unlike = np.zeros(len(rows))
    for k in range(len(rows)):
        for f in range(home.shape[0]):
            unlike[k] += abs(home[f, rows[k]] - current[f, rows[k] + offsets[k]])
    return rows, rows + offsets, unlike / home.shape[0], total / home.shape[0] / len(rows)


@njit(cache=True)
def _walked_back(step: Int8Array, band: int) -> tuple[IntArray, IntArray]:
    """Return the path's home indices and shifts, from the end."""
    length = step.shape[0]
    rows, offsets = np.empty(2 * length, np.int64), np.empty(2 * length, np.int64)
    i, o, steps = length - 1, band, 0
    while True:
        rows[steps], offsets[steps] = i, o - band
        steps += 1
        if i == 0 and o == band:
            return rows[:steps], offsets[:steps]
        way = step[i, o]
        if way == 1:
            i, o = i - 1, o + 1
        elif way == 2:
            o -= 1
        else:
            i -= 1
