"""Loops through two claims: what they miss of closing by, and which are looked for."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from chains import out_and_back, walk

from topomap.core.arrays import FloatArray, IntArray
from topomap.core.geometry import between, compose, wrap_all
from topomap.mapping.closures.agreement_kernels import loop_distance2, short_loops
from topomap.mapping.closures.claims import Claims
from topomap.mapping.closures.clusters import loops_of
from topomap.mapping.uncertainty.odometry_chain import Chain

FAR = 1e9
ANY = 40.0  # variance of an unknown heading


def claims_on(chain: Chain, i: list[int], j: list[int], seed: int = 0, noise: float = 1.0) -> Claims:
    """True claims with noise, each with correlations of its own."""
    rng = np.random.default_rng(seed)
    ends = np.array(i, np.int64), np.array(j, np.int64)
    root = rng.normal(size=(len(i), 3, 3)) * np.array([0.1, 0.1, 0.05])[:, None]
    off = noise * (root @ rng.normal(size=(len(i), 3, 1)))[:, :, 0]
    relative = between(chain.poses[ends[0]], chain.poses[ends[1]]) + off
    return Claims.of(*ends, relative, root @ root.transpose(0, 2, 1) + 1e-6 * np.eye(3))


def blinded(claims: Claims) -> Claims:
    covariance = claims.covariance.copy()
    covariance[:, 2, :] = covariance[:, :, 2] = 0.0
    covariance[:, 2, 2] = ANY
    return Claims.of(claims.i, claims.j, claims.relative * [1.0, 1.0, 0.0], covariance)


def distance(claims: Claims, chain: Chain, a: int, b: int, turned: float = 0.0, limit: float = FAR) -> float:
    args = (claims.i, claims.j, claims.relative, claims.covariance, claims.blind, chain.poses, chain.random)
    return float(loop_distance2(*args, a, b, turned, limit))


def slow_distance(claims: Claims, chain: Chain, a: int, b: int, turned: float | None = None) -> float:
    """The same by numbers: the gap between both ways round, moved by each of its four parts' errors in turn.

    turned: the heading that both claims are taken to have if it isn't known, which then doesn't count.
    """
    i, j = claims.i, claims.j
    parts = [
        claims.relative[a].copy(),
        between(chain.poses[j[a]], chain.poses[j[b]]),
        between(chain.poses[i[a]], chain.poses[i[b]]),
        claims.relative[b].copy(),
    ]
    spreads = [
        claims.covariance[a].copy(),
        chain.covariance(j[[a]], j[[b]])[0],
        chain.covariance(i[[a]], i[[b]])[0],
        claims.covariance[b].copy(),
    ]
    if turned is not None:
        for part, spread in ((parts[0], spreads[0]), (parts[3], spreads[3])):
            part[2] = turned
            spread[2, :] = spread[:, 2] = 0.0
    gap, total, step = _gap(parts), np.zeros((3, 3)), 1e-6
    for n, spread in enumerate(spreads):
        jacobian = np.empty((3, 3))
        for axis in range(3):
            moved = [part.copy() for part in parts]
            moved[n][axis] += step
            jacobian[:, axis] = (_gap(moved) - gap) / step
        total += jacobian @ spread @ jacobian.T
    dof = 3 if turned is None else 2
    return float(gap[:dof] @ np.linalg.solve(total[:dof, :dof], gap[:dof]))


def _gap(parts: list[FloatArray]) -> FloatArray:
    gap = compose(parts[2], parts[3]) - compose(parts[0], parts[1])
    gap[2] = wrap_all(gap[2])
    return np.asarray(gap)


@pytest.mark.parametrize("seed", range(4))
def test_a_loop_misses_by_what_its_four_parts_allow(seed: int) -> None:
    chain = walk(80, seed)
    claims = claims_on(chain, [10, 13, 14, 15, 10], [60, 57, 66, 60, 61], seed, noise=2.0)
    for a, b in combinations(range(len(claims)), 2):
        expected = slow_distance(claims, chain, a, b)
        assert distance(claims, chain, a, b) == pytest.approx(expected, rel=1e-4)
        # it is the same loop the other way round, seen from its other corner
        assert distance(claims, chain, b, a) == pytest.approx(expected, rel=0.2)


def test_true_loops_miss_by_chi_squared_of_three_degrees() -> None:
    """Odometry's own errors count as well: the chain's poses are off by them."""
    chain, rng = walk(6, 1), np.random.default_rng(0)
    found = []
    for seed in range(1500):
        claims = claims_on(chain, [0, 2], [3, 5], seed)
        moved = chain.poses.copy()
        for stretch in ((0, 2), (3, 5)):
            root = np.linalg.cholesky(chain.covariance(*[np.array([k]) for k in stretch])[0])
            true = between(moved[stretch[0]], moved[stretch[1]])
            moved[stretch[1]] = compose(moved[stretch[0]], true + root @ rng.normal(size=3))
        drifted = Chain(moved, chain.travelled, chain.random, chain.systematic, chain.calibration)
        found.append(distance(claims, drifted, 0, 1))
    assert np.mean(found) == pytest.approx(3.0, rel=0.1)
    assert np.mean(np.array(found) <= 16.3) > 0.997


def test_blind_claims_close_forward_or_reversed() -> None:
    chain = out_and_back(20)
    back = blinded(claims_on(chain, [5, 8], [34, 31], 1))  # the way home: the same places, looked at backwards
    assert distance(back, chain, 0, 1, np.pi) < 12.0
    assert distance(back, chain, 0, 1, np.pi) == pytest.approx(slow_distance(back, chain, 0, 1, np.pi), rel=1e-4)
    assert distance(back, chain, 0, 1, 0.0) > 100.0
    assert distance(back, chain, 0, 1, 0.0) == pytest.approx(slow_distance(back, chain, 0, 1, 0.0), rel=1e-4)


@pytest.mark.parametrize("which", [0, 1])
def test_one_blind_claim_makes_both_blind(which: int) -> None:
    chain = walk(80, 2)
    sure, some = claims_on(chain, [10, 13], [60, 57], 2), np.arange(2) == which
    blind = blinded(sure)
    mixed = Claims.of(
        sure.i,
        sure.j,
        np.where(some[:, None], blind.relative, sure.relative),
        np.where(some[:, None, None], blind.covariance, sure.covariance),
    )
    assert distance(mixed, chain, 0, 1, 0.3) == pytest.approx(slow_distance(mixed, chain, 0, 1, 0.3), rel=1e-4)


def test_beyond_the_limit_only_more_is_told_and_within_it_nothing_changes() -> None:
    chain = walk(80, 3)
    claims = claims_on(chain, [10, 13], [60, 57], 3, noise=2.0)
    exact = distance(claims, chain, 0, 1)
    assert distance(claims, chain, 0, 1, limit=exact * 1.01) == exact
    assert distance(claims, chain, 0, 1, limit=exact * 0.5) > exact * 0.5
    turned = Claims.of(claims.i, claims.j, claims.relative + np.array([[0, 0, 0], [0, 0, 2.0]]), claims.covariance)
    assert np.isinf(distance(turned, chain, 0, 1, limit=16.3))
    assert np.isfinite(distance(turned, chain, 0, 1))


def found_loops(claims: Claims, chain: Chain, window: int, asked: IntArray | None = None) -> list[tuple[int, int]]:
    first = np.searchsorted(claims.i, np.arange(len(chain.poses) + 1))
    args = (claims.i, claims.j, claims.relative, claims.covariance, claims.blind, chain.poses, chain.random, first)
    a, b, missed = short_loops(*args, window, FAR, np.arange(len(claims)) if asked is None else asked)
    assert (missed <= FAR).all()
    return list(zip(a.tolist(), b.tolist(), strict=True))


def ordered(pairs: list[tuple[int, int]], chain: Chain) -> Claims:
    pairs = sorted(pairs)
    return claims_on(chain, [p[0] for p in pairs], [p[1] for p in pairs])


def test_all_pairs_within_the_window_are_found_once_and_no_other() -> None:
    chain, rng, window = walk(60, 4), np.random.default_rng(4), 5
    pairs = [(int(i), int(j)) for i, j in zip(rng.integers(0, 25, 120), rng.integers(30, 60, 120), strict=True)]
    claims = ordered(pairs, chain)
    near = [
        (a, b)
        for a, b in combinations(range(len(claims)), 2)
        if abs(claims.i[a] - claims.i[b]) <= window
        and abs(claims.j[a] - claims.j[b]) <= window
        and (claims.i[a], claims.j[a]) != (claims.i[b], claims.j[b])
    ]
    assert sorted(found_loops(claims, chain, window)) == sorted(near)
    assert len(near) > 100
    some = np.array([3, 40, 77])
    assert sorted(found_loops(claims, chain, window, some)) == sorted(p for p in near if p[0] in some)


def test_more_loops_than_were_reckoned_with_are_all_there() -> None:
    """60 claims have 1770 pairs where room for 256 is made at first."""
    chain = walk(60, 5)
    claims = ordered([(i, j) for i in range(6) for j in range(40, 50)], chain)
    assert found_loops(claims, chain, 60) == list(combinations(range(60), 2))


def test_places_at_the_ends_of_the_chain_have_neighbours_too() -> None:
    chain = walk(30, 6)
    claims = ordered([(0, 28), (0, 29), (1, 29)], chain)
    assert found_loops(claims, chain, 5) == [(0, 1), (0, 2), (1, 2)]
    late = ordered([(27, 28), (27, 29), (28, 29)], chain)
    assert found_loops(late, chain, 5) == [(0, 1), (0, 2), (1, 2)]


def test_two_claims_of_the_same_pair_are_no_evidence_of_one_another() -> None:
    chain = walk(30, 7)
    claims = ordered([(3, 20), (3, 20), (4, 20)], chain)
    assert found_loops(claims, chain, 5) == [(0, 2), (1, 2)]


def test_blind_loops_are_found_whichever_way_the_robot_looked() -> None:
    chain = out_and_back(20)
    claims = blinded(claims_on(chain, [5, 8], [34, 31], 1))
    a, b, missed = loops_of(claims, chain, np.arange(2), 16.3)
    assert (a.tolist(), b.tolist()) == ([0], [1])
    assert missed[0] == pytest.approx(distance(claims, chain, 0, 1, np.pi))
    forward = walk(40, 8, turn=0.0)
    ahead = blinded(claims_on(forward, [5, 8], [25, 28], 1))
    ahead = Claims.of(ahead.i, ahead.j, np.zeros((2, 3)), ahead.covariance)
    assert loops_of(ahead, forward, np.arange(2), 16.3)[2][0] == pytest.approx(distance(ahead, forward, 0, 1, 0.0))
