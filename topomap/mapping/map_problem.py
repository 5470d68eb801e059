"""A finished map as the back end's problem again: to solve it anew, or to hand it to another optimiser."""

from __future__ import annotations

from topomap.core.errors import TopomapError
from topomap.mapping.graph import TopoMap
from topomap.mapping.odometry.known import KEPT_SIGMAS
from topomap.mapping.optimizer import Closures, Problem


def map_problem(topo: TopoMap) -> Problem:
    """Return the problem of a map's odometry, measured turns and closures. Raises TopomapError for a single node."""
    edges = topo.odometry()
    if not len(edges):
        raise TopomapError("a map of one node has no edges to solve")
    return Problem(
        topo.poses.copy(),
        edges,
        Closures.of(topo.closures),
        tuple(topo.turns),
        topo.calibration,
        prior=topo.calibration,
        prior_sigmas=KEPT_SIGMAS,
        anchor=topo.chain[0],
    )
