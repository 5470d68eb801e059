"""Where the robot believes it is, and how sure."""

from __future__ import annotations

import math

import numpy as np

from topomap.core.records import MapChange, Where
from topomap.mapping.mapper import Mapper
from topomap.navigation.localiser.start import HERE, Start


class Localiser:
    """Names the nearest node of the map and the probability of being lost.

    The probability is a logistic function of the image difference to the best-matching older place, where one was
    searched; a view like no other place while the map says that one is near means lost.
    """

    def __init__(self, start: Start = HERE, familiar: float = 0.9, softness: float = 0.08) -> None:
        """start: where the belief begins; on a fresh map there is but one place."""
        self._start = start
        self._familiar = familiar
        self._softness = softness

    def update(self, mapper: Mapper, change: MapChange) -> Where:
        """Return the belief of this step."""
        node = self._nearest(mapper, change)
        place = change.place
        if place is None:
            return Where(change.pose, node, change.difference, 0.0)
        lost = 1.0 / (1.0 + math.exp((self._familiar - place.difference) / self._softness))
        near = node is not None and mapper.map.length(node, place.node) < 1.0
        return Where(change.pose, node, place.difference, lost if near else 0.0)

    def _nearest(self, mapper: Mapper, change: MapChange) -> int | None:
        poses = mapper.map.poses
        if not len(poses):
            return None
        offsets = np.hypot(poses[:, 0] - change.pose.x, poses[:, 1] - change.pose.y)
        return int(np.argmin(offsets))
