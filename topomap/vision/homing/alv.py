"""H1, the average landmark vector (Lambrinos et al. 2000; 2.5.1.1, eq. 2.2)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np

from topomap.core.panorama import Panorama
from topomap.core.records import HomeVector
from topomap.vision.contracts import Needs, Origin
from topomap.vision.homing.view_vector import ViewVector, difference, same_camera, vector_home
from topomap.vision.image.landmarks import EDGES, EdgeSpec, Landmarks, MarkerSpec, edges, markers, matched

Recipe = EdgeSpec | MarkerSpec


def landmarks(panorama: Panorama, recipe: Recipe) -> Landmarks:
    """Return the landmarks of a recipe: edges of the ring or colour markers."""
    return edges(panorama, recipe) if isinstance(recipe, EdgeSpec) else markers(panorama, recipe)


@dataclass(frozen=True, slots=True)
class AverageLandmarkVector:
    """Mean unit vector towards the landmarks, at the current place minus at the goal (2.2); bearing only.

    recipe: vertical edges of the horizon ring, or colour markers. pairing "matched": over the landmarks that both
    views show, within reach [rad] (Ramisa et al. 2011); "all": over all, as printed. Edges of distant texture melt
    together, so that near walls show more of them: with all edges the field can point away from the goal, and it
    doesn't claim homing.
    """

    needs: ClassVar[Needs] = Needs(compass=True)
    recipe: Recipe = EDGES
    pairing: Literal["matched", "all"] = "matched"
    reach: float = math.radians(60.0)

    @property
    def origin(self) -> Origin:
        """Row and source of this variant."""
        if isinstance(self.recipe, MarkerSpec):
            return Origin("H1", "2.2, 2.6.5.3")
        return Origin("H1", "2.2; Ramisa et al. 2011" if self.pairing == "matched" else "2.2; Lambrinos et al. 2000")

    @property
    def claims_homing(self) -> bool:
        """Whether the landmarks are the same ones in both views."""
        return self.pairing == "matched" or isinstance(self.recipe, MarkerSpec)

    def describe(self, panorama: Panorama) -> Landmarks:
        """Return the landmarks."""
        return landmarks(panorama, self.recipe)

    def home(self, current: Landmarks, goal: Landmarks) -> HomeVector:
        """Return the bearing [rad] of the goal in the aligned frame. Raises ShapeError."""
        same_camera(current.rig, goal.rig)
        if self.pairing == "all":
            return difference(average(current), average(goal))
        pairs = matched(current, goal, self.reach)
        if not len(pairs.weight):
            return HomeVector(0.0, None, 0.0)
        here, there = current.bearings[pairs.current], goal.bearings[pairs.goal]
        x = float(np.sum(pairs.weight * (np.cos(here) - np.cos(there))))
        y = float(np.sum(pairs.weight * (np.sin(here) - np.sin(there))))
        moved = float(np.sum(pairs.weight * np.abs(2.0 * np.sin((here - there) / 2.0))))
        return vector_home(x, y, max(moved, 1e-6), min(len(pairs.weight) / 8.0, 1.0))


def average(seen: Landmarks) -> ViewVector:
    """Return the mean unit vector towards landmarks."""
    if not len(seen):
        return ViewVector(0.0, 0.0, 0.0, seen.rig)
    share = min(len(seen) / 8.0, 1.0)
    return ViewVector(float(np.cos(seen.bearings).mean()), float(np.sin(seen.bearings).mean()), share, seen.rig)
