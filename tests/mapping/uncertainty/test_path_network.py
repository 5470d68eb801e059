"""What the chain and the closures that stand know of two places, along the best path between them."""

from __future__ import annotations

import numpy as np
import pytest
from chains import HELD, UNSURE, chain_of, out_and_back, walk

from topomap.core.arrays import FloatArray, IntArray
from topomap.mapping.uncertainty.junctions import worth
from topomap.mapping.uncertainty.network import MANY, ROOTS, PathNetwork
from topomap.mapping.uncertainty.odometry_chain import Chain, carried_to_origin
from topomap.mapping.uncertainty.small import seen_from

SURE = np.diag([0.01, 0.02, 0.003]) ** 2


def places(*pairs: tuple[int, int]) -> tuple[IntArray, IntArray]:
    i, j = np.array(pairs, np.int64).reshape(-1, 2).T
    return np.ascontiguousarray(i), np.ascontiguousarray(j)


def linked(chain: Chain, pairs: list[tuple[int, int]], label: list[int], covariance: FloatArray = SURE) -> PathNetwork:
    return PathNetwork(chain, *places(*pairs), np.tile(covariance, (len(pairs), 1, 1)), np.array(label, np.int64))


def useless(chain: Chain) -> PathNetwork:
    """A network that has a closure, but one that no path is the better for: the searching code without its effect."""
    return linked(chain, [(0, len(chain.poses) - 1)], [0], np.diag([1e4, 1e4, 1e4]))


def in_frame(chain: Chain, errors: FloatArray, i: IntArray, j: IntArray) -> FloatArray:
    out = np.empty_like(errors)
    for n in range(len(i)):
        seen_from(errors[n], chain.poses[i[n], 2], *chain.poses[j[n], :2], out[n])
    return out


def across(chain: Chain, ends: tuple[int, int], covariance: FloatArray = SURE) -> FloatArray:
    a, b = (np.array([end]) for end in ends)
    carry = carried_to_origin(chain.poses[a], chain.poses[b])[0]
    return np.asarray(carry @ covariance @ carry.T)


@pytest.mark.parametrize("calibration", [HELD, UNSURE])
@pytest.mark.parametrize("search", [False, True])
def test_along_the_chain_the_errors_are_the_chains_own(calibration: FloatArray, search: bool) -> None:
    chain = walk(60, 3, calibration)
    i, j = places((0, 59), (5, 6), (40, 12), (59, 0), (7, 7))
    network = useless(chain) if search else PathNetwork.of_chain(chain)
    expected = chain.covariance(i, j)
    assert np.allclose(in_frame(chain, network.errors(i, j), i, j), expected, rtol=1e-9, atol=1e-12)
    if not search:
        assert np.allclose(in_frame(chain, network.upper_bounds(i, j), i, j), expected, rtol=1e-9, atol=1e-12)


def test_a_closure_is_used_from_either_end_where_it_is_better() -> None:
    chain = walk(80, 1)
    network = linked(chain, [(10, 70)], [0])
    i, j = places((8, 73), (73, 8), (12, 68), (30, 35), (10, 70))
    expected = [
        (chain.random[10] - chain.random[8]) + across(chain, (10, 70)) + (chain.random[73] - chain.random[70]),
        (chain.random[10] - chain.random[8]) + across(chain, (10, 70)) + (chain.random[73] - chain.random[70]),
        (chain.random[12] - chain.random[10]) + across(chain, (10, 70)) + (chain.random[70] - chain.random[68]),
        chain.random[35] - chain.random[30],
        across(chain, (10, 70)),
    ]
    assert np.allclose(network.errors(i, j), expected, rtol=1e-9, atol=1e-12)


def test_a_path_may_lead_over_several_closures() -> None:
    chain = walk(90, 2)
    network = linked(chain, [(5, 50), (50, 85)], [0, 1])
    expected = across(chain, (5, 50)) + across(chain, (50, 85))
    assert np.allclose(network.errors(*places((5, 85))), expected, rtol=1e-9, atol=1e-12)


def test_the_best_path_is_the_one_with_the_least_variance_of_heading() -> None:
    """A closure that is sure of the place and not of the heading isn't used, one the other way round is."""
    chain = walk(80, 1)
    way = chain.random[70, 2, 2] - chain.random[10, 2, 2]
    i, j = places((10, 70))
    turned = linked(chain, [(10, 70)], [0], np.diag([1e-6, 1e-6, 1.1 * way]))
    assert np.allclose(turned.errors(i, j)[0], chain.random[70] - chain.random[10])
    moved = np.diag([100.0, 100.0, 0.9 * way])
    assert np.allclose(linked(chain, [(10, 70)], [0], moved).errors(i, j)[0], across(chain, (10, 70), moved))


