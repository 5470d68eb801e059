"""How often claims are true, told by those that odometry refuses."""

from __future__ import annotations

import numpy as np
import pytest
from lapped import Lapped, lapped

from topomap.core.arrays import BoolArray, IntArray
from topomap.core.geometry import between
from topomap.mapping.closures.claims import Claims
from topomap.mapping.closures.odds import mahalanobis
from topomap.mapping.closures.prevalence import GATE, MOST, SAMPLE, allowed_by_chance, log_prevalence
from topomap.mapping.uncertainty.network import PathNetwork


def kinds(*parts: tuple[int, int, int]) -> tuple[IntArray, BoolArray]:
    """Size, how many odometry allows and how many it refuses: of each kind of cluster."""
    size = np.concatenate([np.full(kept + refused, size) for size, kept, refused in parts])
    allowed = np.concatenate([np.arange(kept + refused) < kept for _, kept, refused in parts])
    return size, allowed


def worth(*parts: tuple[int, int, int], by_chance: float = 0.0) -> dict[int, float]:
    size, allowed = kinds(*parts)
    found = log_prevalence(size, allowed, by_chance)
    return {s: float(found[size == s][0]) for s in np.unique(size).tolist()}


def odds(true: float, false: float) -> float:
    """Before any is seen there are one true claim and a tenth of a false one of each kind."""
    return float(np.log((true + 1.0) / (false + 0.1)))


def test_where_nothing_is_refused_claims_are_as_often_true_as_there_are_claims() -> None:
    found = worth((1, 20, 0), (5, 3, 0))
    assert found == {1: pytest.approx(odds(20, 0)), 5: pytest.approx(odds(3, 0))}
    assert log_prevalence(np.zeros(0, np.int64), np.zeros(0, bool), 0.0).shape == (0,)


def test_groups_of_false_claims_take_from_agreement_what_it_is_worth_and_lone_ones_do_not() -> None:
    clean = worth((1, 20, 0), (5, 20, 0))
    lone = worth((1, 20, 40), (5, 20, 0))
    grouped = worth((1, 20, 0), (5, 20, 40))
    assert lone[5] == clean[5]
    assert lone[1] == pytest.approx(odds(20, 40))
    assert grouped[1] == clean[1]
    assert grouped[5] == pytest.approx(odds(20, 40))


def test_those_refused_tell_how_many_of_those_allowed_are_false() -> None:
    """90 refused where one in ten passes by chance: 100 are false in all, so 10 of the 15 allowed."""
    assert worth((1, 15, 90), by_chance=0.1)[1] == pytest.approx(odds(5, 100))
    assert worth((1, 6, 90), by_chance=0.1)[1] == pytest.approx(odds(0, 100))  # never fewer than none


def test_kinds_are_seven_from_alone_to_many() -> None:
    """Refused clusters of one size tell of those sizes that are of their kind, and of no other."""
    same = [[1], [2], [3, 4], [5, 7], [8, 12], [13, 20], [21, 50]]
    for group in same:
        for size in group:
            found = worth(*[(other, 10, 30 if other == size else 0) for kind in same for other in kind])
            few = {other for other, value in found.items() if value == min(found.values())}
            assert few == set(group)


def asked(world: Lapped) -> tuple[Claims, PathNetwork, BoolArray, float]:
    """Claims, odometry, which claims are false, and the share of the false ones that odometry allows."""
    drive, claims, false = world.engine_input()
    odometry = PathNetwork.of_chain(drive.chain(drive.start()))
    chi2, _ = mahalanobis(claims, drive.poses, odometry.errors(claims.i, claims.j))
    return claims, odometry, false, float((chi2[false] <= GATE).mean())


def test_claims_that_odometry_allows_by_chance_are_counted_on_others_ends() -> None:
    """On a drive whose claims are all of different places and poses, the mixed ones are as false as any."""
    world = lapped(laps=2, every=1)
    drive, _, _ = world.engine_input()
    odometry = PathNetwork.of_chain(drive.chain(drive.start()))
    rng = np.random.default_rng(0)
    i, j = np.sort(rng.choice(len(drive.poses), (2, 300)), axis=0)
    apart = j - i >= 10
    far = np.column_stack([rng.uniform(-20, 20, (apart.sum(), 2)), rng.uniform(-3, 3, apart.sum())])
    wild = Claims.of(i[apart], j[apart], far, np.tile(np.diag([4.0, 4.0, 0.9]) ** 2, (len(far), 1, 1)))
    chi2, _ = mahalanobis(wild, drive.poses, odometry.errors(wild.i, wild.j))
    found = allowed_by_chance(wild, drive.poses, odometry)
    assert found == pytest.approx((chi2 <= GATE).mean(), rel=0.2)
    assert 0.05 < found < MOST
    wide = Claims.of(wild.i, wild.j, wild.relative, wild.covariance * 1e8)
    assert allowed_by_chance(wide, drive.poses, odometry) == MOST == 0.95


def test_true_claims_of_different_poses_are_false_of_one_anothers_places() -> None:
    drive, claims, _ = lapped(laps=2).engine_input()
    odometry = PathNetwork.of_chain(drive.chain(drive.start()))
    i = np.arange(0, 100, 3)
    j = i + 20 + i % 50
    true = Claims.of(i, j, between(drive.poses[i], drive.poses[j]), np.tile(claims.covariance[0], (len(i), 1, 1)))
    assert allowed_by_chance(true, drive.poses, odometry) < 0.2


def test_few_claims_and_many_are_counted() -> None:
    drive, claims, _ = lapped(laps=2).engine_input()
    odometry = PathNetwork.of_chain(drive.chain(drive.start()))
    assert allowed_by_chance(claims[:0], drive.poses, odometry) == 0.0
    assert allowed_by_chance(claims[:1], drive.poses, odometry) == 0.0
    many = claims[np.arange(SAMPLE + 5) % len(claims)]
    assert allowed_by_chance(many, drive.poses, odometry) == allowed_by_chance(many, drive.poses, odometry)


@pytest.mark.xfail(
    strict=True,
    reason="claims of place recognition all say about the same, and with another's claim the ends of a true one are "
    "true still: of 50 % random false ones odometry allows some 3 %, and 38 % are reckoned",
)
def test_the_share_allowed_by_chance_is_that_of_false_claims() -> None:
    world = lapped()
    claims, odometry, false, share = asked(world.alone(len(world.false)))
    assert false.any()
    found = allowed_by_chance(claims, world.graph.dead_reckoning(), odometry)
    assert found == pytest.approx(share, abs=0.1)
