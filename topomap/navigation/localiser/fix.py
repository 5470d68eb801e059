"""The pose relative to a place that is seen from near it, by ranges or else by where the floor ends."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from topomap.core.arrays import FloatArray
from topomap.core.geometry import Pose2, wrap
from topomap.core.panorama import Panorama
from topomap.vision.image.ground_line import ground_ranges
from topomap.vision.matching.scan_match import MEASURED, SEEN, match_scans

MEASURED_FLOOR = np.diag(np.square([0.05, 0.05, math.radians(1.0)]))
"""Least covariance of a fix by ranges: successive ones share what the map has wrong there."""
SEEN_FLOOR = np.diag(np.square([0.15, 0.15, math.radians(2.0)]))
"""... and of one by the ground line, which is told a third as well."""
FAR, TURNED = 0.8, math.radians(15.0)
"""A fix farther than this [m], [rad] from where it was looked for is another surface."""


@dataclass(frozen=True, slots=True, eq=False)
class Fix:
    """`place_from_robot` (3,) with its covariance (3, 3)."""

    relative: FloatArray
    covariance: FloatArray


def fix(view: Panorama, place: Panorama, expected: Pose2) -> Fix | None:
    """Return where the robot is, seen from a place, near where it is expected; None where nothing tells."""
    if view.ranges is not None and place.ranges is not None:
        match, floor = match_scans(place.ranges, view.ranges, expected.array(), MEASURED), MEASURED_FLOOR
    else:
        match = match_scans(ground_ranges(place), ground_ranges(view), expected.array(), SEEN)
        floor = SEEN_FLOOR
    if match is None:
        return None
    off = match.relative - expected.array()
    if math.hypot(off[0], off[1]) > FAR or abs(wrap(float(off[2]))) > TURNED:
        return None
    return Fix(match.relative, match.covariance + floor)
