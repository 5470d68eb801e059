"""Constraints between neighbouring snapshots: turn and distance, measured by scans or by sight."""

from __future__ import annotations

import math

import numpy as np

from topomap.core.arrays import FloatArray
from topomap.core.panorama import Panorama
from topomap.core.records import Estimate
from topomap.mapping.graph import TopoMap
from topomap.mapping.odometry.calibration import DistanceScale
from topomap.mapping.odometry.increments import Calibration, integrate
from topomap.mapping.optimizer import TurnEdge
from topomap.mapping.places.view_cache import ViewCache
from topomap.vision.contracts import Aligner
from topomap.vision.image.ground_line import ground_ranges
from topomap.vision.matching.scan_match import MEASURED, SEEN, ScanMatch, match_scans

SCAN_TURN_SIGMA = math.radians(0.05)
"""[rad] Least error of a turn measured by ranges."""
SEEN_TURN_SIGMA, SEEN_TURN_SHARE = math.radians(0.4), 0.1
"""[rad] Error of a turn seen by the visual compass, and more by this share of the turn: a column is 0.5 degrees."""
DISTANCE_SIGMA = 0.02
"""[m] A distance measured less exactly isn't used: it is 2 to 8 % of the way between snapshots."""
MIN_WAY = 0.15
"""[m] Shortest way whose distance is used: of a shorter one the measurement's error is the greater part."""


class SequentialConstraints:
    """Compares each snapshot with the one before: by ranges, or else by the visual compass and the ground line."""

    def __init__(self, aligner: Aligner, topo: TopoMap) -> None:
        self._aligner = aligner
        self._map = topo
        self._scale = DistanceScale()

    @property
    def turns(self) -> list[TurnEdge]:
        """The turns measured so far, oldest first; the map keeps them."""
        return self._map.turns

    @property
    def distance_scale(self) -> Estimate:
        """The distance scale by all that was measured so far."""
        return self._scale.estimate()

    def compare(self, a: int, b: int, view_cache: ViewCache) -> None:
        """Measure turn and distance from snapshot a to snapshot b, the next one."""
        before, now = view_cache.panorama(a), view_cache.panorama(b)
        guess = self._map.pose(a).to(self._map.pose(b)).array()
        match = None
        if before.ranges is not None and now.ranges is not None:
            match = match_scans(before.ranges, now.ranges, guess, MEASURED)
        if match is None:
            self._look(a, b, before, now, guess)
            return
        sigma = math.hypot(SCAN_TURN_SIGMA, match.covariance[2, 2] ** 0.5)
        self.turns.append(TurnEdge(a, b, float(match.relative[2]), sigma))
        self._measure(a, b, match)

    def _look(self, a: int, b: int, before: Panorama, now: Panorama, guess: FloatArray) -> None:
        """Take the turn from the visual compass and the distance from where the floor ends in both views."""
        seen = self._aligner.align(now, before, float(guess[2]))
        sigma = math.hypot(SEEN_TURN_SIGMA, SEEN_TURN_SHARE * seen.rotation)
        self.turns.append(TurnEdge(a, b, seen.rotation, sigma))
        start = np.array([guess[0], guess[1], seen.rotation])
        match = match_scans(ground_ranges(before), ground_ranges(now), start, SEEN)
        if match is not None:
            self._measure(a, b, match, seen=True)

    def _measure(self, a: int, b: int, match: ScanMatch, seen: bool = False) -> None:
        """Compare the measured distance with the odometer's, where the surfaces constrain it."""
        way = float(np.hypot(match.relative[0], match.relative[1]))
        if way < MIN_WAY:
            return
        direction = match.relative[:2] / way
        sigma = _along(direction, match.covariance)
        if sigma < DISTANCE_SIGMA:
            now = self._map.calibration
            read, covariance, _ = integrate(self._map.way(a, b), Calibration(now.rotation_scale, now.curvature))
            error = math.hypot(sigma, _along(direction, covariance))
            self._scale.add(float(np.hypot(read[0], read[1])), way, error, seen)


def _along(direction: FloatArray, covariance: FloatArray) -> float:
    return math.sqrt(float(direction @ covariance[:2, :2] @ direction))
