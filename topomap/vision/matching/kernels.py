"""The few hot loops, compiled; each adds in a fixed order, so the same input gives the same bits."""

from __future__ import annotations

import numpy as np
from numba import njit

from topomap.core.arrays import Complex64Array, Float32Array, FloatArray, Int8Array, IntArray


@njit(cache=True)
def spectra_products(spectra: Complex64Array, conjugate: Complex64Array) -> Complex64Array:
    """Return the sum over rows of spectra (N, R, F) times conjugate (R, F): (N, F).

    Real and imaginary parts apart: the compiler then takes eight lines at once, and the bits stay the same.
    """
    count, rows, lines = spectra.shape
    products = np.empty((count, lines), np.complex64)
    real, imaginary = np.empty(lines, np.float32), np.empty(lines, np.float32)
    for n in range(count):
        real[:], imaginary[:] = 0.0, 0.0
        for r in range(rows):
            for f in range(lines):
                a, b = spectra[n, r, f], conjugate[r, f]
                real[f] += a.real * b.real - a.imag * b.imag
                imaginary[f] += a.real * b.imag + a.imag * b.real
        for f in range(lines):
            products[n, f] = complex(real[f], imaginary[f])
    return products


@njit(cache=True)
def spectra_powers(spectra: Complex64Array, columns: int) -> FloatArray:
    """Return each picture's mean power (N,) from its half spectrum (R, F): every line but the first and the Nyquist
    line counts twice (Parseval).
    """
    count, rows, lines = spectra.shape
    powers = np.zeros(count)
    single = lines - 1 if columns % 2 == 0 else lines
    for n in range(count):
        for r in range(rows):
            for f in range(lines):
                value = spectra[n, r, f]
                energy = value.real * value.real + value.imag * value.imag
                powers[n] += energy if f == 0 or f == single else 2.0 * energy
        powers[n] /= rows * columns * columns
    return powers


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
