"""H18, bipolar masks: ON/OFF edge detectors every half degree at several scales, matched and filtered (4.1.1)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np

from topomap.core.arrays import FloatArray, IntArray
from topomap.core.errors import ShapeError
from topomap.core.geometry import TAU
from topomap.core.panorama import Panorama
from topomap.core.records import HomeVector
from topomap.vision.contracts import Needs, Origin
from topomap.vision.homing.view_vector import ViewVector, difference, same_camera, vector_home
from topomap.vision.image.haar_masks import box_sums
from topomap.vision.image.landmarks import Landmarks, Pairs, matched
from topomap.vision.matching.mask_scores import best_partners, unambiguous

Stage = Literal["masks", "matching", "filter"]
Score = Literal["lead", "inverse"]


@dataclass(frozen=True, slots=True)
class BipolarMasks:
    """Landmark vectors of matched masks, current minus goal, weighted by matching score (4.2; (4.3) is reversed).

    levels 1 .. levels are edge masks of mask, growth mask, growth^2 mask [rad] width, level 0 the colour; a mask whose
    edge response is below `inhibition` times the mean falls silent; a match whose rival is about as good is dropped;
    kept: the share of matches that count. half: the masks' half height as a share of the view's.
    stage: "masks" counts every active mask by its response (4.17, left), "matching" every mask with its best partner
    (4.17, right), "filter" the clear ones alone. score: how much better the best partner is than its rival, or as
    printed, the inverse of the difference, level by level (4.1.1.4).
    """

    needs: ClassVar[Needs] = Needs(compass=True, colour=True)
    levels: int = 3
    mask: float = math.radians(4.0)
    inhibition: float = 1.0
    ambiguity: float = 0.05
    kept: float = 0.4
    reach: float = math.radians(50.0)
    half: float = 0.25
    growth: float = 2.0
    stage: Stage = "filter"
    score: Score = "lead"

    @property
    def origin(self) -> Origin:
        """Row and source of this variant."""
        figures = {"masks": "4.1-4.4, fig. 4.17 left", "matching": "4.1.1.4, fig. 4.17 right", "filter": "4.1-4.3"}
        printed = ", score 1/difference" if self.stage == "filter" and self.score == "inverse" else ""
        return Origin("H18", figures[self.stage] + printed)

    @property
    def claims_homing(self) -> bool:
        """Whether masks are matched: their responses alone make the saddle of H4."""
        return self.stage != "masks"

    def describe(self, panorama: Panorama) -> Landmarks:
        """Return the active masks with the responses of all levels, (N, 3 (levels + 1)).

        Matched masks stand where a level-1 response peaks; masks alone are all that aren't inhibited.
        """
        colours = panorama.derived(("colour integrals", self.half), self._integrals)
        width = panorama.rig.width
        strips = [self._responses(colours, width, level) for level in range(self.levels + 1)]
        activity = np.abs(strips[1]).sum(axis=0)
        active = (activity > self.inhibition * activity.mean()) & (activity > 1e-3)
        if self.stage != "masks":
            size = max(round(self.mask * width / TAU / 2), 1)
            active &= activity >= np.max([np.roll(activity, k) for k in range(-size, size + 1)], axis=0)
        at = np.flatnonzero(active)
        looks = np.concatenate(strips)[:, at].T
        return Landmarks(np.asarray(at * (TAU / width), np.float64), looks, np.full(len(at), np.nan), panorama.rig)

    def home(self, current: Landmarks, goal: Landmarks) -> HomeVector:
        """Return the bearing [rad] of the goal in the aligned frame. Raises ShapeError."""
        same_camera(current.rig, goal.rig)
        if current.looks.shape[1:] != goal.looks.shape[1:]:
            raise ShapeError("mask outputs of different levels can't be compared")
        if self.stage == "masks":
            return difference(_activity(current), _activity(goal))
        pairs = self._matched(current, goal)
        here, there, weight = current.bearings[pairs.current], goal.bearings[pairs.goal], pairs.weight
        x = float(np.sum(weight * (np.cos(here) - np.cos(there))))
        y = float(np.sum(weight * (np.sin(here) - np.sin(there))))
        moved = float(np.sum(weight * 2 * np.abs(np.sin((here - there) / 2))))
        size = max(moved, 1e-6 * float(weight.sum()))
        return vector_home(x, y, size, min(float(np.count_nonzero(weight)) / 6.0, 1.0))

    def _matched(self, current: Landmarks, goal: Landmarks) -> Pairs:
        """Return the matched masks, silent ones with weight 0."""
        if self.score == "lead" and self.stage == "filter":
            pairs = matched(current, goal, self.reach)
            clear = pairs.weight > self.ambiguity
        else:
            pairs = best_partners(current, goal, self.reach, self.levels + 1)
            clear = np.ones(len(pairs.weight), np.bool_)
            if self.stage == "filter":
                clear = unambiguous(current, goal, pairs, self.reach, self.levels + 1, self.ambiguity)
        weight = np.where(clear, pairs.weight, 0.0)
        if self.stage == "filter" and clear.any():
            weight = np.where(weight >= np.quantile(weight[clear], 1.0 - self.kept), weight, 0.0)
        return Pairs(pairs.current, pairs.goal, weight)

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
        wide = self.mask * self.growth ** (level - 1) if level else TAU / 90
        half = max(round(0.5 * wide * width / TAU), 1)
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


def _activity(seen: Landmarks) -> ViewVector:
    """Return the active masks' vector: each counts by its responses at all edge levels (4.4)."""
    fired = np.abs(seen.looks[:, 3:]).sum(axis=1)
    x, y = float(np.sum(fired * np.cos(seen.bearings))), float(np.sum(fired * np.sin(seen.bearings)))
    return ViewVector(x, y, 1.0 if len(seen) else 0.0, seen.rig)
