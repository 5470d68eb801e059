"""Closing loops: proposals become candidates, pass the tests one by one, and end in the ledger with a reason."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
from pydantic import BaseModel, Field

from topomap.core.arrays import IntArray
from topomap.core.records import Candidate, Decision, Verdict
from topomap.mapping.closures.appearance import APART
from topomap.mapping.closures.claims import Claims
from topomap.mapping.closures.closure_tests import ClosureTest, Knowledge
from topomap.mapping.closures.engine import ClosureEngine
from topomap.mapping.closures.gates import Gate
from topomap.mapping.closures.ledger import Ledger
from topomap.mapping.closures.odds import mahalanobis
from topomap.mapping.closures.relative_pose import RelativePoseEstimator, RelativePoseSettings
from topomap.mapping.closures.robot_tests import GATE, RobotTests
from topomap.mapping.closures.seen import Seen
from topomap.mapping.closures.sight import Sight
from topomap.mapping.closures.sight_tests import MOST_RATIO
from topomap.mapping.closures.voting import Voting
from topomap.mapping.optimisation import Optimisation
from topomap.mapping.optimizer.problem import ClosureEdge
from topomap.mapping.places.catchment import Catchment
from topomap.mapping.places.contrast import Contrast
from topomap.mapping.places.recognition import Moment, Proposal
from topomap.mapping.places.view_cache import ViewCache
from topomap.mapping.track import Track
from topomap.mapping.uncertainty.reachability import Reachability
from topomap.vision.contracts import Aligner

REACH = 0.99  # probability that the true place is among those compared
ALONE = 1.2  # [m] where odometry knows the place better than this, or than views tell places apart, it leaves no other


class ClosingSettings(BaseModel, frozen=True, extra="forbid"):
    """How a closure is tested and measured."""

    certainty: float = Field(0.5, gt=0, lt=1, description="a closure less probable than this waits for others to agree")
    offset: RelativePoseSettings = Field(default_factory=RelativePoseSettings)


class Closing:
    """Tests proposals by sight, by odometry and by one another, and writes the verdicts into the ledger."""

    def __init__(
        self,
        settings: ClosingSettings,
        aligner: Aligner,
        track: Track,
        view_cache: ViewCache,
        ledger: Ledger,
        optimisation: Optimisation,
        tests: Sequence[ClosureTest] | RobotTests = (),
        catchment: Catchment | None = None,
        contrast: Contrast | None = None,
    ) -> None:
        """tests: a user's own, asked before odometry, or all of them; catchment: how fast views change; contrast: how
        clearly one of other places wins.
        """
        own = tests if isinstance(tests, RobotTests) else RobotTests(place=(*tests, *RobotTests().place))
        self._track, self._map, self._view_cache = track, track.map, view_cache
        self._optimisation = optimisation
        self._alone = math.log(settings.certainty / (1.0 - settings.certainty))
        self._engine, self._stages = ClosureEngine(own.all(), ledger), own.stages()
        self._offset = RelativePoseEstimator(settings.offset)
        self._voting = Voting(track.map)
        self._testimonies: list[tuple[Candidate, bool, str]] = []
        self._unsaid: list[Decision] = []
        self._catchment = Catchment() if catchment is None else catchment
        self._sight = Sight(aligner, track, view_cache, self._offset.same_spot, self._catchment, contrast or Contrast())
        self._reachability = Reachability(track.map, optimisation, settings.offset.position_sigma, REACH)

    @property
    def apart(self) -> float:
        """How far from one another two places are that the views tell apart [m]."""
        return self._sight.apart

    def within_reach(self, nodes: IntArray) -> IntArray:
        """Return those of some older nodes (n,) at which odometry allows the robot to be now."""
        return self._reachability.within_reach(self._track.pose, nodes)

    def testify(self, candidate: Candidate, agrees: bool, reason: str) -> None:
        """Take what an active check saw of a pending candidate; it counts in the next step."""
        self._testimonies.append((candidate, agrees, reason))

    def forget(self, stamp_ns: int) -> None:
        """Refuse all that waits for others: the odometry between them and what comes has a gap."""
        self._testimonies.clear()
        for candidate in self._voting.expired(math.inf):
            reason = "the odometry broke while it waited"
            self._unsaid.append(self._engine.decide(stamp_ns, candidate, Verdict.REFUSED, reason))

    def withdraw(self, stamp_ns: int, behind: set[int]) -> None:
        """Take back what joins nodes `behind` a gap with others; said with the next verdicts."""
        reason = "seen by a robot that took itself for elsewhere"
        self._unsaid += self._optimisation.disbelieve(stamp_ns, self._engine.ledger, behind, reason)

    def prepare(self, imminent: Moment | None, awaited: Iterable[int]) -> None:
        """Do a part of what judging takes before a proposal comes, as much as fits in a step.

        imminent: the moment that is proposed next, if one is; awaited: nodes that one may name soon.
        """
        self._sight.prepare(imminent, awaited)

    def judge(self, stamp_ns: int, proposal: Proposal | None) -> tuple[Decision, ...]:
        """Return the verdicts of this step, on a proposal and on what waited for it; all are kept in the ledger."""
        late = self._voting.expired(self._track.travel)
        reason = "no other closure agreed in time, and odometry leaves several places open"
        decisions = [*self._unsaid, *(self._engine.decide(stamp_ns, c, Verdict.REFUSED, reason) for c in late)]
        self._unsaid.clear()
        for testimony in self._testimonies:
            decisions += self._hear(stamp_ns, *testimony)
        self._testimonies.clear()
        if proposal is not None:
            decisions += self._by_sight(stamp_ns, proposal)
        return tuple(decisions)

    def _hear(self, stamp_ns: int, candidate: Candidate, agrees: bool, reason: str) -> list[Decision]:
        """Refuse a candidate that still waits, or let it vote once more."""
        if self._engine.verdict(candidate) is not Verdict.PENDING:
            return []
        self._voting.drop(candidate)
        if not agrees:
            return [self._engine.decide(stamp_ns, candidate, Verdict.REFUSED, reason)]
        checked = _with(candidate, active=1.0)
        return self._vote(stamp_ns, checked, "odometry leaves several places open", f"; {reason}")

    def _by_sight(self, stamp_ns: int, proposal: Proposal) -> list[Decision]:
        """Compare the likeliest places in detail; a clear winner goes on to the odometry's test."""
        alone = max(ALONE, APART * self._catchment.length)
        open_places = self._reachability.reach(proposal.places[0].node) > alone
        candidate, seen, winner = self._sight.compare(proposal, open_places)
        if objection := self._objection(candidate, seen, self._stages[0]):
            return [self._engine.decide(stamp_ns, candidate, Verdict.REFUSED, objection)]
        place = self._view_cache.panorama(candidate.match)
        offset = self._offset.measure(winner, place, proposal.moment.panorama, self._catchment.length)
        candidate = replace(candidate, relative=offset.relative, covariance=offset.covariance)
        candidate = _with(candidate, share=offset.share)
        self._sight.believed(winner)
        if objection := self._objection(candidate, seen, self._stages[1]):
            return [self._engine.decide(stamp_ns, candidate, Verdict.REFUSED, objection)]
        return self._by_odometry(stamp_ns, candidate, seen, open_places)

    def _objection(self, candidate: Candidate, seen: Seen, stage: slice) -> str:
        """Return why a candidate without a node of its own fails a stage, or an empty string."""
        end = self._map.chain[-1]
        claim = Claims.of_one(candidate.match, end, candidate.relative, candidate.covariance)
        knowledge = Knowledge.of_one(self._map.poses, np.zeros((3, 3)), seen)
        failed = int(self._engine.weigh(claim, knowledge, -np.inf, stage).failed[0])
        return self._engine.reason(claim, knowledge, failed) if failed >= 0 else ""

    def _by_odometry(self, stamp_ns: int, candidate: Candidate, seen: Seen, open_places: bool) -> list[Decision]:
        """Hold a candidate that was believed by sight against the way between the two nodes."""
        query = self._track.node_at(candidate.query_ns)
        candidate = replace(candidate, query=query)
        claim = _claim(candidate)
        knowledge = Knowledge.of_one(self._map.poses, self._reachability.errors(candidate.match, query), seen)
        weighed = self._engine.weigh(claim, knowledge, -np.inf, self._stages[2])
        failed, odds = int(weighed.failed[0]), float(weighed.log_odds[0])
        chi2, _ = mahalanobis(claim, knowledge.poses, knowledge.errors)
        candidate = _with(candidate, sigmas=math.sqrt(chi2[0]), odds=odds if np.isfinite(odds) else None)
        if failed >= 0:
            reason = self._engine.reason(claim, knowledge, failed)
            return [self._engine.decide(stamp_ns, candidate, Verdict.REFUSED, reason)]
        if open_places and not (seen.clear[0] and seen.ratio[0] <= MOST_RATIO and odds >= self._alone):
            return self._vote(stamp_ns, candidate, "odometry leaves several places open")
        if odds < self._alone:
            return self._vote(stamp_ns, candidate, f"it may as well be a look-alike (log odds {odds:.1f})")
        return [self._accept(stamp_ns, candidate, Gate(GATE).reason(claim, knowledge))]

    def _vote(self, stamp_ns: int, candidate: Candidate, why: str, more: str = "") -> list[Decision]:
        """Accept a candidate with all that agree, or let it wait; why it can't stand alone, and what more is known."""
        company = self._voting.add(candidate)
        claim = _claim(candidate)
        knowledge = Knowledge.of_one(self._map.poses, np.zeros((3, 3)), support=company.support)
        if self._engine.weigh(claim, knowledge, -np.inf, self._stages[3]).failed[0] >= 0:
            reason = f"{why}: waits for others that agree{more}"
            return [self._engine.decide(stamp_ns, candidate, Verdict.PENDING, reason)]
        self._voting.settle(company)
        checked = ", and an active check" if any(c.evidence.active for c in company.agreeing) else ""
        reason = f"{len(company.agreeing)} closures agree{checked}{more}"
        return [self._accept(stamp_ns, c, reason) for c in company.agreeing]

    def _accept(self, stamp_ns: int, candidate: Candidate, reason: str) -> Decision:
        assert candidate.query is not None
        edge = ClosureEdge(candidate.match, candidate.query, candidate.relative, candidate.covariance)
        self._map.close(edge)
        self._optimisation.believe(edge, candidate)
        cost, ratio = candidate.evidence.cost or 0.0, candidate.evidence.ratio or 0.0
        seen = f"one place is alike (cost {cost:.2f}, ratio {ratio:.2f})"
        return self._engine.decide(stamp_ns, candidate, Verdict.ACCEPTED, f"{seen}; {reason}")


def _claim(candidate: Candidate) -> Claims:
    """Return a candidate with a node of its own as the engine takes it."""
    assert candidate.query is not None
    looks = candidate.evidence.looks or 0.0
    return Claims.of_one(candidate.match, candidate.query, candidate.relative, candidate.covariance, looks)


def _with(
    candidate: Candidate,
    active: float | None = None,
    share: float | None = None,
    sigmas: float | None = None,
    odds: float | None = None,
) -> Candidate:
    """Return a candidate with what a test measured added to its evidence."""
    old = candidate.evidence
    return replace(
        candidate,
        evidence=replace(
            old,
            active=old.active if active is None else active,
            share=old.share if share is None else share,
            sigmas=old.sigmas if sigmas is None else sigmas,
            odds=old.odds if odds is None else odds,
        ),
    )
