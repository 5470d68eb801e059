"""H6, descent in image distance with three references (Zeil et al. 2003; 2.5.3, eq. 2.5)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from topomap.core.panorama import Panorama
from topomap.core.records import HomeVector
from topomap.vision.contracts import GoalView, Needs, Origin
from topomap.vision.homing.view_vector import same_views, vector_home
from topomap.vision.image.compare import SignatureSpec, mean_abs, signature

BLURRED = SignatureSpec(columns=90, rows=25, blur=2.0)
"""sigma 16 columns by 8 rows of a 720 x 100 panorama after the shrinking's own averaging."""


@dataclass(frozen=True, slots=True)
class ImageDescent:
    """atan2(d_Y - d_0, d_X - d_0), d_R = mean |H_R - C| (2.5), on low-passed views; bearing only.

    spec: the low-pass (without it 37 instead of 16 deg); step [m]: 0.1 near the goal, 0.3 far from it.
    """

    origin: ClassVar[Origin] = Origin("H6", "2.5; Zeil et al. 2003")
    needs: ClassVar[Needs] = Needs(compass=True)
    claims_homing: ClassVar[bool] = True
    spec: SignatureSpec = BLURRED
    step: float = 0.1

    def home(self, current: Panorama, goal: GoalView) -> HomeVector:
        """Return the bearing [rad] of the goal in the aligned frame. Raises ShapeError."""
        same_views(current, goal.home)
        here = signature(current, self.spec)
        apart = [mean_abs(here, signature(p, self.spec)) for p in (goal.home, goal.x, goal.y)]
        x, y = apart[1] - apart[0], apart[2] - apart[0]
        return vector_home(x, y, 0.5 * sum(apart) + 1e-9, 1.0 if here.pixels.any() and apart[0] > 1e-6 else 0.0)
