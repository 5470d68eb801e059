"""The travelled chain of nodes: how well odometry knows one node's pose in another's frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from topomap.core.arrays import FloatArray, IntArray
from topomap.mapping.odometry.increments import Calibration, Preintegrated


@dataclass(frozen=True, slots=True, eq=False)
class Chain:
    """N nodes in travel order with everything summed along the way, so that any pair costs the same.

    poses (N, 3) in the map frame; travelled (N,) path length [m]; random (N, 3, 3) and systematic (N, 3, 3):
    sums of the edges' covariances and calibration derivatives, carried to the map's origin; calibration
    (3, 3): covariance of `Calibration.vector`.
    """

    poses: FloatArray
    travelled: FloatArray
    random: FloatArray
    systematic: FloatArray
    calibration: FloatArray

    @staticmethod
    def of(
        poses: FloatArray,
        edges: Preintegrated,
        calibration: Calibration,
        calibration_covariance: FloatArray,
        head: Chain | None = None,
        turn_variances: FloatArray | None = None,
    ) -> Chain:
        """Sum up the edges between poses (N, 3), which stand in travel order.

        head: the chain of the first nodes, summed up already; then `edges` are those from its last node on.
        turn_variances (E,) [rad^2]: of turns that were measured beside the odometry's; infinite where none was.
        """
        first = 0 if head is None else len(head.poses) - 1
        carry = carried_to_origin(poses[first:-1], poses[first + 1 :])
        noise, response = edges.covariances(calibration), edges.jacobians(calibration)
        if turn_variances is not None:
            noise, response = _with_turns(noise, response, turn_variances)
        random = carry @ noise @ carry.transpose(0, 2, 1)
        systematic = carry @ response
        steps = np.abs(edges.forward) / calibration.distance_scale
        return Chain(
            poses,
            _summed(steps, None if head is None else head.travelled),
            _summed(random, None if head is None else head.random),
            _summed(systematic, None if head is None else head.systematic),
            calibration_covariance,
        )

    @staticmethod
    def held(poses: FloatArray, noise: FloatArray, steps: FloatArray) -> Chain:
        """Sum up edges without systematic errors: poses (N, 3), noise (N - 1, 3, 3) of each and its length (N - 1,)."""
        carry = carried_to_origin(poses[:-1], poses[1:])
        random = carry @ noise @ carry.transpose(0, 2, 1)
        nothing = np.zeros((len(poses), 3, 3))
        return Chain(poses, _summed(steps, None), _summed(random, None), nothing, np.zeros((3, 3)))

    def head(self, count: int) -> Chain:
        """Return the chain of the first nodes, as many as count."""
        return Chain(
            self.poses[:count], self.travelled[:count], self.random[:count], self.systematic[:count], self.calibration
        )

    def covariance(self, i: IntArray, j: IntArray) -> FloatArray:
        """Return (n, 3, 3) covariances of `i_from_j` for chain positions i, j (n,) in either order.

        An edge's error moves every later node and turns it about the edge's end; summed in the map frame that
        is U_j (S_j - S_i) U_j^T, U_j carrying the sum from the origin to node j.
        """
        low, high = np.minimum(i, j), np.maximum(i, j)
        systematic = self.systematic[high] - self.systematic[low]
        total = self.random[high] - self.random[low]
        total = total + systematic @ self.calibration @ systematic.transpose(0, 2, 1)
        turn = _rotation(-self.poses[i, 2]) @ _lever(self.poses[j, :2])
        return np.asarray(turn @ total @ turn.transpose(0, 2, 1))

    def path(self, i: IntArray, j: IntArray) -> FloatArray:
        """Return (n,) the path lengths [m] between chain positions."""
        return np.abs(self.travelled[j] - self.travelled[i])


def _with_turns(noise: FloatArray, response: FloatArray, variances: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return what is left of odometry's errors once turns were measured: noise (E, 3, 3) and response (E, 3, 3).

    A turn updates its edge as a measurement updates a Kalman filter (in Joseph's form), so that random and systematic
    errors shrink alike.
    """
    gain = noise[:, :, 2] / (noise[:, 2, 2] + variances)[:, None]
    left = np.tile(np.eye(3), (len(noise), 1, 1))
    left[:, :, 2] -= gain
    finite = np.where(np.isfinite(variances), variances, 0.0)  # without a measurement the gain is 0
    measured = gain[:, :, None] * gain[:, None, :] * finite[:, None, None]
    return left @ noise @ left.transpose(0, 2, 1) + measured, left @ response


def _rotation(angles: FloatArray) -> FloatArray:
    matrix = np.zeros((len(angles), 3, 3))
    matrix[:, 0, 0] = matrix[:, 1, 1] = np.cos(angles)
    matrix[:, 1, 0] = np.sin(angles)
    matrix[:, 0, 1] = -matrix[:, 1, 0]
    matrix[:, 2, 2] = 1.0
    return matrix


def _lever(points: FloatArray) -> FloatArray:
    """Return (n, 3, 3) what a turn about the origin does to points (n, 2)."""
    matrix = np.broadcast_to(np.eye(3), (len(points), 3, 3)).copy()
    matrix[:, 0, 2], matrix[:, 1, 2] = -points[:, 1], points[:, 0]
    return matrix


def carried_to_origin(start: FloatArray, end: FloatArray) -> FloatArray:
    """Return (n, 3, 3) that carry errors of `start_from_end`, poses (n, 3), to the origin of the map frame."""
    return _lever(-end[:, :2]) @ _rotation(start[:, 2])


def _summed(steps: FloatArray, before: FloatArray | None) -> FloatArray:
    """Return the sums of steps (n, ...) from zero, or from the last of those before."""
    head = np.zeros((1, *steps.shape[1:])) if before is None else before
    return np.concatenate([head, head[-1] + np.cumsum(steps, axis=0)])


def turned_by(angles: FloatArray, covariance: FloatArray) -> FloatArray:
    """Return covariances (n, 3, 3) in axes turned by angles (n,) [rad]."""
    rotation = _rotation(angles)
    return np.asarray(rotation @ covariance @ rotation.transpose(0, 2, 1))
