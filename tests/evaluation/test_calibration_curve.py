"""The calibration curve: shares by hand, its error, and who is left out."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from synthetic_run import make_run

from topomap.core.evidence import Evidence
from topomap.evaluation.calibration import of_run, probability, reliability


def test_by_hand() -> None:
    predicted = np.array([0.05, 0.07, 0.95, 0.99, 1.0])
    found = reliability(predicted, np.array([False, True, True, True, False]))
    assert found.count.tolist() == [2, 3]
    assert found.predicted == pytest.approx([0.06, 0.98])
    assert found.true == pytest.approx([0.5, 2 / 3])
    assert found.error == pytest.approx((2 * 0.44 + 3 * (0.98 - 2 / 3)) / 5)


def test_weights_count() -> None:
    found = reliability(np.array([0.5, 0.5]), np.array([True, False]), np.array([3.0, 1.0]))
    assert found.true == pytest.approx([0.75])
    assert found.error == pytest.approx(0.25)


def test_what_is_as_probable_as_said_has_no_error() -> None:
    rng = np.random.default_rng(0)
    predicted = rng.uniform(size=20_000)
    honest = reliability(predicted, rng.uniform(size=20_000) < predicted)
    boastful = reliability(probability(3 * np.log(predicted / (1 - predicted))), rng.uniform(size=20_000) < predicted)
    assert honest.error < 0.02
    assert boastful.error > 0.1


def test_nothing_predicted() -> None:
    assert math.isnan(reliability(np.zeros(0), np.zeros(0, bool)).error)


def test_log_odds_as_probabilities() -> None:
    assert probability(np.array([-1e9, 0.0, math.log(3.0), 1e9])) == pytest.approx([0.0, 0.5, 0.75, 1.0])


def test_only_judged_candidates_with_a_score_count() -> None:
    run = make_run()
    found = of_run(run, "odds")
    assert found is not None
    assert found.count.sum() == len({(d.candidate.query_ns, d.candidate.match) for d in run.decisions})
    assert found.predicted == pytest.approx(1 / (1 + math.exp(-3.0)))
    assert of_run(replace(run, truth=None), "odds") is None
    bare = tuple(replace(d, candidate=replace(d.candidate, evidence=Evidence())) for d in run.decisions)
    assert of_run(replace(run, decisions=bare), "odds") is None
