"""The loop candidates of a recording as arrays and as the ledger's candidates."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from topomap.core.arrays import BoolArray, FloatArray, IntArray
from topomap.core.geometry import Pose2
from topomap.core.records import Candidate
from topomap.datasets.tuc.drive import Drive
from topomap.datasets.tuc.recording import TucRecording
from topomap.datasets.tuc.settings import TucSettings
from topomap.mapping.odometry.increments import Calibration
from topomap.mapping.optimizer import Closures
from topomap.mapping.uncertainty.agreement import Claims, company, support

LEAST_SUPPORT = 1e-6  # a loop that no neighbour agrees with has none
ANY_HEADING = (2 * math.pi) ** 2  # [rad^2] the recordings give no heading


@dataclass(frozen=True, eq=False)
class Loops:
    """M candidates "the same place": query, match (M,) node ids, -1 for stamps outside the recording;
    support (M,): the summed similarity of neighbours that agree; needed: how much of it a loop must have, a share of
    what all neighbours, agreeing or not, sum up to on average: as dense as the candidates are, so much is asked."""

    recording: TucRecording
    query: IntArray
    match: IntArray
    support: FloatArray
    covariance: FloatArray
    needed: float

    @staticmethod
    def of(recording: TucRecording, drive: Drive, settings: TucSettings, curvature: float) -> Loops:
        """Find the candidates' nodes and who supports whom by an odometry of this curvature [rad/m]."""
        query, match = drive.node_at(recording.query_ns), drive.node_at(recording.match_ns)
        covariance = np.diag([settings.closure_sigma**2, settings.closure_sigma**2, ANY_HEADING])
        loops = Loops(recording, query, match, np.zeros(len(query)), covariance, 0.0)
        told = np.flatnonzero(loops.told(drive, settings.min_way))
        claims = loops._claims(told)
        odometry = drive.dead_reckoning(Calibration(curvature=curvature))[drive.marks]
        loops.support[told] = support(claims, odometry, drive.way, settings.support)
        around = company(claims, drive.way, settings.support.window)
        needed = settings.min_support * float(around.mean()) if len(around) else 0.0
        return replace(loops, needed=max(needed, LEAST_SUPPORT))

    def known(self) -> BoolArray:
        """Return (M,) whether both stamps lie in the recording."""
        return (self.query >= 0) & (self.match >= 0)

    def way(self, drive: Drive) -> FloatArray:
        """Return (M,) the way between both [m]."""
        return np.abs(drive.way[self.query] - drive.way[self.match])

    def told(self, drive: Drive, min_way: float) -> BoolArray:
        """Return (M,) which of them say something: both stamps known, and at least `min_way` [m] between them."""
        return np.asarray(self.known() & (self.way(drive) >= min_way))

    def _claims(self, which: IntArray) -> Claims:
        n = len(which)
        weight = self.recording.similarity[which]
        return Claims(self.match[which], self.query[which], np.zeros((n, 3)), np.ones(n, bool), weight)

    def closures(self, which: IntArray) -> Closures:
        """Return some of them as edges, each counting by its similarity."""
        n = len(which)
        covariance = np.tile(self.covariance, (n, 1, 1))
        weight = np.clip(self.recording.similarity[which], 1e-3, 1.0)
        return Closures(self.match[which], self.query[which], np.zeros((n, 3)), covariance, weight)

    def candidate(self, k: int) -> Candidate:
        """Return one of them for the ledger."""
        return Candidate(
            int(self.recording.query_ns[k]),
            int(self.match[k]),
            int(self.recording.match_ns[k]),
            Pose2(),
            self.covariance,
            float(self.recording.similarity[k]),
            int(self.query[k]) if self.query[k] >= 0 else None,
            {"support": float(self.support[k])},
        )
