"""Whether the odometer counts a step that is none, while the view changes as it does over a usual one."""

from __future__ import annotations

from collections import deque
from statistics import median

from topomap.core.panorama import Panorama
from topomap.mapping.odometry.view_change import LEAST, change_by, seen_turn, view_change
from topomap.vision.image.compare import Signature, rotation_difference, signature

FEWEST = 10
"""Steps before which nothing is usual."""
LEAP, LEAP_LEAST, LEAP_CHANGE = 3.0, 0.3, 1.5
"""Times the longest step of late, and [m], that a leap of the odometer exceeds, while the view changes by no more than
so many times as usual: who drives three times as far sees twice the change."""
LEAP_SHARE = 0.5
"""Share of what the view changed by over as long a way before, below which the odometer's step is none: in hall,
corridor, room and office 99 % of leaps by half a metre are; of true steps 3 to 20 times as long as usual 97 to 100 %
aren't, in a park's photographs too (79 % in the office, whose views change by twice the usual by then)."""


class Leaps:
    """Learns how far and how fast the robot drives a step, and how views changed over the way behind.

    before: whether the step before the last one was a leap.
    """

    def __init__(self, memory: int) -> None:
        self._driven: deque[float] = deque(maxlen=memory)
        self._speeds: deque[float] = deque(maxlen=memory)
        self._behind: deque[tuple[Signature, float]] = deque(maxlen=memory)  # views, and the way at them [m]
        self._travel = 0.0
        self._now = self.before = False

    @property
    def usual(self) -> float:
        """The usual way of a step [m], 0 while none is known."""
        return median(self._driven) if self._driven else 0.0

    def begin(self) -> None:
        """Forget the views behind: they were taken elsewhere, or leaning otherwise than was known."""
        self._behind.clear()

    def learn(self, driven: float, dt: float) -> None:
        """Take a step that is as it should be: way [m], and how long it took [s]."""
        self._driven.append(driven)
        self._speeds.append(driven / dt if dt > 0 else 0.0)

    def judge(self, driven: float, dt: float, now: Panorama, previous: Panorama, usual_change: float) -> bool:
        """Return whether a step's way is a leap of the odometer.

        driven: the way [m] that it counts over dt [s]; now, previous: the views after and before it; usual_change: rms
        by which a view usually changes over a step.
        """
        self._behind.append((signature(previous), self._travel))
        self.before, self._now = self._now, self._leapt(driven, dt, now, previous, usual_change)
        self._travel += self.usual if self._now else driven
        return self._now

    def _leapt(self, driven: float, dt: float, now: Panorama, previous: Panorama, usual_change: float) -> bool:
        if len(self._driven) < FEWEST or driven < max(LEAP_LEAST, LEAP * max(self._driven)):
            return False
        if dt > 0 and driven / dt < LEAP * max(self._speeds):
            return False  # readings were left out
        change, _ = view_change(now, previous, seen_turn(now, previous))
        return change < max(LEAP_CHANGE * usual_change, LEAST) and self._is_little(change, driven)

    def _is_little(self, change: float, way: float) -> bool:
        """Return whether a change is little for such a way: where views change slowly, it says nothing of it."""
        now, last = self._behind[-1]
        before = next((view for view, at in reversed(self._behind) if last - at >= way), self._behind[0][0])
        return change < LEAP_SHARE * change_by(now, before, rotation_difference(now, before)[1])[0]
