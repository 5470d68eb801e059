from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from topomap.evaluation.statistics import angular_errors, mean_interval, paired_bootstrap, share_interval


def test_mean_with_students_interval() -> None:
    values = np.array([3.0, 5.0, 4.0, 8.0, 6.5])
    found = mean_interval(values)
    low, high = stats.t.interval(0.95, 4, loc=values.mean(), scale=stats.sem(values))
    assert (found.value, found.low, found.high) == pytest.approx((5.3, low, high))


def test_one_value_has_no_interval_and_none_has_nothing() -> None:
    assert mean_interval(np.array([2.0])).value == 2.0
    assert math.isnan(mean_interval(np.array([2.0])).low)
    assert math.isnan(mean_interval(np.array([])).value)


def test_wilson_interval_of_a_textbook_case() -> None:
    found = share_interval(8, 10)
    assert (found.low, found.high) == pytest.approx((0.4902, 0.9433), abs=1e-4)


@given(st.integers(1, 500), st.data())
def test_wilson_interval_contains_the_share_and_stays_in_bounds(trials: int, data: st.DataObject) -> None:
    hits = data.draw(st.integers(0, trials))
    found = share_interval(hits, trials)
    assert 0.0 <= found.low <= found.value + 1e-12
    assert found.value - 1e-12 <= found.high <= 1.0


def test_bootstrap_is_paired_and_repeatable() -> None:
    rng = np.random.default_rng(1)
    best = rng.uniform(0, 90, 60)
    worse = best + 2.0  # unpaired, the spread of 26 degrees would hide the difference
    found = paired_bootstrap(worse, best, np.random.default_rng(0))
    assert (found.low, found.value, found.high) == pytest.approx((2.0, 2.0, 2.0))
    noisy = best + rng.normal(2.0, 4.0, 60)
    assert paired_bootstrap(noisy, best, np.random.default_rng(0)) == paired_bootstrap(
        noisy, best, np.random.default_rng(0)
    )


def test_errors_wrap_and_an_abstention_counts_as_a_guess() -> None:
    found = angular_errors(np.radians([170.0, 10.0, np.nan]), np.radians([-170.0, 55.0, 0.0]))
    assert found == pytest.approx([20.0, 45.0, 90.0])
