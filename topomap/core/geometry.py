"""Plane poses and angles: the only place that wraps angles."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from topomap.core.arrays import FloatArray

TAU = 2.0 * math.pi


def wrap(angle: float) -> float:
    """Return the same angle in (-pi, pi] [rad]."""
    wrapped = math.remainder(angle, TAU)
    return math.pi if wrapped == -math.pi else wrapped


def wrap_all(angles: FloatArray) -> FloatArray:
    """Return angles of any shape in (-pi, pi] [rad]."""
    return np.pi - np.mod(np.pi - angles, TAU)


@dataclass(frozen=True, slots=True)
class Pose2:
    """A pose of frame b in frame a (`a_from_b`): x, y [m] and heading [rad, counter-clockwise]."""

    x: float = 0.0
    y: float = 0.0
    heading: float = 0.0

    def __matmul__(self, other: Pose2) -> Pose2:
        """Compose: `a_from_b @ b_from_c` is `a_from_c`."""
        c, s = math.cos(self.heading), math.sin(self.heading)
        return Pose2(
            self.x + c * other.x - s * other.y,
            self.y + s * other.x + c * other.y,
            wrap(self.heading + other.heading),
        )

    def inverse(self) -> Pose2:
        """Return `b_from_a`."""
        c, s = math.cos(self.heading), math.sin(self.heading)
        return Pose2(-c * self.x - s * self.y, s * self.x - c * self.y, wrap(-self.heading))

    def to(self, other: Pose2) -> Pose2:
        """Return `self_from_other` for two poses given in one frame."""
        return self.inverse() @ other

    def distance(self, other: Pose2) -> float:
        """Return the distance between the two origins [m]."""
        return math.hypot(other.x - self.x, other.y - self.y)

    def bearing_to(self, other: Pose2) -> float:
        """Return the bearing of the other origin in this frame, in (-pi, pi] [rad]."""
        return wrap(math.atan2(other.y - self.y, other.x - self.x) - self.heading)

    def array(self) -> FloatArray:
        """Return (3,) x, y, heading."""
        return np.array([self.x, self.y, self.heading])

    @staticmethod
    def of(row: FloatArray) -> Pose2:
        """Return the pose of a row (3,) x, y, heading."""
        return Pose2(float(row[0]), float(row[1]), wrap(float(row[2])))


def compose(a: FloatArray, b: FloatArray) -> FloatArray:
    """Compose poses (..., 3) row by row, broadcasting, as `Pose2.__matmul__` does."""
    c, s = np.cos(a[..., 2]), np.sin(a[..., 2])
    x = a[..., 0] + c * b[..., 0] - s * b[..., 1]
    y = a[..., 1] + s * b[..., 0] + c * b[..., 1]
    return np.stack([x, y, wrap_all(a[..., 2] + b[..., 2])], axis=-1)


def between(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return `a_from_b` of poses (..., 3) given in one frame, row by row, broadcasting."""
    c, s = np.cos(a[..., 2]), np.sin(a[..., 2])
    dx, dy = b[..., 0] - a[..., 0], b[..., 1] - a[..., 1]
    return np.stack([c * dx + s * dy, c * dy - s * dx, wrap_all(b[..., 2] - a[..., 2])], axis=-1)
