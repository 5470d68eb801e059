"""A whole turn on the spot."""

from __future__ import annotations

from topomap.core.geometry import TAU
from topomap.core.records import Command

LIMIT = 80
"""Steps after which it ends whatever odometry says: a whole turn takes 32 at 0.8 rad/s and 0.25 s a step."""


class TurnAndLook:
    """Turns until odometry has counted a whole turn."""

    def __init__(self, turn_rate: float) -> None:
        self._rate = turn_rate
        self._turned, self._steps = 0.0, 0

    def step(self, turn: float) -> Command | None:
        """Take the odometry's turn of this step [rad]; return the command, or None when it is over."""
        self._turned += turn
        self._steps += 1
        if self._turned >= TAU or self._steps > LIMIT:
            return None
        return Command(0.0, self._rate)
