"""How each remedy drives the robot, while the journey waits."""

from __future__ import annotations

from topomap.core.records import Command
from topomap.navigation.journey import Journey
from topomap.navigation.manoeuvres.relocalise import free_bearing
from topomap.navigation.manoeuvres.turn_and_look import TurnAndLook
from topomap.navigation.pilot import Pilot
from topomap.navigation.recovery import Remedy
from topomap.navigation.senses import Now

SPEED = 0.2
"""[m/s] Limit meanwhile."""
BACK = 1.0
"""[m] How far is gone back: a milestone's spacing."""
BACK_STEPS = 40
"""Steps after which going back ends: twice what the way takes, with the turn."""
ABOUT_STEPS = 80
"""Steps of driving about: 4 m, over which half of the lost find themselves in `office-loop`."""
WAIT_STEPS = 60
"""Steps of waiting: 15 s, in which a person walks past several times over."""
NEAR = 0.15
"""[m] So near its end, going back is done."""


class Remedies:
    """Takes the wheels for one remedy at a time."""

    def __init__(self, pilot: Pilot, turn_rate: float) -> None:
        self._pilot, self._turn_rate = pilot, turn_rate
        self._turning: TurnAndLook | None = None

    def begin(self, j: Journey, remedy: Remedy) -> None:
        """Start with a remedy."""
        j.remedy, j.tried = remedy, 0
        self._turning = TurnAndLook(self._turn_rate) if remedy is Remedy.TURN else None

    def step(self, j: Journey, now: Now) -> Command | None:
        """Return this step's command, or None when the remedy is over."""
        j.tried += 1
        if j.remedy is Remedy.TURN and self._turning is not None:
            return self._turning.step(now.senses.turn)
        if j.remedy is Remedy.RETRACE:
            return self._back(j, now)
        if j.remedy is Remedy.RELOCALISE:
            return self._about(j, now)
        if j.remedy is Remedy.WAIT:
            return Command() if j.tried <= WAIT_STEPS else None
        return None  # looking again takes no time: the next look begins anew, from the believed heading

    def _about(self, j: Journey, now: Now) -> Command | None:
        """Drive a short way through free space, for the belief to see other places."""
        if j.tried > ABOUT_STEPS or now.ranges is None:
            return None
        return self._pilot.steer(free_bearing(now.ranges), now.ranges, SPEED)

    def _back(self, j: Journey, now: Now) -> Command | None:
        """Drive back along the course."""
        if j.tried == 1:
            self._target = j.course.point(-BACK)
        pose = now.where.pose
        if j.tried > BACK_STEPS or pose.distance(self._target) < NEAR:
            return None
        return self._pilot.steer(pose.bearing_to(self._target), now.ranges, SPEED)
