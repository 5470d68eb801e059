"""How clearly a place would speak against each rival, were the robot there: told by the map's own views."""

from __future__ import annotations

import numpy as np

from topomap.core.arrays import FloatArray, IntArray
from topomap.core.geometry import Pose2, between, compose
from topomap.mapping.mapper import Mapper
from topomap.navigation.localiser.belief import REACH
from topomap.navigation.localiser.likeness import THERE
from topomap.navigation.localiser.tint import unlike
from topomap.navigation.localiser.views import Usual, look, usual
from topomap.navigation.localiser.weighing import HARDEST, against
from topomap.vision.image.surroundings import surroundings

BESIDE = 3
"""Places near a rival's spot that are compared, as the belief does."""


class Parting:
    """Holds what would be seen at one place's stops against what its rivals would have the robot see there."""

    def __init__(self, mapper: Mapper, here: Pose2, rivals: FloatArray) -> None:
        """here: the likeliest pose; rivals (R, 3): the other ones."""
        self._mapper = mapper
        self._here, self._rivals = here.array(), rivals
        self._first = mapper.located
        self._usual: Usual | None = None

    def against(self, node: int) -> FloatArray:
        """Return (R,) what a stretch at a node's place, seen as that node saw it, would say against each rival [nats].

        A rival that has no place of the map there can't look like it.
        """
        nodes = self._mapper.recognition.nodes()[: self._first]
        places = self._mapper.map.poses[nodes]
        spots = compose(self._rivals, between(self._here, self._mapper.map.poses[node]))
        away = np.hypot(*(spots[:, None, :2] - places[None, :, :2]).transpose(2, 0, 1))
        near = [np.argsort(row, kind="stable")[:BESIDE] for row in away]
        near = [which[row[which] <= REACH] for which, row in zip(near, away, strict=True)]
        squares = self._squares(node, near, spots, places, nodes)
        return np.where(np.isfinite(squares), against(squares, THERE**2), HARDEST)

    def _squares(
        self, node: int, near: list[IntArray], spots: FloatArray, places: FloatArray, nodes: IntArray
    ) -> FloatArray:
        """Return (R,) the least squared likeness of a node's view to the places near each rival's spot; infinite where
        there are none.
        """
        panorama = self._mapper.view_cache.panorama(node)
        view, recognition = surroundings(panorama), self._mapper.recognition
        self._usual = self._usual or usual(view, recognition, self._first)
        seen = look(view, recognition, np.concatenate(near), 0, self._first, self._usual)
        squares = np.full(len(near), np.inf)
        for k, which in enumerate(near):
            if not len(which):
                continue
            found = seen.at(which, spots[k, 2] - places[which, 2])
            best = int(np.argmin(found.likeness))
            other = self._mapper.view_cache.panorama(int(nodes[which[best]]))
            x, y = found.points[best].tolist()
            squares[k] = found.likeness[best] ** 2 + unlike(panorama, other, float(found.rotations[best]), (x, y))
        return squares
