"""The odometry chain of a growing map: only what comes after the first changed node is summed up anew."""

from __future__ import annotations

import numpy as np

from topomap.core.arrays import FloatArray, IntArray
from topomap.mapping.graph import TopoMap
from topomap.mapping.odometry.increments import Calibration
from topomap.mapping.optimizer import TurnEdge
from topomap.mapping.uncertainty.odometry_chain import Chain


class IncrementalChain:
    """Follows a map that grows at its end and is moved now and then, with the turns measured between its snapshots.

    turns: grows, too, and may be weighed anew; each ends at a snapshot and begins at the one before it.
    """

    def __init__(self, topo: TopoMap, turns: list[TurnEdge]) -> None:
        self._map = topo
        self._turns = turns
        self._noise = topo.noise
        self._heard: list[TurnEdge] = []  # the turns as they were when the way was summed up last
        self._told: FloatArray = np.zeros(0)  # (N,) variance of the turn that ends at a node [rad^2], infinite for none
        self._used: FloatArray = np.zeros(0)  # the same at each place of the chain, as it was summed up with
        self._nodes: IntArray = np.zeros(0, np.int64)
        self._calibration = Calibration()
        self._chain: Chain | None = None

    def current(self, covariance: FloatArray) -> Chain:
        """Return the chain as the map stands; covariance (3, 3): of the calibration."""
        self._hear()
        nodes = np.array(self._map.chain, np.int64)
        poses = self._map.poses[nodes]
        same = self._unchanged(nodes, poses)
        edges = self._map.odometry(max(same - 1, 0)).increments.integrate(self._map.calibration)
        head = None if self._chain is None or not same else self._chain.head(same)
        variances = self._turn_variances(nodes[max(same, 1) :], edges.covariance[:, 2, 2])
        self._chain = Chain.of(poses, edges, self._map.calibration, covariance, head, variances)
        self._used = np.concatenate([self._used[:same], self._told[nodes[same:]]])
        self._nodes, self._calibration = nodes, self._map.calibration
        self._noise = self._map.noise
        return self._chain

    def _hear(self) -> None:
        """Take over the turns as they are now; most are the same objects as before."""
        known = next((k for k, (a, b) in enumerate(zip(self._heard, self._turns, strict=False)) if a is not b),
                     min(len(self._heard), len(self._turns)))  # fmt: skip
        self._told = np.concatenate([self._told, np.full(len(self._map.nodes) - len(self._told), np.inf)])
        self._told[[turn.j for turn in self._heard[known:]]] = np.inf
        for turn in self._turns[known:]:
            self._told[turn.j] = turn.sigma**2
        self._heard = list(self._turns)

    def _unchanged(self, nodes: IntArray, poses: FloatArray) -> int:
        """Return how many nodes at the chain's start are as they were, the last of them a snapshot."""
        if self._chain is None or self._calibration != self._map.calibration or self._noise != self._map.noise:
            return 0
        known = min(len(nodes), len(self._nodes))
        differs = (nodes[:known] != self._nodes[:known]) | (poses[:known] != self._chain.poses[:known]).any(axis=1)
        differs |= self._told[nodes[:known]] != self._used[:known]
        same = int(np.argmax(differs)) if differs.any() else known
        while same and self._map.nodes[int(nodes[same - 1])].snapshot is None:
            same -= 1
        return same

    def _turn_variances(self, ends: IntArray, noise: FloatArray) -> FloatArray:
        """Return (E,) the variances of the turns measured on edges that end at nodes (E,), infinite for none.

        A turn between two snapshots is shared among the edges between them by odometry's noise (E,) on them.
        """
        variances = np.full(len(ends), np.inf)
        held = self._map.nodes
        places = np.flatnonzero([held[node].snapshot is not None for node in ends.tolist()])
        first = np.concatenate([[0], places[:-1] + 1]) if len(places) else places
        told = self._told[ends[places]]
        for k in np.flatnonzero(places - first > 1).tolist():
            span = slice(int(first[k]), int(places[k]) + 1)
            variances[span] = np.maximum(told[k] * noise[span] / max(float(noise[span].sum()), 1e-18), 1e-12)
        one, two = first == places, first + 1 == places  # most are: all at once
        sums = np.where(two, noise[first], 0.0) + noise[places]
        for which, ends_at in ((one | two, places), (two, first)):
            at = ends_at[which]
            variances[at] = np.maximum(told[which] * noise[at] / np.maximum(sums[which], 1e-18), 1e-12)
        return variances
