"""Support: how much of what is claimed around a claim agrees with it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from topomap.core.arrays import FloatArray, IntArray
from topomap.mapping.closures.along_settings import AlongSettings
from topomap.mapping.odometry.increments import Calibration
from topomap.mapping.place_claims import PlaceClaims
from topomap.mapping.recorded_drive import RecordedDrive
from topomap.mapping.uncertainty.agreement import Agreeing, company, support

LEAST = 1e-6  # a claim that no neighbour agrees with has no support


class Support(NamedTuple):
    """share (M,): the summed similarity of neighbours that agree with each claim, over what is needed; needed: a share
    of what all neighbours, agreeing or not, sum up to on average: as dense as the claims are, so much is asked.
    """

    share: FloatArray
    needed: float

    def reason(self, k: int) -> str:
        """Return why a claim has too little."""
        found = f"{self.share[k] * self.needed:.2f} of at least {self.needed:.2f}"
        return f"too few neighbours along the way agree ({found})"


def support_of(
    claims: PlaceClaims, drive: RecordedDrive, told: IntArray, settings: AlongSettings, start: Calibration
) -> Support:
    """Return the support of all claims, of which those told (n,) say something, by an odometry calibrated so."""
    n = len(told)
    agreeing = Agreeing(
        claims.match[told], claims.query[told], np.zeros((n, 3)), np.ones(n, bool), claims.similarity[told]
    )
    found = np.zeros(len(claims))
    found[told] = support(agreeing, drive.dead_reckoning(start)[drive.marks], drive.way, settings.support)
    around = company(agreeing, drive.way, settings.support.window)
    needed = max(settings.min_support * float(around.mean()) if n else 0.0, LEAST)
    return Support(found / needed, needed)
