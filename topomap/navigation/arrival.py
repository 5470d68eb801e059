"""When a milestone is reached: a low image difference, or its minimum reached."""

from __future__ import annotations

SAME = 0.12
"""A difference (rms of z-normalised, rotation-aligned views) this low is the place itself: over 75 places of
room-corridor, hall and office-loop it is 0.01 on the spot and 0.06 to 0.26 at 5 cm."""
MINIMUM_BELOW = 0.55
"""A minimum must lie below this to count: at the same places the difference is 0.12 to 0.44 at 0.1 m, and 0.62 or more
from 1 m on, where the next snapshot lies."""
RISE, RISE_STEPS = 1.08, 2
"""The minimum has passed when the difference is this much above it for so many steps: a step of 5 cm adds 0.06
or more."""
REST_STEPS = 6
"""... or when it has come no lower for this many steps."""


class Arrival:
    """Watches the image difference on one leg."""

    def __init__(self, rise_steps: int = RISE_STEPS, rest_steps: int = REST_STEPS) -> None:
        self._rise_steps, self._rest_steps = rise_steps, rest_steps
        self._minimum = float("inf")
        self._rising = 0
        self.since_minimum = 0

    def update(self, difference: float) -> bool:
        """Take the difference of this step; return whether the milestone is reached."""
        if difference < self._minimum:
            self._minimum, self.since_minimum = difference, 0
        else:
            self.since_minimum += 1
        rising = difference > RISE * self._minimum
        self._rising = self._rising + 1 if rising else 0
        over = self._rising >= self._rise_steps or self.since_minimum >= self._rest_steps
        return difference < SAME or (over and self._minimum < MINIMUM_BELOW)
