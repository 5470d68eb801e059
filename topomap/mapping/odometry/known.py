"""What is known of a drive's odometer before places are seen again, by ranges and from drives before it on the map."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from topomap.core.arrays import BoolArray, FloatArray
from topomap.core.records import Estimate
from topomap.mapping.odometry.increments import Calibration
from topomap.mapping.optimizer.problem import PRIOR_SIGMAS

# places seen again tell nothing of the distance scale and would bend it (DESIGN.md): it is held at what was measured
HELD = 1e-4
# [log rotation scale, rad/m, log distance scale] what a kept calibration was found from isn't kept: it stays nearly as
# it was found
KEPT_SIGMAS = (0.01, 0.002, HELD)
OTHER_SCALE = 0.01
"""[log distance scale] By which who goes on may read another way than who drove before, where no ranges tell it:
closures tell one scale beside the other."""


@dataclass(frozen=True, slots=True)
class KnownOdometer:
    """The calibration that a loaded map was left with, if there is one, and how many of its edges drives before made.

    The odometer that goes on may be another one, so that what it is found to be leaves these edges as they are.
    """

    before: Calibration | None = None
    edges: int = 0

    def prior(self, scale: Estimate) -> tuple[Calibration, tuple[float, float, float]]:
        """Return mean and sigmas as `Problem` has them; scale: the distance scale as ranges measured it so far."""
        if self.before is None:
            return Calibration(distance_scale=scale.value), (PRIOR_SIGMAS[0], PRIOR_SIGMAS[1], HELD)
        if scale.observed:
            return replace(self.before, distance_scale=scale.value), KEPT_SIGMAS
        return self.before, (KEPT_SIGMAS[0], KEPT_SIGMAS[1], OTHER_SCALE)

    def others(self, count: int) -> BoolArray | None:
        """Return which (count,) of a map's edges drives before this one made; None if there was none."""
        return np.arange(count) < self.edges if self.edges else None


def honest(covariance: FloatArray, scale: Estimate) -> FloatArray:
    """Return the covariance (3, 3) of a solution; the distance scale was held and is as unknown as before."""
    result = covariance.copy()
    result[2, :], result[:, 2] = 0.0, 0.0
    result[2, 2] = (scale.sigma / scale.value if scale.observed else PRIOR_SIGMAS[2]) ** 2
    return result
