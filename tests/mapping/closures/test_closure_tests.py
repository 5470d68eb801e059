"""The engine's own stages: what each says of a claim, and how they add up."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from topomap.core.arrays import FloatArray
from topomap.core.geometry import Pose2, between
from topomap.mapping.closures.claims import Claims
from topomap.mapping.closures.closure_tests import TESTS, Apart, Crowding, Knowledge, Looks, Odometry, Prevalence
from topomap.mapping.closures.engine import ClosureEngine
from topomap.mapping.closures.gates import Gate, Supported
from topomap.mapping.closures.odds import log_chance, log_crowding, log_density, mahalanobis
from topomap.mapping.closures.spot_tests import CERTAIN, AtPlace

POSES = np.column_stack([np.random.default_rng(0).uniform(0, 20, (80, 2)), np.linspace(-3, 3, 80)])
ERRORS = np.tile(np.diag([0.1, 0.1, 0.01]) ** 2, (3, 1, 1))


def three() -> Claims:
    """A right claim, one a metre off and a blind one; looks speak for the second."""
    i, j = np.array([3, 10, 20]), np.array([50, 60, 70])
    relative = between(POSES[i], POSES[j]) + np.array([[0, 0, 0], [1.0, 0, 0], [0, 0, 2.0]])
    covariance = np.tile(np.diag([0.1, 0.1, 0.05]) ** 2, (3, 1, 1))
    covariance[2, 2, 2] = 40.0
    return replace(Claims.of(i, j, relative, covariance), looks=np.array([0.0, 2.5, -1.0]))


def known(support: FloatArray | None = None) -> Knowledge:
    some = np.ones(3) if support is None else support
    return Knowledge(POSES, ERRORS, np.array([1, 4, 2]), np.array([-2.0, 0.5, 1.0]), some)


def test_each_stage_speaks_of_what_it_knows() -> None:
    claims, knowledge = three(), known()
    assert Looks().weigh(claims, knowledge).tolist() == [0.0, 2.5, -1.0]
    assert Prevalence().weigh(claims, knowledge).tolist() == [-2.0, 0.5, 1.0]
    chi2, determinant = mahalanobis(claims, POSES, ERRORS)
    expected = log_density(chi2, determinant, claims.blind) - log_chance(POSES, claims.blind)
    assert Odometry().weigh(claims, knowledge) == pytest.approx(expected)
    assert np.array_equal(Crowding().weigh(claims, knowledge), -log_crowding(claims, POSES, ERRORS))


def test_odometry_speaks_for_what_fits_and_against_what_does_not() -> None:
    odds = Odometry().weigh(three(), known())
    assert odds[0] > 5.0
    assert odds[1] < odds[0] - 5.0
    assert odds[2] > 3.0  # blind: it fits where it is, whatever its heading says


def test_knowledge_of_some_is_theirs() -> None:
    part = known(np.array([0.2, 1.0, 3.0])).among(np.array([2, 0]))
    assert part.size.tolist() == [2, 1]
    assert part.prevalence.tolist() == [1.0, -2.0]
    assert part.support.tolist() == [3.0, 0.2]
    assert part.poses is POSES
    one = Knowledge.of_one(POSES, ERRORS[0])
    assert (one.size.tolist(), one.prevalence.tolist(), one.support.tolist()) == ([1], [0.0], [1.0])


@pytest.mark.parametrize(("off", "expected"), [([0.9, 0, 0], 0.0), ([1.1, 0, 0], -np.inf), ([0, 0, 0.3], 0.0),
                                               ([0, 0, 0.4], -np.inf)])  # fmt: skip
def test_what_the_map_has_elsewhere_is_another_place(off: list[float], expected: float) -> None:
    """More than 1 m or 20 degrees from what is claimed, unless map and claim are as vague as that."""
    i, j = np.array([3]), np.array([50])
    relative = between(POSES[i], POSES[j]) + np.array([off])
    sharp = Claims.of(i, j, relative, np.diag([0.1, 0.1, 0.05])[None] ** 2)
    vague = Claims.of(i, j, relative, np.diag([1.0, 1.0, 0.5])[None] ** 2)
    knowledge = Knowledge.of_one(POSES, np.zeros((3, 3)))
    assert Apart().weigh(sharp, knowledge).tolist() == [expected]
    assert Apart().weigh(vague, knowledge).tolist() == [0.0]


def test_across_a_gap_a_true_claim_is_as_likely_as_any() -> None:
    claims, nothing = three(), Knowledge(POSES, np.tile(1e6 * np.eye(3), (3, 1, 1)), *known_of_three())
    assert Odometry().weigh(claims, nothing) == pytest.approx(0.0, abs=1e-3)


def known_of_three() -> tuple[np.ndarray, FloatArray, FloatArray]:
    return np.ones(3, np.int64), np.zeros(3), np.ones(3)


def test_too_little_support_refuses() -> None:
    assert Supported().weigh(three(), known(np.array([0.99, 1.0, 7.0]))).tolist() == [-np.inf, 0.0, 0.0]


@pytest.mark.parametrize(("blind", "limit"), [(False, 11.345), (True, 9.210)])
def test_the_gate_lets_its_share_of_true_ones_pass(blind: bool, limit: float) -> None:
    covariance = np.diag([1.0, 1.0, 40.0 if blind else 0.5])[None]
    for chi2, expected in ((limit - 0.01, 0.0), (limit + 0.01, -np.inf)):
        off = np.array([[np.sqrt(chi2), 0.0, 0.0]])
        claim = Claims.of(np.array([3]), np.array([50]), between(POSES[[3]], POSES[[50]]) + off, covariance)
        found = Gate(0.99).weigh(claim, Knowledge.of_one(POSES, np.zeros((3, 3))))
        assert found.tolist() == [expected]


def test_odds_are_the_sum_of_what_all_tests_say() -> None:
    claims, knowledge = three(), known()
    assert [test.name for test in TESTS] == ["looks", "prevalence", "odometry", "apart", "crowding"]
    assert [test.lowers for test in TESTS] == [False, False, True, True, True]
    found = ClosureEngine().weigh(claims, knowledge, -100.0)
    assert found.log_odds == pytest.approx(sum(test.weigh(claims, knowledge) for test in TESTS))
    assert found.failed.tolist() == [-1, -1, -1]


class Said:
    """A test that says what it is told to, and remembers whom it was asked about."""

    def __init__(self, says: list[float], lowers: bool) -> None:
        self.name, self.lowers, self._says = "said", lowers, dict(zip(three().i.tolist(), says, strict=True))
        self.heard: list[int] = []

    def weigh(self, claims: Claims, knowledge: Knowledge) -> FloatArray:
        self.heard = claims.i.tolist()
        return np.array([self._says[i] for i in self.heard])


def test_who_is_below_the_bar_after_a_test_that_lowers_is_not_asked_about_again() -> None:
    first, last = Said([5.0, 1.0, 3.0], True), Said([-4.0, -4.0, 0.0], True)
    found = ClosureEngine((first, last)).weigh(three(), known(), 2.0)
    assert last.heard == [3, 20]
    assert found.log_odds.tolist() == [1.0, 1.0, 3.0]
    assert found.failed.tolist() == [1, 0, -1]


def test_who_is_below_the_bar_may_still_be_raised_by_tests_that_raise() -> None:
    first, second, last = Said([-5.0, 0.0, 3.0], False), Said([9.0, 0.0, 0.0], False), Said([0.0, 0.0, 0.0], True)
    found = ClosureEngine((first, second, last)).weigh(three(), known(), 2.0)
    assert second.heard == [3, 10, 20]
    assert found.log_odds.tolist() == [4.0, 0.0, 3.0]
    assert found.failed.tolist() == [-1, 2, -1]
    last_raises = ClosureEngine((first,)).weigh(three(), known(), 2.0)
    assert last_raises.failed.tolist() == [0, 0, -1]


def test_who_is_refused_is_not_asked_about_again_whoever_refused() -> None:
    first, last = Said([-np.inf, 3.0, 3.0], False), Said([np.inf, 0.0, 0.0], True)
    found = ClosureEngine((first, last)).weigh(three(), known(), 2.0)
    assert last.heard == [10, 20]
    assert found.log_odds.tolist() == [-np.inf, 3.0, 3.0]
    assert found.failed.tolist() == [0, -1, -1]


@pytest.mark.parametrize("sigma", [0.3, 0.5, 1.0, 3.0])
def test_at_place_tells_the_probability_that_odometry_leaves_for_the_spot(sigma: float) -> None:
    """Of positions that odometry allows, the share within 0.75 m of the spot against the rest."""
    poses = np.zeros((2, 3))
    claim = Claims.of_one(0, 1, Pose2(), np.diag([1e-6, 1e-6, 0.01]))
    errors = np.diag([sigma**2, sigma**2, 1e-4])
    share = 1.0 - np.exp(-(0.75**2) / (2 * sigma**2))
    found = float(AtPlace().weigh(claim, Knowledge.of_one(poses, errors))[0])
    assert found == pytest.approx(np.log(share / (1 - share)), abs=1e-3)


def test_at_place_falls_with_the_distance_and_never_says_more_than_odometry_is_known() -> None:
    poses, errors = np.zeros((2, 3)), 0.01 * np.eye(3)
    claims = [Claims.of_one(0, 1, Pose2(x, 0.0, 2.0), 0.01 * np.eye(3)) for x in (0.0, 0.3, 0.5, 3.0)]
    said = [float(AtPlace().weigh(claim, Knowledge.of_one(poses, errors))[0]) for claim in claims]
    assert said == sorted(said, reverse=True)
    assert said[0] == pytest.approx(np.log(CERTAIN))
    assert said[-1] == pytest.approx(-np.log(CERTAIN), abs=0.01)
