"""What two neighbouring snapshots tell of the odometry between them: its turn, and its distance where ranges are."""

from __future__ import annotations

import math

import numpy as np
from pydantic import BaseModel, Field

from topomap.contract import Aligner
from topomap.geometry import FloatArray
from topomap.mapping.album import Album
from topomap.mapping.backend import TurnEdge
from topomap.mapping.calibration import DistanceScale, DistanceScaleSettings
from topomap.mapping.graph import TopoMap
from topomap.mapping.odometry import Calibration, integrate
from topomap.mapping.scan_match import ScanMatch, ScanMatchSettings, match_scans
from topomap.types import Estimate


class NeighbourSettings(BaseModel, frozen=True, extra="forbid"):
    """How neighbouring snapshots are compared."""

    scans: ScanMatchSettings = Field(default_factory=ScanMatchSettings)
    distance: DistanceScaleSettings = Field(default_factory=DistanceScaleSettings)
    scan_turn_sigma_deg: float = Field(0.05, gt=0, description="least error of a turn measured by ranges [degree]")
    seen_turn_sigma_deg: float = Field(0.4, gt=0, description="error of a turn seen by the visual compass [degree] ...")
    seen_turn_share: float = Field(0.1, ge=0, description="... and more by this share of the turn")
    distance_sigma: float = Field(0.02, gt=0, description="a distance measured less exactly isn't used [m]")
    min_way: float = Field(0.15, gt=0, description="shortest way whose distance is used [m]")


class Neighbours:
    """Compares each snapshot with the one before: by their ranges, or else by the visual compass."""

    def __init__(self, settings: NeighbourSettings, aligner: Aligner, topo: TopoMap) -> None:
        self._s = settings
        self._aligner = aligner
        self._map = topo
        self._scale = DistanceScale(settings.distance)
        self.turns: list[TurnEdge] = []

    @property
    def distance_scale(self) -> Estimate:
        """The distance scale by all that was measured so far."""
        return self._scale.estimate()

    def compare(self, a: int, b: int, album: Album) -> None:
        """Take the evidence of snapshot b about the way from snapshot a, the one before it."""
        first, second = self._map.nodes[a].snapshot, self._map.nodes[b].snapshot
        guess = self._map.pose(a).to(self._map.pose(b)).array()
        match = None
        if first is not None and second is not None and first.ranges is not None and second.ranges is not None:
            match = match_scans(first.ranges, second.ranges, guess, self._s.scans)
        if match is None:
            seen = self._aligner.align(album.panorama(b), album.panorama(a), float(guess[2]))
            sigma = math.hypot(math.radians(self._s.seen_turn_sigma_deg), self._s.seen_turn_share * seen.rotation)
            self.turns.append(TurnEdge(a, b, seen.rotation, sigma))
        else:
            floor = math.radians(self._s.scan_turn_sigma_deg)
            self.turns.append(
                TurnEdge(a, b, float(match.relative[2]), math.hypot(floor, match.covariance[2, 2] ** 0.5))
            )
            self._measure(a, b, match)

    def _measure(self, a: int, b: int, match: ScanMatch) -> None:
        """Hold the measured distance against the odometer's, where the surfaces tell it."""
        way = float(np.hypot(match.relative[0], match.relative[1]))
        if way < self._s.min_way:
            return
        direction = match.relative[:2] / way
        sigma = _along(direction, match.covariance)
        if sigma < self._s.distance_sigma:
            now = self._map.calibration
            read, covariance, _ = integrate(self._map.way(a, b), Calibration(now.rotation_scale, now.curvature))
            self._scale.add(float(np.hypot(read[0], read[1])), way, math.hypot(sigma, _along(direction, covariance)))


def _along(direction: FloatArray, covariance: FloatArray) -> float:
    return math.sqrt(float(direction @ covariance[:2, :2] @ direction))
