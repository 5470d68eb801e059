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
WHOLE = SignatureSpec(columns=4096, rows=2048, blur=0.0)
"""Every pixel of a usual panorama as it is, which is how the thesis runs DID (4.2): its low-pass is ours."""


@dataclass(frozen=True, slots=True)
class ImageDescent:
    """atan2(d_Y - d_0, d_X - d_0), d_R = mean |H_R - C| (2.5), on low-passed views; bearing only.

    spec: the low-pass (`WHOLE`, without it, 31 and 46 instead of 12 and 22 deg in a1original and ourlab); step [m]:
    0.1 near the goal, 0.3 far from it.
    """

    needs: ClassVar[Needs] = Needs(compass=True)
    spec: SignatureSpec = BLURRED
    step: float = 0.1

    @property
    def origin(self) -> Origin:
        """Row and source of this variant."""
        return Origin("H6", "2.5; 4.2, whole pixels" if self.spec == WHOLE else "2.5; Zeil et al. 2003")

    @property
    def claims_homing(self) -> bool:
        """Whether fine texture is taken out, whose difference says nothing of the distance."""
        return self.spec.blur > 0.0

    def home(self, current: Panorama, goal: GoalView) -> HomeVector:
        """Return the bearing [rad] of the goal in the aligned frame. Raises ShapeError."""
        same_views(current, goal.home)
        here = signature(current, self.spec)
        apart = [mean_abs(here, signature(p, self.spec)) for p in (goal.home, goal.x, goal.y)]
        x, y = apart[1] - apart[0], apart[2] - apart[0]
        return vector_home(x, y, 0.5 * sum(apart) + 1e-9, 1.0 if here.pixels.any() and apart[0] > 1e-6 else 0.0)
