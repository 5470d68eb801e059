"""Min-warping's scale planes and its search, compiled: the same input gives the same bits."""

from __future__ import annotations

import numpy as np
from numba import njit

from topomap.core.arrays import Float32Array, IntArray


@njit(cache=True)
def scale_planes(
    goal: Float32Array, current: Float32Array, goal_sum: Float32Array, current_sum: Float32Array, floor: float
) -> Float32Array:
    """Return the scale-plane stack ((2 K + 1) P, n, 2 n) of two views' magnified columns (K + 1, P, R, n).

    P phases: the columns at n bearings, then at bearings 1/P column further on, and so on; plane p P + phase.
    Plane K + k compares goal columns magnified by step^k with current ones (k >= 0), or current ones
    magnified by step^-k with goal ones (k < 0), by NSAD: sum |a - b| / (sum |a| + sum |b| + floor). The last
    axis runs over *minus* the current column, twice around, so that a search over rotations reads it forwards
    without wrapping.
    """
    levels, phases, rows, n = goal.shape
    planes = np.empty(((2 * levels - 1) * phases, n, 2 * n), np.float32)
    total = np.empty(n, np.float32)
    for plane in range(2 * levels - 1):
        a = max(plane - levels + 1, 0)
        b = max(levels - 1 - plane, 0)
        for phase in range(phases):
            for i in range(n):
                total[:] = 0.0
                for r in range(rows):
                    value = goal[a, 0, r, i]
                    for j in range(n):
                        total[j] += abs(value - current[b, phase, r, j])
                for m in range(n):
                    j = (n - m) % n
                    size = goal_sum[a, 0, i] + current_sum[b, phase, j] + floor
                    nsad = total[j] / size if size > 1e-6 else 1.0
                    planes[plane * phases + phase, i, m] = nsad
                    planes[plane * phases + phase, i, m + n] = nsad
    return planes


@njit(cache=True)
def warping_search(
    planes: Float32Array,
    shifts: IntArray,
    scales: IntArray,
    counts: IntArray,
    alphas: IntArray,
    first: int,
    width: int,
) -> Float32Array:
    """Return min-warping's cost (A, width) over alphas (A,) and rotations first .. first + width - 1, in
    columns.

    shifts, scales (n, T), counts (n,): for each x = theta - alpha the shifts y that a landmark may have moved
    by, with the plane of its magnification.
    """
    n = planes.shape[1]
    cost = np.zeros((len(alphas), width), np.float32)
    least = np.empty(width, np.float32)
    for i in range(n):
        for a in range(len(alphas)):
            x = (i - alphas[a]) % n
            least[:] = 2.0
            for t in range(counts[x]):
                start = (first - i - shifts[x, t]) % n
                row = planes[scales[x, t], i, start : start + width]
                for p in range(width):
                    value = row[p]
                    least[p] = value if value < least[p] else least[p]
            for p in range(width):
                cost[a, p] += least[p]
    return cost / np.float32(n)
