"""Precision and recall of scores against known answers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from synthetic_run import LAP, candidate, decide, make_run

from topomap.core.evidence import Evidence
from topomap.core.geometry import Pose2
from topomap.core.records import Candidate
from topomap.core.run_data import RunData
from topomap.evaluation.precision_recall import Curve, curve, evaluate


def test_a_perfect_score() -> None:
    found = curve("s", np.array([0.9, 0.8, 0.2, 0.1]), np.array([True, True, False, False]))
    assert (found.auc, found.recall_at_full_precision) == (1.0, 1.0)


def test_a_worked_example() -> None:
    """By falling score true, false, true: precision 1, 1/2, 2/3 at recall 1/2, 1/2, 1."""
    found = curve("s", np.array([3.0, 2.0, 1.0]), np.array([True, False, True]))
    assert found.precision.tolist() == pytest.approx([1, 0.5, 2 / 3])
    assert found.recall.tolist() == pytest.approx([0.5, 0.5, 1])
    assert found.auc == pytest.approx(0.5 + 0.5 * 2 / 3)
    assert found.recall_at_full_precision == 0.5


def test_equal_scores_count_at_once_whatever_their_order() -> None:
    for true in ([True, False], [False, True]):
        found = curve("s", np.zeros(2), np.array(true))
        assert (found.precision.tolist(), found.recall.tolist()) == ([0.5], [1.0])
        assert found.recall_at_full_precision == 0.0


@pytest.mark.parametrize("name", ["similarity", "support", "share", "active"])
def test_a_score_that_grows_with_likeness_counts_when_it_is_large(name: str) -> None:
    assert curve_of(name, true=0.9, false=0.1).auc == 1.0
    assert curve_of(name, true=0.1, false=0.9).auc < 1.0


@pytest.mark.parametrize("name", ["difference", "cost", "ratio", "sigmas", "odometry"])
def test_a_score_that_grows_with_difference_counts_when_it_is_small(name: str) -> None:
    assert curve_of(name, true=0.1, false=0.9).auc == 1.0
    assert curve_of(name, true=0.9, false=0.1).auc < 1.0


@pytest.mark.parametrize("name", ["similarity", "share", "cost"])
def test_a_score_that_was_not_measured_is_the_worst(name: str) -> None:
    assert curve_of(name, true=0.5, false=None).auc == 1.0


def test_a_limit_and_an_unknown_name_are_no_evidence() -> None:
    found = evaluate(run_with("limit", 0.4, 0.6))
    assert found is not None
    assert [curve.score for curve in found.curves] == ["similarity"]


def curve_of(name: str, true: float, false: float | None) -> Curve:
    found = evaluate(run_with(name, true, false))
    assert found is not None
    return next(curve for curve in found.curves if curve.score == name)


def run_with(name: str, true: float, false: float | None) -> RunData:
    """A run with a true and a false candidate that differ in one score only."""
    run = make_run()
    right, wrong = candidate(run, LAP + 5, 8), replace(candidate(run, LAP + 150, 40), relative=Pose2())
    return replace(run, decisions=(decide(scored(right, name, true)), decide(scored(wrong, name, false))))


def scored(one: Candidate, name: str, value: float | None) -> Candidate:
    if name == "similarity":
        return replace(one, similarity=np.nan if value is None else value, evidence=Evidence())
    return replace(one, similarity=0.5, evidence=Evidence() if value is None else Evidence.of({name: value}))
