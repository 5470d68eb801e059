"""A recorded drive cut into nodes: one at each stamp that is asked for, and both ends."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from topomap.core.arrays import BoolArray, FloatArray, IntArray
from topomap.core.geometry import Pose2, between, compose
from topomap.mapping.odometry.increments import Calibration, EdgeIncrements, Increments, Preintegrated, track
from topomap.mapping.optimizer import OdometryEdges
from topomap.mapping.uncertainty.odometry_chain import Chain


@dataclass(frozen=True, eq=False)
class RecordedDrive:
    """K + 1 stamps (ns) around K raw increments; marks (N,): which of these stamps are nodes."""

    stamps_ns: IntArray
    increments: Increments
    marks: IntArray

    def node_at(self, stamps_ns: IntArray) -> IntArray:
        """Return (M,) the nodes at stamps [ns], -1 where there is none."""
        place = np.searchsorted(self.node_stamps, stamps_ns)
        place = np.minimum(place, len(self.marks) - 1)
        return np.where(self.node_stamps[place] == stamps_ns, place, -1)

    @cached_property
    def node_stamps(self) -> IntArray:
        """The nodes' stamps (N,) [ns]."""
        return self.stamps_ns[self.marks]

    @cached_property
    def edges(self) -> OdometryEdges:
        """The odometry from each node to the next."""
        place = np.arange(len(self.marks))
        deltas, covariances = (np.ascontiguousarray(x) for x in (self.increments.deltas, self.increments.covariances))
        return OdometryEdges(place[:-1], place[1:], EdgeIncrements(deltas, covariances, self.marks.astype(np.int64)))

    @cached_property
    def way(self) -> FloatArray:
        """The way travelled up to each node (N,) [m as read]."""
        return self.travelled[self.marks]

    @cached_property
    def travelled(self) -> FloatArray:
        """The way travelled up to each stamp (K + 1,) [m as read]."""
        steps = np.hypot(self.increments.deltas[:, 0], self.increments.deltas[:, 1])
        return np.concatenate([[0.0], np.cumsum(steps)])

    def straight(self, length: float, largest: float) -> BoolArray:
        """Return (N,) whether the drive turns by at most `largest` [rad] over `length` [m] around each node."""
        way = self.travelled
        turned = np.concatenate([[0.0], np.cumsum(self.increments.deltas[:, 2])])
        before = np.searchsorted(way, way[self.marks] - length / 2)
        after = np.minimum(np.searchsorted(way, way[self.marks] + length / 2), len(way) - 1)
        inside = (way[self.marks] >= length / 2) & (way[self.marks] <= way[-1] - length / 2)
        return np.asarray(inside & (np.abs(turned[after] - turned[before]) <= largest))

    def dead_reckoning(self, calibration: Calibration) -> FloatArray:
        """Return (K + 1, 3) the calibrated odometry's poses at all stamps."""
        return track(self.increments, calibration)

    def extended(self, poses: FloatArray, nodes: int, calibration: Calibration) -> FloatArray:
        """Return the poses (n, 3) of the first n nodes, continued by odometry to the first `nodes`."""
        first, last = int(self.marks[len(poses) - 1]), int(self.marks[nodes - 1])
        onward = track(self.increments[first:last], calibration, Pose2.of(poses[-1]))
        return np.vstack([poses, onward[self.marks[len(poses) : nodes] - first]])

    def chain(self, poses: FloatArray, calibration: Calibration, covariance: FloatArray) -> Chain:
        """Return the chain of the first n nodes with poses (n, 3), calibration and its covariance (3, 3)."""
        edges = Preintegrated(*(part[: len(poses) - 1] for part in self.edges.increments.integrate(calibration)))
        return Chain.of(poses, edges, calibration, covariance)

    def between_nodes(self, poses: FloatArray, calibration: Calibration, first: int = 0) -> tuple[IntArray, FloatArray]:
        """Return the stamps (S,) from node `first` to the last of poses (n, 3) and the poses (S, 3) at them."""
        begin, end = int(self.marks[first]), int(self.marks[len(poses) - 1])
        odometry = track(self.increments[begin:end], calibration)
        places = np.arange(begin, end + 1)
        node = np.searchsorted(self.marks[: len(poses)], places, side="right") - 1
        since = between(odometry[self.marks[node] - begin], odometry)
        return self.stamps_ns[begin : end + 1], compose(poses[node], since)
