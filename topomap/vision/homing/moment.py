"""H12, H13: moments of the surroundings, weighted by range and colour (chapter 3)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from topomap.core.arrays import FloatArray
from topomap.core.geometry import TAU
from topomap.core.panorama import Panorama
from topomap.core.records import HomeVector
from topomap.vision.contracts import Needs, Origin
from topomap.vision.homing.view_vector import ViewVector, difference
from topomap.vision.image.colour_features import Feature, features
from topomap.vision.image.distances import Source, distances

Form = Literal["centroid", "gradient", "pixel", "area"]
_SOURCES: dict[Form, str] = {"centroid": "3.9, 3.16", "gradient": "3.34", "pixel": "A.20", "area": "3.40"}
_RAISED = {"centroid": 0.0, "gradient": 0.0, "pixel": 1.0, "area": 2.0}


@dataclass(frozen=True, slots=True)
class Moment:
    """A moment of order `exponent` at the current place minus at the goal; bearing only.

    form "centroid": sum r C u / sum C (3.9, 3.16), whatever the exponent; "gradient": m sum r^(m-1) C u, m = n
    (3.34; (3.28)'s sign is a slip that cancels; the factor m makes a negative order repel); "pixel": m = n + 1
    (A.20); "area": m = n + 2 (3.40). m = 0 is void, and m = 1 with equal features sums to zero: both abstain.
    """

    exponent: float = 2.0
    feature: Feature = "grey"
    form: Form = "gradient"
    distance: Source = "range"

    @property
    def origin(self) -> Origin:
        """Row and source of this variant."""
        colours = ", 3.17-3.23" if self.feature not in ("equal", "grey") else ""
        lengths = {"ground": ", 5.1.1.2", "equal": ", equal distances"}.get(self.distance, "")
        row = "H12" if self.form == "centroid" else "H13"
        return Origin(f"{row}, H17" if lengths else row, f"{_SOURCES[self.form]}{colours}{lengths}")

    @property
    def claims_homing(self) -> bool:
        """Whether the lengths are distances: equal ones leave the saddle of (5.8)."""
        return self.distance != "equal"

    @property
    def needs(self) -> Needs:
        """Aligned views, and what the source of distances asks for."""
        ground = self.distance in ("ground", "polynomial")
        return Needs(True, self.distance == "range", self.feature not in ("equal", "grey"), ground)

    def describe(self, panorama: Panorama) -> ViewVector:
        """Return the moment's vector, the mean over the feature's models. Raises DataError without ranges."""
        found = distances(panorama, self.distance)
        vector = self.vector(found.metres, features(panorama, self.feature))
        return ViewVector(float(vector[0]), float(vector[1]), found.share, panorama.rig)

    def home(self, current: ViewVector, goal: ViewVector) -> HomeVector:
        """Return the bearing [rad] of the goal in the aligned frame. Raises ShapeError."""
        return difference(current, goal)

    def vector(self, metres: FloatArray, models: FloatArray) -> FloatArray:
        """Return the moment's vector (2,) of distances (W,) [m] and features (F, W) along the columns."""
        angles = np.arange(len(metres)) * (TAU / len(metres))
        towards = np.stack([np.cos(angles), np.sin(angles)])
        if self.form == "centroid":
            weight = models / np.maximum(models.sum(axis=1, keepdims=True), 1e-12)
            return np.asarray((towards @ (weight * metres).T).mean(axis=1), np.float64)
        order = self.exponent + _RAISED[self.form]
        if order == 0.0 or (order == 1.0 and self.feature == "equal"):
            return np.zeros(2)
        lengths = order * np.maximum(metres, 1e-3) ** (order - 1.0)
        return np.asarray((towards @ (models * lengths).T).mean(axis=1) / len(metres), np.float64)
