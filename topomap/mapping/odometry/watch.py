"""Whether a step's odometry can be true: the view after it against the view before it."""

from __future__ import annotations

from collections import deque

import numpy as np

from topomap.core.arrays import FloatArray
from topomap.core.geometry import TAU
from topomap.core.panorama import Panorama
from topomap.core.robot import MotionReading
from topomap.vision.image.compare import rotation_difference, signature

SECTORS = 15
"""Parts of the view that are compared one by one: people who pass change a third of them, being carried away all."""
MEMORY, FEWEST = 60, 10
"""Steps over which the usual change is taken, and before which nothing is usual."""
TIMES = 2.5
"""A change so many times the usual one is a break: undisturbed it is at most 1.8 times, carried on by a metre 3 or
more in `hall`, where views change most slowly."""
LEAST = 0.35
"""Change below which nothing is a break: photographs outdoors change by up to 0.31 over 3 cm, views on the way into a
corridor by 0.23 a step; carried on by 2 m a view changes by 0.38 at least in `hall`, by 0.6 in `room-corridor`."""
TURN_WAY = 0.2
"""[m] Way that changes a view as much as turning by one radian on the spot does."""
STILL, STILL_SHARE, MOVING = 0.02, 0.2, 0.5
"""Way up to which wheels stand: in metres, and as a share of the usual way of a step, which may be millimetres; and the
share of the usual change from which on a view moves nevertheless."""
LATELY, MORE = 10, 1.5
"""Steps, and times their greatest change, that a break has to exceed: photographs outdoors change by 0.08 a step and
now and then by 0.3, several times in a row; one break is enough of those."""
ANNOUNCED, SOON = 0.4, 2
"""Change of the whole view, in one of so many steps before, that announces a greater one: what passes close by grows
over some steps before it hides the rest. In grass it is 0.42 or more before each of 12 blades; in rooms, a hall and an
office no undisturbed step changes the view by more than 0.38."""
UNMOVED = 0.2
"""Share of the usual change up to which a view stands still."""
PATIENCE = 4
"""Steps in a row in which wheels and view contradict one another: people who pass do so for two or three."""


class OdometryWatch:
    """Learns how much views change on the way, and says when one changes far more, or for long not as wheels say.

    turn: how far the robot turned in the last step [rad], by the view, where the odometry's turn can't be true and this
    one explains the view; else None.
    """

    def __init__(self) -> None:
        self._previous: Panorama | None = None
        self._changes: deque[float] = deque(maxlen=MEMORY)
        self._ways: deque[float] = deque(maxlen=MEMORY)
        self._latest: deque[float] = deque(maxlen=LATELY)
        self._whole: deque[float] = deque(maxlen=SOON)
        self._lately = 0.0
        self._dead = self._spinning = 0
        self.turn: float | None = None

    @property
    def doubted(self) -> bool:
        """Whether wheels and views contradict one another now."""
        return max(self._dead, self._spinning) >= PATIENCE

    def judge(self, panorama: Panorama, motion: MotionReading) -> str:
        """Return why the robot isn't where odometry has it, or "": it was carried away, or wheels failed until now."""
        previous, self._previous = self._previous, panorama
        self.turn = None
        if previous is None:
            return ""
        change, whole = _change(panorama, previous, float(motion.turn))
        way = abs(motion.forward) + abs(motion.left) + TURN_WAY * abs(motion.turn)
        self._lately = max(self._latest, default=0.0)
        self._latest.append(change)
        announced = max(self._whole, default=0.0) >= ANNOUNCED
        self._whole.append(whole)
        if len(self._changes) >= FEWEST and not announced and self._jumped(change, way):
            turn = rotation_difference(signature(panorama), signature(previous))[1]
            if not self._jumped(_change(panorama, previous, turn)[0], way):
                self.turn = turn
                return ""
            return f"carried away: the view changed by {change:.2f}, usual over a step is {self._usual:.2f}"
        ended = self._contradicted(change, way, abs(motion.forward) + abs(motion.left))
        if way > self._still and not self._spinning and change < TIMES * max(self._usual, LEAST):
            self._changes.append(change)
            self._ways.append(way)
        return ended

    @property
    def _still(self) -> float:
        """Way up to which the wheels stand [m]."""
        return min(STILL, STILL_SHARE * float(np.median(self._ways))) if self._ways else 0.0

    @property
    def _usual(self) -> float:
        return float(np.median(self._changes)) if self._changes else 0.0

    def _jumped(self, change: float, way: float) -> bool:
        longer = max(1.0, way / float(np.median(self._ways)))
        return change > max(TIMES * self._usual * longer, LEAST, MORE * self._lately)

    def _contradicted(self, change: float, way: float, driven: float) -> str:
        """Count the steps in which the wheels stand and the view moves, or the other way round.

        driven: the way without turning [m], which leaves the view as it was but for its direction.
        """
        before, dead, spinning = self.doubted, self._dead, self._spinning
        if len(self._changes) < FEWEST:
            return ""
        usual = self._usual
        slow = min(driven / float(np.median(self._ways)), 1.0)
        self._dead = self._dead + 1 if way <= self._still and MOVING * usual < change else 0
        self._spinning = self._spinning + 1 if driven > self._still and change < UNMOVED * usual * slow else 0
        if before and not self.doubted:
            return f"the odometry stood still for {dead} steps" if dead else f"the wheels spun for {spinning} steps"
        return ""


def _change(now: Panorama, before: Panorama, turn: float) -> tuple[float, float]:
    """Return how two views differ (rms), turned by the odometry's turn or nearly: median over sectors, and whole."""
    a, b = signature(now), signature(before)
    columns = a.pixels.shape[1]
    frequencies = np.arange(a.spectrum.shape[1])
    turns = (turn + np.array([-1.0, 0.0, 1.0]) * TAU / columns) % TAU
    phases = np.exp(-1j * frequencies[None] * turns[:, None])
    rolled = np.fft.irfft(a.spectrum[None] * phases[:, None, :], n=columns, axis=2)
    squares: FloatArray = np.square(rolled - b.pixels[None]).mean(axis=1)
    bounds = np.linspace(0, columns, SECTORS, endpoint=False).astype(np.int64)
    sectors = np.add.reduceat(squares, bounds, axis=1) / np.diff(np.append(bounds, columns))
    return float(np.sqrt(np.median(sectors, axis=1).min())), float(np.sqrt(squares.mean(axis=1).min()))
