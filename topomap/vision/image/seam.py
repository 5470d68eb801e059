"""A line once around a ring of columns that is as sure and as smooth as can be, by dynamic programming."""

from __future__ import annotations

import numpy as np
from numba import njit

from topomap.core.arrays import FloatArray, IntArray

REACH = 2  # rows that the line may bend from one column to the next


@njit(cache=True)
def seam(score: FloatArray, bend: float, jump: float) -> IntArray:
    """Return the row (W,) in each column of score (R, W) along the best line.

    bend: what each row up or down costs; jump: what going on at any other row costs. The line is followed three times
    around, so that the second round neither begins nor ends anywhere.
    """
    rows, columns = score.shape
    total, before = np.zeros(rows), score[:, 0].copy()
    came = np.empty((3 * columns, rows), np.int64)
    for step in range(1, 3 * columns):
        best = int(np.argmax(before))
        for r in range(rows):
            value, source = before[r], r
            for other in range(max(r - REACH, 0), min(r + REACH + 1, rows)):
                there = before[other] - bend * abs(other - r)
                if there > value:
                    value, source = there, other
            if before[best] - jump > value:
                value, source = before[best] - jump, best
            came[step, r] = source
            total[r] = value + score[r, step % columns]
        before[:] = total
    path = np.empty(columns, np.int64)
    row = int(np.argmax(before))
    for step in range(3 * columns - 1, columns - 1, -1):
        if step < 2 * columns:
            path[step - columns] = row
        row = came[step, row]
    return path
