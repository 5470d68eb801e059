"""Small pose graphs for tests: laps of a ring with true and false closures, as a graph or as g2o text."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from topomap.core.arrays import BoolArray, FloatArray
from topomap.core.geometry import between, compose
from topomap.mapping.pose_graph import PoseGraph

LAP = 48  # poses
SIGMAS = np.array([0.05, 0.05, 0.03])  # of a step, and of a closure


@dataclass(frozen=True)
class RingGraph:
    """A graph, its true poses (N, 3) and which of its closures (M,) are false."""

    graph: PoseGraph
    truth: FloatArray
    false: BoolArray

    def without(self, gaps: tuple[int, ...]) -> RingGraph:
        """Return the ring without the odometry of some steps, each as good as unknown."""
        flags = np.isin(np.arange(self.graph.nodes - 1), gaps)
        odometry, spread = self.graph.odometry.copy(), self.graph.odometry_covariance.copy()
        odometry[flags], spread[flags] = 0.0, np.diag([200.0, 200.0, np.pi]) ** 2
        return replace(self, graph=replace(self.graph, odometry=odometry, odometry_covariance=spread, gaps=flags))


def ring_graph(laps: int = 3, false: int = 12, group: int = 0, seed: int = 0) -> RingGraph:
    """Laps of a bent ring; every third pose of the later laps closes with the first; group: false ones that
    follow one another along both stretches and agree."""
    rng = np.random.default_rng(seed)
    poses = _lap_poses()[np.arange(laps * LAP) % LAP]
    steps = between(poses[:-1], poses[1:])
    j = np.arange(LAP, laps * LAP, 3)
    i = j % LAP
    relative = between(poses[i], poses[j]) + rng.normal(size=(len(j), 3)) * SIGMAS
    odometry = steps + rng.normal(size=steps.shape) * SIGMAS
    wrong = _false(rng, poses, odometry, false - group, group)
    spread = np.tile(np.diag(SIGMAS**2), (len(steps) + len(j) + false, 1, 1))
    graph = PoseGraph(
        "ring",
        odometry,
        spread[: len(steps)],
        np.concatenate([i, wrong[:, 0].astype(np.int64)]),
        np.concatenate([j, wrong[:, 1].astype(np.int64)]),
        np.concatenate([relative, wrong[:, 2:]]),
        spread[len(steps) :],
    )
    return RingGraph(graph, poses, np.arange(len(j) + false) >= len(j))


def _lap_poses() -> FloatArray:
    """Return the poses (LAP, 3) of a lap along a bent ring that no turn maps onto itself."""
    angle = np.linspace(0.0, 2 * np.pi, 20 * LAP + 1)
    radius = 5.0 + 0.9 * np.cos(2 * angle) + 0.6 * np.cos(3 * angle + 1.0)
    x, y = radius * np.cos(angle), radius * np.sin(angle)
    way = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))])
    at = np.interp(np.arange(LAP) / LAP * way[-1], way, angle)
    x, y = np.interp(at, angle, x), np.interp(at, angle, y)
    heading = np.arctan2(np.roll(y, -1) - y, np.roll(x, -1) - x)
    return np.column_stack([x, y, heading])


def _false(rng: np.random.Generator, poses: FloatArray, odometry: FloatArray, alone: int, group: int) -> FloatArray:
    """Return rows i, j, x, y, heading of false closures."""
    rows: list[list[float]] = []
    while len(rows) < alone:
        i, j = np.sort(rng.integers(0, len(poses), 2)).tolist()
        claim = rng.normal(size=3) * SIGMAS
        if j - i >= 10 and np.hypot(*(between(poses[i], poses[j]) - claim)[:2]) > 2.0:
            rows.append([i, j, *claim])
    first, second, claim = 5, LAP + 29, np.zeros(3)
    for k in range(group):
        rows.append([first + k, second + k, *(claim + rng.normal(size=3) * SIGMAS)])
        claim = compose(compose(between(odometry[first + k], np.zeros(3)), claim), odometry[second + k])
    return np.array(rows).reshape(-1, 5)


def ring_text(ring: RingGraph, ids: FloatArray | None = None) -> str:
    """Return a ring as g2o text, its steps without odometry left out, the false closures last."""
    graph = ring.graph
    names = np.arange(graph.nodes) if ids is None else ids
    steps = [_edge(names[k], names[k + 1], graph.odometry[k]) for k in range(graph.nodes - 1) if not graph.gaps[k]]
    closures = [_edge(names[a], names[b], z) for a, b, z in zip(graph.i, graph.j, graph.relative, strict=True)]
    true = int((~ring.false).sum())
    return "\n".join([*steps, *closures[:true], "# the closures below are false", *closures[true:], ""])


def _edge(i: int, j: int, relative: FloatArray) -> str:
    x, y, heading = np.round(relative, 5).tolist()
    return f"EDGE_SE2 {i} {j} {x} {y} {heading} 400 0 0 400 0 1111.11"
