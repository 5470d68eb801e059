"""Claims that say only "the same place": what a place recogniser that knows neither heading nor distance tells."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from topomap.core.arrays import BoolArray, FloatArray, IntArray
from topomap.core.geometry import Pose2
from topomap.core.records import Candidate
from topomap.mapping.closures.claims import Claims
from topomap.mapping.recorded_drive import RecordedDrive

ANY_HEADING = (2 * math.pi) ** 2  # [rad^2] nothing is claimed of the heading


@dataclass(frozen=True, slots=True, eq=False)
class PlaceClaims:
    """M claims "the same place": query_ns, match_ns (M,) stamps; query, match (M,) nodes of the drive, -1 for stamps
    outside it; similarity (M,) in [0, 1].
    """

    query_ns: IntArray
    match_ns: IntArray
    query: IntArray
    match: IntArray
    similarity: FloatArray

    def __len__(self) -> int:
        return len(self.query)

    def known(self) -> BoolArray:
        """Return (M,) whether both stamps lie in the drive."""
        return (self.query >= 0) & (self.match >= 0)

    def way(self, drive: RecordedDrive) -> FloatArray:
        """Return (M,) the way between both [m]."""
        return np.abs(drive.way[self.query] - drive.way[self.match])

    def claims(self, which: IntArray, sigma: float) -> Claims:
        """Return some of them (n,), the two places sigma [m] apart, each counting by its similarity."""
        n = len(which)
        covariance = np.tile(np.diag([sigma**2, sigma**2, ANY_HEADING]), (n, 1, 1))
        weight = np.clip(self.similarity[which], 1e-3, 1.0)
        return Claims(self.match[which], self.query[which], np.zeros((n, 3)), covariance, np.zeros(n), weight)

    def candidate(self, k: int, sigma: float) -> Candidate:
        """Return one of them for the ledger."""
        return Candidate(
            int(self.query_ns[k]),
            int(self.match[k]),
            int(self.match_ns[k]),
            Pose2(),
            np.diag([sigma**2, sigma**2, ANY_HEADING]),
            float(self.similarity[k]),
            int(self.query[k]) if self.query[k] >= 0 else None,
        )
