"""Closing loops: proposals become candidates, pass the tests one by one, and end in the ledger with a reason."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from pydantic import BaseModel, Field

from topomap.contract import Aligner
from topomap.geometry import FloatArray
from topomap.mapping.album import Album
from topomap.mapping.backend.problem import ClosureEdge
from topomap.mapping.chain import Chain
from topomap.mapping.correction import Correction
from topomap.mapping.evidence import GateSettings, OdometryGate
from topomap.mapping.ledger import Ledger
from topomap.mapping.odometry import EdgeIncrements
from topomap.mapping.offset import ClosureOffset, OffsetSettings
from topomap.mapping.recognition import Proposal
from topomap.mapping.survey import Survey
from topomap.mapping.verification import Outcome, Verification, VerificationSettings
from topomap.types import Candidate, Decision, Verdict


class ClosingSettings(BaseModel, frozen=True, extra="forbid"):
    """How a closure is tested and measured."""

    verification: VerificationSettings = Field(default_factory=VerificationSettings)
    gate: GateSettings = Field(default_factory=GateSettings)
    offset: OffsetSettings = Field(default_factory=OffsetSettings)


class Closing:
    """Tests proposals by sight and by odometry and writes the verdicts into the ledger."""

    def __init__(
        self,
        settings: ClosingSettings,
        aligner: Aligner,
        survey: Survey,
        album: Album,
        ledger: Ledger,
        correction: Correction,
    ) -> None:
        self._s = settings
        self._verification = Verification(settings.verification, aligner)
        self._gate = OdometryGate(settings.gate)
        self._survey, self._map, self._album = survey, survey.map, album
        self._ledger, self._correction = ledger, correction
        self._offset = ClosureOffset(settings.offset)

    def judge(self, stamp_ns: int, proposal: Proposal) -> Decision:
        """Return the verdict on a proposal, made at `stamp_ns` and kept in the ledger."""
        outcome = self._verification.judge(
            proposal.moment.panorama, proposal.shortlist, self._album.panorama, self._map.length
        )
        candidate = self._candidate(proposal, outcome)
        if outcome.objection:
            return self._ledger.decide(stamp_ns, candidate, Verdict.REFUSED, outcome.objection)
        return self._by_odometry(stamp_ns, candidate)

    def _candidate(self, proposal: Proposal, outcome: Outcome) -> Candidate:
        winner = outcome.winner
        offset = self._offset.measure(
            winner, self._map.nodes[winner.match.node].snapshot, proposal.moment.panorama.ranges
        )
        scores = {
            "difference": winner.match.difference,
            "cost": winner.alignment.residual,
            "ratio": outcome.ratio,
            "share": offset.share,
        }
        return Candidate(
            proposal.moment.stamp_ns,
            winner.match.node,
            self._map.nodes[winner.match.node].stamp_ns,
            offset.relative,
            offset.covariance,
            max(0.0, 1.0 - winner.alignment.residual),
            scores=scores,
        )

    def _by_odometry(self, stamp_ns: int, candidate: Candidate) -> Decision:
        """Hold a candidate that was believed by sight against the way between; accepted, the back end gets it."""
        query = self._survey.node_at(candidate.query_ns)
        candidate = replace(candidate, query=query)
        expected = self._map.pose(candidate.match).to(self._map.pose(query))
        finding = self._gate.judge(candidate, expected, self._way_covariance(candidate.match, query))
        candidate = replace(candidate, scores={**candidate.scores, "sigmas": finding.score})
        if not finding.passed:
            return self._ledger.decide(stamp_ns, candidate, Verdict.REFUSED, finding.reason)
        edge = ClosureEdge(candidate.match, query, candidate.relative, candidate.covariance)
        self._map.close(edge)
        self._correction.believe(edge, candidate)
        seen = f"one place is alike (cost {candidate.scores['cost']:.2f}, ratio {candidate.scores['ratio']:.2f})"
        return self._ledger.decide(stamp_ns, candidate, Verdict.ACCEPTED, f"{seen}; {finding.reason}")

    def _way_covariance(self, match: int, query: int) -> FloatArray:
        """Return the covariance (3, 3) of `match_from_query` along the route, across closures that stand if shorter."""
        topo = self._map
        edges = EdgeIncrements.of([increments for _, _, increments in topo.odometry_edges()])
        way = edges.integrate(topo.calibration)
        chain = Chain.of(topo.poses[topo.chain], way, topo.calibration, self._correction.covariance)
        place = {node: i for i, node in enumerate(topo.chain)}
        ends = np.array([(place[c.i], place[c.j]) for c in topo.closures], np.int64).reshape(-1, 2)
        covariances = np.array([c.covariance for c in topo.closures]).reshape(-1, 3, 3)
        return chain.covariance_via(place[match], place[query], ends[:, 0], ends[:, 1], covariances)
