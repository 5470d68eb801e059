"""The odometry's systematic errors: the distance scale from measured moves, and all three as estimates with sigmas."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from pydantic import BaseModel, Field

from topomap.core.arrays import FloatArray
from topomap.core.records import CalibrationState, Estimate
from topomap.mapping.odometry.increments import Calibration

MAD_TO_SIGMA = 1.4826  # of a normal distribution


class DistanceScaleSettings(BaseModel, frozen=True, extra="forbid"):
    """How measured distances are compared with the odometer's."""

    max_change: float = Field(0.25, gt=0, le=1, description="a scale further from 1 is a wrong measurement")
    min_moves: int = Field(8, ge=2, description="moves before the scale counts as seen")
    outlier: float = Field(3.0, gt=0, description="moves this many sigmas from the others don't count")
    floor: float = Field(0.002, gt=0, le=0.1, description="error that more moves don't take away")
    seen_floor: float = Field(0.015, gt=0, le=0.1, description="... by the share of moves that were seen, not measured")
    prior_sigma: float = Field(0.1, gt=0, le=1, description="sigma of the scale before anything is seen")


class DistanceScale:
    """Estimates the distance scale [odometer's metres per metre] from moves that were measured otherwise as well."""

    def __init__(self, settings: DistanceScaleSettings | None = None) -> None:
        self._s = settings or DistanceScaleSettings()
        self._moves: list[tuple[float, float, bool]] = []

    def add(self, read: float, measured: float, sigma: float, seen: bool = False) -> None:
        """Take a move: way as the odometer read it, as it was measured, and the error of their difference [m].

        seen: measured by the ground line, whose bias doesn't average out over many moves.
        """
        if measured > 0 and abs(read / measured - 1.0) <= self._s.max_change:
            self._moves.append((read / measured, sigma / measured, seen))

    def estimate(self) -> Estimate:
        """Return the distance scale with its sigma; 1 with the prior's sigma as long as it isn't observed."""
        unknown = Estimate(1.0, self._s.prior_sigma, False)
        if len(self._moves) < self._s.min_moves:
            return unknown
        scales, sigmas, seen = np.array(self._moves).T
        away = np.abs(scales - np.median(scales))
        # sigmas are only known up to a factor: the moves' own spread gives it
        sigmas = sigmas * max(1.0, MAD_TO_SIGMA * float(np.median(away / sigmas)))
        weights = np.where(away <= self._s.outlier * sigmas, sigmas**-2.0, 0.0)
        total = float(weights.sum())
        sigma = math.hypot(total**-0.5, self._s.floor, self._s.seen_floor * float(weights @ seen) / total)
        if sigma > 0.5 * self._s.prior_sigma:
            return unknown
        return Estimate(float(weights @ scales / total), sigma, True)


def calibration_state(
    calibration: Calibration, covariance: FloatArray, prior_sigmas: Sequence[float]
) -> CalibrationState:
    """Return the estimates, from the covariance (3, 3) of `Calibration.vector` and its prior's sigmas (3,).

    A value is observed once its sigma is at most half of what it was before any data.
    """
    sigmas = np.sqrt(np.diag(covariance))
    seen = [bool(s <= 0.5 * p) for s, p in zip(sigmas, prior_sigmas, strict=True)]
    return CalibrationState(
        rotation_scale=Estimate(calibration.rotation_scale, float(sigmas[0]) * calibration.rotation_scale, seen[0]),
        curvature=Estimate(calibration.curvature, float(sigmas[1]), seen[1]),
        distance_scale=Estimate(calibration.distance_scale, float(sigmas[2]) * calibration.distance_scale, seen[2]),
    )
