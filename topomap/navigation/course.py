"""The planned way as a line on the map: how far the robot has come along it, where to head, which view comes next."""

from __future__ import annotations

import numpy as np

from topomap.core.arrays import FloatArray
from topomap.core.geometry import Pose2
from topomap.mapping.graph import TopoMap

BACK, AHEAD = 0.5, 1.5
"""[m] Around the last position along the course in which the next one is looked for: a loop of it isn't cut short."""

JUMP = 0.5
"""[m] Where another part of the course is nearer by this, the belief has been set right."""


class Course:
    """A path of nodes, followed from its beginning; the poses are the map's as they stand now."""

    def __init__(self, topo: TopoMap, path: list[int]) -> None:
        self._topo = topo
        self.path = path
        self.milestones = [k for k, node in enumerate(path) if topo.nodes[node].snapshot is not None]
        self.along = 0.0

    @property
    def goal(self) -> int:
        """The last node."""
        return self.path[-1]

    def lengths(self) -> FloatArray:
        """Return the way (K,) [m] along the course at each of its nodes."""
        points = self._points()
        steps = np.hypot(*np.diff(points, axis=0).T) if len(points) > 1 else np.zeros(0)
        return np.concatenate([[0.0], np.cumsum(steps)])

    @property
    def length(self) -> float:
        """The whole way [m]."""
        return float(self.lengths()[-1])

    @property
    def left(self) -> float:
        """What is left of it [m]."""
        return self.length - self.along

    def follow(self, pose: Pose2) -> float:
        """Set how far the robot has come, by the nearest point of the course; return how far it is off it [m]."""
        points, at = self._points(), self.lengths()
        if len(points) == 1:
            return pose.distance(self._topo.pose(self.goal))
        a, b = points[:-1], points[1:]
        step = b - a
        square = np.maximum((step**2).sum(axis=1), 1e-12)
        here = np.array([pose.x, pose.y])
        share = np.clip(((here - a) * step).sum(axis=1) / square, 0.0, 1.0)
        place = at[:-1] + share * np.diff(at)
        off = np.hypot(*(a + share[:, None] * step - here).T)
        near = (place >= self.along - BACK) & (place <= self.along + AHEAD)
        best, nearest = int(np.argmin(np.where(near, off, np.inf))), int(np.argmin(off))
        if not near.any() or off[best] > off[nearest] + JUMP:
            best = nearest
        self.along = float(place[best])
        return float(off[best])

    def reach(self, k: int) -> None:
        """Set that the robot is at the k-th node of the path."""
        self.along = float(self.lengths()[k])

    def point(self, ahead: float) -> Pose2:
        """Return the point of the course so far [m] ahead of where the robot is along it; heading 0."""
        points, at = self._points(), self.lengths()
        s = min(self.along + ahead, float(at[-1]))
        return Pose2(float(np.interp(s, at, points[:, 0])), float(np.interp(s, at, points[:, 1])))

    def next_milestone(self, after: int, beyond: float) -> int | None:
        """Return the place in the path of the first milestone past place `after` that lies `beyond` [m] ahead."""
        at = self.lengths()
        return next((k for k in self.milestones if k > after and at[k] >= self.along + beyond), None)

    def _points(self) -> FloatArray:
        points: FloatArray = self._topo.poses[self.path, :2]
        return points
