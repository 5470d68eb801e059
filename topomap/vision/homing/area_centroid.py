"""H15, the area centroid: where the middle of the open space around the robot lies."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from topomap.core.arrays import FloatArray
from topomap.core.errors import DataError
from topomap.core.geometry import TAU
from topomap.core.panorama import Panorama
from topomap.core.records import HomeVector
from topomap.vision.contracts import Needs, Origin
from topomap.vision.homing.view_vector import ViewVector, same_camera
from topomap.vision.image.distances import distances


@dataclass(frozen=True, slots=True)
class AreaCentroid:
    """2/3 sum r^3 u / sum r^2, at the current place minus at the goal (chapter 3.6; H15); metric.

    least_share: the share of directions that must have a range.
    """

    origin: ClassVar[Origin] = Origin("H15", "3.1.3")
    needs: ClassVar[Needs] = Needs(compass=True, ranges=True)
    claims_homing: ClassVar[bool] = True
    least_share: float = 0.25

    def describe(self, panorama: Panorama) -> ViewVector:
        """Return the centroid; unmeasured directions are interpolated. Raises DataError without ranges."""
        if panorama.ranges is None:
            raise DataError("the area centroid needs measured ranges, and the panorama has none")
        found = distances(panorama, "range")
        if found.share == 0.0:
            return ViewVector(0.0, 0.0, 0.0, panorama.rig)
        x, y = _centroid(found.metres)
        return ViewVector(x, y, found.share, panorama.rig)

    def home(self, current: ViewVector, goal: ViewVector) -> HomeVector:
        """Return bearing [rad] and distance [m]; confidence is the smaller share of measured directions.

        Raises ShapeError.
        """
        same_camera(current.rig, goal.rig)
        x, y = current.x - goal.x, current.y - goal.y
        share = min(current.share, goal.share)
        length = math.hypot(x, y)
        sure = share if share >= self.least_share and length > 0.0 else 0.0
        return HomeVector(math.atan2(y, x), length, sure)


def _centroid(r: FloatArray) -> tuple[float, float]:
    angles = np.arange(len(r)) * (TAU / len(r))
    area = 1.5 * float(np.sum(r**2))
    return float(np.sum(r**3 * np.cos(angles))) / area, float(np.sum(r**3 * np.sin(angles))) / area
