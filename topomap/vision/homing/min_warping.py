"""H11, min-warping as a homing method with its own compass."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from topomap.core.panorama import Panorama
from topomap.core.records import HomeVector
from topomap.vision.contracts import Needs, Origin
from topomap.vision.image.scale_planes import WARPING, WarpingSpec, WarpingView, warping_view
from topomap.vision.matching.warping import least_home, warp


@dataclass(frozen=True, slots=True)
class MinWarping:
    """The direction of the best (alpha, psi), reversed (H11); bearing only.

    window [rad]: how far the views may be turned against each other, pi for any rotation.
    """

    origin: ClassVar[Origin] = Origin("H11", "2.5.2.2; Möller et al. 2010")
    needs: ClassVar[Needs] = Needs()
    claims_homing: ClassVar[bool] = True
    spec: WarpingSpec = WARPING
    window: float = math.pi

    def describe(self, panorama: Panorama) -> WarpingView:
        """Return the view's magnified edge columns."""
        return warping_view(panorama, self.spec)

    def home(self, current: WarpingView, goal: WarpingView) -> HomeVector:
        """Return the bearing [rad] of the goal in the current robot's frame."""
        return least_home(warp(current, goal, 0.0, self.window))
