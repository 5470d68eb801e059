"""The figures of a table over trials: means, shares and differences with their intervals."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.special import stdtrit

from topomap.core.arrays import FloatArray

NORMAL_95 = 1.959963984540054
GUESS_DEG = 90.0
"""The expected error of a guess: what an abstention counts as."""


@dataclass(frozen=True, slots=True)
class Interval:
    """A value with its 95 % interval; the ends are NaN where there is too little to say."""

    value: float
    low: float
    high: float


NOTHING = Interval(math.nan, math.nan, math.nan)


def mean_interval(values: FloatArray) -> Interval:
    """Return the mean of values (N,) with its 95 % confidence interval (Student t)."""
    count = len(values)
    if count == 0:
        return NOTHING
    mean = float(np.mean(values))
    if count == 1:
        return Interval(mean, math.nan, math.nan)
    half = float(stdtrit(count - 1, 0.975)) * float(np.std(values, ddof=1)) / math.sqrt(count)
    return Interval(mean, mean - half, mean + half)


def share_interval(hits: int, trials: int) -> Interval:
    """Return a share with its Wilson 95 % interval (Wilson 1927)."""
    if trials == 0:
        return NOTHING
    share, z = hits / trials, NORMAL_95
    spread = z * math.sqrt(share * (1 - share) / trials + z * z / (4 * trials * trials))
    scale = 1 + z * z / trials
    middle = (share + z * z / (2 * trials)) / scale
    return Interval(share, max(0.0, middle - spread / scale), min(1.0, middle + spread / scale))


def paired_bootstrap(values: FloatArray, best: FloatArray, rng: np.random.Generator, draws: int = 2000) -> Interval:
    """Return mean(values - best) over the same N places with its 95 % percentile interval (Efron 1979)."""
    difference = values - best
    if len(difference) == 0:
        return NOTHING
    picks = rng.integers(len(difference), size=(draws, len(difference)))
    low, high = np.percentile(difference[picks].mean(axis=1), [2.5, 97.5])
    return Interval(float(difference.mean()), float(low), float(high))


def angular_errors(found: FloatArray, true: FloatArray) -> FloatArray:
    """Return the errors (N,) [degrees, 0..180] of directions (N,) [rad]; an abstention (NaN) counts as a guess."""
    off = np.abs(np.degrees(np.angle(np.exp(1j * (found - true)))))
    return np.where(np.isfinite(found), off, GUESS_DEG)
