"""H15, the area centroid: where the middle of the open space around the robot lies."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from topomap.errors import DataError
from topomap.geometry import TAU
from topomap.types import Float32Array, HomeVector
from topomap.vision.homing.needs import Needs
from topomap.vision.panorama import Panorama

FAR = 50.0
"""Ranges [m] beyond this are the sensor's way of saying nothing."""


@dataclass(frozen=True, slots=True)
class Centroid:
    """The centroid of the open space in the robot's frame: x, y [m]; share of the directions measured."""

    x: float
    y: float
    share: float


@dataclass(frozen=True, slots=True)
class AreaCentroid:
    """2/3 sum r^3 u / sum r^2, at the current place minus at the goal (chapter 3.6; H15); metric.

    least_share: the share of directions that must have a range.
    """

    needs: ClassVar[Needs] = Needs(compass=True, ranges=True)
    claims_homing: ClassVar[bool] = True
    least_share: float = 0.25

    def describe(self, panorama: Panorama) -> Centroid:
        """Return the centroid; unmeasured directions are interpolated. Raises DataError without ranges."""
        if panorama.ranges is None:
            raise DataError("the area centroid needs measured ranges, and the panorama has none")
        good = np.isfinite(panorama.ranges) & (panorama.ranges > 0) & (panorama.ranges < FAR)
        if not good.any():
            return Centroid(0.0, 0.0, 0.0)
        return _centroid(panorama.ranges, np.flatnonzero(good))

    def home(self, current: Centroid, goal: Centroid) -> HomeVector:
        """Return bearing [rad] and distance [m]; confidence is the smaller share of measured directions."""
        x, y = current.x - goal.x, current.y - goal.y
        share = min(current.share, goal.share)
        length = math.hypot(x, y)
        sure = share if share >= self.least_share and length > 0.0 else 0.0
        return HomeVector(math.atan2(y, x), length, sure)


def _centroid(ranges: Float32Array, measured: np.ndarray[tuple[int, ...], np.dtype[np.int64]]) -> Centroid:
    width = len(ranges)
    r = np.interp(np.arange(width), measured, ranges[measured].astype(np.float64), period=width)
    angles = np.arange(width) * (TAU / width)
    area = 1.5 * float(np.sum(r**2))
    x, y = float(np.sum(r**3 * np.cos(angles))) / area, float(np.sum(r**3 * np.sin(angles))) / area
    return Centroid(x, y, len(measured) / width)
