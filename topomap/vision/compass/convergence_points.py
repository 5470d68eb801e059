"""A8, three convergence points: the rigid fit of the red, green and blue reference points (3.20-3.22, fig. 3.2)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np

from topomap.core.arrays import FloatArray
from topomap.core.geometry import wrap
from topomap.core.panorama import Panorama
from topomap.core.records import Alignment, HomeVector
from topomap.vision.contracts import Needs, Origin
from topomap.vision.homing.view_vector import same_views
from topomap.vision.image.colour_features import features
from topomap.vision.image.distances import Source, distances
from topomap.vision.matching.moment_potential import centroid, points, rigid_fit

SPREAD = 0.02
"""Reference points that lie closer together than this [m] tell no rotation."""


@dataclass(frozen=True, slots=True)
class ConvergencePoints:
    """Rotation and position from where the moments of three colours converge, seen from both places.

    distance: where distances come from; power: the colours are raised to it, which spreads the points. Needs ranges
    and colour; the residual is the rms of the fit [m]. Raises DataError, ShapeError.
    """

    origin: ClassVar[Origin] = Origin("A8", "3.20-3.22, fig. 3.2")
    needs: ClassVar[Needs] = Needs(ranges=True, colour=True)
    claims_homing: ClassVar[bool] = True
    distance: Source = "range"
    form: Literal["rgb", "hsv"] = "rgb"
    power: float = 3.0

    def align(self, current: Panorama, goal: Panorama, prior: float | None = None) -> Alignment:
        """Return rotation [rad], residual [m] and home vector; the prior only stands in for an answer."""
        same_views(current, goal)
        here, there = self._points(current), self._points(goal)
        spread = min(float(np.hypot(*(p - p.mean(axis=0)).T).max()) for p in (here, there))
        if spread < SPREAD:
            return Alignment(wrap(prior or 0.0), 1.0, HomeVector(0.0, None, 0.0))
        turn, shift, residual = rigid_fit(here, there)
        distance = float(np.hypot(*shift))
        bearing = wrap(math.atan2(-float(shift[1]), -float(shift[0])) - turn)
        sure = spread / (spread + residual) if distance > 1e-6 else 0.0
        return Alignment(turn, residual, HomeVector(bearing, distance, sure))

    def _points(self, panorama: Panorama) -> FloatArray:
        """Return the three reference points (3, 2) [m] in the robot's frame; each range counts by its arc."""
        found = distances(panorama, self.distance)
        landmarks = points(found.metres)
        arc = found.metres if found.share > 0.0 else np.zeros(panorama.rig.width)
        return np.stack([centroid(landmarks, arc * c**self.power) for c in features(panorama, self.form)])
