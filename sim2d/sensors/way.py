"""The last stretch of the robot's way, for senses that lag behind it."""

from __future__ import annotations

import math
from collections import deque

Pose = tuple[float, float, float]
KEPT_S = 5.0  # [s] twice the greatest lag and a long exposure


class Way:
    """The true poses [m, rad] of the last seconds, one a step of `dt` [s]."""

    def __init__(self, dt: float, pose: Pose) -> None:
        self._dt = dt
        self._poses: deque[Pose] = deque([pose], maxlen=2 + math.ceil(KEPT_S / dt))

    def extend(self, pose: Pose) -> None:
        """Take the pose a step later."""
        self._poses.append(pose)

    def back(self, seconds: float) -> Pose:
        """Return the pose so many seconds ago, the oldest one known at most."""
        steps = min(seconds / self._dt, float(len(self._poses) - 1))
        whole = min(int(steps), max(0, len(self._poses) - 2))
        if len(self._poses) == 1 or steps == 0:
            return self._poses[-1]
        a, b, share = self._poses[-1 - whole], self._poses[-2 - whole], steps - whole
        x, y, heading = (p + share * (q - p) for p, q in zip(a, b, strict=True))
        return x, y, heading
