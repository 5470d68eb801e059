"""A pose graph through the closure engine: `topomap optimize` and `bench graphs` both come here."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from topomap.core.arrays import BoolArray, FloatArray
from topomap.mapping.closures.batch import Batch, quiet
from topomap.mapping.closures.closure_tests import TESTS, ClosureTest
from topomap.mapping.closures.noise import variance_factor
from topomap.mapping.closures.pose_graph_drive import claims_of, drive_of
from topomap.mapping.pose_graph import PoseGraph
from topomap.mapping.uncertainty.network import MANY, PathNetwork

Progress = Callable[[float, str], None]


class GraphVerdicts(NamedTuple):
    """What the engine makes of a pose graph.

    poses (N, 3); inlier (M,): which closures stand; log_odds (M,): natural logs of true over false, -inf where
    odometry contradicts; reason (M,); kept: which of several solutions this is, and why.
    """

    poses: FloatArray
    inlier: BoolArray
    log_odds: FloatArray
    reason: tuple[str, ...]
    kept: str


def optimise_graph(graph: PoseGraph, progress: Progress = quiet, tests: Sequence[ClosureTest] = TESTS) -> GraphVerdicts:
    """Judge a pose graph whose closures may be false and whose covariances hold up to a factor.

    progress: hears the share done and what is being done; tests: the engine's stages.
    """
    progress(0.0, "noise")
    claims, order = claims_of(graph)
    if not len(claims):
        return GraphVerdicts(graph.dead_reckoning(), np.zeros(0, bool), np.zeros(0), (), "odometry: nothing is claimed")
    stated = drive_of(graph)
    factor = variance_factor(claims, stated.chain(stated.start()))
    claims, order = claims_of(graph, factor)
    found = Batch(drive_of(graph, factor), claims, tests, progress).run()
    inlier, odds = np.zeros(len(order), bool), np.zeros(len(order))
    inlier[order], odds[order] = found.inlier, found.log_odds
    reason = tuple(found.reason[k] for k in np.argsort(order).tolist())
    return GraphVerdicts(found.state.poses, inlier, odds, reason, found.kept)


def warm_up() -> None:
    """Compile the kernels, of which large graphs ask for some that small ones don't."""
    steps = 48  # of twelve laps round a square: their loops are enough for the noise to be fitted
    relative, spread = np.tile([1.0, 0.0, np.pi / 2], (steps, 1)), np.tile(np.eye(3) * 1e-2, (steps, 1, 1))
    i = np.arange(steps - 3)
    claims = np.zeros((len(i), 3))
    claims[-1] = [5.0, 0.0, 0.0]
    graph = PoseGraph("", relative, spread, i, i + 4, claims, spread[: len(i)])
    optimise_graph(graph)
    drive = drive_of(graph)
    network = PathNetwork(drive.chain(drive.start()), i, graph.j, graph.covariance, i)
    many = np.zeros(MANY, np.int64)
    network.errors(many, many + 1)
    network.upper_bounds(i, graph.j)
