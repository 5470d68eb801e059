"""When a milestone is reached: a low image difference, or its minimum; and when a goal is: by the belief as well."""

from __future__ import annotations

import math
from dataclasses import dataclass

from topomap.core.geometry import Pose2, wrap
from topomap.core.records import PlaceMatch, Where

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
        self._last = float("inf")
        self._rising = 0
        self.since_minimum = 0

    @property
    def over(self) -> bool:
        """Whether the difference has passed its minimum, however low that was."""
        return self._rising >= self._rise_steps or self.since_minimum >= self._rest_steps

    def update(self, difference: float, moved: bool = True, counts: bool | None = None) -> bool:
        """Take the difference of this step; return whether the milestone is reached.

        moved: the robot has come on since the last step, and not but turned: a turn brings it no nearer, so that what
        one look of it shows alone is no minimum. counts: the milestone may be passed by this step; left out, as moved.
        """
        counts = moved if counts is None else counts
        lowest = difference if moved else max(difference, self._last)
        self._last = difference
        if lowest < self._minimum:
            self._minimum, self.since_minimum = lowest, 0
        elif counts:
            self.since_minimum += 1
        if counts:
            rising = difference > RISE * self._minimum
            self._rising = self._rising + 1 if rising else 0
        return difference < SAME or (self.over and self._minimum < MINIMUM_BELOW)


NEAR = 0.6
"""[m] Farthest that the believed pose may be from a goal that is reached: five sigmas of one corrected by sight."""
PASSED = 0.25
"""[m] The same where the view but passed its minimum: along an aisle of a warehouse that lies .32 m beside the goal.
There it was believed .34 m away; in 23 claims of four worlds, amid people, by evening and in mild weather, .1 m at
most."""
SURE = 0.05
"""Probability of being lost, or somewhere else, from which on no arrival is claimed: as sure as who was lost has to be
to go on. Carried on by 5 m in `office-loop` and taken for turned by 180 degrees, which looks alike there, the robot was
wrong for 200 steps, half of them with 0.06 to 0.1."""
ELSEWHERE = 1.0
"""[m] A hypothesis or a snapshot this far from the goal is another place."""
TURNED = 0.5
"""[rad] How far the view may be turned otherwise than the believed heading says: six sigmas of the compass."""


@dataclass(frozen=True, slots=True)
class Claim:
    """What an arrival rests on: the goal's pose, rotation [rad] and place difference of its view, the believed pose.

    other: the node most like the view anywhere, with its distance [m] from the goal; passed: the view only came no
    nearer to the goal's, it isn't the same.
    """

    goal: Pose2
    rotation: float
    difference: float
    where: Where
    other: PlaceMatch | None = None
    other_away: float = 0.0
    passed: bool = False


def doubt(claim: Claim) -> str:
    """Return why an arrival isn't to be believed though the view says so, or ""."""
    where = claim.where
    if where.lost >= SURE:
        return f"lost with a probability of {where.lost:.2f}"
    away = where.pose.distance(claim.goal)
    if away > (PASSED if claim.passed else NEAR):
        return f"it is believed to be {away:.1f} m away"
    rivals = sum(rival.weight for rival in where.rivals if rival.pose.distance(claim.goal) > ELSEWHERE)
    if rivals >= SURE:
        return f"with a probability of {rivals:.2f} it is another place"
    turned = abs(wrap(claim.rotation - (where.pose.heading - claim.goal.heading)))
    if turned > TURNED:
        return f"its view is turned by {math.degrees(turned):.0f} degrees otherwise than it should be"
    other = claim.other
    if other is not None and claim.other_away > ELSEWHERE and other.difference <= claim.difference:
        return f"node {other.node} looks more alike"
    return ""
