"""How fast the view changes along the drive: the unit in which near and far are told where nothing measures metres.

Every new snapshot is compared with older ones at ways back that grow by a factor, and every step with the snapshot
before it. The median difference by way is a curve that rises from what noise alone makes to what any two places differ
by. It tells over which way views are alike: a few centimetres in grass, metres under trees far off, whatever the camera
and its size.
"""

from __future__ import annotations

import math
from collections import deque
from statistics import median

import numpy as np
from scipy.optimize import isotonic_regression

from topomap.core.arrays import FloatArray

SHORTEST, FACTOR = 0.02, math.sqrt(2.0)
"""[m] Bins of way: from 2 cm on, each longer by a factor."""
KEPT = 60
"""Differences a bin keeps, the newest: the curve follows the drive from a room into a corridor."""
FEWEST = 6
"""Differences before a bin counts; each counts by how many it holds, so that a row of look-alike doors or a dark first
view doesn't bend the curve."""
HALF = 0.5
"""Share of the difference between any two places up to which views are alike: half of it is reached at 0.06 m in grass
and at 0.75 m in photographs of a park."""


class Catchment:
    """Learns differences by way and tells over which way views are alike."""

    def __init__(self) -> None:
        self._bins: dict[int, deque[float]] = {}
        self._medians: dict[int, float] = {}  # of the bins that count
        self._curve: tuple[FloatArray, FloatArray] | None = None

    def learn(self, way: float, difference: float) -> None:
        """Take the difference of two views of the drive, the second one taken `way` [m] after the first."""
        if way < SHORTEST or not math.isfinite(difference):
            return
        number = round(math.log(way / SHORTEST) / math.log(FACTOR))
        kept = self._bins.setdefault(number, deque(maxlen=KEPT))
        kept.append(difference)
        if len(kept) >= FEWEST:
            self._medians[number] = median(kept)
            self._curve = None

    @property
    def length(self) -> float:
        """The way over which views are alike [m], 0 while it isn't known."""
        ways, differences = self._known()
        return _way(HALF * float(differences[-1]), ways, differences) if len(ways) else 0.0

    @property
    def other(self) -> float:
        """What views of two places far apart differ by, 0 while it isn't known."""
        _, differences = self._known()
        return float(differences[-1]) if len(differences) else 0.0

    def _known(self) -> tuple[FloatArray, FloatArray]:
        """Return ways [m] and the differences (n,) at them, both rising."""
        if self._curve is None:
            numbers = sorted(self._medians)
            medians = np.array([self._medians[number] for number in numbers])
            counts = np.array([len(self._bins[number]) for number in numbers], float)
            rising = isotonic_regression(medians, weights=counts).x if len(numbers) else medians
            self._curve = SHORTEST * FACTOR ** np.array(numbers, float), np.asarray(rising, float)
        return self._curve


def steps_back(way: float) -> list[float]:
    """Return the ways back [m] at which a new snapshot is compared with older ones, up to `way`."""
    longest = int(math.log(max(way, SHORTEST) / SHORTEST) / math.log(FACTOR))
    return [SHORTEST * FACTOR**number for number in range(longest + 1)]


def _way(difference: float, ways: FloatArray, differences: FloatArray) -> float:
    """Return the way at which a rising curve reaches a difference; before its first point it rises from nothing."""
    if difference <= differences[0]:
        return float(ways[0] * max(difference, 0.0) / max(float(differences[0]), 1e-9))
    return float(np.interp(difference, differences, ways))
