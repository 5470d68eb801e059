"""A goal whose view is partly hidden, then or now, is met by the rest of it and by a belief that is sure and near."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest
from maps import square
from sceneries import scenery, seen, with_people

from topomap.core.geometry import Pose2
from topomap.core.records import HomeVector, Hypothesis, PlaceMatch, Where
from topomap.navigation.goal_met import BARE, PARTS, goal_met
from topomap.navigation.senses import Now, Senses
from topomap.navigation.sight import Look, Sight
from topomap.vision.image.sectors import SECTORS

GOAL, OTHER = 3, 9
MAP = square()
AT_GOAL = Where(MAP.pose(GOAL), GOAL, 0.9, 0.01)
HOME = scenery(0)
HIDDEN = list(range(SECTORS - PARTS - 2))
"""As many directions as leave those that are asked for, and two whose edges are blurred."""


def met(
    where: Where = AT_GOAL, hidden: list[int] = HIDDEN, over: bool = True, other: Any = None, there: bool = False
) -> str:
    """What is noted of an arrival where people hide some directions of the goal's view; "" for none.

    over: the view came no nearer; other: what the place looks like that is most alike; there: the view has passed its
    minimum.
    """
    now_seen = seen(with_people(HOME, hidden))
    sight = Sight(0, GOAL, seen(HOME), 0.0)
    for _ in range(9 if over else 2):
        assert not sight.arrival.update(0.9)
    views = {OTHER: seen(scenery(77) if other is None else other)}
    mapper: Any = SimpleNamespace(map=MAP, view_cache=SimpleNamespace(panorama=views.get))
    senses = Senses(0, now_seen, place=PlaceMatch(OTHER, 0.8, 0.0))
    journey: Any = SimpleNamespace(goal=GOAL)
    look = Look(HomeVector(0.0, None, 0.0), 0.9, 0.0, there)
    reached, note = goal_met(journey, sight, look, Now(senses, where, mapper))
    assert reached == note.startswith("goal reached")
    return note


def moved(x: float) -> Where:
    pose = AT_GOAL.pose
    return replace(AT_GOAL, pose=Pose2(pose.x + x, pose.y, pose.heading))


def test_what_is_left_of_the_view_is_enough_where_the_belief_is_sure_and_near() -> None:
    assert "of 12 directions are as they were" in met()
    assert met(moved(BARE - 0.001)) != "" == met(moved(BARE))


def test_too_little_of_the_view_is_none() -> None:
    assert met(hidden=list(range(SECTORS - PARTS + 1))) == ""


def test_a_view_that_still_comes_nearer_is_waited_for() -> None:
    assert met(over=False) == ""


@pytest.mark.parametrize(
    "where",
    [
        replace(AT_GOAL, lost=0.05),
        replace(AT_GOAL, rivals=(Hypothesis(OTHER, MAP.pose(OTHER), 0.05),)),
        replace(AT_GOAL, pose=Pose2(AT_GOAL.pose.x, AT_GOAL.pose.y, AT_GOAL.pose.heading + 0.7)),
    ],
)
def test_a_belief_that_is_not_sure_or_turned_otherwise_is_not_enough(where: Where) -> None:
    assert met(where) == ""


def test_another_place_that_is_as_alike_is_a_rival() -> None:
    assert MAP.length(GOAL, OTHER) > 1.0
    assert met(other=HOME) == ""


def test_a_place_that_looks_more_alike_as_people_hide_the_goal_is_told_from_it_by_the_rest() -> None:
    """In two corridors alike, amid people, it stood at its goal and another door's view was less unlike."""
    assert "of 12 directions are as they were" in met(there=True, other=scenery(77))
    assert met(there=True, other=HOME) == f"looks like the goal, but node {OTHER} looks more alike"
