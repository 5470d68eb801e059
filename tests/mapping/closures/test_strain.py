"""Which closures strain a map: many small misses in one direction, that no single one of them would show."""

from __future__ import annotations

import numpy as np
import pytest

from topomap.core.arrays import FloatArray, IntArray
from topomap.core.geometry import between
from topomap.mapping.closures.claims import Claims
from topomap.mapping.closures.clusters import STRIDE
from topomap.mapping.closures.strain import STRAIN, strained
from topomap.mapping.uncertainty.network import PathNetwork
from topomap.mapping.uncertainty.odometry_chain import Chain

SIGMAS = np.array([0.05, 0.05, 0.02])


def bent(places: int = 200, turn: float = 0.05) -> FloatArray:
    heading = turn * np.arange(places)
    steps = np.column_stack([np.cos(heading), np.sin(heading)])
    return np.column_stack([np.cumsum(steps, axis=0), heading])


def missing(poses: FloatArray, i: IntArray, j: IntArray, off: FloatArray, sigmas: FloatArray = SIGMAS) -> Claims:
    """Claims that miss by `off` (3,) or (n, 3), in the map's axes."""
    off = np.broadcast_to(off, (len(i), 3))
    c, s = np.cos(poses[i, 2]), np.sin(poses[i, 2])
    own = np.column_stack([c * off[:, 0] + s * off[:, 1], c * off[:, 1] - s * off[:, 0], off[:, 2]])
    spread = np.tile(np.diag(sigmas**2), (len(i), 1, 1))
    return Claims.of(i, j, between(poses[i], poses[j]) - own, spread)


def exact(poses: FloatArray, per_step: float = 0.0) -> PathNetwork:
    """A network of odometry that is exact, or has some variance a step [m^2, rad^2] about the origin."""
    grown = per_step * np.arange(len(poses))[:, None, None] * np.eye(3)
    chain = Chain(poses, np.arange(len(poses), dtype=float), grown, np.zeros_like(grown), np.zeros((3, 3)))
    return PathNetwork.of_chain(chain)


def found(poses: FloatArray, claims: Claims, label: IntArray | None = None) -> list[bool]:
    names = np.zeros(len(claims), np.int64) if label is None else label
    return strained(poses, claims, names, np.arange(len(claims)), exact(poses)).tolist()


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize(("sigmas", "expected"), [(3.9, False), (4.2, True)])
def test_a_single_closure_strains_when_it_misses_by_more_than_one_in_a_thousand_does(
    axis: int, sigmas: float, expected: bool
) -> None:
    poses = bent()
    off = sigmas * SIGMAS * (np.arange(3) == axis)
    assert found(poses, missing(poses, np.array([20]), np.array([150]), off)) == [expected]
    assert (sigmas**2 > STRAIN) == expected


@pytest.mark.parametrize(("sigmas", "expected"), [(1.9, False), (2.1, True)])
def test_the_mean_of_four_is_held_against_half_the_noise(sigmas: float, expected: bool) -> None:
    poses, k = bent(turn=0.0), np.arange(4)
    claims = missing(poses, 16 + k, 100 + k, np.array([sigmas * SIGMAS[0], 0.0, 0.0]))
    assert found(poses, claims) == [expected]
    scattered = missing(poses, 16 + k, 100 + k, sigmas * np.outer([1, -1, 1, -1], SIGMAS * [1, 0, 0]))
    assert found(poses, scattered) == [False]


def test_what_members_miss_by_is_added_up_in_the_maps_axes() -> None:
    """On the way round a bend they miss to the same side of the map, each to another side of its own."""
    poses, k = bent(turn=0.4), np.arange(8)
    claims = missing(poses, 16 + k, 100 + k, np.array([2.2 * SIGMAS[0], 0.0, 0.0]))
    assert found(poses, claims) == [True]
    own = Claims.of(claims.i, claims.j, between(poses[claims.i], poses[claims.j]), claims.covariance)
    own.relative[:, 0] -= 2.2 * SIGMAS[0]  # to the front of each, which turns by 2.8 rad
    assert found(poses, own) == [False]


def test_a_turn_is_carried_to_the_place_where_the_misses_are_added_up() -> None:
    """Eight claims that place one rigid, turned piece: about its first place it is turned and not moved."""
    poses, k = bent(turn=0.1), np.arange(8)
    turned, there = 1.1 * SIGMAS[2], 133 + k  # a stretch across both axes
    lever = poses[there, :2] - poses[there[0], :2]
    off = np.column_stack([-turned * lever[:, 1], turned * lever[:, 0], np.full(8, turned)])
    assert found(poses, missing(poses, 16 + k, there, off)) == [False]  # 1.1 sigmas of turn: chi-squared is 9.7
    assert found(poses, missing(poses, 16 + k, there, off * [-1.0, 1.0, 1.0])) == [True]
    assert found(poses, missing(poses, 16 + k, there, off * [1.0, -1.0, 1.0])) == [True]


