"""Precision and recall of scores against known answers."""

from __future__ import annotations

import numpy as np
import pytest

from topomap.evaluation.precision_recall import curve


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
