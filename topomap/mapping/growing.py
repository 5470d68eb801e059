"""The map's chain, summed up anew only from where it changed since it was last asked for."""

from __future__ import annotations

import numpy as np

from topomap.geometry import FloatArray
from topomap.mapping.chain import Chain
from topomap.mapping.graph import TopoMap
from topomap.mapping.odometry import Calibration, EdgeIncrements, IntArray


class GrowingChain:
    """Follows a map that grows at its end and is moved now and then."""

    def __init__(self, topo: TopoMap) -> None:
        self._map = topo
        self._nodes: IntArray = np.zeros(0, np.int64)
        self._calibration = Calibration()
        self._chain: Chain | None = None

    def current(self, covariance: FloatArray) -> Chain:
        """Return the chain as the map stands; covariance (3, 3): of the calibration."""
        nodes = np.array(self._map.chain, np.int64)
        poses = self._map.poses[nodes]
        same = self._unchanged(nodes, poses)
        new = [increments for _, _, increments in self._map.edges_from(max(same - 1, 0))]
        edges = EdgeIncrements.of(new).integrate(self._map.calibration)
        head = None if self._chain is None or not same else self._chain.head(same)
        self._chain = Chain.of(poses, edges, self._map.calibration, covariance, head)
        self._nodes, self._calibration = nodes, self._map.calibration
        return self._chain

    def _unchanged(self, nodes: IntArray, poses: FloatArray) -> int:
        """Return how many nodes at the chain's start are as they were."""
        if self._chain is None or self._calibration != self._map.calibration:
            return 0
        known = min(len(nodes), len(self._nodes))
        differs = (nodes[:known] != self._nodes[:known]) | (poses[:known] != self._chain.poses[:known]).any(axis=1)
        return int(np.argmax(differs)) if differs.any() else known
