"""Homing policies at the wheels: each move is driven by odometry, and after it the policy looks and is asked anew."""

from __future__ import annotations

import math
from typing import Any

from topomap.core.geometry import Pose2
from topomap.core.panorama import Panorama
from topomap.core.records import Command, HomeVector
from topomap.navigation.pilot import Pilot
from topomap.vision.aligned_homing import AlignedHoming

NEAR = 0.02  # [m] from a move's end that count as there: a fifth of the shortest trial move
STRAIGHT = 0.35  # [rad] beyond which the robot turns on the spot, as a move of 0.1 m has no room for a bend
BRAKE = 0.4  # [s] in which what is left of a move would be driven: it ends slowly enough to stop there
PATIENCE = 30  # steps after which a move is over, wherever the robot is: half a turn takes 20, something is in the way


class PolicyDrive:
    """Drives a policy's moves on one leg.

    Poses are the odometry's as read: over a move of some decimetres its systematic errors don't matter, and no
    correction of the map moves it.
    """

    def __init__(self, homing: AlignedHoming, goal: Panorama, pilot: Pilot) -> None:
        assert homing.policy is not None
        self._homing, self._pilot = homing, pilot
        self._state: Any = homing.policy.start(goal)  # Any: each policy has its own state
        self._end: Pose2 | None = None
        self._steps = 0

    def moving(self, here: Pose2) -> bool:
        """Return whether the last move is still being driven."""
        if self._end is None or self._steps >= PATIENCE:
            return False
        return here.distance(self._end) > NEAR

    def look(self, panorama: Panorama, rotation: float, here: Pose2) -> HomeVector:
        """Return the policy's next move in the robot's frame, by the view after the last one; rotation [rad].

        A confidence of 0 says that it knows no better place.
        """
        self._state, move = self._homing.move(self._state, panorama, rotation)
        way = move.distance or 0.0
        self._end = here @ Pose2(way * math.cos(move.bearing), way * math.sin(move.bearing))
        self._steps = 0
        return move

    def drive(self, panorama: Panorama, here: Pose2, speed: float) -> Command:
        """Return the command towards the move's end, at most `speed` [m/s]."""
        assert self._end is not None
        self._steps += 1
        left, bearing = here.distance(self._end), here.bearing_to(self._end)
        if abs(bearing) > STRAIGHT:
            return Command(0.0, self._pilot.steer(bearing, None).turn)
        return self._pilot.steer(bearing, panorama.ranges, min(speed, left / BRAKE))
