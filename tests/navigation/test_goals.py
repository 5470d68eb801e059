"""A mission: one goal after the other, and what can't be is said in a line."""

from __future__ import annotations

import pytest
from maps import STEP_NS, square
from pydantic import ValidationError

from topomap.core.records import Phase, Travel
from topomap.navigation.mission import Mission, MissionSettings
from topomap.navigation.wish import Kind, parse_wish

ARRIVED, UNDER_WAY = Travel(Phase.ARRIVED), Travel(Phase.TRAVEL)


def test_a_patrol_goes_from_goal_to_goal() -> None:
    topo, mission = square(), Mission(MissionSettings(do="patrol:desk,3,desk"))
    topo.places["desk"] = 5
    assert mission.goal(True, topo).phase is Phase.TEACH
    for node in (5, 3, 5):
        assert not mission.over
        assert mission.goal(False, topo).node == node
        mission.report(UNDER_WAY)
        assert mission.goal(False, topo).node == node
        mission.report(ARRIVED)
    assert mission.over
    assert mission.phase is Phase.ARRIVED


def test_a_patrol_goes_on_after_a_goal_that_is_given_up_and_has_failed_in_the_end() -> None:
    topo, mission = square(), Mission(MissionSettings(do="patrol:1,2,3"))
    assert mission.goal(False, topo).node == 1
    for made, then in ((Phase.ARRIVED, 2), (Phase.FAILED, 3)):
        mission.report(Travel(made))
        assert not mission.over
        assert mission.goal(False, topo).node == then
    mission.report(ARRIVED)
    assert mission.phase is Phase.FAILED


def test_who_is_lost_or_without_senses_ends_a_patrol() -> None:
    topo, mission = square(), Mission(MissionSettings(do="patrol:1,2"))
    mission.goal(False, topo)
    mission.report(Travel(Phase.FAILED), able=False)
    assert mission.phase is Phase.FAILED


@pytest.mark.parametrize(("do", "node"), [("home", 0), ("goto:4", 4), ("goto:desk", 5), ("hall", 0), ("", 0)])
def test_where_each_mission_leads(do: str, node: int) -> None:
    topo = square()
    topo.places["desk"] = 5
    assert Mission(MissionSettings(do=do)).goal(False, topo).node == node


def test_home_is_where_the_first_drive_began_whatever_its_number() -> None:
    topo = square()
    topo.names = [100 + k for k in range(17)]
    assert Mission(MissionSettings(do="home")).goal(False, topo).node == 0
    assert Mission(MissionSettings(do="goto:103")).goal(False, topo).node == 3


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        (MissionSettings(goal_node=99), "no node 99 on the map: it has nodes 0 to 17"),
        (MissionSettings(do="goto:sea"), "no place 'sea' on the map"),
        (MissionSettings(do="patrol:1,17"), "node 17 holds no view"),
    ],
)
def test_a_goal_that_is_not_fails_and_says_what_there_is(settings: MissionSettings, said: str) -> None:
    topo, mission = square(), Mission(settings)
    topo.insert(7 * STEP_NS)
    assert mission.goal(False, topo).phase is Phase.FAILED
    assert mission.over
    assert said in mission.failure


def test_taught_and_stopped() -> None:
    topo = square()
    for settings in (MissionSettings(do="teach"), MissionSettings(then="stop")):
        mission = Mission(settings)
        assert mission.goal(True, topo).phase is Phase.TEACH
        assert mission.goal(False, topo).phase is Phase.ARRIVED


@pytest.mark.parametrize("text", ["fly", "goto", "goto:", "goto:1,2", "home:3", "patrol", "patrol:1,,2", "teach:"])
def test_words_that_are_no_mission(text: str) -> None:
    with pytest.raises(ValidationError, match="expected teach, home, goto"):
        MissionSettings(do=text)


def test_words_that_are() -> None:
    assert parse_wish("patrol:a, b ,3").targets == ("a", "b", "3")
    assert parse_wish("goto:the desk").targets == ("the desk",)
    assert parse_wish("hall").kind is Kind.HALL
