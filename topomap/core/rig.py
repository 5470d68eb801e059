"""The camera rig: how panorama pixels and directions in space belong together."""

from __future__ import annotations

import math
from dataclasses import dataclass

from topomap.core.geometry import TAU
from topomap.core.robot import RigReading


@dataclass(frozen=True, slots=True)
class Rig:
    """A cylindrical panoramic camera inside the stack: column 0 along the nose, counter-clockwise, row 0 on top.

    width, height [pixels]; horizon_row: fractional row of eye level; focal [pixels], W/(2 pi) for square pixels;
    camera_height above the floor [m].
    """

    width: int = 720
    height: int = 100
    horizon_row: float = 49.5
    focal: float = 720 / TAU
    camera_height: float = 0.6

    @staticmethod
    def of(rig: RigReading) -> Rig:
        """Return the stack's rig of a recorded one (its column order is undone by `Panorama.from_reading`)."""
        return Rig(rig.width, rig.height, rig.horizon_row, rig.focal, rig.camera_height)

    def bearing(self, column: float) -> float:
        """Return the bearing of a column, in [0, 2 pi) [rad]."""
        return (column % self.width) * TAU / self.width

    def column(self, bearing: float) -> float:
        """Return the (fractional) column of a bearing [rad], in [0, W)."""
        return (bearing % TAU) * self.width / TAU

    def row(self, height: float, distance: float) -> float:
        """Return the (fractional) row of a point at a height above the floor [m] and a distance [m]."""
        return self.horizon_row - self.focal * (height - self.camera_height) / distance

    def ground_distance(self, row: float) -> float:
        """Return the distance [m] of the floor seen at a row; infinite at and above the horizon."""
        below = row - self.horizon_row
        return self.camera_height * self.focal / below if below > 0 else math.inf
