"""Lapped drives with claims for the closure engine: true ones a lap apart, and false ones alone or in groups."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from topomap.core.arrays import BoolArray, FloatArray, IntArray
from topomap.core.geometry import between, compose, wrap_all
from topomap.mapping.closures.claims import Claims
from topomap.mapping.closures.drive import Drive
from topomap.mapping.closures.pose_graph_drive import claims_of, drive_of
from topomap.mapping.pose_graph import PoseGraph

LAP = 100  # poses
STEP = np.array([0.01, 0.01, 0.004])  # sigmas of odometry a step of some 1.3 m
CLOSURE = np.array([0.05, 0.05, 0.02])  # sigmas of a claim
FALSE = 2.0  # a false claim is off by more than this [m]


@dataclass(frozen=True, eq=False)
class Lapped:
    """A graph, its true poses (N, 3) and which of its closures (M,) are false."""

    graph: PoseGraph
    truth: FloatArray
    false: BoolArray

    def engine_input(self) -> tuple[Drive, Claims, BoolArray]:
        """Return drive and claims as the engine takes them, and which of these claims are false."""
        claims, order = claims_of(self.graph)
        return drive_of(self.graph), claims, self.false[order]

    def shuffled(self, seed: int) -> Lapped:
        """Return the same graph with its closures in another order."""
        order = np.random.default_rng(seed).permutation(len(self.false))
        return replace(self, graph=only(self.graph, order), false=self.false[order])

    def but(self, kept: BoolArray | IntArray) -> Lapped:
        """Return the same graph with some of its closures only."""
        return replace(self, graph=only(self.graph, kept), false=self.false[kept])

    def also(self, i: IntArray, j: IntArray, relative: FloatArray, false: bool = True) -> Lapped:
        """Return the same graph with more closures at its end, their sigmas `CLOSURE`."""
        graph, more = self.graph, len(i)
        spread = np.tile(np.diag(CLOSURE**2), (more, 1, 1))
        return Lapped(
            replace(
                graph,
                i=np.concatenate([graph.i, i]),
                j=np.concatenate([graph.j, j]),
                relative=np.concatenate([graph.relative, relative]),
                covariance=np.concatenate([graph.covariance, spread]),
            ),
            self.truth,
            np.concatenate([self.false, np.full(more, false)]),
        )

    def alone(self, count: int, seed: int = 1) -> Lapped:
        """Return the same graph with false closures between any two places, that claim these are nearly one."""
        return self.groups(count, 1, seed)

    def groups(self, count: int, size: int, seed: int = 1, literal: bool = False) -> Lapped:
        """Return the same graph with groups of false closures along both stretches, in the same direction of travel.

        They agree as odometry carries the first on, with the noise of true ones; literal: all claim the very same.
        """
        rng = np.random.default_rng(seed)
        made, found = self, 0
        while found < count:
            i, j = np.sort(rng.integers(0, len(self.truth) - size, 2))
            claim = rng.normal(size=3) * [0.3, 0.3, 0.1]
            k = np.arange(size)
            if j - i < 10 + size:
                continue
            group = np.tile(claim, (size, 1)) if literal else self._carried(claim, i + k, j + k, rng)
            if off(self.truth, i + k, j + k, group).min() <= FALSE:
                continue
            made, found = made.also(i + k, j + k, group), found + 1
        return made

    def _carried(self, claim: FloatArray, i: IntArray, j: IntArray, rng: np.random.Generator) -> FloatArray:
        back = between(self.truth[i], self.truth[i[:1]])
        onward = between(self.truth[j[:1]], self.truth[j])
        return compose(compose(back, claim), onward) + rng.normal(size=(len(i), 3)) * CLOSURE


def off(truth: FloatArray, i: IntArray, j: IntArray, relative: FloatArray) -> FloatArray:
    """Return how far (n,) claims are from the truth [m]."""
    return np.hypot(*(between(truth[i], truth[j]) - relative)[:, :2].T)


def only(graph: PoseGraph, kept: BoolArray | IntArray) -> PoseGraph:
    """Return the graph with some of its closures."""
    return replace(
        graph, i=graph.i[kept], j=graph.j[kept], relative=graph.relative[kept], covariance=graph.covariance[kept]
    )


def lapped(laps: int = 4, every: int = 4, seed: int = 0, step: FloatArray = STEP) -> Lapped:
    """Return laps of a loop that no turn maps onto itself; some places of later laps close with any lap before.

    step (3,): sigmas of odometry.
    """
    rng = np.random.default_rng(seed)
    truth = _lap()[np.arange(laps * LAP) % LAP]
    steps = between(truth[:-1], truth[1:])
    odometry = steps + rng.normal(size=steps.shape) * step
    odometry[:, 2] = wrap_all(odometry[:, 2])
    j = np.arange(LAP, laps * LAP, every)
    i = j - LAP * rng.integers(1, j // LAP + 1)
    relative = between(truth[i], truth[j]) + rng.normal(size=(len(j), 3)) * CLOSURE
    spread = np.tile(np.diag(step**2), (len(steps), 1, 1))
    closed = np.tile(np.diag(CLOSURE**2), (len(j), 1, 1))
    return Lapped(PoseGraph("lapped", odometry, spread, i, j, relative, closed), truth, np.zeros(len(j), bool))


def _lap() -> FloatArray:
    """Return the poses (LAP, 3) of one lap, evenly along its way."""
    angle = np.linspace(0.0, 2 * np.pi, 40 * LAP + 1)
    radius = 16.0 + 4.0 * np.cos(2 * angle) + 3.0 * np.cos(3 * angle + 1.0) + 1.5 * np.sin(5 * angle)
    x, y = radius * np.cos(angle), radius * np.sin(angle)
    way = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))])
    at = np.interp(np.arange(LAP) / LAP * way[-1], way, angle)
    x, y = np.interp(at, angle, x), np.interp(at, angle, y)
    heading = np.arctan2(np.roll(y, -1) - y, np.roll(x, -1) - x)
    return np.column_stack([x, y, heading])
