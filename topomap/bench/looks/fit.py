"""What the measured likenesses say: weights of a log likelihood ratio, and how well the shipped ones are calibrated."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass

import numpy as np
from scipy.optimize import minimize

from topomap.bench.looks.survey import Row
from topomap.core.arrays import BoolArray, FloatArray
from topomap.evaluation.calibration import Reliability, probability, reliability

FEWEST = 5  # a world with fewer true or false ones than this counts for less


@dataclass(frozen=True, slots=True)
class Fitted:
    """Weights of `none + rival * log(rival / cost) + usual * log(usual / cost)`."""

    none: float
    rival: float
    usual: float


def balanced(rows: Sequence[Row]) -> FloatArray:
    """Return weights (n,) by which each world's true ones, and its false ones, count as much as any other's."""
    kinds = [(row.world, row.true) for row in rows]
    count = {kind: max(kinds.count(kind), FEWEST) for kind in set(kinds)}
    return np.array([1.0 / count[kind] for kind in kinds])


def fit(rows: Sequence[Row], rivals: bool = True) -> Fitted:
    """Return the weights of a logistic regression that never falls where another place costs more.

    rivals: whether the best rival's cost is known.
    """
    cost, rival, usual = np.array([[row.cost, row.rival, row.usual] for row in rows]).T
    terms = np.log(np.column_stack([rival if rivals else cost, usual]) / cost[:, None])
    true, weight = _true(rows), balanced(rows)

    def loss(parts: FloatArray) -> float:
        said = parts[0] + terms @ parts[1:]
        return float(weight @ np.logaddexp(0.0, np.where(true, -said, said)))

    bounds = [(None, None), (0.0, None), (0.0, None)]
    found = minimize(loss, np.zeros(3), bounds=bounds).x
    return Fitted(*(round(float(part), 2) for part in found))


def curves(rows: Sequence[Row]) -> dict[str, Reliability]:
    """Return how well the shipped looks are calibrated: over all worlds, and in each."""
    worlds = sorted({row.world for row in rows})
    return {"all": _curve(rows)} | {world: _curve([row for row in rows if row.world == world]) for world in worlds}


def _curve(rows: Sequence[Row]) -> Reliability:
    return reliability(probability(np.array([row.looks for row in rows])), _true(rows), balanced(rows))


def _true(rows: Sequence[Row]) -> BoolArray:
    return np.array([row.true for row in rows], dtype=np.bool_)


def said(rows: Sequence[Row]) -> dict[str, object]:
    """Return all of it as plain values; weights are None where all are true or all false."""
    found = {name: {"error": one.error, "count": int(one.count.sum())} for name, one in curves(rows).items()}
    number = {kind: sum(row.true == kind for row in rows) for kind in (True, False)}
    both = all(number.values())
    seeds = sorted({row.seed for row in rows})
    aligned = [abs(row.rotation) < 0.35 for row in rows if not row.true]
    return {
        "true": number[True],
        "false": number[False],
        "seeds": seeds,
        "calibration": found,
        "with_rivals": asdict(fit(rows)) if both else None,
        "without_rivals": asdict(fit(rows, rivals=False)) if both else None,
        "false_turned_right": sum(aligned) / max(len(aligned), 1),
    }
