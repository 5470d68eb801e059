"""The odometry's systematic errors: the distance scale from ranges, and what is believed of all three."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from topomap.contract import MotionReading
from topomap.geometry import FloatArray
from topomap.mapping.odometry import Calibration
from topomap.types import CalibrationState, Estimate, Float32Array

MAD_TO_SIGMA = 1.4826  # of a normal distribution
MEDIAN_LOSS = 1.2533  # a median's standard error over a mean's


class RangeScaleSettings(BaseModel):
    """How ranges ahead and behind are held against the odometer on straight moves."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    steps: int = Field(default=5, ge=1, le=100, description="steps of one straight move")
    max_range: float = Field(default=10.0, gt=0, description="ranges beyond this aren't used [m]")
    columns: int = Field(default=5, ge=1, le=99, description="columns around the nose whose median is one range")
    min_travel: float = Field(default=0.2, gt=0, description="shortest straight move [m]")
    max_turn_deg: float = Field(default=1.5, gt=0, le=20, description="largest turn of a straight move [degree]")
    max_change: float = Field(default=0.25, gt=0, le=1, description="a scale further off is another object")
    min_moves: int = Field(default=8, ge=2, description="moves before the scale counts as seen")
    floor: float = Field(default=0.003, gt=0, le=0.1, description="error that more moves don't take away")
    prior_sigma: float = Field(default=0.1, gt=0, le=1, description="sigma of the scale before anything is seen")


class RangeScale:
    """Estimates the distance scale [odometer's metres per metre] from how the ranges ahead and behind change.

    A range along the direction of travel shortens by just what was driven, whatever the wall's angle.
    """

    def __init__(self, settings: RangeScaleSettings | None = None) -> None:
        self._s = settings or RangeScaleSettings()
        self._inverses: list[float] = []
        self._start: FloatArray | None = None
        self._forward = self._turn = 0.0
        self._steps = 0

    def update(self, motion: MotionReading, ranges: Float32Array | None) -> None:
        """Take the raw increment since the last step and the ranges (W,) [m], ccw from the nose, after it."""
        now = None if ranges is None else self._ends(ranges)
        self._forward, self._turn, self._steps = (
            self._forward + motion.forward,
            self._turn + motion.turn,
            self._steps + 1,
        )
        bent = abs(self._turn) > math.radians(self._s.max_turn_deg)
        if self._start is None or now is None or bent:
            self._begin(now)
        elif self._steps >= self._s.steps and abs(self._forward) >= self._s.min_travel:
            self._measure(self._start, now)
            self._begin(now)

    def _ends(self, ranges: Float32Array) -> FloatArray:
        """Return (2,) the ranges ahead and behind, NaN where nothing near was measured."""
        width, half = len(ranges), self._s.columns // 2
        around = np.arange(-half, half + 1)
        ends = np.stack([ranges[around % width], ranges[(around + width // 2) % width]]).astype(float)
        medians = np.median(ends, axis=1)
        return np.where(medians < self._s.max_range, medians, np.nan)

    def _begin(self, ends: FloatArray | None) -> None:
        self._start, self._forward, self._turn, self._steps = ends, 0.0, 0.0, 0

    def _measure(self, before: FloatArray, after: FloatArray) -> None:
        # true metres per metre read: the ranges' noise then stands in the numerator and doesn't bias
        inverses = (before - after) * np.array([1.0, -1.0]) / self._forward
        self._inverses.extend(float(v) for v in inverses if abs(v - 1.0) <= self._s.max_change)

    @property
    def moves(self) -> int:
        """How many range changes have been compared."""
        return len(self._inverses)

    def estimate(self) -> Estimate:
        """Return the distance scale with its sigma; 1 with the prior's sigma as long as it isn't observed."""
        if len(self._inverses) < self._s.min_moves:
            return Estimate(1.0, self._s.prior_sigma, False)
        inverses = np.array(self._inverses)
        middle = float(np.median(inverses))
        spread = MAD_TO_SIGMA * float(np.median(np.abs(inverses - middle)))
        sigma = math.hypot(MEDIAN_LOSS * spread / math.sqrt(len(inverses)), self._s.floor) / middle**2
        if sigma > 0.5 * self._s.prior_sigma:
            return Estimate(1.0, self._s.prior_sigma, False)
        return Estimate(1.0 / middle, sigma, True)


def calibration_state(
    calibration: Calibration, covariance: FloatArray, prior_sigmas: Sequence[float]
) -> CalibrationState:
    """Return what is believed, from the covariance (3, 3) of `Calibration.vector` and its prior's sigmas (3,).

    A value is observed once its sigma is at most half of what it was before any data.
    """
    sigmas = np.sqrt(np.diag(covariance))
    seen = [bool(s <= 0.5 * p) for s, p in zip(sigmas, prior_sigmas, strict=True)]
    return CalibrationState(
        rotation_scale=Estimate(calibration.rotation_scale, float(sigmas[0]) * calibration.rotation_scale, seen[0]),
        curvature=Estimate(calibration.curvature, float(sigmas[1]), seen[1]),
        distance_scale=Estimate(calibration.distance_scale, float(sigmas[2]) * calibration.distance_scale, seen[2]),
    )
