"""H3, the distance-estimated landmark vector (Yu, Kim 2010; 2.5.1.3, eq. 2.4; quantised: fig. 5.33)."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import ClassVar, Literal

import numpy as np

from topomap.core.arrays import FloatArray
from topomap.core.panorama import Panorama
from topomap.core.records import HomeVector
from topomap.vision.contracts import Needs, Origin
from topomap.vision.homing.alv import Recipe, landmarks
from topomap.vision.homing.view_vector import same_camera, vector_home
from topomap.vision.image.landmarks import EDGES, Landmarks, MarkerSpec, matched
from topomap.vision.image.laser_landmarks import JumpSpec

NOWHERE = HomeVector(0.0, None, 0.0)


@dataclass(frozen=True, slots=True)
class DistanceLandmarkVector:
    """Mean over matched landmarks of d_C u(theta_C) - d_H u(theta_H) (2.4); metric.

    pairing: "matched" landmarks, or "full", every landmark with every other; levels: distances quantised to so
    many steps of the largest (0: not); reach [rad]: how far a landmark may move. The mean is the componentwise
    median where robust, which forgives single wrong pairs.
    """

    needs: ClassVar[Needs] = Needs(compass=True, ranges=True)
    recipe: Recipe = EDGES
    pairing: Literal["matched", "full"] = "matched"
    levels: int = 0
    reach: float = math.radians(60.0)
    robust: bool = True

    @property
    def origin(self) -> Origin:
        """Row and source of this variant."""
        if isinstance(self.recipe, JumpSpec):
            return Origin("H3", "2.4, 2.6.5.4; Yu, Kim 2010")
        if self.levels:
            return Origin("H3", "2.4, fig. 5.33")
        return Origin("H3", "2.4; Yu, Kim 2010" if self.pairing == "matched" else "2.4, all pairings")

    @property
    def claims_homing(self) -> bool:
        """Whether the landmarks are the same ones in both views, as in `AverageLandmarkVector`."""
        same = self.pairing == "matched" and not isinstance(self.recipe, JumpSpec)
        return same or isinstance(self.recipe, MarkerSpec)

    def describe(self, panorama: Panorama) -> Landmarks:
        """Return the landmarks with their distances [m]."""
        seen = landmarks(panorama, self.recipe)
        return replace(seen, metres=quantised(seen.metres, self.levels)) if self.levels else seen

    def home(self, current: Landmarks, goal: Landmarks) -> HomeVector:
        """Return bearing [rad] and distance [m] of the goal in the aligned frame. Raises ShapeError."""
        same_camera(current.rig, goal.rig)
        if self.pairing == "full":
            return self._full(current, goal)
        pairs = matched(current, goal, self.reach)
        steps = _points(current)[pairs.current] - _points(goal)[pairs.goal]
        known = np.isfinite(steps).all(axis=1)
        if not known.any():
            return NOWHERE
        steps = steps[known]
        x, y = np.median(steps, axis=0) if self.robust else steps.mean(axis=0)
        size = float(np.hypot(*steps.T).mean()) + 1e-6
        return vector_home(float(x), float(y), size, min(int(known.sum()) / 8.0, 1.0), metric=True)

    def _full(self, current: Landmarks, goal: Landmarks) -> HomeVector:
        here, there = _known(_points(current)), _known(_points(goal))
        if not len(here) or not len(there):
            return NOWHERE
        x, y = here.mean(axis=0) - there.mean(axis=0)
        size = float(np.hypot(*here.mean(axis=0)) + np.hypot(*there.mean(axis=0))) + 1e-6
        return vector_home(float(x), float(y), size, metric=True)


def quantised(metres: FloatArray, levels: int) -> FloatArray:
    """Return distances (N,) rounded up to `levels` equal steps of the largest one (fig. 5.33)."""
    finite = metres[np.isfinite(metres)]
    if not len(finite):
        return metres
    step = float(finite.max()) / levels
    return np.asarray(np.ceil(metres / step) * step, np.float64)


def _points(seen: Landmarks) -> FloatArray:
    towards = np.column_stack([np.cos(seen.bearings), np.sin(seen.bearings)])
    return np.asarray(seen.metres[:, np.newaxis] * towards, np.float64)


def _known(points: FloatArray) -> FloatArray:
    return points[np.isfinite(points).all(axis=1)]
