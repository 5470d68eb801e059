"""A pose graph's odometry as the back end takes it: increments, poses and the travelled chain."""

from __future__ import annotations

import numpy as np

from topomap.core.arrays import FloatArray
from topomap.core.geometry import compose
from topomap.mapping.odometry.increments import Calibration, Increments, Preintegrated
from topomap.mapping.optimizer import OdometryEdge
from topomap.mapping.pose_graph import PoseGraph
from topomap.mapping.uncertainty.odometry_chain import Chain

HELD = (1e-6, 1e-6, 1e-6)  # a pose graph's odometry has no systematic error to find


def odometry_edges(graph: PoseGraph) -> tuple[OdometryEdge, ...]:
    """Return the graph's odometry as increments, one an edge, laid as an arc."""
    half = graph.odometry[:, 2] / 2
    c, s = np.cos(half), np.sin(half)
    x, y = graph.odometry[:, 0], graph.odometry[:, 1]
    deltas = np.column_stack([c * x + s * y, c * y - s * x, graph.odometry[:, 2]])
    carry = np.zeros((len(half), 3, 3))  # what the arc does to the increment's noise, undone below
    carry[:, 0, 0], carry[:, 0, 1], carry[:, 1, 0], carry[:, 1, 1], carry[:, 2, 2] = c, -s, s, c, 1.0
    carry[:, 0, 2], carry[:, 1, 2] = -y / 2, x / 2
    undo = np.linalg.inv(carry)
    covariances = undo @ graph.odometry_covariance @ undo.transpose(0, 2, 1)
    rows = zip(deltas, covariances, strict=True)
    return tuple(
        OdometryEdge(k, k + 1, Increments(np.array([k + 1]), d[None], q[None])) for k, (d, q) in enumerate(rows)
    )


def extended(poses: FloatArray, odometry: FloatArray) -> FloatArray:
    """Return poses (N, 3) and those that odometry (n, 3) adds to them (N + n, 3)."""
    rows = list(poses)
    for step in odometry:
        rows.append(compose(rows[-1], step))
    return np.array(rows)


def odometry_poses(graph: PoseGraph) -> FloatArray:
    """Return the poses (N, 3) by odometry alone."""
    return extended(np.zeros((1, 3)), graph.odometry)


def chain_of(poses: FloatArray, edges: Preintegrated) -> Chain:
    """Return the chain of the first poses (n, 3), whose odometry begins `edges`."""
    some = Preintegrated(*(part[: len(poses) - 1] for part in edges))
    return Chain.of(poses, some, Calibration(), np.diag(np.square(HELD)))


def volume(poses: FloatArray) -> float:
    """Return the area of the drive [m^2] times all headings [rad]: all that a claim might say."""
    width, height = np.maximum(np.ptp(poses[:, :2], axis=0), 1.0)
    return float(width * height * 2 * np.pi)
