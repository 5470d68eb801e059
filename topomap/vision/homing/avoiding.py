"""Homing that keeps clear of things: a moment of negative order pushes away from what is near (6.1: sum of C/r)."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from topomap.core.arrays import FloatArray
from topomap.core.geometry import TAU
from topomap.core.panorama import Panorama
from topomap.core.records import HomeVector
from topomap.vision.contracts import HomingMethod, Needs, Origin
from topomap.vision.homing.scan import ScanMatching
from topomap.vision.image.distances import distances

NEAR = 0.5
"""A wall this near [m] pushes as hard as the goal pulls: the robot's radius and two steps."""


@dataclass(frozen=True, slots=True)
class Avoiding:
    """The home vector of `method`, of length 1, plus (near / r)^2 away from everything around: minus the gradient of
    the moment of order -1, sum 1/r, which repels and fades; bearing only, distance as the method says.
    """

    origin: ClassVar[Origin] = Origin("own", "6.1: collision avoidance by a moment of negative order")
    claims_homing: ClassVar[bool] = True
    method: HomingMethod[Any] = field(default_factory=ScanMatching)  # Any: it keeps its own kind of description
    near: float = NEAR

    @property
    def needs(self) -> Needs:
        """What the method needs, and ranges."""
        return Needs(True, True, self.method.needs.colour, self.method.needs.camera_height, self.method.needs.heading)

    def describe(self, panorama: Panorama) -> tuple[object, FloatArray]:
        """Return what the method keeps, and the push (2,) away from what is near. Raises DataError without ranges."""
        return self.method.describe(panorama), repulsion(panorama, self.near)

    def home(self, current: tuple[object, FloatArray], goal: tuple[object, FloatArray]) -> HomeVector:
        """Return the bearing [rad] to steer in the aligned frame. Raises ShapeError."""
        home = self.method.home(current[0], goal[0])
        if home.confidence <= 0.0:
            return home
        x, y = math.cos(home.bearing) + current[1][0], math.sin(home.bearing) + current[1][1]
        bearing = math.atan2(y, x) if math.hypot(x, y) > 1e-9 else home.bearing
        return HomeVector(bearing, home.distance, home.confidence)


def repulsion(panorama: Panorama, near: float) -> FloatArray:
    """Return minus the mean over all directions of (near / r)^2 u (2,): n sum r^(n-1) C u for n = -1, in units of
    `near`. Raises DataError without ranges.
    """
    found = distances(panorama, "range")
    if found.share == 0.0:
        return np.zeros(2)
    angles = np.arange(len(found.metres)) * (TAU / len(found.metres))
    strength = np.square(near / np.maximum(found.metres, 0.1 * near)) / len(found.metres)
    return -np.array([float(np.sum(strength * np.cos(angles))), float(np.sum(strength * np.sin(angles)))])
