"""A bounded solve between two full ones: the newest nodes move, all older ones are held."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from topomap.core.arrays import FloatArray, IntArray
from topomap.core.geometry import between, compose
from topomap.core.records import UNKNOWN_HEADING
from topomap.mapping.odometry.increments import Calibration
from topomap.mapping.optimizer.problem import (
    Closures,
    OdometryEdge,
    OdometryEdges,
    Problem,
    Solution,
    TurnEdge,
)
from topomap.mapping.optimizer.settings import OptimizerSettings
from topomap.mapping.optimizer.slices import Slices
from topomap.mapping.optimizer.solver import solving
from topomap.mapping.uncertainty.odometry_chain import turned_by

# the calibration is left to full solves: the same stretch, solved again and again, would count many times over
HELD = (1e-6, 1e-6, 1e-6)


class Recent(NamedTuple):
    """What a bounded solve found: nodes (n,), which of the closures were used (m,), and the solution for these."""

    nodes: IntArray
    heard: IntArray
    solution: Solution


def solving_recent(
    poses: FloatArray,
    odometry: Sequence[OdometryEdge],
    closures: Closures,
    turns: Sequence[TurnEdge],
    calibration: Calibration,
    settings: OptimizerSettings | None = None,
) -> Slices[Recent]:
    """Solve the nodes of the newest odometry edges, a slice at a time; the work doesn't grow with the map.

    poses (N, 3) of the whole map, read in the first slice alone: those of all other nodes stay, and the first of these
    nodes is held. Closures are used whose newer end is among these nodes, whether or not the older one is. Raises
    TopomapError.
    """
    nodes = np.array([odometry[0].i, *(edge.j for edge in odometry)], np.int64)
    place = np.full(len(poses), -1)
    place[nodes] = np.arange(len(nodes))
    heard = np.flatnonzero(place[closures.j] > 0)
    problem = Problem(
        poses[nodes],
        OdometryEdges.of([OdometryEdge(k, k + 1, edge.increments) for k, edge in enumerate(odometry)]),
        _hung(poses, int(nodes[0]), place, closures[heard]),
        tuple(
            TurnEdge(int(place[t.i]), int(place[t.j]), t.turn, t.sigma)
            for t in turns
            if place[t.i] >= 0 and place[t.j] >= 0
        ),
        calibration,
        calibration,
        HELD,
    )
    yield
    solution = yield from solving(problem, settings)
    return Recent(nodes, heard, solution)


def _hung(poses: FloatArray, anchor: int, place: IntArray, closures: Closures) -> Closures:
    """Return the closures in the stretch's numbering; one from a held node is carried to the anchor, held as well."""
    outside = place[closures.i] < 0
    old = poses[closures.i[outside]]
    way = between(np.broadcast_to(poses[anchor], old.shape), old)
    relative, covariance = closures.relative.copy(), closures.covariance.copy()
    relative[outside] = compose(way, relative[outside])
    known = covariance[outside]
    turned = turned_by(way[:, 2], known)
    blind = known[:, 2, 2] > UNKNOWN_HEADING
    turned[blind] = known[blind]  # these are given in the map's axes already
    covariance[outside] = turned
    i = np.where(outside, 0, place[closures.i])
    return Closures(i, place[closures.j], relative, covariance, closures.weight)
