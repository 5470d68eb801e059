"""Planar epipolar geometry as compass: the rotation of the movement that most matched points allow."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from topomap.core.panorama import Panorama
from topomap.core.records import Alignment
from topomap.vision.contracts import Needs, Origin
from topomap.vision.homing.epipolar import Epipolar, home_of
from topomap.vision.image.keypoints import keypoints

EPIPOLAR = Epipolar()


@dataclass(frozen=True, slots=True)
class EpipolarCompass:
    """The rotation found by `Epipolar`, with its home vector; window [rad]: how far from a prior to search.

    The residual is the share of the matches' weight that disagrees, 1 without matches. Raises ShapeError.
    """

    origin: ClassVar[Origin] = Origin("own", "planar epipolar geometry")
    needs: ClassVar[Needs] = Needs()
    claims_homing: ClassVar[bool] = True
    method: Epipolar = EPIPOLAR
    window: float = math.radians(30.0)

    def align(self, current: Panorama, goal: Panorama, prior: float | None = None) -> Alignment:
        """Return rotation [rad], residual in [0, 1] and home vector."""
        here, there = keypoints(current, self.method.spec), keypoints(goal, self.method.spec)
        found = self.method.movement(here, there, prior, self.window)
        return Alignment(found.rotation, 1.0 - found.support, home_of(found))
