"""Where the newest nodes lie once the turn that led to them is measured, before anything is solved."""

from __future__ import annotations

import math

import numpy as np

from topomap.core.arrays import FloatArray, IntArray
from topomap.core.geometry import between, compose, wrap
from topomap.mapping.graph import TopoMap
from topomap.mapping.optimisation import BACKEND
from topomap.mapping.optimizer import TurnEdge, geman_mcclure

ITERATIONS = 10  # as in a solve; a turn off by four sigmas of the odometry settles in three


def turned_end(topo: TopoMap, turn: TurnEdge, calibration: FloatArray) -> tuple[IntArray, FloatArray]:
    """Return the nodes (n,) on the chain from a turn's start to its end, and where they lie with it, poses (n, 3).

    calibration: covariance (3, 3) of the odometry's systematic errors. It is the mean of the update whose covariance
    `uncertainty.odometry_chain` takes; a turn that odometry contradicts counts less, as in a solve.
    """
    place = len(topo.chain) - 1 - topo.chain[::-1].index(turn.i)
    nodes = np.array(topo.chain[place:], np.int64)
    poses = topo.poses[nodes]
    edges = topo.odometry(place).increments.integrate(topo.calibration)
    noise = edges.covariances(topo.calibration)[:, :, 2]
    systematic = edges.jacobians(topo.calibration)[:, 2].sum(axis=0)
    off = wrap(turn.turn - float(poses[-1, 2] - poses[0, 2]))
    random, shared = float(noise[:, 2].sum()), float(systematic @ calibration @ systematic)
    gain = _gain(off, turn.sigma, random, shared)
    for k, step in enumerate(between(poses[:-1], poses[1:]) + noise * (gain * off), start=1):
        poses[k] = compose(poses[k - 1], step)
    return nodes, poses


def _gain(off: float, sigma: float, random: float, shared: float) -> float:
    """Return by how much the odometry's covariance with its turn is to be added for each radian that it is off.

    sigma: the measured turn's; random, shared: the odometry's variances of the turn [rad^2].
    """
    cutoff = np.array(BACKEND.turn_cutoff * math.sqrt(1.0 + (random + shared) / sigma**2))
    left, gain = off, 0.0
    for _ in range(ITERATIONS):
        weight = float(geman_mcclure(np.array((left / sigma) ** 2), cutoff))
        gain = weight / (weight * random + sigma**2)
        left = off * (1.0 - gain * random)
    return gain
