"""Differences of two rings at every shift, compiled: the same input gives the same bits."""

from __future__ import annotations

import numpy as np
from numba import njit

from topomap.core.arrays import Float32Array, FloatArray


@njit(cache=True)
def absolute_differences(current: Float32Array, goal: Float32Array) -> FloatArray:
    """Return the mean absolute difference (C,) of goal (R, C) and current (R, C) rolled by 0, 1, .. C-1
    columns.
    """
    rows, columns = goal.shape
    total = np.zeros(columns, np.float32)
    twice = np.empty(2 * columns, np.float32)
    for r in range(rows):
        for j in range(2 * columns):
            twice[j] = current[r, (2 * columns - j) % columns]
        for i in range(columns):
            value = goal[r, i]
            turned = twice[columns - i : 2 * columns - i]
            for k in range(columns):
                total[k] += abs(value - turned[k])
    mean: FloatArray = total.astype(np.float64) / (rows * columns)
    return mean


@njit(cache=True)
def block_differences(home: Float32Array, current: Float32Array, reach: int, half: int) -> Float32Array:
    """Return the summed difference (L, 2 reach + 1) of the windows i +- half of two rings (F, L) at shifts
    -reach .. reach of the current one.
    """
    features, length = home.shape
    shifts = 2 * reach + 1
    around = np.empty(length + 2 * reach, np.float32)
    single = np.zeros((length, shifts), np.float32)
    for f in range(features):
        for j in range(length + 2 * reach):
            around[j] = current[f, (j - reach) % length]
        for i in range(length):
            value = home[f, i]
            row, ahead = single[i], around[i : i + shifts]
            for s in range(shifts):
                row[s] += abs(value - ahead[s])
    summed = np.zeros((length, shifts), np.float32)
    for i in range(length):
        row = summed[i]
        for k in range(i - half, i + half + 1):
            one = single[k % length]
            for s in range(shifts):
                row[s] += one[s]
    return summed
