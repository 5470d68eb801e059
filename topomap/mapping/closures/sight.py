"""What a proposal's views tell: which of the likeliest places is the most alike, and how surely it is that one."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from topomap.core.arrays import FloatArray
from topomap.core.evidence import Evidence
from topomap.core.geometry import Pose2
from topomap.core.records import Candidate
from topomap.mapping.closures.appearance import Appearance, Look, Outcome, apart
from topomap.mapping.closures.looks import LogRatio, UsualCost
from topomap.mapping.closures.seen import Seen
from topomap.mapping.places.catchment import Catchment
from topomap.mapping.places.contrast import Contrast
from topomap.mapping.places.recognition import SHORTLIST, Moment, Proposal
from topomap.mapping.places.view_cache import ViewCache
from topomap.mapping.track import Track
from topomap.vision.contracts import Aligner

EQUALLY = 0.35  # share of the difference between any two places below which one view is as good as another
SLOW = 0.7  # [m] catchment from which on that happens: snapshots lie 0.25 to 1 m apart


class Clear(NamedTuple):
    """What the images tell of a place: its difference over the likest other place's, and a log likelihood ratio."""

    ratio: float
    looks: float


UNCLEAR = Clear(math.inf, -math.inf)


class Sighting(NamedTuple):
    """A candidate by sight alone, what the sight tests ask of it, and the place as it was compared."""

    candidate: Candidate
    seen: Seen
    winner: Look


class Sight:
    """Compares a proposal's places in detail, and learns what true and other places cost."""

    def __init__(
        self,
        aligner: Aligner,
        track: Track,
        view_cache: ViewCache,
        same_spot: FloatArray,
        catchment: Catchment,
        contrast: Contrast,
    ) -> None:
        """same_spot: the covariance (3, 3) of a relative pose that isn't measured yet."""
        self._track, self._map, self._view_cache, self._same_spot = track, track.map, view_cache, same_spot
        self._appearance = Appearance(aligner)
        self._looks = LogRatio()
        self._usual = UsualCost()
        self._catchment, self._contrast = catchment, contrast

    @property
    def apart(self) -> float:
        """How far from one another two places are that the views tell apart [m]."""
        return apart(self._catchment.length)

    def believed(self, winner: Look) -> None:
        """Learn what a place costs that was seen again."""
        self._usual.learn(winner.alignment.residual)

    def prepare(self, imminent: Moment | None, awaited: Iterable[int]) -> None:
        """Compare a part of the places of a moment that is proposed next, or else decode the first view that isn't at
        hand of the places that a proposal may be compared with soon."""
        if imminent is not None:
            self._appearance.look_ahead(imminent.panorama, imminent.places[:SHORTLIST], self._view_cache.panorama)
            return
        node = next((node for node in awaited if node not in self._view_cache), None)
        if node is not None:
            self._appearance.prepare(self._view_cache.panorama(node))

    def compare(self, proposal: Proposal, open_places: bool) -> Sighting:
        """Return the place that looks most alike.

        open_places: odometry leaves several open, so that the true one may not be on the map at all: then what looks
        alike elsewhere, out of reach, tells how much a likeness is worth.
        """
        near = {place.node for place in proposal.places}
        rivals = [rival for rival in proposal.rivals if open_places and rival.node not in near]
        outcome = self._appearance.compare(
            proposal.moment.panorama, proposal.places, rivals, self._view_cache.panorama, self._map.length,
            self._catchment.length,
        )  # fmt: skip
        outcome = self._nearest(proposal.moment.stamp_ns, outcome)
        clear = self._clear(proposal, outcome)
        outcome = replace(outcome, ratio=min(outcome.ratio, clear.ratio))
        looks = max(self._looks.of(self._elsewhere(proposal, outcome), open_places), clear.looks)
        candidate = self._candidate(proposal, outcome, looks)
        clearly = clear.looks > 0.0
        return Sighting(candidate, self._seen(proposal, outcome, clearly, open_places), outcome.winner)

    def _nearest(self, stamp_ns: int, outcome: Outcome) -> Outcome:
        """Return an outcome whose winner is the place, of those equally alike, that lies nearest by odometry.

        Where the view changes slowly several snapshots show the same, and which of them is the most alike is chance.
        """
        best = outcome.winner.match.difference
        limit = max(best, EQUALLY * self._catchment.other)
        equal = [look for look in outcome.alike if look.match.difference <= limit]
        if len(equal) < 2 or self._catchment.length < SLOW:
            return outcome
        here = self._track.pose_at(stamp_ns)
        return replace(outcome, winner=min(equal, key=lambda look: self._away(here, look.match.node)))

    def _away(self, here: Pose2, node: int) -> float:
        there = self._map.pose(node)
        return math.hypot(there.x - here.x, there.y - here.y)

    def _elsewhere(self, proposal: Proposal, outcome: Outcome) -> Outcome:
        """Return an outcome with what places elsewhere cost, looked up where that isn't known at all yet."""
        if self._looks.known or np.isfinite(outcome.elsewhere):
            return outcome
        cost = self._appearance.elsewhere(
            proposal.moment.panorama, outcome.winner, proposal.rivals, self._view_cache.panorama, self._map.length,
            self._catchment.length,
        )  # fmt: skip
        return replace(outcome, elsewhere=cost)

    def _clear(self, proposal: Proposal, outcome: Outcome) -> Clear:
        """Return what the images' differences alone tell."""
        match = outcome.winner.match
        nodes = np.fromiter(proposal.older, np.int64, len(proposal.older))
        values = np.fromiter(proposal.older.values(), float, len(proposal.older))
        away = np.hypot(*(self._map.poses[nodes, :2] - self._map.poses[match.node, :2]).T)
        others = values[away > self.apart]
        if not len(others):
            return UNCLEAR
        rival = float(others.min())
        looks = self._contrast.log_ratio(match.difference, rival)
        return Clear(match.difference / max(rival, 1e-9), looks) if looks > 0.0 else UNCLEAR

    def _seen(self, proposal: Proposal, outcome: Outcome, clear: bool, waits: bool) -> Seen:
        match, cost = outcome.winner.match, outcome.winner.alignment.residual
        compared = match.node in proposal.moment.difference
        usual = self._usual.value
        return Seen.of_one(match.difference, proposal.limit, cost, outcome.ratio, usual, compared, clear, waits)

    def _candidate(self, proposal: Proposal, outcome: Outcome, looks: float) -> Candidate:
        match, cost = outcome.winner.match, outcome.winner.alignment.residual
        return Candidate(
            proposal.moment.stamp_ns,
            match.node,
            self._map.nodes[match.node].stamp_ns,
            Pose2(0.0, 0.0, outcome.winner.alignment.rotation),
            self._same_spot,
            max(0.0, 1.0 - cost),
            evidence=Evidence(match.difference, proposal.limit, cost, outcome.ratio, looks=looks),
        )
