"""When a milestone is reached: a low image difference, or its minimum reached."""

from __future__ import annotations

from pydantic import BaseModel, Field


class ArrivalSettings(BaseModel, frozen=True, extra="forbid"):
    """The arrival rule (differences: rms of z-normalised views, rotation-aligned)."""

    same: float = Field(0.12, gt=0, description="a difference this low is the place itself")
    minimum_below: float = Field(0.55, gt=0, description="a minimum must lie below this to count")
    rise: float = Field(1.08, gt=1, description="the minimum has passed when the difference is this much above it")
    rise_steps: int = Field(2, ge=1, description="... for this many steps")
    rest_steps: int = Field(6, ge=1, description="... or when it has come no lower for this many steps")


class Arrival:
    """Watches the image difference on one leg."""

    def __init__(self, settings: ArrivalSettings) -> None:
        self._s = settings
        self._minimum = float("inf")
        self._rising = 0
        self.since_minimum = 0

    def update(self, difference: float) -> bool:
        """Take the difference of this step; return whether the milestone is reached."""
        if difference < self._minimum:
            self._minimum, self.since_minimum = difference, 0
        else:
            self.since_minimum += 1
        rising = difference > self._s.rise * self._minimum
        self._rising = self._rising + 1 if rising else 0
        over = self._rising >= self._s.rise_steps or self.since_minimum >= self._s.rest_steps
        return difference < self._s.same or (over and self._minimum < self._s.minimum_below)
