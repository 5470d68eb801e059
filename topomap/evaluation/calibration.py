"""How far probabilities can be trusted: what was predicted against how often it was so."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from topomap.core.arrays import BoolArray, FloatArray
from topomap.core.run_data import RunData
from topomap.evaluation.closures import closures

BINS = 10


@dataclass(frozen=True, slots=True, eq=False)
class Reliability:
    """Predictions by bins of probability (K,), those with none left out: the mean predicted, the share that was true
    and the number; error: the mean gap between the first two, each bin by its weight (expected calibration error).
    """

    predicted: FloatArray
    true: FloatArray
    count: FloatArray
    error: float


def probability(log_odds: FloatArray) -> FloatArray:
    """Return the probabilities (n,) of log odds."""
    return np.asarray(1.0 / (1.0 + np.exp(-np.clip(log_odds, -700.0, 700.0))))


def reliability(predicted: FloatArray, true: BoolArray, weight: FloatArray | None = None) -> Reliability:
    """Return how n predicted probabilities (n,) compare with what was true (n,); weight (n,): 1 each by default."""
    each = np.ones(len(predicted)) if weight is None else weight
    kind = np.minimum((predicted * BINS).astype(np.int64), BINS - 1)
    total = np.bincount(kind, each, BINS)
    some = total > 0
    told = np.bincount(kind, each * predicted, BINS)[some] / total[some]
    was = np.bincount(kind, each * true, BINS)[some] / total[some]
    gap = float((total[some] * np.abs(told - was)).sum() / total.sum()) if some.any() else math.nan
    return Reliability(told, was, np.bincount(kind, minlength=BINS)[some].astype(np.float64), gap)


def of_run(run: RunData, score: str) -> Reliability | None:
    """Return how a score in log odds ("odds", "looks") does on a run's candidates; None where nothing is to be judged.

    A score of looks alone tells a likelihood ratio: the odds are then even before.
    """
    judged = [
        (value, not closure.judgement.false)
        for closure in closures(run)
        if closure.judgement is not None
        and (value := closure.candidate.evidence.measured().get(score)) is not None
        and math.isfinite(value)
    ]
    if not judged:
        return None
    values, true = np.array(judged, dtype=np.float64).T
    return reliability(probability(values), true.astype(np.bool_))
