"""How well a score tells true closure candidates from false ones: precision, recall, area under the curve."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from topomap.core.arrays import BoolArray, FloatArray
from topomap.core.records import Verdict
from topomap.core.run_data import RunData
from topomap.evaluation.closures import Closure, closures

HIGH_IS_GOOD = {
    "similarity": True,
    "support": True,
    "share": True,
    "active": True,
    "difference": False,
    "cost": False,
    "ratio": False,
    "sigmas": False,
    "odometry": False,
    "odds": True,
    "looks": True,
}
"""Which way each score points. What isn't named here, such as the limit of the moment, is no evidence: no curve."""


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """Precision and recall (K,) as the threshold on one score opens, candidates of one score at once.

    auc: area under the curve (average precision); recall_at_full_precision: the largest recall without a false one.
    """

    score: str
    precision: FloatArray
    recall: FloatArray
    auc: float
    recall_at_full_precision: float


@dataclass(frozen=True, slots=True)
class Evaluation:
    """Candidates whose truth is known: how many, how many are true, how many of each were accepted; a curve a score."""

    judged: int
    true: int
    accepted_true: int
    accepted_false: int
    curves: tuple[Curve, ...]

    @property
    def precision(self) -> float:
        """The share of true ones among the accepted; NaN where none was."""
        total = self.accepted_true + self.accepted_false
        return self.accepted_true / total if total else math.nan

    @property
    def recall(self) -> float:
        """The share of the true candidates that was accepted; NaN where there is none."""
        return self.accepted_true / self.true if self.true else math.nan


def evaluate(run: RunData) -> Evaluation | None:
    """Judge every candidate by the truth; None where no candidate's truth is known."""
    known = [closure for closure in closures(run) if closure.judgement is not None]
    if not known:
        return None
    true = np.array([c.judgement is not None and not c.judgement.false for c in known])
    kept = np.array([c.verdict is Verdict.ACCEPTED for c in known])
    names = [
        "similarity",
        *sorted({name for c in known for name in c.candidate.evidence.measured()} & HIGH_IS_GOOD.keys()),
    ]
    curves = tuple(curve(name, _values(known, name), true) for name in names) if true.any() else ()
    counts = (int((true & kept).sum()), int((~true & kept).sum()))
    return Evaluation(len(known), int(true.sum()), *counts, curves)


def _values(known: Sequence[Closure], name: str) -> FloatArray:
    """Return the candidates' scores, high for good; one that wasn't measured is the worst."""
    sign = 1.0 if HIGH_IS_GOOD[name] else -1.0
    found = [
        c.candidate.similarity if name == "similarity" else c.candidate.evidence.measured().get(name) for c in known
    ]
    return np.array([-math.inf if v is None or math.isnan(v) else sign * v for v in found])


def curve(score: str, values: FloatArray, true: BoolArray) -> Curve:
    """Return the curve of values (M,), high for good, against true (M,), of which at least one must be.

    The area is the average precision: the sum of precision times the recall that each step adds.
    """
    order = np.argsort(-values, kind="stable")
    found = np.cumsum(true[order])
    last = np.append(values[order][1:] != values[order][:-1], True)
    precision, recall = (found / np.arange(1, len(found) + 1))[last], (found / int(true.sum()))[last]
    auc = float((precision * np.diff(recall, prepend=0.0)).sum())
    full = recall[precision == 1.0]
    return Curve(score, precision, recall, auc, float(full.max()) if len(full) else 0.0)
