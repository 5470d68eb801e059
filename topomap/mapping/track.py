"""The route as it grows: odometry since the last node, and new nodes where they are asked for."""

from __future__ import annotations

import numpy as np

from topomap.core.arrays import FloatArray
from topomap.core.errors import DataError
from topomap.core.geometry import Pose2
from topomap.core.records import Motion
from topomap.core.robot import MotionReading
from topomap.mapping.graph import Node, Snapshot, TopoMap
from topomap.mapping.odometry.gap import GAP, Restated, restated
from topomap.mapping.odometry.increments import Increments, advance, leading

FARTHEST = 1e7
"""[m], [rad] What an increment may count: a quarter of the Earth's circumference; sums of squares stay numbers."""


class Track:
    """Integrates odometry beyond the map's last node and appends or inserts nodes.

    pose: corrected, in the map frame; raw: odometry as read, integrated from the start; motion: the last corrected
    increment; turn: its turn [rad]; travel: the raw odometer way so far [m].
    """

    def __init__(self, topo: TopoMap) -> None:
        self.map = topo
        self.pose = Pose2()
        self.raw = Pose2()
        self.motion = Motion(0.0, 0.0, 0.0, np.zeros((3, 3)), 0.0)
        self.travel = 0.0
        self._stamps: list[int] = []
        self._motions: list[Motion] = []
        self._jump = False  # another drive begins with the next node

    @property
    def turn(self) -> float:
        """The last corrected turn [rad]."""
        return self.motion.turn

    def advance(
        self, stamp_ns: int, reading: MotionReading, broken: bool = False, seen: Restated | None = None
    ) -> Motion:
        """Take one increment as read; return it corrected. The first reading's increment leads nowhere.

        broken: the increment isn't believed; it goes into the map with the covariance of a gap. seen: the step as it
        was seen, where the one that was read isn't believed.
        """
        # plain numbers, as the log hands them back: NumPy's would print otherwise and give the map another hash
        way = float(reading.forward), float(reading.left), float(reading.turn)
        covariance = GAP if broken else np.asarray(reading.covariance, np.float64)
        motion = read = Motion(*way, covariance, float(reading.dt))
        if seen is not None:
            motion = restated(read, seen, self.map.calibration)
        corrected = self.map.calibration.correct(motion)
        self.motion = corrected
        if self.map.nodes:
            self.raw, self.pose = advance(self.raw, read), advance(self.pose, corrected)
            self.travel += abs(motion.forward)
            self._stamps.append(stamp_ns)
            self._motions.append(motion)
        return corrected

    def begin_drive(self, stamp_ns: int, pose: Pose2, covariance: FloatArray, way: float) -> None:
        """Begin another drive on a map at a pose known with covariance (3, 3); the next node is its first.

        way: that the odometer is set on by [m], so that all older places count as left long ago.
        """
        self.map.end_before(stamp_ns)
        last = self.map.chain[-1]
        forward, left, turn = leading(self.map.pose(last).to(pose), self.map.calibration).tolist()
        self.pose, self.travel = pose, self.map.nodes[last].travel + way
        self._stamps, self._motions = [stamp_ns], [Motion(forward, left, turn, covariance, 0.0)]
        self._jump = True

    def node_at(self, stamp_ns: int, snapshot: Snapshot | None = None) -> int:
        """Return the node at a stamp the robot has been at; make one if there is none (a snapshot: only now)."""
        stamp_ns = int(stamp_ns)
        if not self.map.nodes:
            return self.map.add(Node(stamp_ns, 0.0, snapshot), None)
        if stamp_ns <= self.map.nodes[self.map.chain[-1]].stamp_ns:
            return self.map.insert(stamp_ns)
        increments = self._cut(stamp_ns)
        travel = self.travel - sum(abs(m.forward) for m in self._motions)
        jump, self._jump = self._jump, False
        return self.map.add(Node(stamp_ns, travel, snapshot), increments, jump)

    def pose_at(self, stamp_ns: int) -> Pose2:
        """Return the pose at a stamp that the robot has been at."""
        last = self.map.chain[-1]
        if stamp_ns <= self.map.nodes[last].stamp_ns:
            return self.map.pose_at(stamp_ns)
        pose = self.map.pose(last)
        for stamp, motion in zip(self._stamps, self._motions, strict=True):
            if stamp > stamp_ns:
                break
            pose = advance(pose, self.map.calibration.correct(motion))
        return pose

    def restart(self) -> None:
        """Continue from the last node as it stands now: after the map was moved."""
        self.pose = self.map.pose(self.map.chain[-1])
        for motion in self._motions:
            self.pose = advance(self.pose, self.map.calibration.correct(motion))

    def check(self, stamp_ns: int, reading: MotionReading) -> None:
        """Refuse what would only fail later, and elsewhere.

        Raises DataError for a stamp that isn't later than the one before and for an increment that isn't numbers or
        that no odometer counts.
        """
        last = self._last_stamp()
        if last is not None and stamp_ns <= last:
            raise DataError(f"the reading at {stamp_ns} ns isn't later than the one before, at {last} ns")
        if reading.covariance.shape != (3, 3):
            raise DataError(f"odometry at {stamp_ns} ns: the covariance is {reading.covariance.shape}, not (3, 3)")
        numbers = (reading.forward, reading.left, reading.turn, *reading.covariance.flat)
        if not np.isfinite(numbers).all():
            raise DataError(f"odometry at {stamp_ns} ns: an increment or its covariance holds NaN or infinite numbers")
        most = max(numbers[:3], key=abs)
        if abs(most) > FARTHEST:
            raise DataError(f"odometry at {stamp_ns} ns: an increment of {most:.3g}, at most {FARTHEST:g} can be")

    def _last_stamp(self) -> int | None:
        if self._stamps:
            return self._stamps[-1]
        return self.map.nodes[self.map.chain[-1]].stamp_ns if self.map.nodes else None

    def _cut(self, stamp_ns: int) -> Increments:
        k = sum(stamp <= stamp_ns for stamp in self._stamps)
        part = Increments.of(self._stamps[:k], self._motions[:k])
        del self._stamps[:k], self._motions[:k]
        return part
