"""How a camera leans."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Lean:
    """roll: to the right, pitch: forward [rad], both of the camera against the plumb line."""

    roll: float = 0.0
    pitch: float = 0.0

    def __add__(self, other: Lean) -> Lean:
        """Return both one after the other; exact enough for some degrees."""
        return Lean(self.roll + other.roll, self.pitch + other.pitch)

    def __sub__(self, other: Lean) -> Lean:
        """Return what must be added to `other`."""
        return Lean(self.roll - other.roll, self.pitch - other.pitch)

    @property
    def size(self) -> float:
        """How far it leans, whatever the direction [rad]."""
        return math.hypot(self.roll, self.pitch)


UPRIGHT = Lean()
