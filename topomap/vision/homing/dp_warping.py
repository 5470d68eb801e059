"""H10, free warping by dynamic programming: every column may shift on its own, but the order is kept."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numba import njit

from topomap.core.arrays import Float32Array, FloatArray, IntArray
from topomap.core.errors import ShapeError
from topomap.core.geometry import TAU, wrap
from topomap.core.panorama import Panorama
from topomap.core.records import HomeVector
from topomap.vision.contracts import Needs, Origin
from topomap.vision.image.scale_planes import WARPING, WarpingSpec, WarpingView, warping_view
from topomap.vision.matching.warping import CLEAR, NOISE, movements
from topomap.vision.matching.warping_kernels import scale_planes


@dataclass(frozen=True, slots=True)
class DpWarping:
    """As min-warping for a given rotation, but a column may not pass its neighbours (Möller et al. 2010: free
    warping; Hong et al. 1992): for every direction of the movement, warping in time on each side of it, from the point
    ahead to the point astern; bearing only.
    """

    origin: ClassVar[Origin] = Origin("H10", "2.5.2.2, free (dp) warping")
    needs: ClassVar[Needs] = Needs(compass=True)
    claims_homing: ClassVar[bool] = True
    spec: WarpingSpec = WARPING

    def describe(self, panorama: Panorama) -> WarpingView:
        """Return the view's magnified columns."""
        return warping_view(panorama, self.spec)

    def home(self, current: WarpingView, goal: WarpingView) -> HomeVector:
        """Return the bearing [rad] of the goal in the aligned frame. Raises ShapeError."""
        if current.edges.shape != goal.edges.shape:
            raise ShapeError(f"views differ in shape: {current.edges.shape} and {goal.edges.shape}")
        n = goal.edges.shape[3]
        if n < 8 or not (goal.sums.any() and current.sums.any()):
            return HomeVector(0.0, None, 0.0)
        cost = direction_costs(current, goal)
        best = int(cost.argmin())
        offset = _parabola(cost[(best - 1) % n], cost[best], cost[(best + 1) % n])
        mean = float(cost.mean())
        contrast = 1.0 - float(cost[best]) / mean if mean > 1e-6 else 0.0  # at the goal every direction fits
        sure = min(max((contrast - NOISE) / (CLEAR - NOISE), 0.0), 1.0)
        return HomeVector(wrap((best + offset) * TAU / n + goal.first_bearing + math.pi), None, sure)


def direction_costs(current: WarpingView, goal: WarpingView) -> FloatArray:
    """Return the cost (n,) of every direction of the movement goal -> current, in columns."""
    phases, n = goal.edges.shape[1], goal.edges.shape[3]
    floor = goal.spec.floor * float(goal.sums[0, 0].mean() + current.sums[0, 0].mean())
    planes = scale_planes(goal.edges, current.edges, goal.sums, current.sums, floor)
    shifts, scales, counts = movements(n, phases, goal.spec.levels, goal.spec.step)
    return np.asarray(_costs(planes, shifts, scales, counts), np.float64)


@njit(cache=True)
def _costs(planes: Float32Array, shifts: IntArray, scales: IntArray, counts: IntArray) -> FloatArray:
    n = planes.shape[1]
    half = n // 2
    cost = np.zeros(n)
    before, after = np.empty(half + 1), np.empty(half + 1)
    for alpha in range(n):
        for side in (1, -1):
            before[:] = np.inf
            before[0] = 0.0
            for k in range(1, half):
                x = (side * k) % n
                i = (alpha + x) % n
                after[:] = np.inf
                for t in range(counts[x]):
                    place = k + side * shifts[x, t]  # columns from the point ahead, in the current view
                    if 0 <= place <= half:
                        value = planes[scales[x, t], i, (-i - shifts[x, t]) % n]
                        after[place] = min(after[place], value)
                least = np.inf
                for place in range(half + 1):
                    least = min(least, before[place])
                    after[place] += least
                before, after = after, before
            cost[alpha] += before.min()
    mean: FloatArray = cost / n
    return mean


def _parabola(below: float, here: float, above: float) -> float:
    bend = below - 2.0 * here + above
    return min(max(0.5 * (below - above) / bend, -0.5), 0.5) if bend > 1e-12 else 0.0
