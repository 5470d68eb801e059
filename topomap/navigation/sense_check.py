"""The senses watched over: a camera that shows nothing or stands still, ranges that have died."""

from __future__ import annotations

from collections import deque
from statistics import median

import numpy as np

from topomap.core.arrays import Float32Array
from topomap.core.panorama import Panorama
from topomap.core.records import Command, PlaceMatch
from topomap.core.robot import Reading
from topomap.navigation.senses import Health, Senses
from topomap.vision.image.compare import shrunk

BLANK = 1.5
"""[grey levels] Standard deviation of the shrunk view below which it shows nothing: sensor noise leaves 0.2, the
plainest view of nine worlds 12."""
MOVED, TURNED = 0.02, 0.02
"""[m, rad] A step of the odometer above this is a move."""
FROZEN_STEPS = 3
"""Moves over which the image stays the very same before the camera counts as frozen: noise changes every image."""
TOO_NEAR = 0.02
"""[m] What is measured nearer than this, inside the robot, is no range."""
RANGES_SHARE = 0.02
"""Share of rays with a range below which there are none: an empty hall of 40 m still gives some."""
RANGES_STEPS = 3
"""Steps without before they count as lost."""
LATE = 3.0
"""Share of the usual time between readings above which one is late."""


class SenseCheck:
    """Looks at every reading; what it finds amiss is told once, and steers at every step."""

    def __init__(self) -> None:
        self._last: Reading | None = None
        self._same = 0
        self._had_ranges = False
        self._without = 0
        self._usual: deque[float] = deque(maxlen=25)
        self._command = Command()
        self._said: set[str] = set()

    def commanded(self, command: Command) -> None:
        """Take what the wheels were told."""
        self._command = command

    def senses(
        self, reading: Reading, panorama: Panorama, turn: float, place: PlaceMatch | None, odometry: str = ""
    ) -> Senses:
        """Return what was sensed, and what of it can be relied on; odometry: what is wrong with it, in words."""
        stop = self._camera(reading, panorama)
        ranges = self._ranges(panorama)
        blind = self._had_ranges and ranges is None
        late = self._is_late(reading.motion.dt)
        amiss = {
            stop: bool(stop),
            "ranges lost: going on slowly, by contact": blind,
            "readings come late: going on slowly": late,
            odometry: bool(odometry),
        }
        event = self._event({what for what, is_so in amiss.items() if is_so})
        self._last = reading
        health = Health(stop, blind or late or bool(odometry), event)
        return Senses(reading.stamp_ns, panorama, turn, reading.contact, health, ranges, place)

    def _event(self, amiss: set[str]) -> str:
        """Return what is newly amiss or well again."""
        new, well = sorted(amiss - self._said), sorted(self._said - amiss)
        self._said = amiss
        return "; ".join([*new, *(f"over: {what}" for what in well)])

    def _camera(self, reading: Reading, panorama: Panorama) -> str:
        """Return why the camera can't be used, or ""."""
        if float(shrunk(panorama, 90, 10).std()) < BLANK:
            return "the camera shows nothing: the view is all of one tone"
        last, motion = self._last, reading.motion
        moved = abs(motion.forward) > MOVED or abs(motion.turn) > TURNED
        if last is None or not np.array_equal(last.image, reading.image):
            self._same = 0
        elif moved or self._command != Command():
            self._same += 1
        return "the camera is frozen: the image stays the same in motion" if self._same >= FROZEN_STEPS else ""

    def _ranges(self, panorama: Panorama) -> Float32Array | None:
        """Return the ranges with NaN for all that is none, or None where there are too few to rely on."""
        if panorama.ranges is None:
            return None
        valid = np.isfinite(panorama.ranges) & (panorama.ranges > TOO_NEAR)
        enough = float(valid.mean()) >= RANGES_SHARE
        self._without = 0 if enough else self._without + 1
        self._had_ranges |= enough
        if self._without >= RANGES_STEPS or not self._had_ranges:
            return None
        return np.where(valid, panorama.ranges, np.float32(np.nan)).astype(np.float32)

    def _is_late(self, dt: float) -> bool:
        usual = median(self._usual) if self._usual else dt
        self._usual.append(dt)
        return dt > LATE * usual > 0.0
