"""How places look along a drive, with odometry left out: what the closure engine's looks are measured on.

Place search and comparison are the robot's own; every older place counts as within reach, so that what is new looks for
its like among all that was seen before.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from topomap.core.panorama import Panorama
from topomap.core.records import Alignment
from topomap.mapping.closures.appearance import Appearance, Outcome
from topomap.mapping.closures.looks import WITH_RIVALS, log_ratio
from topomap.mapping.places.recognition import Proposal, Recognition, RecognitionSettings
from topomap.mapping.places.snapshots import SnapshotSettings, View, make_rule
from topomap.vision.contracts import Aligner
from topomap.vision.image.compare import rotation_difference, signature


class Likeness(NamedTuple):
    """A place that looked most alike: stamps [ns] of the view and of the place, the rotation between them [rad], its
    alignment cost, that of the best rival and the usual one elsewhere, and what looks says of them.
    """

    query_ns: int
    match_ns: int
    rotation: float
    cost: float
    rival: float
    usual: float
    looks: float


class LookSurvey:
    """Takes a drive's views one by one and returns what looked alike."""

    def __init__(self, aligner: Aligner) -> None:
        self._recognition = Recognition(RecognitionSettings())
        self._appearance = Appearance(aligner)
        self._rule = make_rule(SnapshotSettings())
        self._views: list[Panorama] = []
        self._places: list[tuple[int, float, float]] = []  # stamp and position
        self._kept_at = self._travel = 0.0

    def update(self, stamp_ns: int, forward: float, view: Panorama, x: float, y: float) -> Likeness | None:
        """Take the next view, `forward` [m] on, at x, y as a map that is right would have it [m]."""
        self._travel += abs(forward)
        if self._asks_for_snapshot(view):
            self._kept_at = self._travel
            self._recognition.add(len(self._views), self._travel, view)
            self._views.append(view)
            self._places.append((stamp_ns, x, y))
        self._recognition.update(stamp_ns, self._travel, view, self._recognition.old_nodes(self._travel))
        proposal = self._recognition.proposal()
        return None if proposal is None else self._compared(proposal)

    def _asks_for_snapshot(self, view: Panorama) -> bool:
        if not self._views:
            return True
        difference = rotation_difference(signature(view), signature(self._views[-1]))[0]
        return self._rule.judge(View(difference, 0.0, self._travel - self._kept_at)) is not None

    def _compared(self, proposal: Proposal) -> Likeness | None:
        found = self._appearance.compare(
            proposal.moment.panorama, proposal.places, (), self._views.__getitem__, self._distance
        )
        return _likeness(proposal.moment.stamp_ns, self._places[found.winner.match.node][0], found)

    def _distance(self, a: int, b: int) -> float:
        return float(np.hypot(*np.subtract(self._places[a][1:], self._places[b][1:])))


def _likeness(query_ns: int, match_ns: int, found: Outcome) -> Likeness | None:
    """Return a comparison, None where there was no place elsewhere to compare with."""
    if not found.ratio > 0.0:
        return None
    aligned: Alignment = found.winner.alignment
    rival = aligned.residual / found.ratio
    said = log_ratio(WITH_RIVALS, aligned.residual, rival, found.elsewhere)
    return Likeness(query_ns, match_ns, aligned.rotation, aligned.residual, rival, found.elsewhere, said)
