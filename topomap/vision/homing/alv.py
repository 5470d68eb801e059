"""H1, the average landmark vector (Lambrinos et al. 2000; 2.5.1.1, eq. 2.2)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from topomap.core.panorama import Panorama
from topomap.core.records import HomeVector
from topomap.vision.contracts import Needs, Origin
from topomap.vision.homing.view_vector import ViewVector, difference, same_camera, vector_home
from topomap.vision.image.keypoints import KeypointSpec, keypoints
from topomap.vision.image.landmarks import EDGES, EdgeSpec, Landmarks, MarkerSpec, edges, markers, matched
from topomap.vision.image.laser_landmarks import JumpSpec, jumps

Recipe = EdgeSpec | MarkerSpec | JumpSpec | KeypointSpec


def landmarks(panorama: Panorama, recipe: Recipe) -> Landmarks:
    """Return the landmarks of a recipe: edges of the ring, colour markers, the scan's jumps or SIFT points.

    Raises DataError where the recipe needs ranges and there are none.
    """
    if isinstance(recipe, EdgeSpec):
        return edges(panorama, recipe)
    if isinstance(recipe, MarkerSpec):
        return markers(panorama, recipe)
    if isinstance(recipe, JumpSpec):
        return jumps(panorama, recipe)
    found = keypoints(panorama, recipe)
    return Landmarks(found.bearings, found.looks.astype(np.float64), np.full(len(found), np.nan), found.rig)


@dataclass(frozen=True, slots=True)
class AverageLandmarkVector:
    """Mean unit vector towards the landmarks, at the current place minus at the goal (2.2); bearing only.

    recipe: vertical edges of the horizon ring, or colour markers. pairing "matched": over the landmarks that both
    views show, within reach [rad] (Ramisa et al. 2011); "all": over all, as printed; "sum": their sum, not their
    mean, as in the proof of A.3. Edges of distant texture melt
    together, so that near walls show more of them: with all edges the field can point away from the goal, and it
    doesn't claim homing.
    """

    recipe: Recipe = EDGES
    pairing: Literal["matched", "all", "sum"] = "matched"
    reach: float = math.radians(60.0)

    @property
    def origin(self) -> Origin:
        """Row and source of this variant."""
        found = {MarkerSpec: "2.2, 2.6.5.3", JumpSpec: "2.2, 2.6.5.4", KeypointSpec: "2.2, 2.6.5.2; Ramisa et al. 2011"}
        if not isinstance(self.recipe, EdgeSpec):
            return Origin("H1", found[type(self.recipe)])
        if self.pairing == "sum":
            return Origin("H1", "A.3")
        return Origin("H1", "2.2; Ramisa et al. 2011" if self.pairing == "matched" else "2.2; Lambrinos et al. 2000")

    @property
    def needs(self) -> Needs:
        """Aligned views, and ranges where they show the landmarks."""
        return Needs(compass=True, ranges=isinstance(self.recipe, JumpSpec))

    @property
    def claims_homing(self) -> bool:
        """Whether the landmarks are the same in both views: the scan's jumps, told apart by width, often aren't."""
        same = self.pairing == "matched" and not isinstance(self.recipe, JumpSpec)
        return same or isinstance(self.recipe, MarkerSpec)

    def describe(self, panorama: Panorama) -> Landmarks:
        """Return the landmarks."""
        return landmarks(panorama, self.recipe)

    def home(self, current: Landmarks, goal: Landmarks) -> HomeVector:
        """Return the bearing [rad] of the goal in the aligned frame. Raises ShapeError."""
        same_camera(current.rig, goal.rig)
        if self.pairing != "matched":
            summed = self.pairing == "sum"
            return difference(average(current, summed), average(goal, summed))
        pairs = matched(current, goal, self.reach)
        if not len(pairs.weight):
            return HomeVector(0.0, None, 0.0)
        here, there = current.bearings[pairs.current], goal.bearings[pairs.goal]
        x = float(np.sum(pairs.weight * (np.cos(here) - np.cos(there))))
        y = float(np.sum(pairs.weight * (np.sin(here) - np.sin(there))))
        moved = float(np.sum(pairs.weight * np.abs(2.0 * np.sin((here - there) / 2.0))))
        return vector_home(x, y, max(moved, 1e-6), min(len(pairs.weight) / 8.0, 1.0))


def average(seen: Landmarks, summed: bool = False) -> ViewVector:
    """Return the mean unit vector towards landmarks, or their sum."""
    if not len(seen):
        return ViewVector(0.0, 0.0, 0.0, seen.rig)
    share = min(len(seen) / 8.0, 1.0)
    count = 1 if summed else len(seen)
    x, y = float(np.cos(seen.bearings).sum()) / count, float(np.sin(seen.bearings).sum()) / count
    return ViewVector(x, y, share, seen.rig)
