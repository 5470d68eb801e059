"""The one place where a pose graph meets the closure engine: `topomap optimize` and `bench graphs` both come here."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from topomap.core.arrays import BoolArray, FloatArray
from topomap.mapping.closures.growth import map_graph
from topomap.mapping.pose_graph import PoseGraph

Progress = Callable[[float, str], None]


class GraphVerdicts(NamedTuple):
    """What the engine makes of a pose graph.

    poses (N, 3); inlier (M,): which closures stand; log_odds (M,): natural logs of true over false, NaN where nothing
    was worked out; reason (M,); kept: which of several solutions this is, and why.
    """

    poses: FloatArray
    inlier: BoolArray
    log_odds: FloatArray
    reason: tuple[str, ...]
    kept: str


def optimise_graph(graph: PoseGraph, progress: Progress | None = None) -> GraphVerdicts:
    """Optimise a pose graph whose closures may be false; progress hears the share done and what is done next."""
    if progress is not None:
        progress(0.0, "weighing closures")
    poses, inlier = map_graph(graph)
    reason = tuple("the rest of the map stands by it" if good else "not likely enough" for good in inlier)
    if progress is not None:
        progress(1.0, "done")
    return GraphVerdicts(poses, inlier, np.full(len(inlier), np.nan), reason, "grown along the chain, the only one")
