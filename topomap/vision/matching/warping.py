"""Min-warping (H11): the movement and rotation under which one panorama's columns best explain another's.

Möller, Krzykawski, Gerstmayr (2010), as METHODS.md states it: a landmark at bearing theta of the goal view,
seen x = theta - alpha from the direction alpha of the movement goal -> current, appears y further on and
larger by sigma = r_goal/r_current = sin(x + y)/sin x.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from topomap.core.arrays import Float32Array, FloatArray, IntArray
from topomap.core.errors import ShapeError
from topomap.core.geometry import TAU, wrap
from topomap.core.records import Alignment, HomeVector
from topomap.vision.image.scale_planes import WarpingView
from topomap.vision.matching.warping_kernels import scale_planes, warping_search, whole_search

NOISE, CLEAR = 0.08, 0.35
"""How far the best direction's cost lies below the mean of all: unrelated views or noise, and a clear view.
"""


@lru_cache(maxsize=8)
def movements(n: int, phases: int, levels: int, step: float) -> tuple[IntArray, IntArray, IntArray]:
    """Return for each x [columns] the shifts y [columns], (n, T), their planes (n, T) and how many there are
    (n,).
    """
    rows = [_shifts(x, n, phases, levels, step) for x in range(n)]
    longest = max(len(row) for row in rows)
    table = np.zeros((2, n, longest), np.int64)
    for x, row in enumerate(rows):
        table[:, x, : len(row)] = np.array(row).T
    return table[0], table[1], np.array([len(row) for row in rows], np.int64)


def _shifts(x: int, n: int, phases: int, levels: int, step: float) -> list[tuple[int, int]]:
    """Ahead and astern nothing shifts and only the size changes; abeam the shift fixes the size."""
    angle = wrap(x * TAU / n)
    if x == 0:
        return [(0, plane * phases) for plane in range(levels, 2 * levels + 1)]
    if 2 * x == n:
        return [(0, plane * phases) for plane in range(levels + 1)]
    found = []
    for fine in range(n * phases // 2):
        turned = angle + math.copysign(fine * TAU / (n * phases), angle)
        if abs(turned) >= math.pi - 1e-9:
            break
        plane = round(math.log(math.sin(turned) / math.sin(angle)) / math.log(step)) + levels
        if 0 <= plane <= 2 * levels:
            whole, phase = divmod(int(math.copysign(fine, angle)), phases)
            found.append((whole, plane * phases + phase))
    return found


@dataclass(frozen=True, slots=True, eq=False)
class WarpingCost:
    """The search's outcome: cost (n, P) over alpha [columns] and rotation first .. first + P - 1 [columns];
    level: what a wrong movement and rotation costs, on average, in these two views (0 when one of them is
    blank); first_bearing [rad] of column 0.
    """

    cost: Float32Array
    first: int
    level: float
    first_bearing: float

    @property
    def whole(self) -> bool:
        """Whether every rotation was searched."""
        return bool(self.cost.shape[0] == self.cost.shape[1])


def warp(current: WarpingView, goal: WarpingView, prior: float | None = None, window: float = math.pi) -> WarpingCost:
    """Search alpha everywhere and rotation within prior +- window [rad] (None: everywhere).

    Raises ShapeError.
    """
    if current.edges.shape != goal.edges.shape:
        raise ShapeError(f"views differ in shape: {current.edges.shape} and {goal.edges.shape}")
    n = goal.edges.shape[3]
    floor = goal.spec.floor * float(goal.sums[0, 0].mean() + current.sums[0, 0].mean())
    planes = scale_planes(goal.edges, current.edges, goal.sums, current.sums, floor)
    shifts, scales, counts = movements(n, goal.edges.shape[1], goal.spec.levels, goal.spec.step)
    first, width = rotations(prior, window, n)
    cost = whole_search(planes, shifts, scales, counts, first, width)
    sample = cost if width == n else warping_search(planes, shifts, scales, counts, np.arange(0, n, 9), 0, n)
    seen = bool(goal.sums.any() and current.sums.any())
    return WarpingCost(cost, first, float(sample.mean(dtype=np.float64)) if seen else 0.0, goal.first_bearing)


def rotations(prior: float | None, window: float, n: int) -> tuple[int, int]:
    """Return the first of the rotations to search and how many, in columns, within prior +- window [rad]."""
    half = math.ceil(window * n / TAU)
    if prior is None or 2 * half + 1 >= n:
        return 0, n
    return round(prior * n / TAU) - half, 2 * half + 1


def best(found: WarpingCost) -> Alignment:
    """Return rotation, residual (the cost over a wrong one's: below 1, unrelated views 0.95) and home vector
    of the least cost.

    The confidence is how much the least cost stays below the same rotation's mean over all directions: none
    where every direction explains the view alike (the goal itself, a blank wall, fog).
    """
    n = found.cost.shape[0]
    alpha, turn = np.unravel_index(int(found.cost.argmin()), found.cost.shape)
    refined = _refined(found, int(alpha), int(turn))
    d_alpha, d_turn = refined or (0.0, 0.0)
    least, mean = float(found.cost[alpha, turn]), float(found.cost[:, turn].mean())
    rotation = wrap((found.first + int(turn) + d_turn) * TAU / n)
    direction = (int(alpha) + d_alpha) * TAU / n + found.first_bearing
    contrast = 1.0 - least / mean if min(mean, found.level) > 1e-9 else 0.0
    confidence = min(max((contrast - NOISE) / (CLEAR - NOISE), 0.0), 1.0)
    home = HomeVector(wrap(direction + math.pi - rotation), None, confidence)
    return Alignment(rotation, least / found.level if found.level > 1e-9 else 1.0, home, refined is not None)


def least_home(found: WarpingCost) -> HomeVector:
    """Return the home vector of the least cost: there is always one, of confidence 0 where nothing is told."""
    home = best(found).home
    assert home is not None
    return home


_GRID = np.array([(a, t) for a in (-1.0, 0.0, 1.0) for t in (-1.0, 0.0, 1.0)])
_DESIGN = np.column_stack([np.ones(9), _GRID, _GRID**2, _GRID[:, 0] * _GRID[:, 1]])
_SOLVE: FloatArray = np.linalg.pinv(_DESIGN)


def _refined(found: WarpingCost, alpha: int, turn: int) -> tuple[float, float] | None:
    """Return the offset [columns] of the minimum of the quadratic through the 3 x 3 neighbourhood.

    None where the minimum lies at the edge of what was searched, or the neighbourhood is no bowl.
    """
    n, width = found.cost.shape
    if not found.whole and turn in (0, width - 1):
        return None
    rows, columns = np.arange(alpha - 1, alpha + 2) % n, np.arange(turn - 1, turn + 2) % width
    fit: FloatArray = _SOLVE @ found.cost[np.ix_(rows, columns)].astype(np.float64).ravel()
    bend = np.array([[2 * fit[3], fit[5]], [fit[5], 2 * fit[4]]])
    if bend[0, 0] <= 1e-12 or np.linalg.det(bend) <= 1e-12:
        return None
    offset = np.clip(-np.linalg.solve(bend, fit[1:3]), -1.0, 1.0)
    return float(offset[0]), float(offset[1])
