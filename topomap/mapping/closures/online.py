"""Closing loops: proposals become candidates, pass the tests one by one, and end in the ledger with a reason."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from pydantic import BaseModel, Field

from topomap.core.arrays import IntArray
from topomap.core.evidence import Evidence
from topomap.core.geometry import Pose2
from topomap.core.records import Candidate, Decision, Verdict
from topomap.mapping.closures.appearance import AppearanceSettings, AppearanceTest, Outcome
from topomap.mapping.closures.claims import Claims
from topomap.mapping.closures.closure_tests import ClosureTest, Gate, Knowledge, Odometry
from topomap.mapping.closures.engine import ClosureEngine
from topomap.mapping.closures.ledger import Ledger
from topomap.mapping.closures.odometry_gate import GateSettings, OdometryGate
from topomap.mapping.closures.relative_pose import RelativePoseEstimator, RelativePoseSettings
from topomap.mapping.closures.same_place import SamePlaceSettings, SamePlaceTest
from topomap.mapping.closures.voting import Voting, VotingSettings
from topomap.mapping.optimisation import Optimisation
from topomap.mapping.optimizer.problem import ClosureEdge
from topomap.mapping.places.recognition import Proposal
from topomap.mapping.places.view_cache import ViewCache
from topomap.mapping.track import Track
from topomap.mapping.uncertainty.reachability import Reachability
from topomap.vision.contracts import Aligner


class ClosingSettings(BaseModel, frozen=True, extra="forbid"):
    """How a closure is tested and measured."""

    appearance: AppearanceSettings = Field(default_factory=AppearanceSettings)
    gate: GateSettings = Field(default_factory=lambda: GateSettings(probability=0.95))
    reach: float = Field(0.99, gt=0.5, lt=1, description="probability that the true place is among those compared")
    offset: RelativePoseSettings = Field(default_factory=RelativePoseSettings)
    same_place: SamePlaceSettings = Field(default_factory=SamePlaceSettings)
    voting: VotingSettings = Field(default_factory=VotingSettings)
    alone: float = Field(
        1.2, gt=0, description="where odometry knows the place better than this, it leaves no other [m]"
    )


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
        tests: Sequence[ClosureTest] = (),
    ) -> None:
        """tests: a user's own, asked before odometry."""
        self._s = settings
        self._track, self._map, self._view_cache = track, track.map, view_cache
        self._optimisation = optimisation
        self._appearance = AppearanceTest(settings.appearance, aligner)
        self._gate = OdometryGate(settings.gate)
        self._engine = ClosureEngine((*tests, Odometry(), Gate(settings.gate.probability)), ledger)
        self._offset = RelativePoseEstimator(settings.offset)
        self._same_place = SamePlaceTest(settings.same_place)
        self._voting = Voting(settings.voting, track.map)
        self._testimonies: list[tuple[Candidate, bool, str]] = []
        self._unsaid: list[Decision] = []
        self._reachability = Reachability(track.map, optimisation, settings.offset.position_sigma, settings.reach)

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
        return self._vote(stamp_ns, _with(candidate, active=1.0), f"; {reason}")

    def _by_sight(self, stamp_ns: int, proposal: Proposal) -> list[Decision]:
        """Compare the likeliest places in detail; a clear winner goes on to the odometry's test.

        Where odometry leaves several places open, the true one may not be on the map at all: then what looks alike
        elsewhere, out of reach, tells how much a likeness is worth.
        """
        open_places = self._reachability.reach(proposal.places[0].node) > self._s.alone
        near = {place.node for place in proposal.places}
        rivals = [rival for rival in proposal.rivals if open_places and rival.node not in near]
        outcome = self._appearance.judge(
            proposal.moment.panorama, proposal.places, rivals, self._view_cache.panorama, self._map.length
        )
        objection = outcome.objection
        match = outcome.winner.match
        if not objection and match.node not in proposal.moment.difference:
            objection = "the place most alike is out of the odometry's reach"
        if not objection and match.difference > proposal.limit:
            objection = f"the view is as unlike it as other places are ({match.difference:.2f} > {proposal.limit:.2f})"
        if objection:
            candidate = self._candidate(proposal, outcome, Pose2(0.0, 0.0, outcome.winner.alignment.rotation))
            return [self._engine.decide(stamp_ns, candidate, Verdict.REFUSED, objection)]
        place = self._view_cache.panorama(match.node)
        offset = self._offset.measure(outcome.winner, place, proposal.moment.panorama)
        candidate = self._candidate(proposal, outcome, offset.relative)
        candidate = _with(replace(candidate, covariance=offset.covariance), share=offset.share)
        if unlike := self._same_place.objection(outcome.winner.alignment.residual, offset):
            return [self._engine.decide(stamp_ns, candidate, Verdict.REFUSED, unlike)]
        return self._by_odometry(stamp_ns, candidate, open_places)

    def _candidate(self, proposal: Proposal, outcome: Outcome, relative: Pose2) -> Candidate:
        winner = outcome.winner
        cost = winner.alignment.residual
        return Candidate(
            proposal.moment.stamp_ns,
            winner.match.node,
            self._map.nodes[winner.match.node].stamp_ns,
            relative,
            self._offset.same_spot,
            max(0.0, 1.0 - cost),
            evidence=Evidence(winner.match.difference, proposal.limit, cost, outcome.ratio),
        )

    def _by_odometry(self, stamp_ns: int, candidate: Candidate, open_places: bool) -> list[Decision]:
        """Hold a candidate that was believed by sight against the way between the two nodes."""
        query = self._track.node_at(candidate.query_ns)
        expected = self._map.pose(candidate.match).to(self._map.pose(query))
        claim = Claims.of_one(candidate.match, query, candidate.relative, candidate.covariance)
        errors = self._reachability.errors(candidate.match, query)
        weighed = self._engine.weigh(claim, Knowledge.of_one(self._map.poses, errors), -np.inf)
        finding = self._gate.judge(candidate, expected, self._reachability.seen(candidate.match, query, errors))
        odds = float(weighed.log_odds[0]) if np.isfinite(weighed.log_odds[0]) else None
        candidate = _with(replace(candidate, query=query), sigmas=finding.score, odds=odds)
        if weighed.failed[0] >= 0:
            test = self._engine.tests[int(weighed.failed[0])].name
            reason = finding.reason if not finding.passed else f"the test '{test}' speaks against it"
            return [self._engine.decide(stamp_ns, candidate, Verdict.REFUSED, reason)]
        if not open_places:
            return [self._accept(stamp_ns, candidate, finding.reason)]
        return self._vote(stamp_ns, candidate)

    def _vote(self, stamp_ns: int, candidate: Candidate, more: str = "") -> list[Decision]:
        """Accept a candidate with all that agree, or let it wait; more: what else there is to say of it."""
        agreeing = self._voting.add(candidate)
        if not agreeing:
            reason = f"odometry leaves several places open: waits for others that agree{more}"
            return [self._engine.decide(stamp_ns, candidate, Verdict.PENDING, reason)]
        checked = ", and an active check" if any(c.evidence.active for c in agreeing) else ""
        return [self._accept(stamp_ns, c, f"{len(agreeing)} closures agree{checked}{more}") for c in agreeing]

    def _accept(self, stamp_ns: int, candidate: Candidate, reason: str) -> Decision:
        assert candidate.query is not None
        edge = ClosureEdge(candidate.match, candidate.query, candidate.relative, candidate.covariance)
        self._map.close(edge)
        self._optimisation.believe(edge, candidate)
        cost, ratio = candidate.evidence.cost or 0.0, candidate.evidence.ratio or 0.0
        seen = f"one place is alike (cost {cost:.2f}, ratio {ratio:.2f})"
        return self._engine.decide(stamp_ns, candidate, Verdict.ACCEPTED, f"{seen}; {reason}")


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
