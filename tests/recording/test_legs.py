"""A run's missions as legs, one for each goal."""

from __future__ import annotations

from logs import records as log
from topomap.core.run_data import Leg
from topomap.recording.legs import legs


def row(goal: int | None, travel: str = "travel", milestone: int | None = None) -> log.Mission:
    return log.Mission("travel", goal, travel, milestone, 0, "")


TAUGHT = row(None, "teach")


def test_a_patrol_has_a_leg_for_each_goal() -> None:
    rows = [
        TAUGHT,
        row(5, milestone=3),
        row(5, milestone=4),
        row(5, "arrived", 5),
        row(2, milestone=4),
        row(2, "failed"),
    ]
    assert legs(rows) == (Leg(5, 1, 3, True, (3, 4, 5)), Leg(2, 4, 5, False, (4,)))


def test_the_same_goal_twice_is_two_legs() -> None:
    assert [(one.first, one.last) for one in legs([row(5), row(5, "arrived"), row(5), row(5, "arrived")])] == [
        (0, 1), (2, 3)
    ]  # fmt: skip


def test_another_goal_or_none_ends_a_leg_that_nobody_claimed() -> None:
    assert legs([row(5), row(4), TAUGHT, row(4)]) == (Leg(5, 0, 0, None), Leg(4, 1, 1, None), Leg(4, 3, 3, None))


def test_a_lesson_alone_has_none() -> None:
    assert legs([TAUGHT, TAUGHT]) == ()


def test_a_milestone_is_named_once_where_it_was_first_steered_for() -> None:
    assert legs([row(5, milestone=3), row(5, milestone=4), row(5, milestone=3)])[0].milestones == (3, 4)