def test_closures_of_a_label_can_be_left_out() -> None:
    chain = walk(80, 1)
    network = linked(chain, [(10, 70), (11, 71), (12, 66)], [4, 4, 7])
    i, j = places((10, 70), (10, 70), (10, 70))
    both, other, none = network.errors(i, j, np.array([-1, 4, 7]))
    assert np.allclose(both, across(chain, (10, 70)))
    around = (chain.random[12] - chain.random[10]) + across(chain, (12, 66)) + (chain.random[70] - chain.random[66])
    assert np.allclose(other, around)
    assert np.allclose(none, across(chain, (10, 70)))
    assert np.allclose(network.errors(i, j)[0], both)
    bare = linked(chain, [(10, 70)], [4]).errors(i[:1], j[:1], np.array([4]))
    assert np.allclose(bare[0], chain.random[70] - chain.random[10])


def test_a_search_leaves_nothing_behind_for_the_next() -> None:
    chain = walk(60, 4)
    network = linked(chain, [(3, 40), (20, 55)], [0, 1])
    i, j = places(*[(a, b) for a in range(0, 60, 7) for b in range(0, 60, 5)])
    together = network.errors(i, j)
    alone = np.concatenate([network.errors(i[n : n + 1], j[n : n + 1]) for n in range(len(i))])
    assert np.array_equal(together, alone)
    assert np.array_equal(together, network.errors(i, j))


@pytest.mark.parametrize("seed", range(6))
def test_bounds_know_no_more_of_the_heading_than_the_best_path(seed: int) -> None:
    rng = np.random.default_rng(seed)
    chain = walk(30 * ROOTS, seed)  # most places are no root
    ends = np.sort(rng.integers(0, len(chain.poses), (40, 2)), axis=1)
    ends = ends[ends[:, 1] > ends[:, 0]]
    network = linked(chain, [(a, b) for a, b in ends.tolist()], [0] * len(ends))
    i, j = rng.integers(0, len(chain.poses), (2, 300))
    exact, bound = network.errors(i, j)[:, 2, 2], network.upper_bounds(i, j)[:, 2, 2]
    assert (bound >= exact * (1 - 1e-12)).all()
    assert (bound > exact * 1.01).any()  # or it is no bound but the thing itself
    along = PathNetwork.of_chain(chain).errors(i, j)[:, 2, 2]
    far = np.abs(i - j) > 10 * ROOTS
    assert np.median(bound[far] / along[far]) < 0.9  # and worth having beside the chain alone


def test_bounds_from_a_root_are_the_best_paths_themselves() -> None:
    chain = walk(ROOTS, 5)  # every place is a root
    network = linked(chain, [(2, 20), (4, 15)], [0, 1])
    i, j = places(*[(a, b) for a in range(ROOTS) for b in range(ROOTS)])
    assert np.allclose(network.upper_bounds(i, j), network.errors(i, j), rtol=1e-9, atol=1e-12)


def along(chain: Chain, *parts: tuple[int, int]) -> FloatArray:
    """What the calibration does along stretches from one place to another, the sign told by the direction."""
    return np.asarray(sum(chain.systematic[b] - chain.systematic[a] for a, b in parts))


