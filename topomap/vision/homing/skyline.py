"""Homing by the skyline alone: its heights around the robot, matched by warping (2.6.3.1)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import cv2
import numpy as np

from topomap.core.arrays import Float32Array
from topomap.core.geometry import TAU
from topomap.core.panorama import Panorama
from topomap.core.records import HomeVector
from topomap.vision.contracts import Needs, Origin
from topomap.vision.homing.dtw import DynamicWarping, RingPair
from topomap.vision.homing.view_vector import same_views
from topomap.vision.image.compare import normalised
from topomap.vision.image.skyline import skyline

WARPING = DynamicWarping()


@dataclass(frozen=True, slots=True)
class SkylineHoming:
    """The skyline's height and steepness as a ring of two bands, warped as the horizon's colours are; bearing only.

    Claims no homing: under a ceiling it is off by 45 deg in ourlab, 55 in a1original, 65 in cylinders and 87 in hall1
    (seed 0). It is for wide views under the sky.
    """

    origin: ClassVar[Origin] = Origin("own", "2.6.3.1: skyline; matched as 5.16")
    needs: ClassVar[Needs] = Needs(compass=True)
    claims_homing: ClassVar[bool] = False
    warping: DynamicWarping = WARPING

    def describe(self, panorama: Panorama) -> Panorama:
        """Return the panorama, which keeps its skyline."""
        return panorama

    def home(self, current: Panorama, goal: Panorama) -> HomeVector:
        """Return the bearing [rad] of the goal in the aligned frame. Raises ShapeError."""
        same_views(current, goal)
        here, there = self._rings(current), self._rings(goal)
        if not here.fine.any() or not there.fine.any():
            return HomeVector(0.0, None, 0.0)
        return self.warping.home(here, there)

    def _rings(self, panorama: Panorama) -> RingPair:
        width, columns = panorama.rig.width, min(self.warping.spec.columns, panorama.rig.width)
        heights = skyline(panorama).astype(np.float32)
        fine = _bands(heights, columns)
        coarse = _bands(heights, min(self.warping.flow_columns, width))
        return RingPair(fine, coarse, 0.5 * (TAU / columns - TAU / width))


def _bands(heights: Float32Array, columns: int) -> Float32Array:
    """Return height and steepness (2, C) of mean 0 and variance 1 each."""
    small = np.asarray(cv2.resize(heights[np.newaxis], (columns, 1), interpolation=cv2.INTER_AREA), np.float32)
    steep = np.roll(small, -1, axis=1) - np.roll(small, 1, axis=1)
    return np.concatenate([normalised(small), normalised(steep)])
