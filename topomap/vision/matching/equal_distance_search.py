"""Warping under equal distances: direction, rotation and relative step that warp the goal into the current view."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numba import njit

from topomap.core.arrays import Float32Array, FloatArray, IntArray
from topomap.core.geometry import TAU
from topomap.vision.matching.warping import WarpingCost


@dataclass(frozen=True, slots=True)
class Steps:
    """The relative steps rho = step / distance that are tried: count of them, evenly from 0 up to `largest` < 1."""

    count: int = 11
    largest: float = 0.75


def flow(x: FloatArray, rho: float) -> FloatArray:
    """Return how far landmarks at x [rad] from the step's direction move [rad]: the exact flow of METHODS.md."""
    return np.asarray(np.arctan2(rho * np.sin(x), 1.0 - rho * np.cos(x)), np.float64)


@lru_cache(maxsize=8)
def tables(n: int, phases: int, levels: int, step: float, steps: Steps) -> tuple[IntArray, IntArray]:
    """Return for each rho and x [columns] the shift [columns] and the scale plane, (K, n) each.

    The magnification is r_goal / r_current = 1 / |u - rho b|; levels 0: one plane per phase.
    """
    x = np.arange(n, dtype=np.float64) * (TAU / n)
    shifts, planes = np.zeros((2, steps.count, n), np.int64)
    for k in range(steps.count):
        rho = steps.largest * k / (steps.count - 1)
        fine = np.rint(flow(x, rho) * n * phases / TAU).astype(np.int64)
        shifts[k] = fine // phases
        closer = -0.5 * np.log(1.0 - 2.0 * rho * np.cos(x) + rho * rho)
        scale = np.clip(np.rint(closer / math.log(step)), -levels, levels).astype(np.int64) + levels
        planes[k] = scale * phases + fine % phases
    return shifts, planes


@njit(cache=True)
def equal_search(planes: Float32Array, shifts: IntArray, scales: IntArray, first: int, width: int) -> Float32Array:
    """Return the least mean cost (n, width) over rho, for each direction alpha and rotation first .. [columns].

    planes: as `warping_kernels.scale_planes` makes them.
    """
    n = planes.shape[1]
    count = shifts.shape[0]
    least = np.full((n, width), np.inf, np.float32)
    total = np.empty(width, np.float32)
    for a in range(n):
        for k in range(count):
            total[:] = 0.0
            for i in range(n):
                x = (i - a) % n
                start = (first - i - shifts[k, x]) % n
                row = planes[scales[k, x], i, start : start + width]
                for p in range(width):
                    total[p] += row[p]
            for p in range(width):
                mean = total[p] / np.float32(n)
                least[a, p] = mean if mean < least[a, p] else least[a, p]
    return least


def found(cost: Float32Array, first: int, first_bearing: float, seen: bool) -> WarpingCost:
    """Return the search's outcome in min-warping's terms."""
    return WarpingCost(cost, first, float(cost.mean(dtype=np.float64)) if seen else 0.0, first_bearing)
