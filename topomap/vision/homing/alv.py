"""H1, the average landmark vector (Lambrinos et al. 2000; 2.5.1.1, eq. 2.2)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from topomap.types import HomeVector
from topomap.vision.homing.needs import Needs
from topomap.vision.homing.view_vector import ViewVector, difference
from topomap.vision.landmarks import EDGES, EdgeSpec, Landmarks, MarkerSpec, edges, markers
from topomap.vision.panorama import Panorama

Recipe = EdgeSpec | MarkerSpec


def landmarks(panorama: Panorama, recipe: Recipe) -> Landmarks:
    """Return the landmarks of a recipe: edges of the ring or colour markers."""
    return edges(panorama, recipe) if isinstance(recipe, EdgeSpec) else markers(panorama, recipe)


@dataclass(frozen=True, slots=True)
class AverageLandmarkVector:
    """Mean unit vector towards the landmarks, at the current place minus at the goal (2.2); bearing only.

    recipe: vertical edges of the horizon ring, or colour markers; needs aligned views.
    """

    needs: ClassVar[Needs] = Needs(compass=True)
    claims_homing: ClassVar[bool] = True
    recipe: Recipe = EDGES

    def describe(self, panorama: Panorama) -> ViewVector:
        """Return the average landmark vector."""
        return average(landmarks(panorama, self.recipe))

    def home(self, current: ViewVector, goal: ViewVector) -> HomeVector:
        """Return the bearing [rad] of the goal in the aligned frame. Raises ShapeError."""
        return difference(current, goal)


def average(seen: Landmarks) -> ViewVector:
    """Return the mean unit vector towards landmarks."""
    if not len(seen):
        return ViewVector(0.0, 0.0, 0.0, seen.rig)
    share = min(len(seen) / 8.0, 1.0)
    return ViewVector(float(np.cos(seen.bearings).mean()), float(np.sin(seen.bearings).mean()), share, seen.rig)
