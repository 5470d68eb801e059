"""Looks: the better a place's cost beside that of others, the likelier it is the place, whatever the cost's unit."""

from __future__ import annotations

import math

import numpy as np
import pytest

from topomap.core.records import Alignment, PlaceMatch
from topomap.mapping.closures.appearance import Look, Outcome
from topomap.mapping.closures.looks import MOST, WITH_RIVALS, WITHOUT_RIVALS, LogRatio, Weights, log_ratio


def outcome(cost: float, ratio: float, elsewhere: float) -> Outcome:
    return Outcome(Look(PlaceMatch(0, 0.3, 0.0), Alignment(0.0, cost)), ratio, elsewhere)


def test_by_hand() -> None:
    assert log_ratio(Weights(-1.0, 2.0, 3.0), 0.5, 0.6, 0.8) == pytest.approx(
        -1.0 + 2.0 * math.log(1.2) + 3.0 * math.log(1.6)
    )


@pytest.mark.parametrize("weights", [WITH_RIVALS, WITHOUT_RIVALS])
def test_it_falls_with_the_cost_and_levels_off_where_the_measurement_ends(weights: Weights) -> None:
    said = [log_ratio(weights, cost, 0.8, 0.9) for cost in np.linspace(0.05, 1.5, 50)]
    assert (np.diff(said) <= 0).all()
    assert max(said) == MOST
    assert min(said) == -MOST
    assert log_ratio(weights, 0.8, 0.8, 0.8) < 0.0  # as alike as others: rather not the place
    assert np.isfinite(log_ratio(weights, 0.0, 0.8, 0.9))


def test_the_unit_of_the_cost_does_not_matter() -> None:
    assert log_ratio(WITH_RIVALS, 0.5, 0.6, 0.7) == pytest.approx(log_ratio(WITH_RIVALS, 50.0, 60.0, 70.0))


def test_a_look_alike_world_makes_the_same_cost_worth_less() -> None:
    assert log_ratio(WITH_RIVALS, 0.45, 0.8, 0.9) > 2.9
    assert log_ratio(WITH_RIVALS, 0.45, 0.47, 0.55) < 0.0


def test_rivals_tell_where_they_were_compared_and_else_what_is_usual() -> None:
    looks = LogRatio()
    assert looks.of(outcome(0.4, 0.0, np.nan), rivals=False) == 0.0  # nothing is known
    assert looks.of(outcome(0.4, 0.5, 0.9), rivals=True) == pytest.approx(log_ratio(WITH_RIVALS, 0.4, 0.8, 0.9))
    for _ in range(9):
        looks.of(outcome(0.4, 0.5, 0.9), rivals=True)
    expected = log_ratio(WITHOUT_RIVALS, 0.6, 0.9, 0.9)
    assert looks.of(outcome(0.6, 0.0, np.nan), rivals=False) == pytest.approx(expected)
    assert looks.of(outcome(0.6, 0.99, 0.9), rivals=False) == pytest.approx(expected)
    for _ in range(30):
        looks.of(outcome(0.4, 0.5, 0.6), rivals=True)
    assert looks.of(outcome(0.6, 0.0, np.nan), rivals=False) < 0.0  # what is usual has become as low
