"""Looking for a milestone: its view against the current one, turned as it may be."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from topomap.core.geometry import TAU, Pose2, wrap, wrap_all
from topomap.core.panorama import Panorama
from topomap.core.records import Alignment, HomeVector
from topomap.navigation.arrival import Arrival
from topomap.vision.aligned_homing import AlignedHoming
from topomap.vision.image.aligned_difference import aligned_difference
from topomap.vision.image.compare import signature, squared_differences

NEAR_TURN = 0.5
"""[rad] A compass reading this near the tracked rotation is the same one: the aligner searches as far itself."""
CLEARLY = 0.8
"""Share of the squared difference at the tracked rotation below which another rotation is looked at: pixel noise
changes it by 0.01."""
KNOWN = 0.6
"""Difference below which another rotation is taken: the place itself within 0.2 m. In a corridor the view turned round
has 0.9 and more, and from a metre off both ways are as unlike."""
SEEN = 0.8
"""Difference below which a milestone was seen in passing: 0.42 to 0.87 at 0.3 m over 75 places of three worlds, 0.75 to
1.6 from 1 m on."""

STANDING = 0.02
"""[m] Way below which a robot has but turned: a step near the goal is 5 cm."""


@dataclass(frozen=True, slots=True)
class Look:
    """What one look at a milestone told: the home vector, the difference of the aligned views, and the rotation [rad].

    there: the difference has passed its minimum, or is that of the place itself; turned: another rotation than the
    tracked one was taken.
    """

    home: HomeVector
    difference: float
    rotation: float
    there: bool = False
    turned: bool = False


class Sight:
    """One milestone in view: the rotation against it is tracked by odometry and compass, the full turn is searched.

    place: where it stands in the course; rotation [rad]: the robot's heading minus the milestone's; least: the lowest
    difference seen so far.
    """

    def __init__(self, place: int, node: int, view: Panorama, rotation: float, arrival: Arrival | None = None) -> None:
        self.place, self.node, self.view = place, node, view
        self.rotation = rotation
        self.arrival = arrival or Arrival()
        self.least = float("inf")
        self.looks = 0
        self._looked_from: Pose2 | None = None

    @property
    def seen(self) -> bool:
        """Whether the milestone's view was met."""
        return self.least < SEEN

    def expect(self, rotation: float) -> None:
        """Take a rotation [rad] that is believed where the tracked one is another: a corridor looks alike both ways."""
        if abs(wrap(self.rotation - rotation)) > NEAR_TURN:
            self.rotation = rotation

    def has_moved(self, here: Pose2) -> bool:
        """Return whether the robot, by odometry at `here`, has come on since it last had, and not but turned."""
        moved = self._looked_from is None or here.distance(self._looked_from) > STANDING
        if moved:
            self._looked_from = here
        return moved

    def look(
        self, panorama: Panorama, homing: AlignedHoming, wide: bool = True, moved: bool = True,
        counts: bool | None = None,
    ) -> Look:  # fmt: skip
        """Return what is seen of the milestone now.

        wide: any rotation is looked at, not those near the tracked one; moved, counts: as `Arrival.update` has them.
        """
        self.looks += 1
        found = homing.align(panorama, self.view, self.rotation)
        difference = aligned_difference(panorama, self.view, found.rotation)
        turned = False
        elsewhere = self._elsewhere(panorama, found.rotation) if wide else None
        if elsewhere is not None:
            other = homing.align(panorama, self.view, elsewhere)
            less = aligned_difference(panorama, self.view, other.rotation)
            if less < min(KNOWN, difference):
                found, difference, turned = other, less, True
        there = self.arrival.update(difference, moved, counts)
        return self._told(found, difference, turned, there)

    def _told(self, found: Alignment, difference: float, turned: bool, there: bool) -> Look:
        self.rotation = found.rotation
        self.least = min(self.least, difference)
        home = found.home or HomeVector(0.0, None, 0.0)
        return Look(home, difference, found.rotation, there, turned)

    def _elsewhere(self, panorama: Panorama, rotation: float) -> float | None:
        """Return a rotation far from the tracked one at which the views are clearly more alike, if there is one."""
        squares = squared_differences(signature(panorama), signature(self.view).spectrum[np.newaxis])[0]
        angles = np.arange(len(squares)) * TAU / len(squares)
        near = np.abs(wrap_all(angles - rotation)) <= NEAR_TURN
        best = int(np.argmin(squares))
        if near[best] or squares[best] >= CLEARLY * float(squares[near].min()):
            return None
        return wrap(float(angles[best]))
