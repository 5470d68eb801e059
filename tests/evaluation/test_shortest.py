from __future__ import annotations

import math

import numpy as np
import pytest

from topomap.core.records import Plan
from topomap.evaluation.shortest import BODY, shortest_way

ROOM = np.array([[0.0, 0.0], [6.0, 0.0], [6.0, 4.0], [0.0, 4.0], [0.0, 0.0]])
WALL = np.array([[3.0, 0.0], [3.0, 3.0]])
HERE, THERE = np.array([1.0, 1.0]), np.array([5.0, 1.0])
STOOD = HERE[None]


def test_the_free_way_is_straight_in_any_direction() -> None:
    for end in ([5.0, 1.0], [4.7, 2.3], [2.1, 3.4]):
        found = shortest_way(Plan((ROOM,)), STOOD, HERE, np.array(end))
        assert found == pytest.approx(math.dist(HERE, end), rel=0.01)


def test_round_a_wall_it_keeps_the_bodys_radius() -> None:
    found = shortest_way(Plan((ROOM, WALL)), STOOD, HERE, THERE)
    assert found is not None
    # at least round the wall's end, at most round a square corner a body and a cell beyond it
    least = 2 * math.hypot(2.0, 2.0)
    assert least < found < 2 * math.hypot(2.0, 2.0 + BODY + 0.15) + 0.2


def test_a_door_that_was_driven_through_stood_open_and_a_shut_room_has_no_way() -> None:
    door = np.array([[3.0, 0.0], [3.0, 4.0]])
    assert shortest_way(Plan((ROOM, door)), STOOD, HERE, THERE) is None
    through = np.array([[2.5, 1.0], [3.5, 1.1]])
    assert shortest_way(Plan((ROOM, door)), through, HERE, THERE) == pytest.approx(4.0, rel=0.01)


def test_a_pillar_is_gone_round_and_an_empty_plan_says_nothing() -> None:
    found = shortest_way(Plan((ROOM,), ((3.0, 1.0, 0.5),)), STOOD, HERE, THERE)
    assert found is not None
    assert 4.1 < found < 4.6
    assert shortest_way(Plan(), STOOD, HERE, THERE) is None
