"""The clean optimum of a pose graph whose closures are all true: what a bench holds results against."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import breadth_first_order

from topomap.core.arrays import FloatArray
from topomap.core.geometry import between, compose
from topomap.mapping.optimizer.peers import optimum
from topomap.mapping.pose_graph import PoseGraph


def clean_optimum(graph: PoseGraph) -> FloatArray:
    """Return the poses (N, 3) that fit best when every closure is true (LAGO, then Levenberg-Marquardt)."""
    return optimum(bridged(graph) if graph.gaps.any() else graph)


def bridged(graph: PoseGraph) -> PoseGraph:
    """Return the graph with its gaps as the closures have them.

    LAGO counts full turns round loops along the chain: what a gap says of the heading must be about right, however
    little it weighs.
    """
    poses = _along_closures(graph)
    odometry = graph.odometry.copy()
    odometry[graph.gaps] = between(poses[:-1], poses[1:])[graph.gaps]
    return replace(graph, odometry=odometry)


def _along_closures(graph: PoseGraph) -> FloatArray:
    """Return poses (N, 3) along the fewest edges from the first; where no edge leads across a gap, the gap does."""
    steps = np.arange(graph.nodes - 1)
    low, high = np.concatenate([steps, graph.i]), np.concatenate([steps + 1, graph.j])
    relative = np.concatenate([graph.odometry, graph.relative])
    edge = {(a, b): k for k, (a, b) in reversed(list(enumerate(zip(low.tolist(), high.tolist(), strict=True))))}
    solid = np.concatenate([~graph.gaps, np.ones(len(graph.i), np.bool_)])
    net = coo_array((np.ones(int(solid.sum())), (low[solid], high[solid])), (graph.nodes, graph.nodes)).tocsr()
    poses = np.full((graph.nodes, 3), np.nan)
    poses[0] = 0.0
    for first in range(graph.nodes):
        if first and not np.isnan(poses[first, 0]):
            continue
        if first:
            poses[first] = compose(poses[first - 1], graph.odometry[first - 1])
        order, before = breadth_first_order(net, first, directed=False)
        for node in order[1:].tolist():
            a = int(before[node])
            forth = relative[edge[min(a, node), max(a, node)]]
            poses[node] = compose(poses[a], forth if a < node else between(forth, np.zeros(3)))
    return poses
