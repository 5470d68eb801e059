"""How far the robot has come along its course, and what comes next."""

from __future__ import annotations

import pytest
from maps import STEP_NS, square

from topomap.core.geometry import Pose2
from topomap.navigation.course import Course


def test_it_follows_the_nearest_point_and_tells_how_far_off() -> None:
    topo = square()
    course = Course(topo, [0, 1, 2, 3])
    assert course.length == pytest.approx(1.5, abs=0.1)
    assert course.follow(Pose2(0.7, 0.2)) == pytest.approx(0.2, abs=0.01)
    assert course.along == pytest.approx(0.7, abs=0.01)
    assert course.left == pytest.approx(course.length - 0.7, abs=0.01)
    ahead = course.point(0.3)
    assert (ahead.x, ahead.y) == pytest.approx((1.0, 0.0), abs=0.01)


def test_a_loop_of_the_course_is_not_cut_short() -> None:
    topo = square()
    course = Course(topo, list(range(17)))
    course.follow(Pose2(*topo.poses[0]))
    assert course.along < 0.1
    course.reach(16)
    course.follow(Pose2(*topo.poses[16]))
    assert course.left < 0.1


def test_the_next_milestone_lies_far_enough_ahead() -> None:
    topo = square()
    topo.insert(7 * STEP_NS)
    course = Course(topo, [0, 1, 17, 2, 3])
    assert course.next_milestone(-1, 0.0) == 0
    assert course.next_milestone(-1, 0.3) == 1
    course.along = 0.5
    assert course.next_milestone(1, 0.1) == 3
    assert course.next_milestone(4, 0.0) is None


def test_the_goal_alone_is_a_course() -> None:
    topo = square()
    course = Course(topo, [2])
    assert course.length == 0.0
    assert course.follow(Pose2(1.0, 0.5)) == pytest.approx(0.5, abs=0.05)
    assert course.point(0.7).distance(topo.pose(2)) < 1e-9


def test_a_belief_that_was_set_right_is_followed_back() -> None:
    topo = square(8)
    course = Course(topo, list(range(9)))
    course.reach(6)
    off = course.follow(Pose2(1.0, 0.0))
    assert off == pytest.approx(0.0, abs=0.01)
    assert course.along == pytest.approx(1.0, abs=0.01)
