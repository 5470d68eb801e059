"""Closures that wait for one another: where odometry leaves several places open, one view alone decides nothing."""

from __future__ import annotations

import math

from pydantic import BaseModel, Field

from topomap.core.records import Candidate
from topomap.mapping.graph import TopoMap


class VotingSettings(BaseModel, frozen=True, extra="forbid"):
    """How many closures must agree where odometry leaves the place open."""

    votes: float = Field(3, gt=0, description="clear closures that must agree, the new one included")
    clear: float = Field(0.75, gt=0, lt=1, description="a vote counts fully if its place costs this share of its rival")
    within: float = Field(8.0, gt=0, description="way on which they must come [m]")
    distance: float = Field(0.4, gt=0, description="how far they may disagree [m] ...")
    share: float = Field(0.05, ge=0, description="... plus this share of the way between them")
    angle_deg: float = Field(10.0, gt=0, description="how far their rotations may disagree [degree]")


class Voting:
    """Keeps candidates until enough of them tell the same shift of the map, in either driving direction."""

    def __init__(self, settings: VotingSettings, topo: TopoMap) -> None:
        self._s = settings
        self._map = topo
        self._waiting: list[Candidate] = []

    def add(self, candidate: Candidate) -> tuple[Candidate, ...]:
        """Take a candidate with a query node; return all that agree with it, itself last, or none yet.

        A place that hardly beats its rival is a small part of a vote: in a row of look-alikes the same wrong one wins
        again and again.
        """
        agreeing = tuple(other for other in self._waiting if self._agree(other, candidate))
        self._waiting.append(candidate)
        if sum(map(self._weight, (*agreeing, candidate))) < self._s.votes - 1e-9:
            return ()
        self._waiting = [c for c in self._waiting if c not in agreeing and c is not candidate]
        return (*agreeing, candidate)

    def drop(self, candidate: Candidate) -> None:
        """Forget one that waits."""
        self._waiting = [c for c in self._waiting if c is not candidate]

    def expired(self, travel: float) -> tuple[Candidate, ...]:
        """Return and forget those that nothing supported in time; `travel`: the raw odometer way now [m]."""
        late = tuple(c for c in self._waiting if travel - self._travel(c) > self._s.within)
        self._waiting = [c for c in self._waiting if c not in late]
        return late

    def _weight(self, candidate: Candidate) -> float:
        """Return how much of a vote a candidate is, in [0, 1], and one more if an active check speaks for it."""
        clear = min(1.0, (1.0 - (candidate.evidence.ratio or 0.0)) / (1.0 - self._s.clear))
        return clear + (candidate.evidence.active or 0.0)

    def _agree(self, a: Candidate, b: Candidate) -> bool:
        """Whether b lies where a and the odometry between them say."""
        assert a.query is not None
        assert b.query is not None
        way = self._map.pose(a.query).to(self._map.pose(b.query))
        told = self._map.pose(a.match) @ a.relative @ way
        found = self._map.pose(b.match) @ b.relative
        error = told.to(found)
        allowed = self._s.distance + self._s.share * abs(self._travel(b) - self._travel(a))
        return math.hypot(error.x, error.y) <= allowed and abs(error.heading) <= math.radians(self._s.angle_deg)

    def _travel(self, candidate: Candidate) -> float:
        assert candidate.query is not None
        return self._map.nodes[candidate.query].travel
