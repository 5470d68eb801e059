"""What a robot that was carried makes of its first view: how sure it may be, by what else looks like it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from topomap.core.arrays import FloatArray
from topomap.navigation.localiser.mixture import Mixture
from topomap.navigation.localiser.set_down import ODDS, OTHERWISE, SLOPE, set_down
from topomap.navigation.localiser.views import Seen, Usual
from topomap.navigation.localiser.weighing import APART, APART_SHARE, GROWTH, by_stretch

COLUMNS = 90
USUAL = Usual(1.0, np.random.default_rng(3).normal(0.95, 0.06, 40))
UNIT = APART + APART_SHARE * 0.15**2


def seen(likeness: list[float]) -> Seen:
    """Places so unlike the view at the best rotation, and by nearly twice the usual at every other."""
    squares = np.full((len(likeness), COLUMNS), 3.0)
    squares[:, 0] = np.square(likeness)
    squares[:, [1, -1]] = np.square(likeness)[:, None] + 0.5
    where = np.arange(len(likeness))
    return Seen(where, squares, np.zeros(squares.shape, np.int64), np.zeros((1, 2)), USUAL)


def row(count: int, apart: float = 9.0) -> FloatArray:
    return np.column_stack([apart * np.arange(count), np.zeros((count, 2))])


def behind(units: float) -> float:
    return math.sqrt(0.15**2 + units * UNIT)


def after(likeness: list[float], apart: float = 9.0) -> Mixture:
    return set_down(Mixture.unknown(), seen(likeness), row(len(likeness), apart))


def lost(mixture: Mixture) -> float:
    return 1.0 - math.exp(mixture.weights.max())


def test_a_view_that_one_place_alone_looks_like_tells_it() -> None:
    assert OTHERWISE < lost(after([0.15, 0.7, 0.8, 0.75])) < 0.05


def test_of_two_places_alike_neither_is_likelier_than_not() -> None:
    found = after([0.15, 0.15, 0.8])
    assert lost(found) > 0.5
    assert found.weights[0] == pytest.approx(found.weights[1])


@pytest.mark.parametrize("units", [0.5, 1.0, 2.0])
def test_a_unit_behind_speaks_so_much_against_a_place_and_as_many_may_not_be_on_the_map(units: float) -> None:
    found = after([0.15, behind(units), 0.9])
    assert found.weights[0] - found.weights[1] == pytest.approx(SLOPE * units, rel=1e-3)
    rival = math.exp(-SLOPE * units)
    assert lost(found) == pytest.approx(1 - 1 / (1 + (1 + ODDS) * rival), abs=0.04)


def test_a_view_like_nothing_on_the_map_was_not_taken_on_it() -> None:
    assert lost(after([0.8, 0.85, 0.9])) > 0.7
    assert lost(after([0.65, 0.9, 0.9])) > lost(after([0.3, 0.9, 0.9])) + 0.1


def test_neighbours_that_see_the_same_pose_are_one_place() -> None:
    """A place passed twice isn't twice as likely, nor its own rival."""
    assert len(after([0.15, 0.16, 0.9], apart=0.2).weights) < 3
    assert lost(after([0.15, 0.16, 0.9], apart=0.2)) == pytest.approx(lost(after([0.15, 0.9], apart=9.0)), abs=0.01)


def test_where_the_belief_has_its_hypotheses_no_new_one_is_made() -> None:
    start = Mixture.at(np.zeros(3), 0.01 * np.eye(3), 0.8)
    assert set_down(start, seen([0.15]), row(1)) is start
    found = set_down(start, seen([0.15, 0.2]), row(2))
    assert len(found) == 2
    assert math.exp(found.weights[0]) == pytest.approx(0.2)
    assert math.exp(found.weights[1]) == pytest.approx(0.8 * (1 - OTHERWISE), abs=0.03)
    assert np.logaddexp.reduce([*found.weights, found.elsewhere]) == pytest.approx(0.0)


def test_a_stretch_that_says_what_the_first_view_said_says_no_more() -> None:
    found = after([0.15, behind(1.5)])
    assert found.behind == pytest.approx([0.0, math.sqrt(SLOPE * 1.5 / GROWTH)], rel=1e-3, abs=1e-6)
    for _ in range(6):
        found = found.looked(np.array([0, 1]), 0.15**2 + np.array([0.0, 1.2 * UNIT]))
    again = by_stretch(found, seen([0.15, 0.2]))
    assert again.weights[0] - again.weights[1] == pytest.approx(found.weights[0] - found.weights[1], abs=0.15)
