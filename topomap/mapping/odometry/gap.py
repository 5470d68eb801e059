"""A gap in the odometry: an increment that is in the map, but tells nothing."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from topomap.core.arrays import FloatArray
from topomap.core.geometry import Pose2
from topomap.core.records import Motion
from topomap.mapping.odometry.increments import Calibration, Increments, integrate

GAP = np.diag(np.square([50.0, 50.0, math.pi]))
"""Covariance of an increment over which the robot may have been carried anywhere in a building, and turned."""


@dataclass(frozen=True, slots=True)
class Restated:
    """A step as ranges, views or what is usual have it: true forward, left [m], turn [rad]; ways, turns: which of them
    stand in for the odometry's, with their standard deviations [m], [rad], or None."""

    forward: float
    left: float
    turn: float
    ways: float | None
    turns: float | None


def restated(read: Motion, seen: Restated, calibration: Calibration) -> Motion:
    """Return an increment as an odometer with these errors should have read it."""
    forward, left, turn, covariance = read.forward, read.left, read.turn, read.covariance.copy()
    if seen.ways is not None:
        forward, left = calibration.distance_scale * seen.forward, calibration.distance_scale * seen.left
        covariance[:2, :], covariance[:, :2] = 0.0, 0.0
        covariance[0, 0] = covariance[1, 1] = seen.ways**2
    if seen.turns is not None:
        turn = calibration.rotation_scale * seen.turn + calibration.curvature * forward / calibration.distance_scale
        covariance[2, :], covariance[:, 2] = 0.0, 0.0
        covariance[2, 2] = seen.turns**2
    return Motion(forward, left, turn, covariance, read.dt)


def bridged(increments: Increments, calibration: Calibration, target: Pose2) -> Increments:
    """Return an edge's increments whose last one, which becomes a gap, leads to `target`, its end seen from its start.

    Where a gap leads isn't measured: it is set, so that the route as integrated is the route as believed.
    """
    before, _, _ = integrate(increments[:-1], calibration)
    rest = Pose2.of(before).to(target)
    c, s = math.cos(rest.heading / 2), math.sin(rest.heading / 2)
    forward, left = c * rest.x + s * rest.y, c * rest.y - s * rest.x
    raw = _as_read(Motion(forward, left, rest.heading, GAP, 0.0), calibration)
    deltas, covariances = increments.deltas.copy(), increments.covariances.copy()
    deltas[-1], covariances[-1] = raw, GAP
    return Increments(increments.stamps_ns, deltas, covariances)


def _as_read(motion: Motion, calibration: Calibration) -> FloatArray:
    """Return forward, left, turn (3,) as an odometer with these errors reads a true motion."""
    turn = calibration.rotation_scale * motion.turn + calibration.curvature * motion.forward
    return np.array([calibration.distance_scale * motion.forward, calibration.distance_scale * motion.left, turn])
