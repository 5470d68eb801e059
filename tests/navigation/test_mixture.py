"""Several hypotheses of one pose: they move, are measured, weighed and brought together."""

from __future__ import annotations

import math

import numpy as np
import pytest

from topomap.core.records import Motion
from topomap.navigation.localiser.likeness import AGAINST, FOR, log_ratio
from topomap.navigation.localiser.mixture import MOST, Mixture

SMALL = 0.01 * np.eye(3)


def pair() -> Mixture:
    start = Mixture.at(np.array([0.0, 0.0, 0.0]), SMALL, 0.5)
    return start.joined_by(np.array([[4.0, 2.0, math.pi / 2]]), SMALL, np.log([0.2])).normalised()


def probabilities(mixture: Mixture) -> list[float]:
    return [*np.exp(mixture.weights).tolist(), math.exp(mixture.elsewhere)]


def test_each_hypothesis_moves_the_way_it_looks_and_grows_less_certain() -> None:
    moved = pair().moved(Motion(1.0, 0.0, 0.0, np.zeros((3, 3)), 0.25), np.diag([0.04, 0.01, 0.0]))
    assert moved.poses == pytest.approx(np.array([[1.0, 0.0, 0.0], [4.0, 3.0, math.pi / 2]]))
    assert moved.covariances[0, 0, 0] == pytest.approx(0.05)
    assert moved.covariances[1, 1, 1] == pytest.approx(0.05)  # it looks along y
    assert moved.covariances[0, 1, 1] == pytest.approx(0.01 + 0.01 + 0.01)  # its heading's error, one metre on


def test_probabilities_add_up_to_one_and_evidence_decides() -> None:
    weighed = pair().weighed(np.array([-3.0, 2.0]), 1e-3)
    assert sum(probabilities(weighed)) == pytest.approx(1.0)
    assert weighed.weights[1] - weighed.weights[0] == pytest.approx(math.log(0.2 / 0.5) + 5.0)


def test_what_nothing_speaks_for_any_more_is_elsewhere() -> None:
    mixture = Mixture.at(np.zeros(3), SMALL, 1e-3)
    for _ in range(6):
        mixture = mixture.weighed(np.array([-3.0]), 1e-3)
    assert math.exp(mixture.elsewhere) > 0.99


def test_a_measured_pose_is_between_and_across_the_turn_of_the_angle() -> None:
    start = Mixture.at(np.array([0.0, 0.0, math.pi - 0.1]), SMALL, 0.1)
    seen = start.measured(np.array([0]), np.array([[0.2, 0.0, -math.pi + 0.1]]), SMALL[None])
    assert seen.poses[0] == pytest.approx([0.1, 0.0, math.pi], abs=1e-9) or seen.poses[0][2] == pytest.approx(-math.pi)
    assert seen.covariances[0, 0, 0] == pytest.approx(0.005)


def test_near_hypotheses_become_one_and_keep_their_probability() -> None:
    start = pair()
    twin = start.joined_by(np.array([[0.1, 0.1, 0.05]]), SMALL, np.log([0.1])).normalised()
    one = twin.looked(np.array([0, 2]), np.array([0.3, 0.5])).pruned()
    assert len(one) == 2
    assert sum(probabilities(one)) == pytest.approx(1.0)
    assert math.exp(one.weights[0]) == pytest.approx((0.5 / 1.2 + 0.1) / 1.1)
    assert one.seen[0].tolist() == [0.3, 1.0, 0.3]  # of the likelier one


def test_looks_add_up_for_those_that_had_them() -> None:
    seen = pair().looked(np.array([1]), np.array([0.2])).looked(np.array([0, 1]), np.array([0.1, 0.4])).seen
    assert seen == pytest.approx(np.array([[0.1, 1.0, 0.1], [0.6, 2.0, 0.2]]))


def test_no_more_are_kept_than_a_step_has_time_for() -> None:
    count = 2 * MOST
    poses = np.column_stack([np.arange(count) * 2.0, np.zeros(count), np.zeros(count)])
    many = Mixture.unknown().joined_by(poses, SMALL, -np.linspace(1, 9, count)).normalised()
    kept = many.pruned()
    assert len(kept) == MOST
    assert kept.poses[0, 0] == 0.0
    assert sum(probabilities(kept)) == pytest.approx(1.0)


def test_a_likeness_that_half_the_map_has_says_little() -> None:
    unique, common = np.full(60, 1.0), np.concatenate([np.full(30, 0.25), np.full(30, 1.0)])
    alike = np.array([0.25])
    assert float(log_ratio(alike, unique)[0]) > 3.0
    assert float(log_ratio(alike, common)[0]) < 0.7
    assert float(log_ratio(np.array([1.0]), unique)[0]) < -1.5
    assert AGAINST <= float(log_ratio(np.array([5.0]), unique)[0]) <= FOR


def test_a_break_leaves_little_and_forgets_what_was_seen_before_it() -> None:
    start = Mixture.at(np.zeros(3), SMALL, 1e-3)
    seen = Mixture(
        start.poses, start.covariances, start.weights, np.array([[0.05, 1.0, 0.05]]), np.ones(1), start.elsewhere
    )
    after = seen.shaken(0.8)
    assert math.exp(after.weights[0]) == pytest.approx(0.2, abs=1e-3)
    assert sum(probabilities(after)) == pytest.approx(1.0)
    assert after.seen.tolist() == [[0.0, 0.0, np.inf]]
    assert after.behind.tolist() == [0.0]


def test_a_look_that_is_bounded_counts_for_no_more_in_the_sum_but_is_kept_as_the_least() -> None:
    seen = pair().looked(np.array([0, 1]), np.array([1.2, 0.1]), 0.25).seen
    assert seen[:, 0].tolist() == [0.25, 0.1]
    assert seen[:, 2].tolist() == [1.2, 0.1]
