"""Path integration: raw increments, the calibration that corrects them, and whole edges integrated at once.

An increment is an arc: its translation is laid along the heading in the middle of its turn.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from topomap.core.arrays import FloatArray, IntArray
from topomap.core.errors import ShapeError
from topomap.core.geometry import Pose2, wrap, wrap_all
from topomap.core.records import Motion
from topomap.mapping.odometry.preintegration import accumulate


@dataclass(frozen=True, slots=True)
class Calibration:
    """The odometry's systematic errors as values, in the convention of `topomap.core.records`.

    forward_read = distance_scale * forward; turn_read = rotation_scale * turn + curvature [rad/m] * forward.
    """

    rotation_scale: float = 1.0
    curvature: float = 0.0
    distance_scale: float = 1.0

    def vector(self) -> FloatArray:
        """Return (3,) log rotation_scale, curvature [rad/m], log distance_scale."""
        return np.array([math.log(self.rotation_scale), self.curvature, math.log(self.distance_scale)])

    @staticmethod
    def of(vector: FloatArray) -> Calibration:
        """Return the calibration of a vector (3,) as `vector` gives it."""
        return Calibration(math.exp(vector[0]), float(vector[1]), math.exp(vector[2]))

    def correct(self, motion: Motion) -> Motion:
        """Return what the robot really did when it read `motion`."""
        forward = motion.forward / self.distance_scale
        turn = (motion.turn - self.curvature * forward) / self.rotation_scale
        shrink = np.diag([1 / self.distance_scale, 1 / self.distance_scale, 1 / self.rotation_scale])
        covariance = shrink @ motion.covariance @ shrink
        return Motion(forward, motion.left / self.distance_scale, turn, covariance, motion.dt)


@dataclass(frozen=True, slots=True, eq=False)
class Increments:
    """Raw odometry increments of one edge, K of them, as read and never corrected.

    stamps_ns (K,): the end of each; deltas (K, 3): forward [m], left [m], turn [rad]; covariances (K, 3, 3).
    Raises ShapeError.
    """

    stamps_ns: IntArray
    deltas: FloatArray
    covariances: FloatArray

    def __post_init__(self) -> None:
        k = len(self.stamps_ns)
        if self.deltas.shape != (k, 3) or self.covariances.shape != (k, 3, 3):
            raise ShapeError(
                f"increments need deltas ({k}, 3) and covariances ({k}, 3, 3), "
                f"not {self.deltas.shape} and {self.covariances.shape}"
            )

    def __len__(self) -> int:
        return len(self.stamps_ns)

    @staticmethod
    def empty() -> Increments:
        """Return no increments."""
        return Increments(np.zeros(0, np.int64), np.zeros((0, 3)), np.zeros((0, 3, 3)))

    @staticmethod
    def of(stamps_ns: Sequence[int], motions: Sequence[Motion]) -> Increments:
        """Return the increments of motions as read, each with the stamp of its end."""
        deltas = np.array([(m.forward, m.left, m.turn) for m in motions], float).reshape(-1, 3)
        covariances = np.array([m.covariance for m in motions], float).reshape(-1, 3, 3)
        return Increments(np.array(stamps_ns, np.int64), deltas, covariances)

    @staticmethod
    def concatenate(parts: Sequence[Increments]) -> Increments:
        """Return all increments of the parts, in their order."""
        if not parts:
            return Increments.empty()
        return Increments(
            np.concatenate([p.stamps_ns for p in parts]),
            np.concatenate([p.deltas for p in parts]),
            np.concatenate([p.covariances for p in parts]),
        )

    def split(self, k: int) -> tuple[Increments, Increments]:
        """Return the first k increments and the rest."""
        return self[:k], self[k:]

    def __getitem__(self, part: slice) -> Increments:
        return Increments(self.stamps_ns[part], self.deltas[part], self.covariances[part])


class Preintegrated(NamedTuple):
    """E edges integrated in raw odometry units (metres as read, radians as read; headings corrected).

    translation (E, 2): p_raw in the frame of the edge's start; turn (E,), forward (E,): sums as read;
    by_rotation, by_bend (E, 2): the translation's derivatives by log rotation scale and by the curvature per
    metre as read; covariance (E, 3, 3) of translation and turn as read.
    """

    translation: FloatArray
    turn: FloatArray
    forward: FloatArray
    by_rotation: FloatArray
    by_bend: FloatArray
    covariance: FloatArray

    def deltas(self, calibration: Calibration) -> FloatArray:
        """Return (E, 3) the calibrated relative poses x, y [m], turn [rad] (unwrapped)."""
        bend = calibration.curvature / calibration.distance_scale
        turn = (self.turn - bend * self.forward) / calibration.rotation_scale
        return np.column_stack([self.translation / calibration.distance_scale, turn])

    def covariances(self, calibration: Calibration) -> FloatArray:
        """Return (E, 3, 3) the random covariance of `deltas`."""
        d, r = 1 / calibration.distance_scale, 1 / calibration.rotation_scale
        shrink = np.array([d, d, r])
        return np.asarray(self.covariance * (shrink[:, None] * shrink[None, :]))

    def jacobians(self, calibration: Calibration) -> FloatArray:
        """Return (E, 3, 3) the derivatives of `deltas` by `Calibration.vector`."""
        d, bend = calibration.distance_scale, calibration.curvature / calibration.distance_scale
        jacobian = np.empty((len(self.turn), 3, 3))
        jacobian[:, :2, 0] = self.by_rotation / d
        jacobian[:, :2, 1] = self.by_bend / d**2
        jacobian[:, :2, 2] = -(self.translation + bend * self.by_bend) / d
        jacobian[:, 2, 0] = -self.deltas(calibration)[:, 2]
        jacobian[:, 2, 1] = -self.forward / (d * calibration.rotation_scale)
        jacobian[:, 2, 2] = bend * self.forward / calibration.rotation_scale
        return jacobian


@dataclass(frozen=True, slots=True, eq=False)
class EdgeIncrements:
    """The increments of E edges in one piece: deltas (K, 3), covariances (K, 3, 3), starts (E + 1,)."""

    deltas: FloatArray
    covariances: FloatArray
    starts: IntArray

    @staticmethod
    def of(edges: Sequence[Increments]) -> EdgeIncrements:
        """Return the edges' increments in one piece."""
        joined = Increments.concatenate(edges)
        starts = np.concatenate([[0], np.cumsum([len(e) for e in edges], dtype=np.int64)]).astype(np.int64)
        return EdgeIncrements(np.ascontiguousarray(joined.deltas), np.ascontiguousarray(joined.covariances), starts)

    def first(self, count: int) -> EdgeIncrements:
        """Return the first edges, as many as count."""
        last = self.starts[count]
        return EdgeIncrements(self.deltas[:last], self.covariances[:last], self.starts[: count + 1])

    def after(self, count: int) -> EdgeIncrements:
        """Return the edges without the first ones, as many as count."""
        first = self.starts[count]
        return EdgeIncrements(self.deltas[first:], self.covariances[first:], self.starts[count:] - first)

    def followed_by(self, other: EdgeIncrements) -> EdgeIncrements:
        """Return these edges and then others."""
        if len(other.starts) == 1:
            return self
        return EdgeIncrements(
            np.concatenate([self.deltas, other.deltas]),
            np.concatenate([self.covariances, other.covariances]),
            np.concatenate([self.starts, self.starts[-1] + other.starts[1:]]),
        )

    def integrate(self, calibration: Calibration) -> Preintegrated:
        """Integrate every edge with the calibration."""
        bend = calibration.curvature / calibration.distance_scale
        rho = 1 / calibration.rotation_scale
        return Preintegrated(*accumulate(self.deltas, self.covariances, self.starts, rho, bend))

    def read_by(self, theirs: Calibration, ours: Calibration) -> EdgeIncrements:
        """Return the increments as another odometer would have read what the first one read.

        theirs, ours: the errors of the odometer that read them and of the other one.
        """
        f, left, turn = self.deltas.T
        forward = f / theirs.distance_scale
        true_turn = (turn - theirs.curvature * forward) / theirs.rotation_scale
        scale = ours.distance_scale / theirs.distance_scale
        read = np.column_stack([
            ours.distance_scale * forward, scale * left, ours.rotation_scale * true_turn + ours.curvature * forward
        ])  # fmt: skip
        shrink = np.array([scale, scale, ours.rotation_scale / theirs.rotation_scale])
        return EdgeIncrements(read, self.covariances * (shrink[:, None] * shrink[None, :]), self.starts)


