"""Anybody's pose graph with doubtful closures, judged by the closure engine."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from topomap.core.arrays import BoolArray, FloatArray
from topomap.mapping.closures.closure_tests import TESTS, ClosureTest
from topomap.mapping.closures.engine import ClosureEngine, Told, quiet
from topomap.mapping.closures.noise import variance_factor
from topomap.mapping.closures.pose_graph_drive import claims_of, drive_of
from topomap.mapping.pose_graph import PoseGraph


@dataclass(frozen=True, slots=True, eq=False)
class GraphVerdicts:
    """A judged pose graph: poses (N, 3), and in the order of its closures inlier, log_odds and reason (M,).

    factor: by which the file's covariances are too large.
    """

    poses: FloatArray
    inlier: BoolArray
    log_odds: FloatArray
    reason: tuple[str, ...]
    factor: float


def optimise_graph(graph: PoseGraph, tests: Sequence[ClosureTest] = TESTS, told: Told = quiet) -> GraphVerdicts:
    """Judge a pose graph whose closures may be false and whose covariances hold up to a factor."""
    told(0.0, "noise")
    stated = drive_of(graph)
    claims, order = claims_of(graph)
    factor = variance_factor(claims, stated.chain(stated.start()))
    claims, order = claims_of(graph, factor)
    found = ClosureEngine(drive_of(graph, factor), claims, tests, told).run()
    inlier, odds = np.zeros(len(order), bool), np.zeros(len(order))
    inlier[order], odds[order] = found.inlier, found.log_odds
    back = np.argsort(order)
    return GraphVerdicts(found.state.poses, inlier, odds, tuple(found.reason[k] for k in back.tolist()), factor)
