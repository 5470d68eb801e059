"""Scans as a homing method: where the current range scan lies in the goal's, by search and alignment."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from topomap.core.arrays import Float32Array
from topomap.core.errors import DataError
from topomap.core.geometry import wrap
from topomap.core.panorama import Panorama
from topomap.core.records import Alignment, HomeVector
from topomap.core.rig import Rig
from topomap.vision.contracts import Needs, Origin
from topomap.vision.homing.view_vector import same_camera, same_views
from topomap.vision.image.distances import FAR
from topomap.vision.matching.scan_match import MEASURED, ScanMatch, Surfaces, match_scans
from topomap.vision.matching.scan_search import SEARCH, SearchSpec, places

NOWHERE = HomeVector(0.0, 0.0, 0.0)
NEAR_PRIOR = math.radians(30.0)
"""How far from an odometry prior the views may be turned."""
AT_HOME = 0.005
"""Nearer than this [m] there is nowhere to go: 720 rays of 1 cm noise place a scan to 1-2 mm."""
LEAST_SHARE = 0.1
"""Of all rays that must find a partner: behind pillars two scans of a hall share less than a closure's quarter."""
FROM_AFAR: Surfaces = replace(MEASURED, min_share=LEAST_SHARE)


@dataclass(frozen=True, slots=True, eq=False)
class Scan:
    """Ranges (W,) float32 [m], NaN where nothing was measured, and the camera they belong to."""

    ranges: Float32Array
    rig: Rig


@dataclass(frozen=True, slots=True)
class ScanMatching:
    """The current scan laid over the goal's: searched over all places within reach, the best ones aligned point to
    line (Censi 2008), and the place kept on which most rays agree; metric.

    window [rad]: how far the views may be turned against each other, or from a prior; pi: any rotation, which makes it
    a compass and an `Aligner` too. The residual is the share of rays that found no partner.
    """

    origin: ClassVar[Origin] = Origin("own", "scan matching: Olson 2009, Censi 2008")
    claims_homing: ClassVar[bool] = True
    search: SearchSpec = SEARCH
    window: float = math.radians(8.0)

    @property
    def needs(self) -> Needs:
        """Ranges, and aligned views where only a small rotation is searched."""
        return Needs(compass=self.window < math.pi, ranges=True)

    def describe(self, panorama: Panorama) -> Scan:
        """Return the scan. Raises DataError without ranges."""
        if panorama.ranges is None:
            raise DataError("scan matching needs measured ranges, and the panorama has none")
        good = np.isfinite(panorama.ranges) & (panorama.ranges > 0) & (panorama.ranges < FAR)
        return Scan(np.where(good, panorama.ranges, np.nan).astype(np.float32), panorama.rig)

    def home(self, current: Scan, goal: Scan) -> HomeVector:
        """Return bearing [rad] and distance [m] of the goal in the current frame. Raises ShapeError."""
        return _home(self._placed(current, goal, 0.0, self.window))

    def align(self, current: Panorama, goal: Panorama, prior: float | None = None) -> Alignment:
        """Return the rotation [rad], near a prior where there is one, with the home vector; nothing without ranges.

        Raises ShapeError.
        """
        same_views(current, goal)
        if current.ranges is None or goal.ranges is None:
            return Alignment(prior or 0.0, 1.0, NOWHERE)
        here, there = (p.derived(("scan", FAR), self.describe) for p in (current, goal))
        window = self.window if prior is None else min(self.window, NEAR_PRIOR)
        found = self._placed(here, there, prior or 0.0, window)
        rotation = wrap(float(found.relative[2])) if found else prior or 0.0
        return Alignment(rotation, 1.0 - found.share if found else 1.0, _home(found))

    def _placed(self, current: Scan, goal: Scan, prior: float, window: float) -> ScanMatch | None:
        """Return `goal_from_current`: of the searched places that one on which most rays agree after alignment."""
        same_camera(current.rig, goal.rig)
        sought = places(goal.ranges, current.ranges, prior, window, self.search)
        tried = [match_scans(goal.ranges, current.ranges, np.array([p.x, p.y, p.turn]), FROM_AFAR) for p in sought]
        slack = window + 2.0 * self.search.step
        fitting = [m for m in tried if m is not None and abs(wrap(float(m.relative[2]) - prior)) <= slack]
        return max(fitting, key=lambda match: match.share, default=None)


def _home(found: ScanMatch | None) -> HomeVector:
    """Return the goal as seen by a scan that stands at `relative` (3,) in the goal's frame."""
    if found is None:
        return NOWHERE
    x, y, turn = (float(v) for v in found.relative)
    length = math.hypot(x, y)
    if length < AT_HOME:
        return NOWHERE
    return HomeVector(wrap(math.atan2(-y, -x) - turn), length, min(found.share, 1.0))
