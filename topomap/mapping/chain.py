"""The travelled chain of nodes: how well odometry knows one node's pose in another's frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from topomap.geometry import FloatArray, between
from topomap.mapping.odometry import Calibration, IntArray, Preintegrated


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
        poses: FloatArray, edges: Preintegrated, calibration: Calibration, calibration_covariance: FloatArray
    ) -> Chain:
        """Sum up the N - 1 edges between poses (N, 3), which stand in travel order."""
        carry = _carry(poses)
        random = carry @ edges.covariances(calibration) @ carry.transpose(0, 2, 1)
        systematic = carry @ edges.jacobians(calibration)
        steps = np.abs(edges.forward) / calibration.distance_scale
        return Chain(
            poses,
            np.concatenate([[0.0], np.cumsum(steps)]),
            _from_zero(random),
            _from_zero(systematic),
            calibration_covariance,
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

    def covariance_via(self, i: int, j: int, a: IntArray, b: IntArray, closures: FloatArray) -> FloatArray:
        """Return (3, 3) covariance of `i_from_j` by the best of the direct way and one closure on the way.

        i, j: chain positions; a, b (n,): the closures' ends; closures (n, 3, 3): their covariances. Errors
        along the way are taken as independent.
        """
        n = len(a)
        first, last = np.concatenate([a, b]), np.concatenate([b, a])
        here, there = np.full(2 * n, i), np.full(2 * n, j)
        to_first = between(self.poses[here], self.poses[first])
        to_last = between(self.poses[here], self.poses[last])
        start = self.covariance(here, first)
        middle = composed_covariance(
            to_first,
            start,
            between(self.poses[first], self.poses[last]),
            np.concatenate([closures, closures]),
        )
        onward = between(self.poses[last], self.poses[there])
        ways = composed_covariance(to_last, middle, onward, self.covariance(last, there))
        ways = np.concatenate([self.covariance(np.array([i]), np.array([j])), ways])
        return np.asarray(ways[int(np.argmin(ways[:, 0, 0] + ways[:, 1, 1]))])

    def path(self, i: IntArray, j: IntArray) -> FloatArray:
        """Return (n,) the path lengths [m] between chain positions."""
        return np.abs(self.travelled[j] - self.travelled[i])


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


def _carry(poses: FloatArray) -> FloatArray:
    """Return (N - 1, 3, 3) that carry an edge's error to the origin of the map frame."""
    return _lever(-poses[1:, :2]) @ _rotation(poses[:-1, 2])


def _from_zero(steps: FloatArray) -> FloatArray:
    return np.concatenate([np.zeros((1, 3, 3)), np.cumsum(steps, axis=0)])


def composed_covariance(a: FloatArray, a_covariance: FloatArray, b: FloatArray, b_covariance: FloatArray) -> FloatArray:
    """Return (n, 3, 3) covariances of the poses a b (n, 3), each given with the covariance of its own."""
    rotation = _rotation(a[:, 2])
    ahead = (rotation[:, :2, :2] @ b[:, :2, None])[:, :, 0]
    lever = _lever(ahead)
    first = lever @ a_covariance @ lever.transpose(0, 2, 1)
    return np.asarray(first + rotation @ b_covariance @ rotation.transpose(0, 2, 1))
