"""How fast the view changes is learnt from the drive itself, and lengths follow it whatever the world's scale."""

from __future__ import annotations

import math

import numpy as np
import pytest

from topomap.core.geometry import Pose2
from topomap.mapping.closures.appearance import RIVAL_DISTANCE, apart
from topomap.mapping.closures.claims import Claims
from topomap.mapping.closures.closure_tests import Knowledge
from topomap.mapping.closures.spot_tests import Beside, Placed
from topomap.mapping.places.catchment import Catchment, steps_back
from topomap.mapping.places.contrast import FEWEST, Contrast


def seen(scale: float, noise: float = 0.0) -> Catchment:
    """A drive on which views differ by 0.1 at once and by 1.0 from 1 m times the scale on."""
    rng, catchment = np.random.default_rng(0), Catchment()
    for way in np.geomspace(0.05, 20.0, 400) * scale:
        catchment.learn(float(way), float(min(0.1 + 0.9 * way / scale, 1.0) + noise * rng.normal()))
    return catchment


@pytest.mark.parametrize("scale", [0.3, 1.0, 10.0])
def test_half_of_the_difference_tells_the_length_in_any_scale(scale: float) -> None:
    assert seen(scale).length == pytest.approx(0.45 * scale, rel=0.15)
    assert seen(scale, 0.1).length == pytest.approx(0.45 * scale, rel=0.3)


def test_nothing_is_known_at_first_and_a_few_odd_views_bend_nothing() -> None:
    assert Catchment().length == Catchment().other == 0.0
    assert seen(10.0).other == pytest.approx(1.0, abs=0.01)
    odd = seen(1.0)
    for _ in range(FEWEST):
        odd.learn(0.03, 1.2)
    assert odd.length == pytest.approx(seen(1.0).length, rel=0.2)


def test_ways_back_grow_by_a_factor_up_to_the_whole_way() -> None:
    ways = steps_back(10.0)
    assert ways[0] == 0.02
    assert 7.0 < ways[-1] <= 10.0
    assert np.allclose(np.diff(np.log(ways)), math.log(2.0) / 2)


def test_other_places_lie_farther_off_where_the_view_changes_slowly() -> None:
    assert apart(0.0) == apart(0.3) == RIVAL_DISTANCE
    assert apart(4.0) == 10.0


PLACES = np.array([[0.0, 0.0], [0.5, 0.0], [20.0, 0.0], [40.0, 0.0]])


def chances(least: float) -> Contrast:
    """Fifty views like none of four places, one of which is at best `least` times as unlike as the next."""
    contrast = Contrast()
    for k in range(50):
        contrast.learn(np.array([least + (1.0 - least) * k / 50, 1.0, 1.0, 1.1]), PLACES, 1.5)
    return contrast


def test_what_is_clearer_than_chance_speaks_for_a_place() -> None:
    assert chances(0.9).log_ratio(0.2, 0.8) > 2.0
    assert chances(0.9).log_ratio(0.7, 0.8) == 0.0


def test_where_places_have_doubles_nothing_is_clear() -> None:
    assert chances(0.2).log_ratio(0.2, 0.8) == 0.0
    assert Contrast().log_ratio(0.1, 0.8) == 0.0


@pytest.mark.parametrize(("aside", "sigma", "refused"), [(1.5, 5.0, True), (0.5, 5.0, False), (1.5, 0.35, False)])
def test_odometry_tells_what_lies_beside_where_views_do_not(aside: float, sigma: float, refused: bool) -> None:
    """The map, unsure by 1 m, has the spots 1.5 m apart: views alike over metres don't contradict it, others do."""
    claim = Claims.of_one(0, 1, Pose2(), np.diag([sigma, sigma, 0.07]) ** 2)
    poses = np.array([[0.0, 0.0, 0.0], [0.0, aside, 0.0]])
    knowledge = Knowledge.of_one(poses, np.diag([1.0, 1.0, 1e-4]))
    assert np.isneginf(Beside(0.8).weigh(claim, knowledge)[0]) == refused
    assert "apart by odometry" in Beside(0.8).reason(claim, knowledge)


@pytest.mark.parametrize(("sigma", "unsure", "aside"), [(0.35, 3.0, 0.0), (1.3, 0.6, 0.7), (5.0, 1.8, 0.1)])
def test_what_sight_and_odometry_leave_to_chance_is_no_closure(sigma: float, unsure: float, aside: float) -> None:
    """Against draws from where both together have the spot."""
    claim = Claims.of_one(0, 1, Pose2(), np.diag([sigma, sigma, 0.07]) ** 2)
    poses = np.array([[0.0, 0.0, 0.0], [0.0, aside, 0.0]])
    map_errors = np.diag([unsure, 0.6 * unsure, 0.0]) ** 2
    knowledge = Knowledge.of_one(poses, map_errors)
    covariance = np.linalg.inv(np.linalg.inv(map_errors[:2, :2]) + np.eye(2) / sigma**2)
    mean = covariance @ np.linalg.inv(map_errors[:2, :2]) @ [0.0, aside]
    drawn = np.random.default_rng(0).multivariate_normal(mean, covariance, 100_000)
    share = float((np.hypot(*drawn.T) < 1.0).mean())
    assert Placed(share - 0.01).weigh(claim, knowledge)[0] == 0.0
    assert np.isneginf(Placed(share + 0.01).weigh(claim, knowledge)[0])
    assert "sight and odometry don't tell where" in Placed(1.0).reason(claim, knowledge)
