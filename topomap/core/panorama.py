"""A panorama in the stack's one column order, with what was derived from it."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass, field
from typing import TypeVar, cast

import cv2
import numpy as np

from topomap.core.arrays import Float32Array, Image
from topomap.core.errors import ShapeError
from topomap.core.geometry import TAU
from topomap.core.rig import Rig
from topomap.core.robot import Reading, RigReading

D = TypeVar("D")


@dataclass(frozen=True, slots=True, eq=False)
class Panorama:
    """What the robot sees all around.

    image (H, W, 3) uint8 RGB, column j along bearing 2 pi j/W from the nose, counter-clockwise, row 0 on top;
    ranges (W,) float32 [m] in the same order (NaN: nothing measured) or None; rig: the camera. Raises
    ShapeError.
    """

    image: Image
    ranges: Float32Array | None = None
    rig: Rig = field(default_factory=Rig)
    _derived: dict[Hashable, object] = field(default_factory=dict, init=False, repr=False)

    def __post_init__(self) -> None:
        """Refuse what would only fail later and elsewhere."""
        shape = (self.rig.height, self.rig.width, 3)
        if self.image.dtype != np.uint8 or self.image.shape != shape:
            raise ShapeError(f"panorama is {self.image.dtype} {self.image.shape}, the rig says uint8 {shape}")
        if self.ranges is not None and self.ranges.shape != (self.rig.width,):
            raise ShapeError(f"ranges are {self.ranges.shape}, the rig says ({self.rig.width},)")

    @staticmethod
    def from_reading(reading: Reading) -> Panorama:
        """Return a reading's panorama in the stack's column order. Raises ShapeError."""
        return Panorama.from_recorded(reading.image, reading.rig, reading.ranges)

    @staticmethod
    def from_recorded(image: Image, rig: RigReading, ranges: Float32Array | None = None) -> Panorama:
        """Flip and roll a recorded image (H, W, 3) once, losslessly; ranges (W,) already run
        counter-clockwise.

        Raises ShapeError.
        """
        if image.ndim != 3 or image.shape[1] != rig.width:
            raise ShapeError(f"recorded image is {image.shape}, the rig says ({rig.height}, {rig.width}, 3)")
        ordered = cv2.flip(np.ascontiguousarray(image), 1) if rig.clockwise else image
        nose = rig.width - 1 - rig.forward_column if rig.clockwise else rig.forward_column
        return Panorama(np.roll(ordered, -nose, axis=1), ranges, Rig.of(rig))

    def columns(self, angle: float) -> int:
        """Return the nearest whole number of columns to an angle [rad]."""
        return round(angle * self.rig.width / TAU)

    def rolled(self, columns: int) -> Panorama:
        """Return the panorama a robot turned by `columns` clockwise would see."""
        ranges = None if self.ranges is None else np.roll(self.ranges, columns)
        return Panorama(np.roll(self.image, columns, axis=1), ranges, self.rig)

    def rotated(self, angle: float) -> Panorama:
        """Roll by the nearest column to an angle [rad].

        When the current robot is turned by psi against the goal, `current.rotated(psi)` looks the goal's way.
        """
        return self.rolled(self.columns(angle))

    def derived(self, key: Hashable, make: Callable[[Panorama], D]) -> D:
        """Return `make(self)`, computed once per key; the key must say the recipe with all its parameters."""
        if key not in self._derived:
            self._derived[key] = make(self)
        return cast(D, self._derived[key])
