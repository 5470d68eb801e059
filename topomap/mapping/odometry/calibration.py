"""The odometry's systematic errors: the distance scale from measured moves, and all three as estimates with sigmas."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from topomap.core.arrays import FloatArray
from topomap.core.records import CalibrationState, Estimate
from topomap.mapping.odometry.increments import Calibration

MAD_TO_SIGMA = 1.4826  # of a normal distribution


MAX_CHANGE = 0.25
"""A scale further from 1 is a wrong measurement: the conditions' worst odometer is 10 to 12 % off."""
MIN_MOVES = 8
"""Moves before the scale counts as seen: of eight, three wrong ones don't move the median far."""
OUTLIER = 3.0
"""Moves this many sigmas from the others don't count."""
FLOOR = 0.002
"""Error that more moves don't take away: scales by ranges came out 0.2 to 0.6 % off."""
YOUNG = 3.0
"""A scatter of few moves is widened: its variance by 1 + 3/sqrt(n)."""
PRIOR_SIGMA = 0.1
"""Sigma of the scale before anything is seen: covers the conditions' odometers, 5 and 10 % off."""


class DistanceScale:
    """Estimates the distance scale [odometer's metres per metre] from moves that were measured otherwise as well."""

    def __init__(self) -> None:
        self._moves: list[tuple[float, float, float]] = []
        self._checks: list[tuple[float, float, float, float]] = []

    def add(self, read: float, measured: float, sigma: float, bias: float = 0.0, odometer: float = 0.0) -> None:
        """Take a move: way as the odometer read it, as it was measured, the errors of this and of the odometer [m].

        bias: share by which it may be off as all others are, which doesn't average out: 0 for one by ranges.
        """
        if measured > 0 and abs(read / measured - 1.0) <= MAX_CHANGE:
            self._moves.append((read / measured, math.hypot(sigma, odometer) / measured, bias))
            if not bias:
                self._checks.append((read, measured, sigma, odometer))

    def odometer(self) -> tuple[float, float] | None:
        """Return the variance of the odometer's way over the declared one, least and most, where ranges tell it."""
        if len(self._checks) < MIN_MOVES or not self._checks[0][3]:
            return None
        read, measured, sigma, declared = np.array(self._checks).T
        off = np.abs(read - float(np.median(read / measured)) * measured) / declared
        scatter = (MAD_TO_SIGMA * float(np.median(off))) ** 2
        least = max(scatter - float(np.median((sigma / declared) ** 2)), 0.0)
        return least, scatter * (1.0 + YOUNG / math.sqrt(len(off)))

    def estimate(self) -> Estimate:
        """Return the distance scale with its sigma: 1 with the prior's at first, nearer to it the less is known."""
        unknown = Estimate(1.0, PRIOR_SIGMA, False)
        if len(self._moves) < MIN_MOVES:
            return unknown
        scales, sigmas, biases = np.array(self._moves).T
        away = np.abs(scales - np.median(scales))
        # sigmas are only known up to a factor: the moves' own spread gives it
        sigmas = sigmas * max(1.0, MAD_TO_SIGMA * float(np.median(away / sigmas)))
        weights = np.where(away <= OUTLIER * sigmas, sigmas**-2.0, 0.0)
        total = float(weights.sum())
        sigma = math.hypot(total**-0.5, FLOOR, float(weights @ biases) / total)
        value = float(weights @ scales / total)
        if sigma <= 0.5 * PRIOR_SIGMA:
            return Estimate(value, sigma, True)
        share = PRIOR_SIGMA**2 / (PRIOR_SIGMA**2 + sigma**2)  # what is vague counts as far as it tells
        return Estimate(1.0 + share * (value - 1.0), math.sqrt(1.0 - share) * PRIOR_SIGMA, False)


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
