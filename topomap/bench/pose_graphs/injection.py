"""False closures injected into a pose graph, so that a given share of all closures is false."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from topomap.core.arrays import BoolArray, FloatArray
from topomap.core.geometry import between, wrap_all
from topomap.mapping.closures.odds import FALSE_DISTANCE, FALSE_ROTATION
from topomap.mapping.pose_graph import PoseGraph

LARGEST = 1000  # false closures at most
SHORTEST = 10  # nodes between the ends of a false closure at least
MOST_TRUE = 4000


@dataclass(frozen=True, slots=True, eq=False)
class Injected:
    """A pose graph with false (M,) telling which closures are false."""

    graph: PoseGraph
    false: BoolArray


def counts(true: int, share: float) -> tuple[int, int]:
    """Return how many true and false closures make `share` of them false, with at most 1,000 false ones.

    All true ones stay (of more than 4,000, 4,000) where the false ones suffice; otherwise they are thinned.
    """
    kept = min(true, MOST_TRUE)
    wanted = round(kept * share / (1.0 - share))
    if wanted <= LARGEST:
        return kept, wanted
    return min(kept, round(LARGEST * (1.0 - share) / share)), LARGEST


def inject(graph: PoseGraph, optimum: FloatArray, share: float, rng: np.random.Generator) -> Injected:
    """Return the graph with false closures; optimum (N, 3): what tells false from true.

    The ends of a false closure are drawn evenly among pairs at least 10 nodes apart; it claims the relative pose of a
    true closure drawn likewise, with that one's covariance, and is drawn again while the optimum lies within 1 m and
    20 degrees of the claim. True and false stand mixed.
    """
    true, false = counts(len(graph.i), share)
    kept = np.sort(rng.choice(len(graph.i), true, replace=False))
    i, j, like = _draw(graph, optimum, false, rng)
    order = rng.permutation(true + false)
    parts = (
        np.concatenate([graph.i[kept], i]),
        np.concatenate([graph.j[kept], j]),
        np.concatenate([graph.relative[kept], graph.relative[like]]),
        np.concatenate([graph.covariance[kept], graph.covariance[like]]),
    )
    mixed = [part[order] for part in parts]
    told = replace(graph, i=mixed[0], j=mixed[1], relative=mixed[2], covariance=mixed[3])
    return Injected(told, (np.arange(true + false) >= true)[order])


def _draw(
    graph: PoseGraph, optimum: FloatArray, wanted: int, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    drawn = np.zeros((0, 3), np.int64)
    while len(drawn) < wanted:
        ends = np.sort(rng.integers(0, graph.nodes, (wanted, 2)), axis=1)
        like = rng.integers(0, len(graph.i), wanted)
        error = between(optimum[ends[:, 0]], optimum[ends[:, 1]]) - graph.relative[like]
        far = np.hypot(error[:, 0], error[:, 1]) > FALSE_DISTANCE
        turned = np.abs(wrap_all(error[:, 2])) > FALSE_ROTATION
        good = (ends[:, 1] - ends[:, 0] >= SHORTEST) & (far | turned)
        drawn = np.concatenate([drawn, np.column_stack([ends, like])[good]])
    return drawn[:wanted, 0], drawn[:wanted, 1], drawn[:wanted, 2]
