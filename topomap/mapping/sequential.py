"""Constraints between neighbouring snapshots: turn and distance, measured by scans or by sight."""

from __future__ import annotations

import math

import numpy as np
from pydantic import BaseModel, Field

from topomap.core.arrays import FloatArray
from topomap.core.panorama import Panorama
from topomap.core.records import Estimate
from topomap.mapping.graph import TopoMap
from topomap.mapping.odometry.calibration import DistanceScale, DistanceScaleSettings
from topomap.mapping.odometry.increments import Calibration, integrate
from topomap.mapping.odometry.scan_match import ScanMatch, ScanMatchSettings, match_scans, seen_scans
from topomap.mapping.optimizer import TurnEdge
from topomap.mapping.places.view_cache import ViewCache
from topomap.vision.contracts import Aligner
from topomap.vision.image.ground_line import ground_ranges


class SequentialSettings(BaseModel, frozen=True, extra="forbid"):
    """How neighbouring snapshots are compared."""

    scans: ScanMatchSettings = Field(default_factory=ScanMatchSettings)
    seen_scans: ScanMatchSettings = Field(
        default_factory=seen_scans, description="the same for distances seen by the ground line"
    )
    distance: DistanceScaleSettings = Field(default_factory=DistanceScaleSettings)
    scan_turn_sigma_deg: float = Field(0.05, gt=0, description="least error of a turn measured by ranges [degree]")
    seen_turn_sigma_deg: float = Field(0.4, gt=0, description="error of a turn seen by the visual compass [degree] ...")
    seen_turn_share: float = Field(0.1, ge=0, description="... and more by this share of the turn")
    distance_sigma: float = Field(0.02, gt=0, description="a distance measured less exactly isn't used [m]")
    min_way: float = Field(0.15, gt=0, description="shortest way whose distance is used [m]")


class SequentialConstraints:
    """Compares each snapshot with the one before: by ranges, or else by the visual compass and the ground line."""

    def __init__(self, settings: SequentialSettings, aligner: Aligner, topo: TopoMap) -> None:
        self._s = settings
        self._aligner = aligner
        self._map = topo
        self._scale = DistanceScale(settings.distance)

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
            match = match_scans(before.ranges, now.ranges, guess, self._s.scans)
        if match is None:
            self._look(a, b, before, now, guess)
            return
        floor = math.radians(self._s.scan_turn_sigma_deg)
        sigma = math.hypot(floor, match.covariance[2, 2] ** 0.5)
        self.turns.append(TurnEdge(a, b, float(match.relative[2]), sigma))
        self._measure(a, b, match)

    def _look(self, a: int, b: int, before: Panorama, now: Panorama, guess: FloatArray) -> None:
        """Take the turn from the visual compass and the distance from where the floor ends in both views."""
        seen = self._aligner.align(now, before, float(guess[2]))
        sigma = math.hypot(math.radians(self._s.seen_turn_sigma_deg), self._s.seen_turn_share * seen.rotation)
        self.turns.append(TurnEdge(a, b, seen.rotation, sigma))
        start = np.array([guess[0], guess[1], seen.rotation])
        match = match_scans(ground_ranges(before), ground_ranges(now), start, self._s.seen_scans)
        if match is not None:
            self._measure(a, b, match, seen=True)

    def _measure(self, a: int, b: int, match: ScanMatch, seen: bool = False) -> None:
        """Compare the measured distance with the odometer's, where the surfaces constrain it."""
        way = float(np.hypot(match.relative[0], match.relative[1]))
        if way < self._s.min_way:
            return
        direction = match.relative[:2] / way
        sigma = _along(direction, match.covariance)
        if sigma < self._s.distance_sigma:
            now = self._map.calibration
            read, covariance, _ = integrate(self._map.way(a, b), Calibration(now.rotation_scale, now.curvature))
            error = math.hypot(sigma, _along(direction, covariance))
            self._scale.add(float(np.hypot(read[0], read[1])), way, error, seen)


def _along(direction: FloatArray, covariance: FloatArray) -> float:
    return math.sqrt(float(direction @ covariance[:2, :2] @ direction))
