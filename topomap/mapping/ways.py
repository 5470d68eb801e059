"""How well the map knows one place from another, and which older places the robot can be at."""

from __future__ import annotations

import math

import numpy as np
from scipy.special import chdtri

from topomap.geometry import FloatArray, Pose2, between
from topomap.mapping.chain import Chain, composed_covariance
from topomap.mapping.correction import Correction
from topomap.mapping.graph import TopoMap
from topomap.mapping.odometry import EdgeIncrements, IntArray

LATEST = 3  # closures over which a shorter way is looked for


class Ways:
    """Covariances along the travelled chain, short cuts over closures included; made anew when the map changes."""

    def __init__(self, topo: TopoMap, correction: Correction, sigma: float, probability: float) -> None:
        """sigma [m]: how far apart the two spots of a true closure may lie; probability of a true one to pass."""
        self._map = topo
        self._correction = correction
        self._variance = sigma**2
        self._limit = float(chdtri(2, 1 - probability))
        self._made: tuple[int, int, int] | None = None
        self._chain: Chain | None = None
        self._place: IntArray = np.zeros(0, np.int64)
        self._informations: FloatArray = np.zeros((0, 2, 2))

    def covariance(self, match: int, query: int) -> FloatArray:
        """Return the covariance (3, 3) of `match_from_query` along the route, across closures where that is shorter."""
        chain, place = self._current()
        ends = np.array([(place[c.i], place[c.j]) for c in self._map.closures], np.int64).reshape(-1, 2)
        covariances = np.array([c.covariance for c in self._map.closures]).reshape(-1, 3, 3)
        return chain.covariance_via(int(place[match]), int(place[query]), ends[:, 0], ends[:, 1], covariances)

    def reach(self, node: int) -> float:
        """Return how far from where the map has it the robot may be, seen from an older node [m]."""
        self._current()
        variance = 1.0 / float(np.linalg.eigvalsh(self._informations[node])[0]) - self._variance
        return math.sqrt(self._limit * max(variance, 0.0))

    def within_reach(self, pose: Pose2, nodes: IntArray) -> IntArray:
        """Return those of some older nodes (n,) at which odometry allows the robot to be, believed at `pose`."""
        if not len(nodes):
            return nodes
        self._current()
        away = self._map.poses[nodes, :2] - np.array([pose.x, pose.y])
        chi2 = np.einsum("ni,nij,nj->n", away, self._informations[nodes], away)
        possible: IntArray = nodes[chi2 <= self._limit]
        return possible

    def _current(self) -> tuple[Chain, IntArray]:
        state = (len(self._map.nodes), len(self._map.closures), self._correction.solves)
        if self._made != state or self._chain is None:
            self._made = state
            self._remake()
        assert self._chain is not None
        return self._chain, self._place

    def _remake(self) -> None:
        topo = self._map
        edges = EdgeIncrements.of([increments for _, _, increments in topo.odometry_edges()])
        poses = topo.poses[topo.chain]
        self._chain = Chain.of(poses, edges.integrate(topo.calibration), topo.calibration, self._correction.covariance)
        self._place = np.empty(len(topo.chain), np.int64)
        self._place[topo.chain] = np.arange(len(topo.chain))
        self._informations = self._reach(self._chain, poses)[self._place]

    def _reach(self, chain: Chain, poses: FloatArray) -> FloatArray:
        """Return (N, 2, 2) informations of where the end of the chain lies from each node, in the map frame."""
        every, end = np.arange(len(poses)), len(poses) - 1
        best = chain.covariance(every, np.full(len(poses), end))
        for closure in self._map.closures[-LATEST:]:
            a, b = int(self._place[closure.i]), int(self._place[closure.j])
            to_a, to_b = between(poses, poses[[a]]), between(poses, poses[[b]])
            way = composed_covariance(
                to_a, chain.covariance(every, np.full(len(poses), a)),
                between(poses[[a]], poses[[b]]), closure.covariance[None],
            )  # fmt: skip
            onward = chain.covariance(np.array([b]), np.array([end]))
            way = composed_covariance(to_b, way, between(poses[[b]], poses[[end]]), onward)
            shorter = np.trace(way[:, :2, :2], axis1=1, axis2=2) < np.trace(best[:, :2, :2], axis1=1, axis2=2)
            best = np.where(shorter[:, None, None], way, best)
        c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
        turn = np.stack([np.stack([c, -s], axis=1), np.stack([s, c], axis=1)], axis=1)
        in_map = turn @ best[:, :2, :2] @ turn.transpose(0, 2, 1) + self._variance * np.eye(2)
        return np.asarray(np.linalg.inv(in_map))
