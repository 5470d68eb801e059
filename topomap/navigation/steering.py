"""Where to head: what the view says and what the believed pose says, each by how sure it is."""

from __future__ import annotations

import math

import numpy as np

from topomap.core.geometry import Pose2, wrap
from topomap.core.records import HomeVector

LOST = 0.5
"""The probability of being lost from which on the believed pose isn't asked."""
POSE_SIGMA = 0.12
"""[m] Error of the believed pose against a milestone near by."""
HEADING_SIGMA = 0.05
"""[rad] Error of the believed heading."""
CONFIDENCES = (0.0, 0.1, 0.22, 0.4, 0.62, 0.87, 1.0)
VIEW_SIGMAS = (0.9, 0.78, 0.62, 0.54, 0.24, 0.13, 0.1)
"""[rad] Error (rms) of min-warping's bearing by its confidence: 792 pairs 0.15 to 1 m apart in office-loop,
room-corridor and hall, the mount leaning by 0, 2 and 3 degrees (upright half of them lie above 0.7, at 3 degrees
below 0.15)."""
GATE = 3.0
"""Sigmas of their difference from which on view and pose contradict each other; the pose then leads."""


def view_sigma(confidence: float) -> float:
    """Return the bearing error [rad] of a home vector by its confidence."""
    return float(np.interp(confidence, CONFIDENCES, VIEW_SIGMAS))


def map_sigma(distance: float, lost: float) -> float:
    """Return the error [rad] of the bearing of a place so far away [m], by the believed pose."""
    if lost >= LOST:
        return math.inf
    return math.hypot(HEADING_SIGMA, math.atan2(POSE_SIGMA / (1.0 - lost), max(distance, 1e-6)))


def share_of_view(home: HomeVector, bearing: float, distance: float, lost: float, least_sigma: float = 0.0) -> float:
    """Return the weight in [0, 1] of the home vector against the map's bearing [rad] of the same milestone.

    least_sigma [rad]: error of the home vector, however confident it is.
    """
    if home.confidence <= 0.0:
        return 0.0 if lost < LOST else 1.0
    by_map, by_view = map_sigma(distance, lost), max(view_sigma(home.confidence), least_sigma)
    if math.isinf(by_map):
        return 1.0
    if abs(wrap(home.bearing - bearing)) > GATE * math.hypot(by_map, by_view):
        return 0.0
    return by_map**2 / (by_map**2 + by_view**2)


def heading_for(
    pose: Pose2, milestone: Pose2, ahead: Pose2, home: HomeVector, lost: float, least_sigma: float = 0.0
) -> float:
    """Return the bearing [rad] to steer.

    The course's point `ahead` is headed for, shifted by what the view says of the milestone against what the pose says
    of it, weighed by their errors: both right, the course is followed; nothing seen, the pose leads; lost, the view. A
    milestone at the robot's feet shifts it by a hand's breadth, whatever way its bearing turns.
    """
    bearing, distance = pose.bearing_to(milestone), pose.distance(milestone)
    share = share_of_view(home, bearing, distance, lost, least_sigma)
    if share >= 1.0:
        return home.bearing
    way, on = pose.distance(ahead), pose.bearing_to(ahead)
    shift = share * min(distance, way)
    x = way * math.cos(on) + shift * (math.cos(home.bearing) - math.cos(bearing))
    y = way * math.sin(on) + shift * (math.sin(home.bearing) - math.sin(bearing))
    return math.atan2(y, x)
