"""How much views change over a step of this drive: usually, of late, and now and then."""

from __future__ import annotations

import heapq
import math
from collections import deque
from statistics import median

from topomap.mapping.odometry.leaps import FEWEST
from topomap.mapping.odometry.view_change import LEAST

MEMORY = 60
"""Steps over which the usual change is taken."""
TIMES = 2.5
"""A change so many times the usual one is a break: undisturbed it is at most 1.8 times, carried on by a metre 3 or
more in `hall`, where views change most slowly."""
STILL, STILL_SHARE = 0.02, 0.2
"""Way up to which wheels stand: in metres, and as a share of the usual way of a step, which may be millimetres."""
LATELY, MORE = 10, 1.5
"""Steps, and times their greatest change, that a break has to exceed: photographs outdoors change by 0.08 a step and
now and then by 0.3, several times in a row; one break is enough of those."""
SELDOM = 3
"""What happened so often in this drive happens: the same holds of the third greatest change so far. Among blades of
grass that nearly touch the camera views change by 0.9 to 1.7 ten times in 16 m, where 0.04 is usual; in rooms, halls
and corridors the greatest change is within twice the usual one."""
LONG = 2.5
"""Times the usual way of a step, beyond which readings were left out: odometers' noise makes half of it or twice."""
UNRELATED = math.sqrt(2.0)
"""What two views that have nothing in common differ by: a greater change tells no more."""
ANNOUNCED, SOON = 0.4, 2
"""Change of the whole view, in one of so many steps before, that announces a greater one: what passes close by grows
over some steps before it hides the rest. In grass it is 0.42 or more before 12 of 14 blades; in rooms, a hall and an
office no undisturbed step changes the view by more than 0.38."""


class UsualChange:
    """Learns how much views change over a step, and tells what is far more.

    announced: whether a step just before the last one changed the view as what passes close by does.
    """

    def __init__(self) -> None:
        self._changes: deque[float] = deque(maxlen=MEMORY)
        self._ways: deque[float] = deque(maxlen=MEMORY)
        self._structures: deque[float] = deque(maxlen=MEMORY)  # the same changes, without light
        self._latest: deque[float] = deque(maxlen=LATELY)
        self._whole: deque[float] = deque(maxlen=SOON)
        self._greatest: list[float] = []  # a heap of the drive's greatest changes
        self._lately = 0.0
        self.announced = False

    @property
    def known(self) -> bool:
        """Whether anything is usual yet."""
        return len(self._changes) >= FEWEST

    @property
    def change(self) -> float:
        """By how much a view usually changes over a step (rms), 0 while that isn't known."""
        return median(self._changes) if self._changes else 0.0

    @property
    def structure(self) -> float:
        """The same without light. Raises StatisticsError before anything was learnt."""
        return median(self._structures)

    @property
    def way(self) -> float:
        """The usual way of a step, turns counted [m]. Raises StatisticsError before anything was learnt."""
        return median(self._ways)

    @property
    def still(self) -> float:
        """Way up to which the wheels stand [m]."""
        return min(STILL, STILL_SHARE * self.way) if self._ways else 0.0

    def note(self, change: float, whole: float) -> None:
        """Take the change of a step before it is judged: by the median of the view's sectors, and of the whole view."""
        self._lately = max(self._latest, default=0.0)
        self._latest.append(change)
        self.announced = max(self._whole, default=0.0) >= ANNOUNCED
        self._whole.append(whole)

    def learn(self, change: float, structure: float, way: float) -> None:
        """Take a step that was as it should be; way: with its turn [m]."""
        self._changes.append(change)
        self._structures.append(structure)
        self._ways.append(way)

    def happened(self, change: float, way: float) -> None:
        """Take the change of a step that was no break, however great; way: of the step, with its turn [m]."""
        if self._longer(way) > LONG:
            return  # readings were left out
        heapq.heappush(self._greatest, change)
        if len(self._greatest) > SELDOM:
            heapq.heappop(self._greatest)

    def exceeded(self, change: float, way: float) -> bool:
        """Return whether a change is far more than those that happen; way: of the step, with its turn [m]."""
        seldom = self._greatest[0] if len(self._greatest) == SELDOM else 0.0
        return self.unusual(change, way) and min(change, UNRELATED) > MORE * seldom

    def unusual(self, change: float, way: float) -> bool:
        """Return whether a change is far more than usual and of late; way: of the step, with its turn [m]."""
        return self.known and change > max(TIMES * self.change * self._longer(way), LEAST, MORE * self._lately)

    def _longer(self, way: float) -> float:
        return max(1.0, way / self.way) if self._ways else 1.0
