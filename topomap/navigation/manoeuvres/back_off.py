"""After a contact: back off, and remember for a while where something stands that no range showed."""

from __future__ import annotations

import math

import numpy as np

from topomap.core.arrays import Float32Array
from topomap.core.geometry import TAU, Pose2, wrap_all
from topomap.core.records import Command

STEPS = 6
"""Steps of backing off: 15 cm at SPEED and 0.25 s a step, room to turn beside what was touched."""
SPEED = 0.1
"""[m/s]"""
HALF_WIDTH = 0.2
"""[m] Half the width of what is assumed to stand where the body touched: as wide as the body."""
FORGET = 4.0
"""[m] Way after which it is forgotten: drift and people move what was touched."""
DIRECTIONS = 360


class BackOff:
    """Takes the wheels for a moment after a contact, and adds what was touched to the ranges.

    Poses are the odometry's as read: over a few metres no correction moves what was touched.
    """

    def __init__(self, body_radius: float) -> None:
        self._radius = body_radius
        self._left = 0
        self._touched: list[tuple[float, float, float]] = []  # x, y [m], raw odometer way at the contact [m]

    def step(self, contact: bool, here: Pose2, travel: float, forward: bool) -> Command | None:
        """Return the command to back off with, or None; forward: whether the last command drove ahead."""
        self._touched = [one for one in self._touched if travel - one[2] < FORGET]
        if contact and forward and not self._left:
            self._left = STEPS
            ahead = here @ Pose2(self._radius + 0.03)
            self._touched.append((ahead.x, ahead.y, travel))
        if not self._left:
            return None
        self._left -= 1
        return Command(-SPEED, 0.0)

    def ranges(self, measured: Float32Array | None, here: Pose2) -> Float32Array | None:
        """Return the ranges (W,) with what was touched in them."""
        if not self._touched:
            return measured
        merged = np.full(DIRECTIONS, np.inf, np.float32) if measured is None else measured.copy()
        angles = np.arange(len(merged)) * TAU / len(merged)
        for x, y, _ in self._touched:
            spot = Pose2(x, y)
            away, bearing = here.distance(spot), here.bearing_to(spot)
            wide = np.abs(wrap_all(angles - bearing)) <= math.atan2(HALF_WIDTH, max(away, 0.05))
            merged[wide] = np.fmin(merged[wide], np.float32(away))
        return merged
