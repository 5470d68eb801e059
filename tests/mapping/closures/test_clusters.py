"""Clusters: neighbouring claims that agree are one piece of evidence."""

from __future__ import annotations

import numpy as np
import pytest
from chains import chain_of, walk
from lapped import lapped

from topomap.core.arrays import FloatArray
from topomap.core.geometry import between, compose
from topomap.mapping.closures.claims import Claims
from topomap.mapping.closures.clusters import AGREE, STRIDE, WINDOW, clusters_of, loops_of
from topomap.mapping.uncertainty.odometry_chain import Chain

SURE = np.diag([0.05, 0.05, 0.02]) ** 2


def claims_at(chain: Chain, pairs: list[tuple[int, int]], off: FloatArray | None = None) -> Claims:
    """Claims in order, right to the letter but for an offset (3,) that all share as odometry carries it on."""
    i, j = np.array(sorted(pairs), np.int64).T
    relative = between(chain.poses[i], chain.poses[j])
    if off is not None:
        relative = compose(np.broadcast_to(off, relative.shape), relative)
    return Claims.of(np.ascontiguousarray(i), np.ascontiguousarray(j), relative, np.tile(SURE, (len(i), 1, 1)))


def joined(a: Claims, b: Claims) -> Claims:
    parts = [np.concatenate([getattr(a, name), getattr(b, name)]) for name in ("i", "j", "relative", "covariance")]
    order = np.lexsort((parts[1], parts[0]))
    return Claims.of(*(part[order] for part in parts))


def test_neighbours_that_agree_are_one_cluster_and_who_does_not_is_alone() -> None:
    chain = walk(80, 1)
    right = claims_at(chain, [(10, 50), (12, 52), (14, 54)])
    wrong = claims_at(chain, [(11, 51)], np.array([3.0, 0.0, 0.0]))
    found = clusters_of(joined(right, wrong), chain)
    assert found.label[0] == found.label[2] == found.label[3] != found.label[1]
    assert len(found) == 2
    assert found.size[found.label].tolist() == [3, 1, 3, 3]


def test_false_claims_that_agree_are_a_cluster_of_their_own() -> None:
    chain = walk(80, 1)
    right = claims_at(chain, [(10, 50), (12, 52)])
    wrong = claims_at(chain, [(11, 51), (13, 53)], np.array([3.0, 0.0, 0.0]))
    found = clusters_of(joined(right, wrong), chain)
    assert found.size.tolist() == [2, 2]


@pytest.mark.parametrize(("apart", "count"), [(WINDOW, 1), (WINDOW + 1, 2)])
@pytest.mark.parametrize("end", ["i", "j"])
def test_neighbours_are_up_to_five_places_apart_at_both_ends(apart: int, count: int, end: str) -> None:
    assert WINDOW == 5
    chain = walk(80, 2)
    other = (10 + apart, 50) if end == "i" else (10, 50 + apart)
    assert len(clusters_of(claims_at(chain, [(10, 50), other]), chain)) == count


def test_clusters_grow_along_a_chain_of_neighbours() -> None:
    chain = walk(80, 3)
    pairs = [(5 + 4 * k, 45 + 4 * k) for k in range(8)]
    assert clusters_of(claims_at(chain, pairs), chain).size.tolist() == [8]
    without = [pair for pair in pairs if pair[0] not in (17, 21)]
    assert clusters_of(claims_at(chain, without), chain).size.tolist() == [3, 3]


@pytest.mark.parametrize(("sigmas", "count"), [(3.9, 1), (4.2, 2)])
def test_claims_agree_up_to_what_one_right_loop_in_a_thousand_misses_by(sigmas: float, count: int) -> None:
    """Along a straight line with odometry that is as good as exact, two claims miss by the root of both variances."""
    steps = np.tile([1.0, 0.0, 0.0], (60, 1))
    chain = chain_of(steps, np.tile(1e-12 * np.eye(3), (60, 1, 1)))
    claims = claims_at(chain, [(10, 40), (11, 41)])
    claims.relative[1, 0] += sigmas * np.sqrt(2) * 0.05
    assert len(clusters_of(claims, chain)) == count
    missed = loops_of(claims, chain, np.arange(2), np.inf)[2]
    assert missed == pytest.approx(sigmas**2, rel=1e-6)
    assert (missed[0] <= AGREE) == (count == 1)


def test_a_cluster_has_one_representative_every_eight_places_of_i() -> None:
    assert STRIDE == 8
    chain = walk(120, 4)
    claims = claims_at(chain, [(k, k + 60) for k in range(0, 40, 2)])
    found = clusters_of(claims, chain)
    assert len(found) == 1
    assert (claims.i[found.representatives] // STRIDE).tolist() == [0, 1, 2, 3, 4]


def test_the_representative_is_the_one_most_others_agree_with() -> None:
    """The middle one of three agrees with both, the outer ones are too far from one another."""
    chain = walk(80, 5)
    claims = claims_at(chain, [(8, 40), (11, 44), (15, 48)])
    found = clusters_of(claims, chain)
    assert found.size.tolist() == [3]
    assert claims.i[found.representatives].tolist() == [11]
    level = claims_at(chain, [(8, 40), (11, 44)])
    assert level.i[clusters_of(level, chain).representatives].tolist() == [8]  # the first, whenever they are level


def test_clusters_that_share_places_have_representatives_of_their_own() -> None:
    chain = walk(80, 6)
    right = claims_at(chain, [(16, 50), (17, 51)])
    wrong = claims_at(chain, [(18, 52), (19, 53)], np.array([3.0, 0.0, 0.0]))
    found = clusters_of(joined(right, wrong), chain)
    assert sorted(found.label[found.representatives].tolist()) == [0, 1]


def test_no_claims_make_no_clusters() -> None:
    chain = walk(20, 7)
    none = claims_at(chain, [(3, 10)])[:0]
    found = clusters_of(none, chain)
    assert (len(found), len(found.label), len(found.representatives)) == (0, 0, 0)


def test_the_same_claim_twice_is_not_two_that_agree() -> None:
    chain = walk(40, 8)
    assert clusters_of(claims_at(chain, [(3, 20), (3, 20)]), chain).size.tolist() == [1, 1]


@pytest.mark.parametrize("seed", range(3))
def test_on_a_lapped_drive_no_cluster_mixes_true_and_false(seed: int) -> None:
    drive, claims, false = lapped(seed=seed).groups(10, 5, seed).alone(60, seed).engine_input()
    found = clusters_of(claims, drive.chain(drive.start()))
    mixed = np.bincount(found.label, false) / found.size
    assert set(mixed.tolist()) == {0.0, 1.0}
    assert (found.size[found.label[false]] >= 5).sum() >= 50  # each group is one cluster, a lone one may join it
