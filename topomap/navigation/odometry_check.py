"""The odometer held against the wheels' command and the view; where it can't be true, these stand in for it.

Only while the stack drives: what a driver told the wheels isn't known.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np

from topomap.core.arrays import Float32Array, Image
from topomap.core.geometry import wrap
from topomap.core.panorama import Panorama
from topomap.core.records import Command, Motion
from topomap.core.robot import MotionReading, Reading, RigReading
from topomap.mapping.odometry.increments import Calibration
from topomap.navigation.manoeuvres.back_off import SPEED
from topomap.vision.image.aligned_difference import aligned_difference
from topomap.vision.image.compare import rotation_within, signature

TURN_OFF = 0.1
"""[rad] A turn this far from the one between two views isn't true: undisturbed they agree to 2.5 degrees, and to 5
where people pass, in three worlds."""
LESS_ALIKE = 1.5
"""... if two views are so many times less alike at the odometer's turn than at the one between them: 0.9 to 1.1 where
people hide much of them (20 steps of three worlds), 2.1 or more where the odometer's turn is off (180 steps of two)."""
MORE, BEYOND = 1.5, 0.02
"""An odometer can't count this many times the fastest way (and [m] more), ahead or back; less than told it can: wheels
take time and are blocked, and in a replay the commands aren't those that were driven by."""
WINDOW, BAD = 8, 3
"""Steps looked back on; so many untrue ones of them, and the odometer isn't believed: one is a person or a slip."""
TURN_BEYOND = 0.4
"""[rad] How far beyond what wheels were told a turn is looked for in two views: twice the fastest turn of a step. In
`office-loop` a corridor's view turned round was once the one more alike, and the way home ended at another door."""
WELL = 40
"""Steps without an untrue one after which it is believed again: noise that shows in one step of three hides for 8."""
SEEN_MOVE, SEEN_TURN = 0.06, 0.03
"""Difference of two views, and turn between them [rad], above which the robot has moved: at rest pixel noise makes 0.01
and 0.002."""
FORWARD_SIGMA, SIDE_SIGMA, TURN_SIGMA = 0.03, 0.01, 0.03
"""[m, m, rad] Error a step of what stands in: a third of a step's way; the compass between two views."""


@dataclass(frozen=True, slots=True, eq=False)
class Restated:
    """A reading with another motion."""

    reading: Reading
    motion: MotionReading

    @property
    def stamp_ns(self) -> int:
        return self.reading.stamp_ns

    @property
    def image(self) -> Image:
        return self.reading.image

    @property
    def encoded(self) -> bytes:
        return self.reading.encoded

    @property
    def ranges(self) -> Float32Array | None:
        return self.reading.ranges

    @property
    def rig(self) -> RigReading:
        return self.reading.rig

    @property
    def contact(self) -> bool:
        return self.reading.contact

    @property
    def driven(self) -> bool:
        return self.reading.driven


class OdometryCheck:
    """Judges each increment, and restates what can't be true.

    dead, turns, ways: whether the odometer counts nothing, or its turns or ways aren't believed.
    """

    def __init__(self, fastest: float) -> None:
        """fastest: speed that the robot is driven at [m/s]."""
        self._fastest = fastest
        self.dead = self.turns = self.ways = False
        self._bad_turns: deque[bool] = deque(maxlen=WELL)
        self._bad_ways: deque[bool] = deque(maxlen=WELL)
        self._previous: Panorama | None = None

    @property
    def amiss(self) -> str:
        """What isn't believed, in words, or ""."""
        if self.dead:
            return "odometry dead: it counts nothing though the view moves; the commands stand in for it"
        what = " and ".join(["turns"] * self.turns + ["ways"] * self.ways)
        return f"odometry untrue: its {what} can't be; view and commands stand in for it" if what else ""

    def checked(self, reading: Reading, panorama: Panorama, told: Command, calibration: Calibration) -> Reading:
        """Return the reading, with another motion where its own can't be true; told: the command it answers."""
        before, self._previous = self._previous, panorama
        if reading.driven or before is None:
            self._bad_turns.clear()
            self._bad_ways.clear()
            self.dead = self.turns = self.ways = False
            return reading
        difference, seen = _turned(panorama, before, told.turn * reading.motion.dt)
        moved = difference > SEEN_MOVE or abs(seen) > SEEN_TURN
        way = told.forward * reading.motion.dt
        counts = bool(reading.motion.forward != 0.0 or reading.motion.turn != 0.0)
        self._bad_turns.append(counts and _is_off(float(reading.motion.turn), seen, panorama, before))
        self._judge(reading.motion, counts, moved, told)
        if not (self.dead or self.turns or self.ways):
            return reading
        return Restated(reading, self._instead(reading.motion, way if moved else 0.0, seen, calibration))

    def _judge(self, motion: MotionReading, counts: bool, moved: bool, told: Command) -> None:
        if counts:
            self.dead = False
        elif moved and told != Command():
            self.dead = True
        ahead, back = (MORE * speed * motion.dt + BEYOND for speed in (self._fastest, SPEED))
        untrue = motion.forward > ahead or motion.forward < -back
        self._bad_ways.append(bool(untrue))
        self.turns = _untrue(self._bad_turns, self.turns)
        self.ways = _untrue(self._bad_ways, self.ways)

    def _instead(self, read: MotionReading, way: float, seen: float, calibration: Calibration) -> Motion:
        """Return what the odometer should have read: it is corrected by its calibration later on."""
        covariance = np.array(read.covariance, np.float64)
        forward, turn = float(read.forward), float(read.turn)
        if self.dead or self.ways:
            forward = way * calibration.distance_scale
            covariance[0, :], covariance[:, 0] = 0.0, 0.0
            covariance[0, 0], covariance[1, 1] = FORWARD_SIGMA**2, SIDE_SIGMA**2
        if self.dead or self.turns:
            turn = seen * calibration.rotation_scale + calibration.curvature * forward / calibration.distance_scale
            covariance[2, :], covariance[:, 2] = 0.0, 0.0
            covariance[2, 2] = TURN_SIGMA**2
        return Motion(forward, float(read.left), turn, covariance, float(read.dt))


def _turned(now: Panorama, before: Panorama, told: float) -> tuple[float, float]:
    """Return the difference of two views and the turn between them [rad], of those that the wheels can have made.

    told [rad]: what they were told, of which blocked ones make none. Whoever is turned by somebody else isn't judged
    here: the map notices it.
    """
    return rotation_within(signature(now), signature(before), told / 2, abs(told) / 2 + TURN_BEYOND)


def _is_off(read: float, seen: float, now: Panorama, before: Panorama) -> bool:
    """Return whether a turn [rad] that was read is another one than the one seen, and the views speak against it."""
    if abs(wrap(read - seen)) <= TURN_OFF:
        return False
    return aligned_difference(now, before, read) > LESS_ALIKE * aligned_difference(now, before, seen)


def _untrue(bad: deque[bool], already: bool) -> bool:
    """Return whether so many steps of late were untrue, or one of those looked back on where it wasn't believed."""
    return sum(list(bad)[-WINDOW:]) >= BAD or (already and any(bad))
