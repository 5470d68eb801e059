"""Whether a journey gets on: what is left of the course, and the steps since it last grew less."""

from __future__ import annotations

import math

STRETCH = 0.25
"""[m] By so much the rest of the course must grow less to count."""
PATIENCE = 48
"""Steps without that after which the journey is stuck: 12 s, three half turns on the spot or 4.8 m
round an obstacle."""
RECOVERED = 1.5
"""[m] Progress beyond the place of a trouble after which it is over: more than a milestone's spacing."""


class Progress:
    """Counts the steps since the course's rest [m] grew less."""

    def __init__(self) -> None:
        self.best = math.inf
        self.idle = 0
        self._trouble_at: float | None = None

    def update(self, left: float) -> bool:
        """Take what is left of the course now; return whether a trouble has just been overcome."""
        if self._trouble_at == math.inf:
            self._trouble_at = left
        if left < self.best - STRETCH:
            self.best, self.idle = left, 0
        else:
            self.idle += 1
        over = self._trouble_at is not None and left < self._trouble_at - RECOVERED
        if over:
            self._trouble_at = None
        return over

    def trouble(self) -> None:
        """Note that something was tried here; it has time to help."""
        self._trouble_at = self.best if self._trouble_at is None else min(self._trouble_at, self.best)
        self.idle = 0

    def renew(self) -> None:
        """Begin with another course; what is tried on it is counted anew once there is progress."""
        self.best, self.idle, self._trouble_at = math.inf, 0, math.inf
