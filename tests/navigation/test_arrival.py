"""When a milestone counts as reached, and a goal."""

from __future__ import annotations

from dataclasses import replace

from topomap.core.geometry import Pose2
from topomap.core.records import Hypothesis, PlaceMatch, Where
from topomap.navigation.arrival import Arrival, Claim, doubt
from topomap.navigation.localiser.localiser import UNPROVEN


def steps_to_arrive(curve: list[float]) -> int | None:
    arrival = Arrival()
    return next((i for i, value in enumerate(curve) if arrival.update(value)), None)


def test_the_place_itself_is_reached_at_once() -> None:
    assert steps_to_arrive([0.9, 0.5, 0.1]) == 2


def test_a_passed_minimum_is_reached_two_steps_later() -> None:
    assert steps_to_arrive([0.9, 0.6, 0.4, 0.3, 0.34, 0.4, 0.5]) == 5


def test_one_noisy_step_is_no_passed_minimum() -> None:
    assert steps_to_arrive([0.9, 0.5, 0.56, 0.45, 0.4, 0.38]) is None


def test_a_high_minimum_is_another_place() -> None:
    assert steps_to_arrive([0.9, 0.7, 0.8, 0.9, 0.9, 0.9]) is None


def test_a_curve_that_rests_low_is_reached() -> None:
    assert steps_to_arrive([0.9, 0.5, 0.28] + [0.285] * 10) == 8


def test_what_one_look_of_a_turn_on_the_spot_shows_is_no_minimum() -> None:
    """The bars that hold a mirror turn with the robot: at one heading in three they lie on the goal's, and the views
    are much alike, for that look alone. Who believes to be at the goal counts its looks all the same."""
    arrival = Arrival()
    assert not arrival.update(0.66)
    dip = [0.67, 0.66, 0.68, 0.465, 0.67, 0.68, 0.66, 0.67, 0.68, 0.67]
    assert not any(arrival.update(one, moved=False, counts=True) for one in dip)
    lasting = [0.67, 0.465, 0.46, 0.465, 0.47, 0.465, 0.47, 0.465, 0.47]
    assert any(arrival.update(one, moved=False, counts=True) for one in lasting), "the place looks so from here"


GOAL = Pose2(5.0, 2.0, 1.0)


def claimed(where: Where, **values: object) -> str:
    """Why a claim isn't believed whose view is the goal's and turned as it is believed."""
    return doubt(replace(Claim(GOAL, 0.3, 0.1, where), **values))


HERE = Where(Pose2(5.2, 2.0, 1.3), 0, 0.1, 0.01)


def test_view_and_belief_together_are_an_arrival() -> None:
    assert claimed(HERE) == ""


def test_a_belief_that_is_lost_elsewhere_or_torn_is_none() -> None:
    assert "lost with a probability of 0.20" in claimed(replace(HERE, lost=0.2))
    assert "it is believed to be 0.7 m away" in claimed(replace(HERE, pose=Pose2(5.7, 2.0, 1.3)))
    torn = (Hypothesis(7, Pose2(8.0, 2.0, 1.3), 0.15), Hypothesis(9, Pose2(2.0, 2.0, 1.3), 0.1))
    assert "with a probability of 0.25 it is another place" in claimed(replace(HERE, rivals=torn))
    beside = (Hypothesis(1, Pose2(5.4, 2.0, 1.3), 0.4),)
    assert claimed(replace(HERE, rivals=beside)) == ""


def test_a_view_turned_otherwise_than_the_belief_is_none() -> None:
    assert claimed(HERE, rotation=0.7) == ""
    assert "turned by 57 degrees otherwise" in claimed(HERE, rotation=1.3)


def test_where_another_place_looks_more_alike_it_is_none() -> None:
    assert "node 12 looks more alike" in claimed(HERE, other=PlaceMatch(12, 0.1, 0.0), other_away=3.0)
    assert claimed(HERE, other=PlaceMatch(12, 0.11, 0.0), other_away=3.0) == ""
    assert claimed(HERE, other=PlaceMatch(12, 0.05, 0.0), other_away=0.6) == ""


def test_a_view_that_came_no_nearer_is_believed_beside_the_goal_alone() -> None:
    """A goal .32 m beside the aisle that the robot drove along was claimed in a warehouse, believed .34 m away."""
    beside = replace(HERE, pose=Pose2(5.34, 2.0, 1.3))
    assert claimed(beside) == "" == claimed(replace(HERE, pose=Pose2(5.25, 2.0, 1.3)), passed=True)
    assert "it is believed to be 0.3 m away" in claimed(beside, passed=True)


def test_each_doubt_begins_at_its_bound() -> None:
    assert claimed(replace(HERE, lost=0.05)) != "" == claimed(replace(HERE, lost=0.0499))
    assert claimed(replace(HERE, pose=Pose2(5.6, 2.0, 1.3))) == ""
    for weight, says in ((0.05, True), (0.0499, False)):
        away = (Hypothesis(7, Pose2(8.0, 2.0, 1.3), weight), Hypothesis(8, Pose2(6.0, 2.0, 1.3), 0.5))
        assert bool(claimed(replace(HERE, rivals=away))) == says
    assert claimed(HERE, rotation=0.79) == "" != claimed(HERE, rotation=0.81)
    assert claimed(HERE, other=PlaceMatch(12, 0.1, 0.0), other_away=1.0) == ""
    assert claimed(HERE, other=PlaceMatch(12, 0.1, 0.0), other_away=1.001) != ""


def test_a_belief_that_is_not_proven_yet_claims_nothing() -> None:
    assert "lost with a probability of 0.05" in claimed(replace(HERE, lost=UNPROVEN))
