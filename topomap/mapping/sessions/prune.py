"""Nodes that add nothing: views of ground that an older view shows as well."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from topomap.core.arrays import FloatArray, IntArray
from topomap.mapping.graph import TopoMap
from topomap.mapping.places.view_cache import ViewCache
from topomap.mapping.sessions.rebuild import only
from topomap.vision.image.compare import rotation_difference, signature

NEAR = 0.6
"""[m] Snapshots are kept once 1 m is full, which is up to 1.13 m on the way in `hall`: nobody on it is farther from one
than half of that, and a little aside."""
ALIKE = 0.8
"""A view that differs less (rms of z-normalised views, any rotation) isn't worth a snapshot: the rule that keeps them
asks for more."""
TIED = 4.0
"""[m] Way on which a closure must join a node's neighbourhood to the older one's: poses alone may be off by a corridor.
Closures of one pass come every 0.3 to 3 m in the three worlds looked at."""


class Pruned(NamedTuple):
    """The map without what adds nothing, and the numbers of the nodes left out."""

    map: TopoMap
    gone: tuple[int, ...]


def prune(topo: TopoMap, told: Callable[[float], None] = lambda _: None) -> Pruned:
    """Return the map without nodes that add nothing; every number, place and pose that stays is as it was.

    A stretch of the route whose views older ones show as well is left out between the closures at its ends, so that the
    ways to it stay; named nodes, the first and those that a drive ends with on new ground stay. told: the share done.
    """
    covered = _covered(topo, told)
    gone: set[int] = set()
    for drive in _drives(topo):
        for stretch in _stretches(topo, drive, covered):
            gone |= _inside(topo, drive, stretch, gone)
    bare = {node for node in topo.chain if topo.nodes[node].snapshot is None} - gone
    needed = {end for c in topo.closures if not {c.i, c.j} & gone for end in (c.i, c.j)}
    needed |= set(topo.jumps) | {topo.chain[0], topo.chain[-1]}
    keep = set(topo.chain) - gone - (bare - needed)
    left = tuple(sorted(topo.names[node] for node in set(topo.chain) - keep))
    return Pruned(only(topo, keep, gone), left)


def _drives(topo: TopoMap) -> list[list[int]]:
    """Return the nodes of each drive, in travel order."""
    drives: list[list[int]] = []
    for node in topo.chain:
        if not drives or node in topo.jumps:
            drives.append([])
        drives[-1].append(node)
    return drives


def _covered(topo: TopoMap, told: Callable[[float], None]) -> set[int]:
    """Return the snapshot nodes whose ground an older snapshot that isn't covered itself shows as well."""
    views = ViewCache(topo)
    named = set(topo.places.values())
    ties = np.array([(c.i, c.j) for c in topo.closures], np.int64).reshape(-1, 2)
    travel = np.array([node.travel for node in topo.nodes])
    standing: list[int] = []
    covered = set()
    for place, node in enumerate(topo.chain):
        told(place / len(topo.chain))
        if topo.nodes[node].snapshot is None:
            continue
        tied = _tied(topo, node, ties, travel)
        older = [k for k in standing if topo.length(k, node) <= NEAR and _reaches(topo, tied, k)]
        if topo.names[node] not in named and any(_alike(views, node, k) for k in older):
            covered.add(node)
        else:
            standing.append(node)
    return covered


def _tied(topo: TopoMap, node: int, ties: IntArray, travel: FloatArray) -> IntArray:
    """Return the older ends (n,) of closures that lie near a node on its way."""
    if not len(ties):
        return ties.reshape(-1)
    near = np.abs(travel[ties[:, 1]] - travel[node]) <= TIED
    return np.asarray(ties[near, 0])


def _reaches(topo: TopoMap, tied: IntArray, older: int) -> bool:
    return any(topo.length(int(end), older) <= TIED for end in tied)


def _alike(views: ViewCache, a: int, b: int) -> bool:
    return rotation_difference(signature(views.panorama(a)), signature(views.panorama(b)))[0] < ALIKE


def _stretches(topo: TopoMap, drive: list[int], covered: set[int]) -> list[range]:
    """Return the parts of a drive whose snapshots are all covered; pose nodes beside them belong to them."""
    found, begin, some = [], 0, False
    for place, node in enumerate([*drive, -1]):
        if node >= 0 and (node in covered or topo.nodes[node].snapshot is None):
            some = some or node in covered
            continue
        if some:
            found.append(range(begin, place))
        begin, some = place + 1, False
    return found


def _inside(topo: TopoMap, drive: list[int], stretch: range, gone: set[int]) -> set[int]:
    """Return what of a stretch can be left out: all between the closures to older ground that lie at its ends.

    Where the drive has nothing else before or behind the stretch, nothing needs to be reached over that end.
    """
    own = set(drive[stretch.start :])
    ends = {c.j for c in topo.closures if c.i not in own and c.i not in gone}
    ties = [place for place in stretch if drive[place] in ends]
    first = ties[0] + 1 if stretch.start > 0 and ties else stretch.start
    last = ties[-1] if stretch.stop < len(drive) and ties else stretch.stop
    reached = ties or (stretch.start == 0 and stretch.stop == len(drive))
    keep = {topo.chain[0], *(node for node in drive if topo.names[node] in topo.places.values())}
    return {drive[place] for place in range(first, last)} - keep if reached else set()
