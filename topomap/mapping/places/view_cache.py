"""The map's views, decoded when they are needed and kept while they are in use."""

from __future__ import annotations

from collections import OrderedDict

from topomap.core.encoded import image_size
from topomap.core.errors import DataError
from topomap.core.panorama import Panorama
from topomap.core.view_size import parse_view
from topomap.mapping.graph import TopoMap
from topomap.mapping.places.small_view import view_of


class ViewCache:
    """Panoramas of snapshot nodes: the most recently used are kept with all that was derived from them."""

    def __init__(self, topo: TopoMap, size: int = 256) -> None:
        """topo: says how large its views are; a larger one is made as small."""
        self._topo = topo
        self._size = size
        self._views: OrderedDict[int, Panorama] = OrderedDict()

    def put(self, node: int, panorama: Panorama) -> None:
        """Keep a panorama that is at hand already."""
        self._views[node] = panorama
        self._views.move_to_end(node)
        if len(self._views) > self._size:
            self._views.popitem(last=False)

    def drop(self, node: int) -> None:
        """Let go of a panorama that isn't as the map has it any more."""
        self._views.pop(node, None)

    def __contains__(self, node: int) -> bool:
        """Return whether a node's view is at hand, decoded."""
        return node in self._views

    def panorama(self, node: int) -> Panorama:
        """Return the view of a snapshot node. Raises KeyError for a pose node, DataError for no image."""
        if node not in self._views:
            snapshot = self._topo.nodes[node].snapshot
            if snapshot is None:
                raise KeyError(f"node {node} is a pose node without a view")
            if image_size(snapshot.encoded) != (snapshot.rig.width, snapshot.rig.height):
                raise DataError(f"the view of node {node} isn't a PNG or JPEG image of its rig's size")
            self.put(node, view_of(snapshot, parse_view(self._topo.view)))
        self._views.move_to_end(node)
        return self._views[node]
