"""A6, min-warping as compass: the rotation of the movement and rotation that explain two views best."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, Literal

from topomap.core.panorama import Panorama
from topomap.core.records import Alignment
from topomap.vision.compass.visual_compass import VISUAL_COMPASS, VisualCompass
from topomap.vision.contracts import Needs, Origin
from topomap.vision.image.scale_planes import WARPING, WarpingSpec, warping_view
from topomap.vision.matching.warping import best, warp


@dataclass(frozen=True, slots=True)
class MinWarpingCompass:
    """The rotation of the best (alpha, psi) of `topomap.vision.matching.warping`, with its home vector.

    search: every rotation ("full"), or near the visual compass ("compass") where no prior is given; window
    [rad]: how far from the prior, or else from the visual compass. The residual is the cost over a wrong
    movement's.
    """

    needs: ClassVar[Needs] = Needs()
    claims_homing: ClassVar[bool] = True
    spec: WarpingSpec = WARPING
    search: Literal["full", "compass"] = "full"
    window: float = math.radians(30.0)
    compass: VisualCompass = VISUAL_COMPASS

    @property
    def origin(self) -> Origin:
        """Row and source of this variant."""
        near = ", near A1" if self.search == "compass" else ""
        return Origin("A6", f"2.5.2.2; Möller et al. 2010{near}")

    def align(self, current: Panorama, goal: Panorama, prior: float | None = None) -> Alignment:
        """Return rotation [rad], residual (0 same, about 0.95 unrelated) and home vector."""
        near = prior
        if prior is None and self.search == "compass":
            near = self.compass.align(current, goal).rotation
        views = warping_view(current, self.spec), warping_view(goal, self.spec)
        return best(warp(*views, near, self.window))

    def prepare(self, panorama: Panorama) -> None:
        """Magnify a view's columns, which takes half as long as a search."""
        warping_view(panorama, self.spec)
