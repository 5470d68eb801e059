"""The shortest way for a round body on a true plan."""

from __future__ import annotations

import math

import cv2
import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from topomap.core.arrays import BoolArray, FloatArray, IntArray
from topomap.core.records import Plan

BODY = 0.2
"""[m] Radius of the robot's body."""
CELL, CELLS = 0.1, 400_000
"""[m] Size of a cell, and how many there are at most: a campus gets larger ones."""
AROUND = 1.0
"""[m] Free ground beyond plan, path and ends."""
STEPS = ((1, 0), (0, 1), (1, 1), (1, -1), (2, 1), (1, 2), (2, -1), (1, -2))
"""Moves between cells: of sixteen directions the best is within 2.7 % of straight, which pulling tight takes away."""


def shortest_way(plan: Plan, driven: FloatArray, start: FloatArray, end: FloatArray) -> float | None:
    """Return the length [m] of the shortest way from start (2,) to end (2,) past all that stands on a plan.

    driven (N, 2) [m]: where the robot truly was; a line that it drove through is a door that stood open. None where
    there is no way, or the plan shows nothing.
    """
    if not plan.polylines and not plan.circles:
        return None
    points = np.concatenate([*plan.polylines, driven, [start, end]])
    low, high = points.min(axis=0) - AROUND, points.max(axis=0) + AROUND
    cell = max(CELL, math.sqrt(float(np.prod(high - low)) / CELLS))
    free = _free(plan, driven, low, high, cell)
    cells = [_nearest_free(free, (np.asarray(p) - low) / cell) for p in (start, end)]
    path = _cheapest(free, *cells)
    if path is None:
        return None
    taut = _pulled(free, path)
    taut[0], taut[-1] = (np.asarray(start) - low) / cell, (np.asarray(end) - low) / cell
    return float(np.hypot(*np.diff(taut, axis=0).T).sum()) * cell


def _free(plan: Plan, driven: FloatArray, low: FloatArray, high: FloatArray, cell: float) -> BoolArray:
    """Return where a body's middle may be (X, Y)."""
    size = np.ceil((high - low) / cell).astype(int) + 1
    stands = np.ones((size[1], size[0]), np.uint8)
    for line in plan.polylines:
        if not _crossed(line, driven):
            cv2.polylines(stands, [np.round((line - low) / cell).astype(np.int32)], False, 0)
    for x, y, radius in plan.circles:
        middle = np.round((np.array([x, y]) - low) / cell).astype(int)
        cv2.circle(stands, (int(middle[0]), int(middle[1])), max(round(radius / cell), 0), 0, -1)
    gap = cv2.distanceTransform(stands, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    free: BoolArray = (gap * cell > BODY).T
    return free


def _crossed(line: FloatArray, driven: FloatArray) -> bool:
    """Return whether the robot drove through a straight line of a plan."""
    if len(line) != 2 or len(driven) < 2:
        return False
    a, b = line
    p, q = driven[:-1], driven[1:]
    sides = _side(a, b, p) * _side(a, b, q) < 0
    ends = _side(p, q, a) * _side(p, q, b) < 0
    return bool(np.any(sides & ends))


def _side(a: FloatArray, b: FloatArray, p: FloatArray) -> FloatArray:
    way, to = b - a, p - a
    side: FloatArray = way[..., 0] * to[..., 1] - way[..., 1] * to[..., 0]
    return side


def _nearest_free(free: BoolArray, point: FloatArray) -> tuple[int, int]:
    cells = np.argwhere(free)
    x, y = cells[int(np.hypot(*(cells - point).T).argmin())]
    return int(x), int(y)


def _cheapest(free: BoolArray, start: tuple[int, int], end: tuple[int, int]) -> FloatArray | None:
    """Return the cells (K, 2) of the cheapest way over the grid, None without one."""
    numbers = np.arange(free.size).reshape(free.shape)
    rows, columns, weights = [], [], []
    for dx, dy in STEPS:
        here, there = _shifted(numbers, dx, dy)
        open_both = free.ravel()[here] & free.ravel()[there]
        rows.append(here[open_both])
        columns.append(there[open_both])
        weights.append(np.full(int(open_both.sum()), math.hypot(dx, dy)))
    graph = coo_array(
        (np.concatenate(weights), (np.concatenate(rows), np.concatenate(columns))), shape=(free.size, free.size)
    ).tocsr()
    first, last = int(numbers[start]), int(numbers[end])
    before = dijkstra(graph, directed=False, indices=[first], return_predecessors=True)[1][0]
    path = [last]
    while path[-1] != first:
        path.append(int(before[path[-1]]))
        if path[-1] < 0:
            return None
    return np.column_stack(np.unravel_index(path[::-1], free.shape)).astype(np.float64)


def _shifted(numbers: IntArray, dx: int, dy: int) -> tuple[IntArray, IntArray]:
    """Return the numbers of cells and of those a move away."""
    width = numbers.shape[1]
    here = numbers[: len(numbers) - dx, max(-dy, 0) : width - max(dy, 0)]
    there = numbers[dx:, max(dy, 0) : width - max(-dy, 0)]
    return here.ravel(), there.ravel()


def _pulled(free: BoolArray, path: FloatArray) -> FloatArray:
    """Return the corners (M, 2) of a way pulled tight: from each the farthest that can be seen."""
    corners = [0]
    while corners[-1] < len(path) - 1:
        here = corners[-1]
        ahead = range(len(path) - 1, here, -1)
        corners.append(next(k for k in ahead if k == here + 1 or _seen(free, path[here], path[k])))
    return path[corners]


def _seen(free: BoolArray, a: FloatArray, b: FloatArray) -> bool:
    count = int(2 * np.abs(b - a).max()) + 2
    cells = np.round(a + np.linspace(0.0, 1.0, count)[:, None] * (b - a)).astype(int)
    return bool(free[cells[:, 0], cells[:, 1]].all())
