"""Chains of odometry for tests of what they know: random walks with noise of any shape, and drives out and back."""

from __future__ import annotations

import numpy as np

from topomap.core.arrays import FloatArray
from topomap.core.geometry import compose
from topomap.mapping.odometry.increments import Calibration, EdgeIncrements
from topomap.mapping.uncertainty.odometry_chain import Chain

UNSURE = np.diag([0.05, 0.01, 0.1]) ** 2  # covariance of a calibration that nobody found out
HELD = np.zeros((3, 3))


def chain_of(steps: FloatArray, noise: FloatArray, calibration: FloatArray = HELD) -> Chain:
    """Return the chain of steps (N - 1, 3), each one increment, with covariances (N - 1, 3, 3)."""
    edges = EdgeIncrements(np.ascontiguousarray(steps), np.ascontiguousarray(noise), np.arange(len(steps) + 1))
    whole = edges.integrate(Calibration())
    poses = [np.zeros(3)]
    for delta in whole.deltas(Calibration()):
        poses.append(compose(poses[-1], delta))
    return Chain.of(np.array(poses), whole, Calibration(), calibration)


def walk(nodes: int, seed: int = 0, calibration: FloatArray = HELD, turn: float = 0.3) -> Chain:
    """Return a walk of steps of some 1 m that turns at random; no two steps are equally sure."""
    rng = np.random.default_rng(seed)
    size = rng.uniform(0.5, 1.5, nodes - 1)
    steps = np.column_stack([size, 0.1 * rng.normal(size=nodes - 1), turn * rng.normal(size=nodes - 1)])
    root = rng.normal(size=(nodes - 1, 3, 3)) * np.array([0.05, 0.05, 0.02])[:, None]
    return chain_of(steps, root @ root.transpose(0, 2, 1) + 1e-8 * np.eye(3), calibration)


def out_and_back(length: int, calibration: FloatArray = HELD) -> Chain:
    """Return a drive along a line, with a U-turn at its end: places k and 2 length - 1 - k are one."""
    steps = np.tile([1.0, 0.0, 0.0], (2 * length - 1, 1))
    steps[length - 1] = [0.0, 0.0, np.pi]
    return chain_of(steps, np.tile(np.diag([0.02, 0.02, 0.01]) ** 2, (len(steps), 1, 1)), calibration)
