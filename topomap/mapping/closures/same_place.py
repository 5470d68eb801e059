"""Near a place isn't at it: what is measured farther off, or much less alike than places seen again usually are."""

from __future__ import annotations

from collections import deque

import numpy as np
from pydantic import BaseModel, Field

from topomap.mapping.closures.relative_pose import Offset


class SamePlaceSettings(BaseModel, frozen=True, extra="forbid"):
    """When a closure is believed to be at the place itself."""

    times: float = Field(2.0, gt=1, description="the usual cost of places seen again, so many times at most")
    memory: int = Field(30, ge=1, description="closures over which the usual cost is taken")
    fewest: int = Field(10, ge=1, description="closures before which nothing is usual")
    apart: float = Field(0.8, gt=0, description="places measured to lie farther apart are two [m]")
    unmeasured: float = Field(0.25, gt=0, description="error of a position from which on nothing measured it [m]")


class SamePlaceTest:
    """Objects where the offset is too long, or unmeasured and the view differs more than at the spot it would."""

    def __init__(self, settings: SamePlaceSettings) -> None:
        self._s = settings
        self._costs: deque[float] = deque(maxlen=settings.memory)

    def objection(self, cost: float, offset: Offset) -> str:
        """Return why a closure isn't believed, or an empty string; learn what is usual.

        cost: the residual of its alignment, 0 for equal views and some 1 for unlike ones.
        """
        usual = float(np.median(self._costs)) if len(self._costs) >= self._s.fewest else np.inf
        self._costs.append(cost)
        away = float(np.hypot(offset.relative.x, offset.relative.y))
        if away > self._s.apart:
            return f"another place nearby: measured {away:.2f} m apart (at most {self._s.apart:.2f} m)"
        sigma = float(np.sqrt(np.linalg.eigvalsh(offset.covariance[:2, :2])[-1]))
        if sigma <= self._s.unmeasured or cost <= self._s.times * usual:
            return ""
        return (
            f"much less alike than places seen again are here (cost {cost:.2f}, usually {usual:.2f}): it is near, "
            "and nothing measures how far"
        )
