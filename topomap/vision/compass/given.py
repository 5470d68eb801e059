"""A7, a given heading: odometry or a compass sensor says how the robot is turned."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from topomap.core.geometry import wrap
from topomap.core.panorama import Panorama
from topomap.core.records import Alignment
from topomap.vision.contracts import Needs, Origin
from topomap.vision.image.compare import ARRIVAL, SignatureSpec, rms, signature


@dataclass(frozen=True, slots=True)
class GivenHeading:
    """The prior itself; without one the headings are taken as the same. The residual is the aligned rms."""

    origin: ClassVar[Origin] = Origin("A7", "2.6.4.1")
    needs: ClassVar[Needs] = Needs(heading=True)
    claims_homing: ClassVar[bool] = False
    spec: SignatureSpec = ARRIVAL

    def align(self, current: Panorama, goal: Panorama, prior: float | None = None) -> Alignment:
        """Return the prior rotation [rad]."""
        rotation = wrap(prior or 0.0)
        turned = signature(current.rotated(rotation), self.spec)
        return Alignment(rotation, rms(turned, signature(goal, self.spec)))
