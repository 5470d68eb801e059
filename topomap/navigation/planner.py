"""Routes over the snapshot graph."""

from __future__ import annotations

import networkx as nx

from topomap.core.errors import TopomapError
from topomap.mapping.graph import TopoMap


def route(topo: TopoMap, start: int, goal: int) -> list[int]:
    """Return the snapshot nodes to pass on the shortest way from `start` (left out) to `goal` (the last one).

    Lengths are map metres; bare pose nodes are passed but are no milestones, as they hold no view to home to.
    Raises TopomapError when a node is unknown or the two are not connected.
    """
    try:
        path = nx.shortest_path(topo.graph, start, goal, weight=lambda a, b, _: topo.length(a, b))
    except (nx.NodeNotFound, nx.NetworkXNoPath) as error:
        raise TopomapError(f"no route from node {start} to node {goal}: {error}") from error
    return [node for node in path[1:] if topo.nodes[node].snapshot is not None]
