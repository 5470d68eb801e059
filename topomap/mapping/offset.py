"""Where the robot stood relative to the place it saw again: a revisit is rarely at the very same spot."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from pydantic import BaseModel, Field

from topomap.geometry import FloatArray, Pose2, wrap
from topomap.mapping.graph import Snapshot
from topomap.mapping.scan_match import ScanMatch, ScanMatchSettings, match_scans
from topomap.mapping.verification import Look
from topomap.types import Float32Array


class OffsetSettings(BaseModel, frozen=True, extra="forbid"):
    """What is believed of a closure's relative pose."""

    position_sigma: float = Field(0.35, gt=0, description="how far apart the two spots lie, unmeasured [m]")
    heading_sigma_deg: float = Field(4.0, gt=0, description="error of the rotation by sight [degree]")
    scan_sigma: float = Field(0.03, gt=0, description="least error of a position measured by ranges [m]")
    scan_heading_sigma_deg: float = Field(0.5, gt=0, description="least error of a rotation by ranges [degree]")
    reach: tuple[float, ...] = Field((0.0, 0.25, 0.5), description="distances at which ranges begin to search [m]")
    scans: ScanMatchSettings = Field(default_factory=ScanMatchSettings)


@dataclass(frozen=True, slots=True, eq=False)
class Offset:
    """`match_from_query` with its covariance (3, 3), and the share of rays that fit (0 where ranges say nothing)."""

    relative: Pose2
    covariance: FloatArray
    share: float


class ClosureOffset:
    """Measures a closure's relative pose by ranges; where these don't tell, the same spot is believed, less exactly.

    same_spot (3, 3): the covariance of that belief.
    """

    def __init__(self, settings: OffsetSettings) -> None:
        self._s = settings
        heading, scan_heading = math.radians(settings.heading_sigma_deg), math.radians(settings.scan_heading_sigma_deg)
        self.same_spot = np.diag([settings.position_sigma, settings.position_sigma, heading]) ** 2
        self._floor = np.diag([settings.scan_sigma, settings.scan_sigma, scan_heading]) ** 2

    def measure(self, look: Look, place: Snapshot | None, ranges: Float32Array | None) -> Offset:
        """Return the offset of a view with `ranges` (W,) from the place it was compared with."""
        spot = np.array([0.0, 0.0, look.alignment.rotation])
        match = self._best_match(look, place, ranges)
        if match is None:
            return Offset(Pose2.of(spot), self.same_spot, 0.0)
        measured, believed = np.linalg.inv(match.covariance + self._floor), np.linalg.inv(self.same_spot)
        covariance = np.linalg.inv(measured + believed)
        away = match.relative - spot
        away[2] = wrap(float(away[2]))
        return Offset(Pose2.of(spot + covariance @ measured @ away), covariance, match.share)

    def _best_match(self, look: Look, place: Snapshot | None, ranges: Float32Array | None) -> ScanMatch | None:
        """Search from the same spot and from some way along the home vector's line; the most rays win."""
        if place is None or place.ranges is None or ranges is None:
            return None
        found = [match_scans(place.ranges, ranges, guess, self._s.scans) for guess in self._guesses(look)]
        matches = [match for match in found if match is not None]
        return max(matches, key=lambda match: match.share, default=None)

    def _guesses(self, look: Look) -> list[FloatArray]:
        rotation, home = look.alignment.rotation, look.alignment.home
        away = rotation + home.bearing + math.pi if home is not None else 0.0
        reach = self._s.reach if home is not None else self._s.reach[:1]
        return [np.array([d * math.cos(away), d * math.sin(away), rotation]) for d in reach]