def test_what_a_calibration_does_adds_up_with_its_sign() -> None:
    """Over a closure the stretch behind it may be driven the other way: then it takes back what the first brought."""
    chain = walk(80, 1, UNSURE)
    network = linked(chain, [(40, 60)], [0])
    i, j = places((30, 55), (55, 30), (30, 65))
    for n, (a, b) in enumerate([((30, 40), (60, 55)), ((55, 60), (40, 30)), ((30, 40), (60, 65))]):
        shared = along(chain, a, b)
        apart = sum(chain.random[max(part)] - chain.random[min(part)] for part in (a, b))
        expected = apart + across(chain, (40, 60)) + shared @ UNSURE @ shared.T
        assert np.allclose(network.errors(i, j)[n], expected, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("by", ["errors", "upper_bounds"])
def test_out_and_back_a_wrong_distance_scale_cancels(by: str) -> None:
    """Places k and 39 - k are one. What a distance scale brings on the way out it takes back on the way home."""
    scale = np.diag([0.0, 0.0, 0.1]) ** 2
    chain, without = out_and_back(20, scale), out_and_back(20)
    i, j = places((0, 39), (0, 19))
    for make in (PathNetwork.of_chain, useless):
        there = in_frame(chain, getattr(make(chain), by)(i, j), i, j)
        known = in_frame(without, getattr(make(without), by)(i, j), i, j)
        assert np.allclose(there[0], known[0], rtol=1e-6, atol=1e-9)
        assert there[1, 0, 0] - known[1, 0, 0] == pytest.approx(19.0**2 * 0.01, rel=1e-6)


def test_paths_know_their_systematic_heading_though_each_step_has_none_of_its_own() -> None:
    """With an unsure curvature a closure with less heading than the way is used, whatever the steps' own noise is."""
    curve = np.diag([0.0, 0.1, 0.0]) ** 2
    steps = np.tile([1.0, 0.0, 0.0], (40, 1))
    chain = chain_of(steps, np.tile(np.diag([1e-8] * 3), (40, 1, 1)), curve)
    claim = np.diag([0.1, 0.1, 0.1]) ** 2
    network = linked(chain, [(0, 40)], [0], claim)
    assert network.errors(*places((0, 40)))[0, 2, 2] == pytest.approx(0.01, rel=1e-6)
    assert PathNetwork.of_chain(chain).errors(*places((0, 40)))[0, 2, 2] == pytest.approx(16.0, rel=1e-3)


def test_bounds_hold_where_a_step_adds_too_little_to_be_counted() -> None:
    """After a gap in the odometry the variance of heading is so large that exact steps don't change it at all."""
    steps = np.tile([1.0, 0.0, 0.0], (400, 1))
    noise = np.tile(np.diag([0.01, 0.01, 0.0]), (400, 1, 1))
    noise[0, 2, 2] = 25.0
    chain = chain_of(steps, noise)
    i, j = places(*[(0, k) for k in range(1, 401, 13)])
    expected = PathNetwork.of_chain(chain).errors(i, j)
    assert np.allclose(useless(chain).errors(i, j), expected, rtol=1e-9)
    assert np.allclose(useless(chain).upper_bounds(i, j), expected, rtol=1e-9)


def test_a_path_is_chosen_by_what_the_calibration_does_to_all_of_it() -> None:
    """40 steps of 0.1 rad/m curvature, all in one direction, are 16 rad^2; a closure of 0.9 rad^2 is better."""
    curve = np.diag([0.0, 0.1, 0.0]) ** 2
    steps = np.tile([1.0, 0.0, 0.0], (40, 1))
    chain = chain_of(steps, np.tile(np.diag([1e-8] * 3), (40, 1, 1)), curve)
    network = linked(chain, [(0, 40)], [0], np.diag([0.1, 0.1, 0.9]))
    assert network.errors(*places((0, 40)))[0, 2, 2] <= 0.9 * (1 + 1e-9)


def test_bounds_are_no_smaller_than_the_errors_with_an_unsure_calibration() -> None:
    chain = walk(240, 0, UNSURE)
    rng = np.random.default_rng(0)
    ends = np.sort(rng.integers(0, 240, (20, 2)), axis=1)
    network = linked(chain, ends[ends[:, 1] > ends[:, 0]].tolist(), [0] * int((ends[:, 1] > ends[:, 0]).sum()))
    i, j = rng.integers(0, 240, (2, 200))
    exact, bound = network.errors(i, j)[:, 2, 2], network.upper_bounds(i, j)[:, 2, 2]
    assert (bound >= exact * (1 - 1e-9)).all()


@pytest.mark.parametrize("label", [-1, 0])
def test_searches_that_look_where_they_go_find_the_same_paths(label: int) -> None:
    """Of many paths asked for at once landmarks show the way; closed closures only make them longer."""
    rng, chain = np.random.default_rng(7), walk(400, 7)
    ends = np.sort(rng.integers(0, 400, (60, 2)), axis=1)
    ends = ends[ends[:, 1] > ends[:, 0]]
    network = linked(chain, [(a, b) for a, b in ends.tolist()], (np.arange(len(ends)) % 3).tolist())
    i, j = rng.integers(0, 400, (2, MANY))
    without = np.full(MANY, label)
    few = [network.errors(i[part], j[part], without[part]) for part in np.array_split(np.arange(MANY), 5)]
    assert np.allclose(network.errors(i, j, without), np.concatenate(few), rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("closures", [1, 7, 40])
def test_by_junctions_paths_are_those_of_a_search_each(monkeypatch: pytest.MonkeyPatch, closures: int) -> None:
    rng = np.random.default_rng(closures)
    chain = walk(300, 4, HELD)
    ends = [(int(a), int(b)) for a, b in np.sort(rng.choice(300, (closures, 2), replace=True), axis=1) if a < b]
    label = list(range(len(ends)))
    covariances = [SURE * rng.uniform(0.2, 3.0) for _ in ends]
    network, one_by_one = (
        PathNetwork(chain, *places(*ends), np.array(covariances), np.array(label, np.int64)) for _ in range(2)
    )
    i, j = rng.integers(0, 300, (2, 2000))
    i[:5], j[:5] = [0, 299, 7, ends[0][0], ends[0][0]], [299, 0, 7, ends[0][1], 3]
    assert worth(len(i), len(np.unique(ends)), len(ends))
    found = network.errors(i, j)
    monkeypatch.setattr("topomap.mapping.uncertainty.network.worth", lambda *_: False)
    assert np.allclose(found, one_by_one.errors(i, j), rtol=1e-9, atol=1e-15)
    assert (found[:, 2, 2] < chain.random[:, 2, 2][np.maximum(i, j)] - chain.random[:, 2, 2][np.minimum(i, j)]).any()
