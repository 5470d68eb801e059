"""How clearly a view can be more like one place than like all others though it is none of them: learnt on the way.

Of places that odometry excludes, one is the most like the view by chance. How far it lies below the next one elsewhere,
over all views so far, is what a claimed place has to beat: in a row of look-alike doors it often lies far below, in a
park never. So nothing has to be known of camera or world.
"""

from __future__ import annotations

import math
from bisect import bisect_left, insort

import numpy as np

from topomap.core.arrays import Float32Array, FloatArray

FEWEST = 8
"""Views before anything is told."""
TRUE = 0.3
"""Share of true revisits that beat what chance hardly ever does: 0 where every place has its double, 0.9 elsewhere."""
RARELY, MARGIN = 0.02, 0.6
"""Share of views that chance may have made as clear, by a margin: one in a hundred places is excluded though the robot
is there, and every new record of chance would count as clear otherwise."""
MOST = 3.0
"""A single look never says more (`topomap.mapping.closures.looks`)."""


class Contrast:
    """Keeps, for each view, the difference to the likest excluded place over that to the likest one elsewhere."""

    def __init__(self) -> None:
        self._chance: list[float] = []  # rising

    def learn(self, differences: FloatArray | Float32Array, places: FloatArray, apart: float) -> None:
        """Take a view's differences (n,) to places (n, 2) [m] where it wasn't taken; two that lie `apart` are two."""
        if not len(differences):
            return
        best = int(differences.argmin())
        others = differences[np.hypot(*(places - places[best]).T) > apart]
        if len(others):
            insort(self._chance, float(differences[best]) / max(float(others.min()), 1e-9))

    def log_ratio(self, difference: float, rival: float) -> float:
        """Return how much likelier a claimed place's difference is if true, as a log; 0 where chance does as much.

        rival: the least difference to a place elsewhere.
        """
        beaten = bisect_left(self._chance, difference / max(MARGIN * rival, 1e-9))
        if len(self._chance) < FEWEST or beaten > RARELY * len(self._chance):
            return 0.0
        return min(max(math.log(TRUE * (len(self._chance) + 1) / (beaten + 1)), 0.0), MOST)