def integrate(increments: Increments, calibration: Calibration) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Integrate one edge: relative pose, its random covariance and its dependence on the calibration.

    Returns delta (3,) x, y [m], turn [rad, wrapped] in the frame of the edge's start, covariance (3, 3), and
    the Jacobian (3, 3) of delta by (log rotation_scale, curvature, log distance_scale).
    """
    edge = EdgeIncrements.of([increments]).integrate(calibration)
    delta = edge.deltas(calibration)[0]
    delta[2] = wrap(delta[2])
    return delta, edge.covariances(calibration)[0], edge.jacobians(calibration)[0]


def leading(relative: Pose2, calibration: Calibration) -> FloatArray:
    """Return the raw increment (3,) forward, left [m], turn [rad] that leads along `relative` when corrected."""
    c, s = math.cos(relative.heading / 2), math.sin(relative.heading / 2)
    forward, left = c * relative.x + s * relative.y, c * relative.y - s * relative.x
    turn = calibration.rotation_scale * relative.heading + calibration.curvature * forward
    return np.array([calibration.distance_scale * forward, calibration.distance_scale * left, turn])


def advance(pose: Pose2, motion: Motion) -> Pose2:
    """Return the pose after a (corrected) motion, laid as an arc."""
    c, s = math.cos(motion.turn / 2), math.sin(motion.turn / 2)
    step = Pose2(c * motion.forward - s * motion.left, s * motion.forward + c * motion.left, motion.turn)
    return pose @ step


def track(increments: Increments, calibration: Calibration, start: Pose2 | None = None) -> FloatArray:
    """Return (K + 1, 3) the poses before and after every increment, from `start` (default the origin)."""
    origin = start or Pose2()
    forward, left = increments.deltas[:, 0] / calibration.distance_scale, increments.deltas[:, 1]
    left = left / calibration.distance_scale
    turn = (increments.deltas[:, 2] - calibration.curvature * forward) / calibration.rotation_scale
    middle = origin.heading + np.cumsum(turn) - turn / 2
    steps = np.column_stack([np.cos(middle) * forward - np.sin(middle) * left,
                             np.sin(middle) * forward + np.cos(middle) * left, turn])  # fmt: skip
    poses = np.vstack([origin.array(), origin.array() + np.cumsum(steps, axis=0)])
    poses[:, 2] = wrap_all(poses[:, 2])
    return poses
