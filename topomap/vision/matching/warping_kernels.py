"""Min-warping's scale planes and its search, compiled: the same input gives the same bits."""

from __future__ import annotations

import numpy as np
from numba import njit

from topomap.core.arrays import Float32Array, Int32Array, IntArray


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
    by_four = rows - rows % 4
    for plane in range(2 * levels - 1):
        a = max(plane - levels + 1, 0)
        b = max(levels - 1 - plane, 0)
        seen = goal[a, 0]
        for phase in range(phases):
            other = current[b, phase]
            for i in range(n):
                total[:] = 0.0
                for r in range(0, by_four, 4):  # four rows at once, added one by one: the total stays in a register
                    v0, v1, v2, v3 = seen[r, i], seen[r + 1, i], seen[r + 2, i], seen[r + 3, i]
                    o0, o1, o2, o3 = other[r], other[r + 1], other[r + 2], other[r + 3]
                    for j in range(n):
                        total[j] = total[j] + abs(v0 - o0[j]) + abs(v1 - o1[j]) + abs(v2 - o2[j]) + abs(v3 - o3[j])
                for r in range(by_four, rows):
                    value = seen[r, i]
                    for j in range(n):
                        total[j] += abs(value - other[r, j])
                for j in range(n):
                    size = goal_sum[a, 0, i] + current_sum[b, phase, j] + floor
                    total[j] = total[j] / size if size > 1e-6 else 1.0
                row = planes[plane * phases + phase, i]
                row[0] = total[0]
                for m in range(1, n):
                    row[m] = total[n - m]
                row[n:] = row[:n]
    return planes


WORST = 0x40000000
"""The bits of 2.0. Costs aren't negative, and such floats are ordered as their bits are: the least of eight integers
takes one instruction, that of floats, one of which might be none, eight."""


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
    bits = planes.view(np.int32)
    cost = np.zeros((len(alphas), width), np.float32)
    least = np.empty(width, np.int32)
    found = least.view(np.float32)
    for i in range(n):
        for a in range(len(alphas)):
            x = (i - alphas[a]) % n
            least[:] = WORST
            for t in range(counts[x]):
                start = (first - i - shifts[x, t]) % n
                row = bits[scales[x, t], i, start : start + width]
                for p in range(width):
                    least[p] = min(row[p], least[p])
            for p in range(width):
                cost[a, p] += found[p]
    return cost / np.float32(n)


@njit(cache=True)
def _by_rotation(bits: Int32Array) -> Int32Array:
    """Return planes (P, n, 2 n) as rows (P, 2 n n) by minus the current column plus the goal column, twice around."""
    count, n = bits.shape[0], bits.shape[1]
    rows = np.empty((count, 2 * n, n), np.int32)
    for k in range(count):
        for i in range(n):
            for u in range(n):
                rows[k, u, i] = rows[k, u + n, i] = bits[k, i, u - i + n]
    return rows.reshape(count, 2 * n * n)


@njit(cache=True)
def whole_search(
    planes: Float32Array, shifts: IntArray, scales: IntArray, counts: IntArray, first: int, width: int
) -> Float32Array:
    """Return what `warping_search` does over all alphas, the same bits (n, width), four times as fast.

    One x is taken for all goal columns and rotations at once, which lie side by side; sums run in the same order.
    """
    n = planes.shape[1]
    rows = _by_rotation(planes.view(np.int32))
    size = width * n
    least = np.empty(size, np.int32)
    of_column = np.empty((n, size), np.int32)
    for x in range(n):
        least[:] = WORST
        for t in range(counts[x]):
            begin = ((first - shifts[x, t]) % n) * n
            row = rows[scales[x, t], begin : begin + size]
            for q in range(size):
                least[q] = min(row[q], least[q])
        for p in range(width):
            for i in range(n):
                a = i - x if i >= x else i - x + n
                of_column[i, p * n + a] = least[p * n + i]
    found = of_column.view(np.float32)
    cost = np.zeros(size, np.float32)
    for i in range(n):
        for q in range(size):
            cost[q] += found[i, q]
    return np.ascontiguousarray((cost / np.float32(n)).reshape(width, n).T)
