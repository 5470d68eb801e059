"""H18, bipolar masks: ON/OFF edge detectors every half degree at three scales, matched and filtered (4.1.1)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from topomap.core.arrays import FloatArray, IntArray
from topomap.core.errors import ShapeError
from topomap.core.geometry import TAU
from topomap.core.panorama import Panorama
from topomap.core.records import HomeVector
from topomap.vision.contracts import Needs, Origin
from topomap.vision.homing.view_vector import same_camera, vector_home
from topomap.vision.image.haar_masks import box_sums
from topomap.vision.image.landmarks import Landmarks, matched


@dataclass(frozen=True, slots=True)
class BipolarMasks:
    """Landmark vectors of matched masks, current minus goal, weighted by matching score (4.2; (4.3) is reversed).

    levels 1 .. levels are edge masks of mask, 2 mask, 4 mask [rad] width, level 0 the colour; a mask whose edge
    response is below `inhibition` times the mean falls silent; a match whose rival is about as good is dropped;
    kept: the share of matches that count. half: the masks' half height as a share of the view's.
    """

    origin: ClassVar[Origin] = Origin("H18", "4.1-4.3")
    needs: ClassVar[Needs] = Needs(compass=True, colour=True)
    claims_homing: ClassVar[bool] = True
    levels: int = 3
    mask: float = math.radians(4.0)
    inhibition: float = 1.0
    ambiguity: float = 0.05
    kept: float = 0.4
    reach: float = math.radians(50.0)
    half: float = 0.25

    def describe(self, panorama: Panorama) -> Landmarks:
        """Return the active masks: where a level-1 response peaks, with the responses of all levels beside."""
        colours = panorama.derived(("colour integrals", self.half), self._integrals)
        width = panorama.rig.width
        strips = [self._responses(colours, width, level) for level in range(self.levels + 1)]
        activity = np.abs(strips[1]).sum(axis=0)
        size = max(round(self.mask * width / TAU / 2), 1)
        highest = np.max([np.roll(activity, k) for k in range(-size, size + 1)], axis=0)
        active = (activity >= highest) & (activity > self.inhibition * activity.mean()) & (activity > 1e-3)
        at = np.flatnonzero(active)
        looks = np.concatenate(strips)[:, at].T
        return Landmarks(np.asarray(at * (TAU / width), np.float64), looks, np.full(len(at), np.nan), panorama.rig)

    def home(self, current: Landmarks, goal: Landmarks) -> HomeVector:
        """Return the bearing [rad] of the goal in the aligned frame. Raises ShapeError."""
        same_camera(current.rig, goal.rig)
        if current.looks.shape[1:] != goal.looks.shape[1:]:
            raise ShapeError("mask outputs of different levels can't be compared")
        pairs = matched(current, goal, self.reach)
        clear = pairs.weight > self.ambiguity
        if not clear.any():
            return HomeVector(0.0, None, 0.0)
        weight = np.where(clear, pairs.weight, 0.0)
        weight = np.where(weight >= np.quantile(weight[clear], 1.0 - self.kept), weight, 0.0)
        here, there = current.bearings[pairs.current], goal.bearings[pairs.goal]
        x = float(np.sum(weight * (np.cos(here) - np.cos(there))))
        y = float(np.sum(weight * (np.sin(here) - np.sin(there))))
        moved = float(np.sum(weight * 2 * np.abs(np.sin((here - there) / 2))))
        return vector_home(x, y, max(moved, 1e-6), min(float(np.count_nonzero(weight)) / 6.0, 1.0))

    def _integrals(self, panorama: Panorama) -> FloatArray:
        """Return the integral (3, 2, W + 1) of each colour's horizon band; the bands are means over rows."""
        middle, half = panorama.rig.horizon_row, self.half * panorama.rig.height
        first = min(max(round(middle - half), 0), panorama.rig.height - 1)
        band = panorama.image[first : max(round(middle + half) + 1, first + 1)].mean(axis=0, dtype=np.float64).T / 255.0
        spread = max(float(band.std()), 1e-2)
        summed = np.zeros((3, 2, band.shape[1] + 1))
        summed[:, 1, 1:] = ((band - band.mean()) / spread).cumsum(axis=1)
        return summed

    def _responses(self, colours: FloatArray, width: int, level: int) -> FloatArray:
        """Return ON minus OFF (3, W) of a level's masks at every column; level 0: the mean colour."""
        half = max(round(self.mask * width / TAU * 2.0 ** (level - 2)), 1) if level else max(round(width / 180), 1)
        here = np.arange(width)
        ahead = _means(colours, here, here + half)
        behind = _means(colours, here - half, here)
        return 0.5 * (ahead + behind) if level == 0 else ahead - behind


def _means(
    colours: FloatArray,
    left: IntArray,
    right: IntArray,
) -> FloatArray:
    corners = np.stack([left, np.zeros_like(left), right, np.ones_like(left)], axis=1)
    return np.stack([box_sums(colour, corners)[0] for colour in colours]) / (right - left)
