"""Where the robot stood relative to the place it saw again: a revisit is rarely at the very same spot."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from pydantic import BaseModel, Field

from topomap.core.arrays import Float32Array, FloatArray
from topomap.core.geometry import Pose2, wrap
from topomap.core.panorama import Panorama
from topomap.mapping.closures.appearance import Look
from topomap.vision.image.ground_line import ground_ranges
from topomap.vision.matching.scan_match import MEASURED, SEEN, ScanMatch, Surfaces, match_scans


class RelativePoseSettings(BaseModel, frozen=True, extra="forbid"):
    """What is believed of a closure's relative pose."""

    position_sigma: float = Field(0.35, gt=0, description="how far apart the two spots lie, unmeasured [m]")
    heading_sigma_deg: float = Field(4.0, gt=0, description="error of the rotation by sight [degree]")
    scan_sigma: float = Field(0.03, gt=0, description="least error of a position measured by ranges [m]")
    scan_heading_sigma_deg: float = Field(0.5, gt=0, description="least error of a rotation by ranges [degree]")
    reach: tuple[float, ...] = Field((0.0, 0.25, 0.5), description="distances at which ranges begin to search [m]")
    seen_sigma: float = Field(0.1, gt=0, description="least error of a position measured by the ground line [m]")
    seen_heading_sigma_deg: float = Field(2.0, gt=0, description="least error of a rotation by it [degree]")


@dataclass(frozen=True, slots=True, eq=False)
class Offset:
    """`match_from_query` with its covariance (3, 3), and the share of rays that fit (0 where none does)."""

    relative: Pose2
    covariance: FloatArray
    share: float


class RelativePoseEstimator:
    """Measures a closure's relative pose by ranges, or else by where the floor ends; where these don't tell, the same
    spot is believed, less exactly.

    same_spot (3, 3): the covariance of that belief.
    """

    def __init__(self, settings: RelativePoseSettings) -> None:
        self._s = settings
        self.same_spot = _diagonal(settings.position_sigma, settings.heading_sigma_deg)
        self._floor = _diagonal(settings.scan_sigma, settings.scan_heading_sigma_deg)
        self._seen_floor = _diagonal(settings.seen_sigma, settings.seen_heading_sigma_deg)

    def measure(self, look: Look, place: Panorama | None, view: Panorama) -> Offset:
        """Return the offset of a view from the place it was compared with; None: that place kept no view."""
        spot = np.array([0.0, 0.0, look.alignment.rotation])
        match, floor = self._match(look, place, view)
        if match is None:
            return Offset(Pose2.of(spot), self.same_spot, 0.0)
        measured, believed = np.linalg.inv(match.covariance + floor), np.linalg.inv(self.same_spot)
        covariance = np.linalg.inv(measured + believed)
        away = match.relative - spot
        away[2] = wrap(float(away[2]))
        return Offset(Pose2.of(spot + covariance @ measured @ away), covariance, match.share)

    def _match(self, look: Look, place: Panorama | None, view: Panorama) -> tuple[ScanMatch | None, FloatArray]:
        """Return the best match of what both views have of ranges, and the least covariance of such a match."""
        if place is None:
            return None, self._floor
        if place.ranges is not None and view.ranges is not None:
            found = self._best_match(look, place.ranges, view.ranges, MEASURED)
            if found is not None:
                return found, self._floor
        return self._best_match(look, ground_ranges(place), ground_ranges(view), SEEN), self._seen_floor

    def _best_match(self, look: Look, place: Float32Array, view: Float32Array, surfaces: Surfaces) -> ScanMatch | None:
        """Search from the same spot and from some way along the home vector's line; the most rays win."""
        found = [match_scans(place, view, guess, surfaces) for guess in self._guesses(look)]
        matches = [match for match in found if match is not None]
        return max(matches, key=lambda match: match.share, default=None)

    def _guesses(self, look: Look) -> list[FloatArray]:
        rotation, home = look.alignment.rotation, look.alignment.home
        away = rotation + home.bearing + math.pi if home is not None else 0.0
        reach = self._s.reach if home is not None else self._s.reach[:1]
        return [np.array([d * math.cos(away), d * math.sin(away), rotation]) for d in reach]


def _diagonal(position: float, heading_deg: float) -> FloatArray:
    """Return the covariance (3, 3) of errors of a position [m] and a heading [degree]."""
    return np.asarray(np.diag([position, position, math.radians(heading_deg)]) ** 2)
