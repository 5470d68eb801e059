"""H2, the average correctional vector (Weber et al. 1999; 2.5.1.2, eq. 2.3)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from topomap.core.geometry import wrap_all
from topomap.core.panorama import Panorama
from topomap.core.records import HomeVector
from topomap.vision.contracts import Needs, Origin
from topomap.vision.homing.alv import Recipe, landmarks
from topomap.vision.homing.view_vector import same_camera, vector_home
from topomap.vision.image.landmarks import EDGES, Landmarks, matched


@dataclass(frozen=True, slots=True)
class AverageCorrectionalVector:
    """-sum over matched landmarks of wrap(theta_H - theta_C) * u(theta_C + 90 deg) (2.3); bearing only.

    Without the wrap, which (2.3) doesn't print, it is up to 178 deg off. reach [rad]: how far a landmark may move.
    """

    origin: ClassVar[Origin] = Origin("H2", "2.3; Weber et al. 1999")
    needs: ClassVar[Needs] = Needs(compass=True)
    claims_homing: ClassVar[bool] = True
    recipe: Recipe = EDGES
    reach: float = math.radians(60.0)

    def describe(self, panorama: Panorama) -> Landmarks:
        """Return the landmarks."""
        return landmarks(panorama, self.recipe)

    def home(self, current: Landmarks, goal: Landmarks) -> HomeVector:
        """Return the bearing [rad] of the goal in the aligned frame. Raises ShapeError."""
        same_camera(current.rig, goal.rig)
        pairs = matched(current, goal, self.reach)
        if not len(pairs.weight):
            return HomeVector(0.0, None, 0.0)
        there, here = goal.bearings[pairs.goal], current.bearings[pairs.current]
        turn = -wrap_all(there - here) * pairs.weight
        across = here + math.pi / 2
        x, y = float(np.sum(turn * np.cos(across))), float(np.sum(turn * np.sin(across)))
        size = max(float(np.abs(turn).sum()), 1e-6 * float(pairs.weight.sum()))
        return vector_home(x, y, size, min(len(pairs.weight) / 8.0, 1.0))
