"""H21, pixel-wise landmarks with distance (5.1.1, eqs. 5.2-5.5)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from topomap.core.geometry import TAU
from topomap.core.panorama import Panorama
from topomap.core.records import HomeVector
from topomap.vision.contracts import Needs, Origin
from topomap.vision.homing.view_vector import ViewVector, difference
from topomap.vision.image.distances import Source, distances
from topomap.vision.image.pixel_selection import coloured


@dataclass(frozen=True, slots=True)
class PixelLandmarks:
    """sum over landmark pixels of delta C r u, current minus goal ((5.5) as printed is reversed); bearing only.

    delta picks pixels by colour (saturation, value >= in [0, 1]) in the middle `rows` of the height; C is 1; r
    comes from `distance`.
    """

    claims_homing: ClassVar[bool] = True
    distance: Source = "ground"
    saturation: float = 0.25
    value: float = 0.2
    rows: float = 0.9

    @property
    def origin(self) -> Origin:
        """Row and source of this variant."""
        ground = self.distance == "ground"
        return Origin("H21, H17", "5.2-5.5, ground line") if ground else Origin("H21", "5.2-5.5")

    @property
    def needs(self) -> Needs:
        """Aligned colour views, and what the source of distances asks for."""
        ground = self.distance in ("ground", "polynomial")
        return Needs(True, self.distance == "range", True, ground)

    def describe(self, panorama: Panorama) -> ViewVector:
        """Return the landmark pixels' vector. Raises DataError without ranges."""
        found = distances(panorama, self.distance)
        weight = coloured(panorama, self.saturation, self.value, self.rows)
        angles = np.arange(len(weight)) * (TAU / len(weight))
        x, y = (float(np.mean(weight * found.metres * part)) for part in (np.cos(angles), np.sin(angles)))
        return ViewVector(x, y, min(found.share, 10.0 * float(weight.mean()), 1.0), panorama.rig)

    def home(self, current: ViewVector, goal: ViewVector) -> HomeVector:
        """Return the bearing [rad] of the goal in the aligned frame. Raises ShapeError."""
        return difference(current, goal)
