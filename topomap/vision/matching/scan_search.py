"""Where one range scan lies in another, sought over the whole neighbourhood (Olson 2009: correlative matching)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit

from topomap.core.arrays import Float32Array, FloatArray


@dataclass(frozen=True, slots=True)
class SearchSpec:
    """The search: reach [m] of it, cell [m] of the coarse grid, rays of each scan that are compared; step [rad] of the
    rotations; peaks, how many places are followed, and `rival`, the share of the best one's score that each needs.
    """

    reach: float = 6.0
    cell: float = 0.25
    rays: int = 72
    step: float = 0.13
    peaks: int = 2
    rival: float = 0.8


SEARCH = SearchSpec()
MOST_TABLE = 240
"""Cells to a side of the distance table: 60 m of 0.25 m cells, beyond which ranges tell little."""


@dataclass(frozen=True, slots=True)
class Place:
    """Where the second scan stands in the first one's frame: x, y [m], turn [rad], and the share of rays that fit."""

    x: float
    y: float
    turn: float
    score: float


def places(a: Float32Array, b: Float32Array, prior: float, window: float, spec: SearchSpec = SEARCH) -> list[Place]:
    """Return where scan b (W,) may stand in the frame of scan a (W,) [m], turned by prior +- window [rad], the best
    first.

    A place counts by both scans: what b sees must be there in a, and what a sees must be there in b.
    """
    found = [place for turn in _turns(prior, window, spec.step) for place in _turned_places(a, b, turn, spec)]
    found.sort(key=lambda place: -place.score)
    return [place for place in found[: spec.peaks] if place.score >= spec.rival * found[0].score]


def _turns(prior: float, window: float, step: float) -> list[float]:
    if window >= math.pi:
        count = math.ceil(math.tau / (2.0 * step))
        return [k * math.tau / count for k in range(count)]
    half = max(math.ceil(window / step), 0)
    return [prior + k * step for k in range(-half, half + 1)]


def _turned_places(a: Float32Array, b: Float32Array, turn: float, spec: SearchSpec) -> list[Place]:
    one, two = _points(a, spec.rays), _points(np.roll(b, round(turn * len(b) / math.tau)), spec.rays)
    if min(len(one), len(two)) < 3:
        return []
    steps = math.ceil(spec.reach / spec.cell)
    offsets = np.arange(-steps, steps + 1, dtype=np.float64) * spec.cell
    forth = _scores(_table(one, spec.cell), two, offsets, spec.cell)
    back = _scores(_table(two, spec.cell), one, offsets, spec.cell)[::-1, ::-1]
    return _peaks(0.5 * (forth + back), offsets, turn, spec.peaks)


def _points(ranges: Float32Array, rays: int) -> FloatArray:
    """Return about `rays` of a scan's points (N, 2) [m]."""
    chosen = np.linspace(0, len(ranges), min(rays, len(ranges)), endpoint=False).astype(np.intp)
    metres = ranges[chosen].astype(np.float64)
    good = np.isfinite(metres) & (metres > 0.0)
    angles = chosen[good] * (math.tau / len(ranges))
    return np.asarray(metres[good, np.newaxis] * np.column_stack([np.cos(angles), np.sin(angles)]), np.float64)


def _table(points: FloatArray, cell: float) -> FloatArray:
    """Return exp(-d^2/2 cell^2) (S, S) of the distance d to the nearest point at the cells around the scan."""
    half = min(math.ceil((float(np.abs(points).max()) + 1.0) / cell), MOST_TABLE // 2)
    return np.asarray(_nearness(points, half, cell), np.float64)


@njit(cache=True)
def _nearness(points: FloatArray, half: int, cell: float) -> FloatArray:
    size = 2 * half + 1
    table = np.zeros((size, size))
    for k in range(len(points)):
        i, j = round(points[k, 0] / cell) + half, round(points[k, 1] / cell) + half
        for di in range(-2, 3):
            for dj in range(-2, 3):
                if 0 <= i + di < size and 0 <= j + dj < size:
                    x, y = (i + di - half) * cell - points[k, 0], (j + dj - half) * cell - points[k, 1]
                    near = math.exp(-0.5 * (x * x + y * y) / (cell * cell))
                    table[i + di, j + dj] = max(table[i + di, j + dj], near)
    return table


@njit(cache=True)
def _scores(table: FloatArray, points: FloatArray, offsets: FloatArray, cell: float) -> FloatArray:
    """Return the mean nearness (S, S) of points (N, 2) moved by every pair of offsets (S,) [m]."""
    half, count = (len(table) - 1) // 2, len(points)
    found = np.zeros((len(offsets), len(offsets)))
    for k in range(count):
        for i in range(len(offsets)):
            row = round((points[k, 0] + offsets[i]) / cell) + half
            if row < 0 or row >= len(table):
                continue
            for j in range(len(offsets)):
                column = round((points[k, 1] + offsets[j]) / cell) + half
                if 0 <= column < len(table):
                    found[i, j] += table[row, column]
    return found / count


def _peaks(score: FloatArray, offsets: FloatArray, turn: float, count: int) -> list[Place]:
    left, found = score.copy(), []
    for _ in range(count):
        i, j = divmod(int(left.argmax()), score.shape[1])
        found.append(Place(float(offsets[i]), float(offsets[j]), turn, float(score[i, j])))
        left[max(i - 2, 0) : i + 3, max(j - 2, 0) : j + 3] = -1.0
    return found
