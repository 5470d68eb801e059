"""Which way parts a lost robot's places soonest: stops are looked at from near to far until that is settled."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from topomap.core.arrays import BoolArray, FloatArray
from topomap.navigation.search.parting import Parting
from topomap.navigation.search.stops import FAR, Stops

PARTED = 2.5
"""[nats] What has to speak against a rival for it to be parted from: 12 to 1."""
CONFIRMED = 1.25
"""[nats] ... and what the next stop has to say, which is passed within the same two stretches."""
WORTH = 2.0
"""[m] By how much sooner the places must part for the robot to leave the way it looks: turning costs time, and the two
are told to a metre."""
SETTLED = 0.8
"""Share of the rivals' weight that must have parted for a way to count as having told: what is left is unlikely, or
parts on the next way that is chosen."""
AHEAD, BEHIND = math.radians(60.0), math.radians(120.0)


@dataclass(frozen=True, slots=True)
class Choice:
    """The way to drive: its nodes, none where the robot goes on as it looks; and why, in plain words."""

    path: tuple[int, ...]
    why: str


class Deliberation:
    """Weighs the ways from the likeliest place by how far it is to where most of its rivals have parted."""

    def __init__(self, ways: Stops, weights: FloatArray, parting: Parting, seen: BoolArray) -> None:
        """weights (R,): of the rivals; seen: at which of the stops the robot has been, where there is nothing new."""
        self._ways, self._parting, self._seen = ways, parting, seen
        self._weights = weights / weights.sum()
        self._parted = np.full((len(ways.bearings), len(weights)), np.inf)
        self._last = np.full(len(ways.bearings), -1)
        self._claimed = np.full((len(ways.bearings), len(weights)), -1)
        self._next = 0

    def step(self, count: int) -> Choice | None:
        """Look at `count` more stops at most; return the choice once it is settled."""
        stops = self._ways.stops
        for k in range(self._next, min(self._next + count, len(stops))):
            self._look(k)
        self._next = min(self._next + count, len(stops))
        return self._settled()

    def _look(self, k: int) -> None:
        """Part from rivals at a stop if it speaks against them, and so does the next one on that way, if there is one:
        a single view may have been taken too far beside the others.
        """
        stop = self._ways.stops[k]
        open_ = ~np.isfinite(self._parted[stop.direction])
        if self._seen[k] or not open_.any():
            return
        said, claimed = self._parting.against(stop.node), self._claimed[stop.direction]
        last = all(other.direction != stop.direction for other in self._ways.stops[k + 1 :])
        claimed[:] = np.where((claimed >= 0) & (said >= CONFIRMED), claimed, np.where(said >= PARTED, k, -1))
        for rival in np.flatnonzero(open_ & (claimed >= 0) & ((claimed < k) | last)):
            self._parted[stop.direction, rival] = self._ways.stops[claimed[rival]].way
            self._last[stop.direction] = k

    def _settled(self) -> Choice | None:
        """Return the choice, where no stop to come can change it."""
        if not len(self._ways.bearings):
            return Choice((), "goes on: the map has no way from its likeliest place")
        stops = self._ways.stops
        reached = stops[self._next].way if self._next < len(stops) else FAR
        coming = np.isin(np.arange(len(self._parted)), [stop.direction for stop in stops[self._next :]])
        exact = (np.isfinite(self._parted) @ self._weights >= SETTLED) | ~coming
        least = np.array(
            [self._settles(row, FAR if known else reached) for row, known in zip(self._parted, exact, strict=True)]
        )
        ahead, best = int(np.argmin(np.abs(self._ways.bearings))), int(np.argmin(least))
        chosen = best if least[ahead] > least[best] + WORTH else ahead
        # what isn't exact yet can only become more
        if not exact[chosen] or (chosen != ahead and not exact[best]):
            return None
        return self._choice(chosen, ahead, least, exact)

    def _settles(self, parted: FloatArray, others: float) -> float:
        """Return the way [m] after which enough rivals have parted; others: the way of those not parted from yet."""
        ways = np.where(np.isfinite(parted), parted, others)
        order = np.argsort(ways, kind="stable")
        enough = np.cumsum(self._weights[order]) >= SETTLED
        return float(ways[order[np.argmax(enough)]])

    def _choice(self, chosen: int, ahead: int, least: FloatArray, exact: BoolArray) -> Choice:
        count = 1 + len(self._weights)
        if least[chosen] >= FAR:
            return Choice((), f"goes on: its {count} places part nowhere within {FAR:.0f} m")
        others = [self._told(k, least[k], exact[k]) for k in range(len(least)) if k != chosen]
        why = f"its {count} places part {', '.join([f'after {least[chosen]:.0f} m {self._word(chosen)}', *others])}"
        if chosen == ahead:
            return Choice((), f"goes on: {why}")
        word = self._word(chosen)
        turn = "turns round" if word == "behind" else f"turns {word}"
        return Choice(self._ways.stops[self._last[chosen]].path, f"{turn}: {why}")

    def _told(self, direction: int, way: float, exact: bool) -> str:
        """Return what is known of a way that wasn't chosen."""
        if way >= FAR:
            return f"nowhere {self._word(direction)}"
        return f"{'' if exact else 'not before '}{way:.0f} m {self._word(direction)}"

    def _word(self, direction: int) -> str:
        bearing = float(self._ways.bearings[direction])
        if abs(bearing) < AHEAD:
            return "ahead"
        return "behind" if abs(bearing) > BEHIND else "to the left" if bearing > 0 else "to the right"
