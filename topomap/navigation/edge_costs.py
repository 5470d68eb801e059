"""What each edge of the map costs to drive: its length, dearer beyond the catchment, where it failed, where it is shut.

A cost is metres of good way that would be driven instead.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from topomap.core.arrays import BoolArray, FloatArray, IntArray
from topomap.mapping.graph import TopoMap

CATCHMENT = 1.2
"""[m] Way over which a snapshot's view homes: bearings err by 4 degrees (median) up to 1 m off in three worlds, and
beyond it the image difference is that of unrelated views (1.0 to 1.3)."""
BEYOND = 1.0
"""Price of a metre beyond the catchment, in metres: it is driven by the believed pose alone."""
FAILED = 10.0
"""[m] Price of an edge that fails every time: a way round of that length is tried first."""
GAP = 100.0
"""[m^2] Variance of a step above which it is a gap in the odometry: no odometer errs by 10 m a step."""
SHUT_S = 600.0
"""[s] Time for which an edge that just failed isn't planned at all: at 0.35 m/s a way round of 200 m ..."""
MEMORY_S = 6000.0
"""[s] ... and over which its failures lose their weight: a door that was shut is open another day."""
SHUT_RADIUS = 0.45
"""[m] What leads nearer than this past a place where nothing got through is shut as well: half a door's width."""


@dataclass(frozen=True, slots=True)
class Shut:
    """A place [m, map frame] where nothing got through, and when."""

    x: float
    y: float
    stamp_ns: int


def edges_of(topo: TopoMap) -> IntArray:
    """Return the graph's edges (M, 2)."""
    return np.array(list(topo.graph.edges()), dtype=np.int64).reshape(-1, 2)


def costs(topo: TopoMap, edges: IntArray, shut: tuple[Shut, ...], stamp_ns: int) -> tuple[FloatArray, FloatArray]:
    """Return the cost (M,) [m] of each edge forwards and backwards; infinite where it is shut now."""
    a, b = topo.poses[edges[:, 0], :2], topo.poses[edges[:, 1], :2]
    length = np.hypot(*(b - a).T)
    base = length + BEYOND * np.maximum(length - CATCHMENT, 0.0) + 1e-6
    base = np.where(_closed(a, b, shut, stamp_ns) | (_carried(topo, edges) & (length > CATCHMENT)), np.inf, base)
    there, back = base.copy(), base
    place = {(int(i), int(j)): k for k, (i, j) in enumerate(edges)}
    for row in topo.experience:
        price = _price(row.passed, row.failed, stamp_ns - row.failed_ns)
        if (row.a, row.b) in place:
            there[place[row.a, row.b]] += price
        elif (row.b, row.a) in place:
            back[place[row.b, row.a]] += price
    return there, back


def _carried(topo: TopoMap, edges: IntArray) -> BoolArray:
    """Return over which edges (M, 2) the odometry has a gap: the robot was carried, nobody drove that way."""
    gaps = {frozenset((a, b)) for a, b, way in topo.odometry_edges() if way.covariances[:, 0, 0].max(initial=0.0) > GAP}
    return np.array([frozenset((int(a), int(b))) in gaps for a, b in edges], dtype=bool)


def _price(passed: int, failed: int, since_ns: int) -> float:
    """Return what failures add [m]: their share, fading with time."""
    if not failed:
        return 0.0
    if since_ns < SHUT_S * 1e9:
        return float("inf")
    fading = max(0.0, 1.0 - since_ns * 1e-9 / MEMORY_S)
    return FAILED * fading * failed / (passed + failed)


def _closed(a: FloatArray, b: FloatArray, shut: tuple[Shut, ...], stamp_ns: int) -> BoolArray:
    """Return which of the segments a-b (M, 2) pass a place that was shut lately."""
    closed: BoolArray = np.zeros(len(a), dtype=bool)
    for place in shut:
        if stamp_ns - place.stamp_ns < SHUT_S * 1e9:
            closed |= distance_to(np.array([place.x, place.y]), a, b) < SHUT_RADIUS
    return closed


def distance_to(point: FloatArray, a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the distance (M,) [m] of a point (2,) to the segments a-b (M, 2)."""
    along = b - a
    square = np.maximum((along**2).sum(axis=1), 1e-12)
    share = np.clip(((point - a) * along).sum(axis=1) / square, 0.0, 1.0)
    away: FloatArray = np.hypot(*(a + share[:, None] * along - point).T)
    return away