def test_blind_claims_are_held_against_their_places_alone() -> None:
    poses, k = bent(turn=0.0), np.arange(8)
    unknown = np.array([0.05, 0.05, 1.05])  # just more than what is called unknown
    turned = missing(poses, 16 + k, 100 + k, np.array([0.0, 0.0, 2.0]), unknown)
    assert turned.blind.all()
    assert found(poses, turned) == [False]
    assert found(poses, missing(poses, 16 + k, 100 + k, np.array([0.08, 0.0, 2.0]), unknown)) == [True]


def test_what_is_unsure_ahead_is_unsure_aside_on_a_way_across() -> None:
    poses = bent(turn=0.0)
    poses[:, 2] = np.pi / 2
    long = np.array([0.2, 0.05, 0.02])  # a claim is unsure ahead, which is up in the map
    i, j = np.array([20]), np.array([150])
    assert found(poses, missing(poses, i, j, np.array([0.0, 0.3, 0.0]), long)) == [False]
    assert found(poses, missing(poses, i, j, np.array([0.3, 0.0, 0.0]), long)) == [True]


def test_clusters_are_judged_apart_and_one_strained_stretch_is_enough() -> None:
    poses = bent(turn=0.0)
    k = np.arange(3 * STRIDE)
    off = np.zeros((len(k), 3))
    off[STRIDE : 2 * STRIDE, 0] = 1.8 * SIGMAS[0]  # one stretch of eight places, a little
    claims = missing(poses, 16 + k, 100 + k, off)
    assert found(poses, claims) == [True]
    spread_out = missing(poses, 16 + k, 100 + k, off / 3)
    assert found(poses, spread_out) == [False]
    two = np.concatenate([claims.i, claims.i]), np.concatenate([claims.j, claims.j + 30])
    both = missing(poses, *two, np.concatenate([off, np.zeros_like(off)]))
    label = np.repeat([1, 0], len(k))
    assert found(poses, both, label) == [False, True]


def test_only_closures_that_stand_strain() -> None:
    poses, k = bent(turn=0.0), np.arange(4)
    claims = missing(poses, 16 + k, 100 + k, np.outer([0, 50, 0, 0], SIGMAS * [1, 0, 0]))
    label = np.array([0, 2, 0, 1])
    assert strained(poses, claims, label, np.array([0, 2, 3]), exact(poses)).tolist() == [False, False, False]
    assert strained(poses, claims, label, np.array([0, 1, 2, 3]), exact(poses)).tolist() == [False, False, True]
    assert strained(poses, claims, label, np.zeros(0, np.int64), exact(poses)).tolist() == [False, False, False]
    assert strained(poses, claims[:0], label[:0], np.zeros(0, np.int64), exact(poses)).tolist() == []


def test_a_miss_across_the_back_is_a_small_one() -> None:
    poses = bent(turn=0.0)
    poses[100:, 2] = np.pi - 0.001
    claims = missing(poses, np.array([20]), np.array([150]), np.zeros(3))
    claims.relative[0, 2] = -np.pi + 0.001
    assert found(poses, claims) == [False]


@pytest.mark.parametrize(("sigmas", "expected"), [(0.95, False), (1.05, True)])
def test_a_closure_that_bent_the_map_would_miss_by_more_without_itself(sigmas: float, expected: bool) -> None:
    """The rest has 15 times the claim's variance, so a sixteenth of a miss is left in the map."""
    poses = bent(turn=0.0)
    poses[150, :2] = 0.0  # at the origin, where a turn moves nothing
    i, j = np.array([20]), np.array([150])
    claims = missing(poses, i, j, np.array([sigmas * np.sqrt(STRAIN / 16) * SIGMAS[0], 0.0, 0.0]))
    rest = exact(poses, 15 * SIGMAS[0] ** 2 / 130)
    assert strained(poses, claims, np.zeros(1, np.int64), np.arange(1), rest).tolist() == [expected]
    assert strained(poses, claims, np.zeros(1, np.int64), np.arange(1), exact(poses)).tolist() == [False]


def test_what_the_rest_knows_is_without_the_cluster_itself() -> None:
    poses = bent(turn=0.0)
    poses[150, :2] = 0.0
    grown = 1e-2 * np.arange(len(poses))[:, None, None] * np.eye(3)
    chain = Chain(poses, np.arange(len(poses), dtype=float), grown, np.zeros_like(grown), np.zeros((3, 3)))
    i, j = np.array([20]), np.array([150])
    claims = missing(poses, i, j, np.array([SIGMAS[0], 0.0, 0.0]))
    itself = PathNetwork(chain, i, j, claims.covariance, np.zeros(1, np.int64))
    assert strained(poses, claims, np.zeros(1, np.int64), np.arange(1), itself).tolist() == [True]


def test_a_blind_claims_heading_says_nothing_beside_one_that_knows_its_own() -> None:
    poses, k = bent(turn=0.0), np.arange(8)
    blind = missing(poses, 16 + k, 100 + k, np.array([0.0, 0.0, 2.0]), np.array([0.05, 0.05, 1.05]))
    other = missing(poses, np.array([60]), np.array([170]), np.zeros(3))
    parts = [np.concatenate([getattr(blind, n), getattr(other, n)]) for n in ("i", "j", "relative", "covariance")]
    assert found(poses, Claims.of(*parts), np.repeat([0, 1], [8, 1])) == [False, False]
