"""H16, the numeric convergence point: where the moment's potential is least, seen from both places (3.29-3.33)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from topomap.core.panorama import Panorama
from topomap.core.records import HomeVector
from topomap.vision.contracts import Needs, Origin
from topomap.vision.homing.view_vector import ViewVector, difference
from topomap.vision.image.colour_features import Feature, features
from topomap.vision.image.distances import Source, distances
from topomap.vision.matching.moment_potential import convergence_point, points


@dataclass(frozen=True, slots=True)
class ConvergencePoint:
    """The minimum of sum C |p - a|^n by Barzilai-Borwein descent to `precision` [m], current minus goal (3.33).

    Metric for point landmarks; a bearing only on pixel rings, which sample near walls more densely. For n = 1 and equal
    features the point is the robot itself, wherever it stands: then it abstains.
    """

    origin: ClassVar[Origin] = Origin("H16", "3.29-3.33")
    exponent: float = 3.0
    feature: Feature = "equal"
    distance: Source = "range"
    precision: float = 1e-3

    @property
    def claims_homing(self) -> bool:
        """Whether there is a point at all: n = 1 with equal features has none of its own."""
        return not (self.exponent == 1.0 and self.feature == "equal")

    @property
    def needs(self) -> Needs:
        """Aligned views, and what the source of distances asks for."""
        ground = self.distance in ("ground", "polynomial")
        return Needs(True, self.distance == "range", self.feature not in ("equal", "grey"), ground)

    def describe(self, panorama: Panorama) -> ViewVector:
        """Return the convergence point [m], the mean over the feature's models. Raises DataError without ranges."""
        found = distances(panorama, self.distance)
        if not self.claims_homing:
            return ViewVector(0.0, 0.0, 0.0, panorama.rig)
        models = features(panorama, self.feature)
        landmarks = points(found.metres)
        each = [convergence_point(landmarks, weights, self.exponent, self.precision) for weights in models]
        x, y = np.mean(each, axis=0)
        return ViewVector(float(x), float(y), found.share, panorama.rig)

    def home(self, current: ViewVector, goal: ViewVector) -> HomeVector:
        """Return the bearing [rad] of the goal in the aligned frame. Raises ShapeError."""
        found = difference(current, goal)
        near = math.hypot(current.x - goal.x, current.y - goal.y) <= 2.0 * self.precision  # each is off by so much
        return HomeVector(found.bearing, None, 0.0) if near else found
