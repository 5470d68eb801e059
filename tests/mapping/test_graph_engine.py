"""A pose graph through the engine: covariances that hold up to a factor, closures in any order."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from lapped import Lapped, lapped

from topomap.core.arrays import FloatArray
from topomap.evaluation.trajectory import ate
from topomap.mapping.closures.claims import Claims
from topomap.mapping.closures.closure_tests import TESTS, Knowledge
from topomap.mapping.graph_engine import GraphVerdicts, optimise_graph
from topomap.mapping.pose_graph import PoseGraph


def mixed(seed: int = 0) -> Lapped:
    return lapped(seed=seed).groups(10, 5, seed + 3).alone(75, seed + 4)


def restated(graph: PoseGraph, times: float) -> PoseGraph:
    return replace(graph, covariance=times * graph.covariance, odometry_covariance=times * graph.odometry_covariance)


def right(world: Lapped, found: GraphVerdicts) -> None:
    assert not found.inlier[world.false].any()
    assert found.inlier[~world.false].mean() >= 0.97
    assert ate(found.poses, world.truth) < 0.15


@pytest.mark.parametrize("times", [1.0, 100.0])
def test_verdicts_stand_in_the_order_of_the_file_whatever_its_covariances_state(times: float) -> None:
    world = mixed().shuffled(7)
    found = optimise_graph(restated(world.graph, times))
    right(world, found)
    assert len(found.inlier) == len(found.log_odds) == len(found.reason) == len(world.false)
    words = np.array(found.reason)
    assert (words[found.inlier] == "fits the map with all other closures").all()
    assert np.isneginf(found.log_odds[words == "odometry contradicts it"]).all()
    assert not (words[found.inlier] == "odometry contradicts it").any()


def test_the_order_of_the_file_changes_nothing() -> None:
    world = mixed(1)
    one = optimise_graph(world.graph)
    for seed in (1, 2):
        order = np.random.default_rng(seed).permutation(len(world.false))
        other = optimise_graph(world.shuffled(seed).graph)
        assert other.poses.tobytes() == one.poses.tobytes()
        assert np.array_equal(other.inlier, one.inlier[order])
        assert np.array_equal(other.log_odds, one.log_odds[order])
        assert other.reason == tuple(one.reason[k] for k in order)


def test_two_runs_agree_to_the_byte() -> None:
    graph = mixed(2).graph
    one, other = optimise_graph(graph), optimise_graph(graph)
    assert one.poses.tobytes() == other.poses.tobytes()
    assert one.log_odds.tobytes() == other.log_odds.tobytes()


def test_a_graph_without_closures_is_its_odometry() -> None:
    graph = lapped().but(np.zeros(0, np.int64)).graph
    found = optimise_graph(graph)
    assert found.poses.tobytes() == graph.dead_reckoning().tobytes()
    assert (found.inlier.shape, found.reason) == ((0,), ())
    assert found.kept == "odometry: nothing is claimed"


@pytest.mark.parametrize("size", [1, 5])
def test_a_graph_whose_closures_are_all_false_is_its_odometry(size: int) -> None:
    world = lapped(seed=1).but(np.zeros(0, np.int64)).groups(60 // size, size, 51)
    found = optimise_graph(world.graph)
    assert not found.inlier.any()
    assert found.poses.tobytes() == world.graph.dead_reckoning().tobytes()


class Nobody:
    """A test that refuses all."""

    name, lowers = "nobody", True

    def weigh(self, claims: Claims, knowledge: Knowledge) -> FloatArray:
        return np.full(len(claims), -np.inf)


def test_a_users_own_stages_are_the_engines() -> None:
    world = mixed()
    assert not optimise_graph(world.graph, tests=(*TESTS, Nobody())).inlier.any()


def test_progress_begins_with_the_noise_and_ends_at_one() -> None:
    heard: list[tuple[float, str]] = []
    optimise_graph(mixed().graph, lambda share, doing: heard.append((share, doing)))
    shares = [share for share, _ in heard]
    assert heard[0] == (0.0, "noise")
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
