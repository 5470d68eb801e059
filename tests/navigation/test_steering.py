"""How view and believed pose are weighed against each other."""

from __future__ import annotations

import math

import pytest

from topomap.core.geometry import Pose2
from topomap.core.records import HomeVector
from topomap.navigation.steering import heading_for, map_sigma, share_of_view, view_sigma

HERE, MILESTONE = Pose2(), Pose2(1.0, 0.0)


def headed(home: HomeVector, lost: float = 0.0, milestone: Pose2 = MILESTONE, ahead: Pose2 | None = None) -> float:
    return heading_for(HERE, milestone, ahead or milestone, home, lost)


def test_a_home_vector_that_flips_with_no_confidence_moves_nothing() -> None:
    both = [headed(HomeVector(bearing, None, 0.1)) for bearing in (math.radians(100), math.radians(-95))]
    assert all(abs(bearing) < math.radians(5) for bearing in both)


def test_a_sure_home_vector_counts_about_as_much_as_the_pose() -> None:
    assert 0.08 < headed(HomeVector(0.2, None, 1.0)) < 0.15


def test_near_the_milestone_the_view_leads_and_far_off_the_pose() -> None:
    home = HomeVector(0.3, None, 0.9)
    shares = [share_of_view(home, 0.0, distance, 0.0) for distance in (0.05, 0.3, 1.0, 3.0)]
    assert shares == sorted(shares, reverse=True)
    assert shares[0] > 0.9
    assert shares[-1] < 0.4


def test_what_contradicts_the_pose_is_not_followed_unless_lost() -> None:
    away = HomeVector(math.pi, None, 1.0)
    assert headed(away) == pytest.approx(0.0)
    assert headed(away, lost=0.6) == pytest.approx(math.pi)


def test_a_view_that_says_nothing_leaves_the_pose() -> None:
    assert headed(HomeVector(2.0, None, 0.0)) == pytest.approx(0.0)


def test_the_course_is_followed_past_the_milestone() -> None:
    ahead = Pose2(1.0, 1.0)
    assert headed(HomeVector(0.0, None, 0.8), ahead=ahead) == pytest.approx(math.pi / 4)


def test_the_less_sure_the_belief_the_more_the_view_counts() -> None:
    home = HomeVector(0.2, None, 0.7)
    shares = [share_of_view(home, 0.0, 1.0, lost) for lost in (0.0, 0.2, 0.4, 0.6)]
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    assert math.isinf(map_sigma(1.0, 0.5))


def test_a_methods_own_error_counts_however_confident_it_is() -> None:
    assert share_of_view(HomeVector(0.1), 0.0, 1.0, 0.0, 0.3) < share_of_view(HomeVector(0.1), 0.0, 1.0, 0.0)


def test_bearings_err_less_the_surer_they_are() -> None:
    sigmas = [view_sigma(0.1 * k) for k in range(11)]
    assert sigmas == sorted(sigmas, reverse=True)


def test_a_milestone_at_the_robots_feet_turns_nobody_round() -> None:
    ahead, milestone = Pose2(0.7, 0.0), Pose2(-0.08, 0.02)  # just passed
    for bearing in (math.pi, 2.0, -2.0, 0.5):
        heading = heading_for(Pose2(), milestone, ahead, HomeVector(bearing, None, 0.5), 0.0)
        assert abs(heading) < 0.25


def test_a_milestone_as_far_as_the_point_ahead_turns_the_course_as_it_says() -> None:
    ahead = Pose2(0.7, 0.0)
    heading = heading_for(Pose2(), ahead, ahead, HomeVector(0.3, None, 1.0), 0.0)
    share = share_of_view(HomeVector(0.3, None, 1.0), 0.0, 0.7, 0.0)
    assert heading == pytest.approx(share * 0.3, abs=0.02)
