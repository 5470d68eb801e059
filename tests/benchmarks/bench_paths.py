"""What 20,000 paths through a chain of 10,000 places and its closures know, beside scipy's search from every start."""

from __future__ import annotations

import time

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from topomap.core.arrays import IntArray
from topomap.mapping.uncertainty.network import PathNetwork
from topomap.mapping.uncertainty.odometry_chain import Chain

Row = dict[str, str | float | None]
PLACES, PATHS, STARTS = 10_000, 20_000, 400  # of the peer's starts so many are timed
NOISE = np.diag([1e-4, 1e-4, 1e-5])


def rows() -> list[Row]:
    """Return a row for few closures, which go by junctions, and one for many, which are searched path by path."""
    return [_row(closures) for closures in (40, 1_000, 20_000)]


def _row(closures: int) -> Row:
    rng = np.random.default_rng(closures)
    poses = np.cumsum(rng.normal(size=(PLACES, 3)) * [0.5, 0.5, 0.1], axis=0)
    chain = Chain.held(poses, np.tile(NOISE, (PLACES - 1, 1, 1)), np.full(PLACES - 1, 0.5))
    i, j = np.sort(rng.integers(0, PLACES, (closures, 2)), axis=1).T
    own = np.ascontiguousarray(i[j > i + 1]), np.ascontiguousarray(j[j > i + 1])
    asked = rng.integers(0, PLACES, (2, PATHS))
    ms = min(_ours(chain, own, asked) for _ in range(2))
    peer = _scipy(own, np.unique(asked[0]))
    return {
        "name": f"paths over {closures} closures",
        "ms": ms,
        "size": f"{PATHS} paths, {PLACES} places",
        "peer": "scipy dijkstra, distances alone",
        "peer_ms": peer,
        "ratio": peer / ms,
    }


def _ours(chain: Chain, own: tuple[IntArray, IntArray], asked: IntArray) -> float:
    count = len(own[0])
    start = time.perf_counter()
    network = PathNetwork(chain, *own, np.tile(NOISE, (count, 1, 1)), np.arange(count))
    network.errors(asked[0], asked[1])
    return 1e3 * (time.perf_counter() - start)


def _scipy(own: tuple[IntArray, IntArray], starts: IntArray) -> float:
    """Return the time from every start [ms], as that from some of them tells it."""
    at = np.arange(PLACES - 1)
    i, j = np.concatenate([at, own[0]]), np.concatenate([at + 1, own[1]])
    graph = coo_array((np.full(len(i), NOISE[2, 2]), (i, j)), (PLACES, PLACES)).tocsr()
    start = time.perf_counter()
    dijkstra(graph, directed=False, indices=starts[:STARTS])
    return 1e3 * (time.perf_counter() - start) * len(starts) / STARTS
