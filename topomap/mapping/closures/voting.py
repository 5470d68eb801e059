"""Closures that wait for one another: where odometry leaves several places open, one view alone decides nothing."""

from __future__ import annotations

import math
from typing import NamedTuple

from topomap.core.records import Candidate
from topomap.mapping.graph import TopoMap

VOTES = 3.0  # clear closures that must agree, the new one included
CLEAR = 0.75  # a vote counts fully if its place costs this share of its rival
WITHIN = 8.0  # [m] way on which they must come
UNSURE = 0.8  # sigmas of two positions that they may disagree by: 0.4 m for two that nothing measured
DISTANCE, SHARE = 0.4, 0.05  # [m] how far they may disagree, and more by this share of the way between them
ANGLE = math.radians(10.0)  # [rad] how far their rotations may disagree


class Company(NamedTuple):
    """A candidate with all that agree with it, itself last, and their votes over those needed."""

    agreeing: tuple[Candidate, ...]
    support: float


class Voting:
    """Keeps candidates until enough of them tell the same shift of the map, in either driving direction."""

    def __init__(self, topo: TopoMap) -> None:
        self._map = topo
        self._waiting: list[Candidate] = []

    def add(self, candidate: Candidate) -> Company:
        """Take a candidate with a query node, which waits from now on; return all that agree with it.

        A place that hardly beats its rival is a small part of a vote: in a row of look-alikes the same wrong one wins
        again and again.
        """
        agreeing = tuple(other for other in self._waiting if self._agree(other, candidate))
        self._waiting.append(candidate)
        every = (*agreeing, candidate)
        return Company(every, (sum(map(self._weight, every)) + 1e-9) / VOTES)

    def settle(self, company: Company) -> None:
        """Forget those that were believed."""
        self._waiting = [c for c in self._waiting if all(c is not other for other in company.agreeing)]

    def drop(self, candidate: Candidate) -> None:
        """Forget one that waits."""
        self._waiting = [c for c in self._waiting if c is not candidate]

    def expired(self, travel: float) -> tuple[Candidate, ...]:
        """Return and forget those that nothing supported in time; `travel`: the raw odometer way now [m]."""
        late = tuple(c for c in self._waiting if travel - self._travel(c) > WITHIN)
        self._waiting = [c for c in self._waiting if c not in late]
        return late

    def _weight(self, candidate: Candidate) -> float:
        """Return how much of a vote a candidate is, in [0, 1], and one more if an active check speaks for it."""
        clear = min(1.0, (1.0 - (candidate.evidence.ratio or 0.0)) / (1.0 - CLEAR))
        return clear + (candidate.evidence.active or 0.0)

    def _agree(self, a: Candidate, b: Candidate) -> bool:
        """Whether b lies where a and the odometry between them say."""
        assert a.query is not None
        assert b.query is not None
        way = self._map.pose(a.query).to(self._map.pose(b.query))
        told = self._map.pose(a.match) @ a.relative @ way
        found = self._map.pose(b.match) @ b.relative
        error = told.to(found)
        unsure = max(DISTANCE, UNSURE * math.hypot(_sigma(a), _sigma(b)))
        allowed = unsure + SHARE * abs(self._travel(b) - self._travel(a))
        return math.hypot(error.x, error.y) <= allowed and abs(error.heading) <= ANGLE

    def _travel(self, candidate: Candidate) -> float:
        assert candidate.query is not None
        return self._map.nodes[candidate.query].travel


def _sigma(candidate: Candidate) -> float:
    """Return the error of a candidate's position [m]."""
    return math.sqrt(float(candidate.covariance[0, 0] + candidate.covariance[1, 1]) / 2.0)
