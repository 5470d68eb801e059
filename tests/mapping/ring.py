"""A drive round a square ring with a known odometer and closures on the second lap."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from topomap.core.arrays import FloatArray
from topomap.core.geometry import Pose2, between
from topomap.mapping.odometry.increments import Calibration, Increments, track
from topomap.mapping.optimizer import ClosureEdge, Closures, OdometryEdge, OdometryEdges, Problem

PER_NODE = 5
TRUE = Calibration(rotation_scale=1.04, curvature=0.003, distance_scale=0.95)
START = Calibration(distance_scale=0.95)  # the ranges are taken to have shown the distance scale
SIGMAS = (0.05, 0.01, 0.01)


@dataclass(frozen=True)
class Ring:
    """truth (N, 3), the problem, and which closures are false (M,)."""

    truth: FloatArray
    problem: Problem
    false: np.ndarray


def turns(nodes: int, back: bool) -> FloatArray:
    """Two laps of four corners; `back`: the second lap the other way round after a U-turn."""
    turn = np.zeros(nodes * PER_NODE)
    lap = len(turn) // 2
    for k in range(2):
        for corner in range(4):
            end = k * lap + (2 * corner + 1) * lap // 8
            turn[end : end + 10] = (-1 if back and k else 1) * np.pi / 20
    if back:
        turn[lap - 5 : lap + 5] += np.pi / 10
    return turn


def drive(seed: int, nodes: int, length: float, back: bool) -> tuple[FloatArray, Increments]:
    """Return the true poses at the nodes and what the odometer read."""
    rng = np.random.default_rng(seed)
    turn = turns(nodes, back)
    k, step = len(turn), length / len(turn)
    stamps = np.arange(1, k + 1) * 250_000_000
    true = np.column_stack([np.full(k, step), np.zeros(k), turn])
    truth = track(Increments(stamps, true, np.zeros((k, 3, 3))), Calibration())[::PER_NODE]
    sigma = np.array([0.02, 1e-4, np.deg2rad(0.5)]) * np.sqrt(step)
    read = true * [0.95, 0.95, 1.04]
    read[:, 2] += TRUE.curvature * step
    noisy = read + rng.normal(size=(k, 3)) * sigma
    return truth, Increments(stamps, noisy, np.tile(np.diag(sigma**2), (k, 1, 1)))


def ring(
    seed: int, nodes: int = 240, length: float = 240.0, closures: int = 36, false: float = 0.0, back: bool = False
) -> Ring:
    """Return a ring whose second lap meets the first, a share of the closures false."""
    rng = np.random.default_rng(1000 + seed)
    truth, read = drive(seed, nodes, length, back)
    edges = OdometryEdges.of(
        [OdometryEdge(n, n + 1, read[PER_NODE * n : PER_NODE * n + PER_NODE]) for n in range(nodes)]
    )
    wrong = rng.random(closures) < false
    closing = [
        _closure(rng, truth, int(q), bool(w), nodes) for q, w in zip(_queries(nodes, closures), wrong, strict=True)
    ]
    start = track(read, START)[::PER_NODE]
    problem = Problem(start, edges, Closures.of(closing), calibration=START, prior=START, prior_sigmas=SIGMAS)
    return Ring(truth, problem, wrong)


def _queries(nodes: int, closures: int) -> FloatArray:
    return np.linspace(nodes // 2 + 6, nodes, closures).astype(int)


def _closure(rng: np.random.Generator, truth: FloatArray, query: int, false: bool, nodes: int) -> ClosureEdge:
    sigma = np.array([0.2, 0.2, 0.03])
    if false:
        match, claimed = int(rng.integers(0, query - 20)), np.zeros(3)
    else:
        old = truth[: nodes // 2 - 5, :2]
        match = int(np.argmin(np.hypot(*(old - truth[query, :2]).T)))
        claimed = between(truth[match], truth[query])
    claimed = claimed + rng.normal(size=3) * sigma
    return ClosureEdge(match, query, Pose2.of(claimed), np.diag(sigma**2))


def blinded(problem: Problem) -> Problem:
    """Return the problem with no closure knowing its heading."""
    covariance = problem.closures.covariance.copy()
    covariance[:, 2, 2] = 40.0
    relative = problem.closures.relative * [1, 1, 0]
    return replace(problem, closures=replace(problem.closures, covariance=covariance, relative=relative))


def ate(poses: FloatArray, truth: FloatArray) -> float:
    """Return the root mean square position error after the best rigid motion [m]."""
    a, b = poses[:, :2] - poses[:, :2].mean(axis=0), truth[:, :2] - truth[:, :2].mean(axis=0)
    u, _, v = np.linalg.svd(a.T @ b)
    rotation = u @ np.diag([1, np.sign(np.linalg.det(u @ v))]) @ v
    return float(np.sqrt(((a @ rotation - b) ** 2).sum(axis=1).mean()))


def edges_of(problem: Problem) -> list[OdometryEdge]:
    """Return a problem's odometry edges one by one; the stamps aren't kept."""
    starts, whole = problem.odometry.increments.starts.tolist(), problem.odometry.increments
    parts = [slice(a, b) for a, b in pairwise(starts)]
    return [
        OdometryEdge(i, j, Increments(np.zeros(s.stop - s.start, np.int64), whole.deltas[s], whole.covariances[s]))
        for i, j, s in zip(problem.odometry.i.tolist(), problem.odometry.j.tolist(), parts, strict=True)
    ]
