"""The map's views, decoded when they are needed and kept while they are in use."""

from __future__ import annotations

from collections import OrderedDict

from topomap.core.encoded import decode
from topomap.core.panorama import Panorama
from topomap.mapping.graph import Snapshot, TopoMap


class ViewCache:
    """Panoramas of snapshot nodes: the most recently used are kept with all that was derived from them."""

    def __init__(self, topo: TopoMap, size: int = 256) -> None:
        self._topo = topo
        self._size = size
        self._views: OrderedDict[int, Panorama] = OrderedDict()

    def put(self, node: int, panorama: Panorama) -> None:
        """Keep a panorama that is at hand already."""
        self._views[node] = panorama
        self._views.move_to_end(node)
        if len(self._views) > self._size:
            self._views.popitem(last=False)

    def panorama(self, node: int) -> Panorama:
        """Return the view of a snapshot node. Raises KeyError for a pose node."""
        if node not in self._views:
            snapshot = self._topo.nodes[node].snapshot
            if snapshot is None:
                raise KeyError(f"node {node} is a pose node without a view")
            self.put(node, _view(snapshot))
        self._views.move_to_end(node)
        return self._views[node]


def _view(snapshot: Snapshot) -> Panorama:
    return Panorama.from_recorded(decode(snapshot.encoded), snapshot.rig, snapshot.ranges)
