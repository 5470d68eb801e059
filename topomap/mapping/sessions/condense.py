"""Odometry over an edge as a single increment: what a finished map needs of it, in a tenth of the room."""

from __future__ import annotations

import numpy as np

from topomap.core.arrays import FloatArray
from topomap.core.geometry import Pose2
from topomap.mapping.graph import TopoMap
from topomap.mapping.odometry.increments import Calibration, EdgeIncrements, Increments, leading


def condensed(increments: Increments, calibration: Calibration) -> Increments:
    """Return one increment, an arc, that leads where all of them lead under the calibration, as uncertain as they are.

    Under a calibration a little different it leads where they do but for the square of that difference.
    """
    if len(increments) < 2:
        return increments
    edge = EdgeIncrements.of([increments]).integrate(calibration)
    x, y, turn = edge.deltas(calibration)[0].tolist()
    deltas = leading(Pose2(x, y, turn), calibration)
    covariance = _of_arc(edge.covariances(calibration)[0], x, y, turn, calibration)
    return Increments(increments.stamps_ns[-1:], deltas[None], covariance[None])


def _of_arc(covariance: FloatArray, x: float, y: float, turn: float, calibration: Calibration) -> FloatArray:
    """Return the covariance (3, 3) of a raw increment whose arc ends at x, y, turn with this covariance (3, 3)."""
    c, s = np.cos(turn / 2), np.sin(turn / 2)
    undo = np.linalg.inv(np.array([[c, -s, -y / 2], [s, c, x / 2], [0.0, 0.0, 1.0]]))
    scales = np.array([calibration.distance_scale, calibration.distance_scale, calibration.rotation_scale])
    raw = (scales[:, None] * undo) @ covariance @ (scales[:, None] * undo).T
    return np.asarray((raw + raw.T) / 2)


def condense(topo: TopoMap) -> None:
    """Condense all odometry of a finished map, rounded to what single precision holds."""
    for a, b, increments in list(topo.odometry_edges()):
        one = condensed(increments, topo.calibration)
        topo.replace_way(a, b, Increments(one.stamps_ns, _single(one.deltas), _single(one.covariances)))


def _single(values: FloatArray) -> FloatArray:
    return values.astype(np.float32).astype(np.float64)
