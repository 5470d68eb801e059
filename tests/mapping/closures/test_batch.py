"""All claims about a drive at once: on lapped drives with every kind of false claim, and at the edges."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from lapped import LAP, STEP, Lapped, lapped

from topomap.core.arrays import FloatArray
from topomap.core.geometry import between
from topomap.evaluation.trajectory import ate
from topomap.mapping.closures import batch, growing, settling
from topomap.mapping.closures.batch import Batch, Judgement
from topomap.mapping.closures.claims import Claims
from topomap.mapping.closures.closure_tests import TESTS, Knowledge
from topomap.mapping.closures.working_map import WorkingMap

NONE = np.zeros(0, np.int64)


def judged(world: Lapped, tests: tuple[object, ...] = TESTS) -> Judgement:
    drive, claims, _ = world.engine_input()
    return Batch(drive, claims, tests).run()


def counts(world: Lapped, found: Judgement) -> tuple[float, int]:
    """The share of the true claims that stand, and how many false ones do."""
    false = world.engine_input()[2]
    return float(found.inlier[~false].mean()), int(found.inlier[false].sum())


MIXES = {
    "none false": lambda world, seed: world,
    "half random": lambda world, seed: world.alone(75, seed),
    "80 % random": lambda world, seed: world.alone(300, seed),
    "half in fives": lambda world, seed: world.groups(15, 5, seed),
    "80 % in fives": lambda world, seed: world.groups(60, 5, seed),
    "half in tens": lambda world, seed: world.groups(7, 10, seed),
    "80 % in tens": lambda world, seed: world.groups(30, 10, seed),
}


@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize("mix", MIXES)
def test_true_claims_stand_and_false_ones_do_not(mix: str, seed: int) -> None:
    world = MIXES[mix](lapped(seed=seed), seed + 50)
    found = judged(world)
    kept, wrong = counts(world, found)
    assert wrong == 0
    assert kept >= 0.97
    assert rms(found.state.poses, world) < min(0.15, 0.3 * rms(world.graph.dead_reckoning(), world))
    assert found.kept.startswith(f"{int(found.inlier.sum())} of {len(found.inlier)} closures are likely, ")


def rms(poses: FloatArray, world: Lapped) -> float:
    return ate(poses, world.truth)


@pytest.mark.parametrize("size", [5, 10])
def test_groups_that_claim_the_very_same_are_not_let_in(size: int) -> None:
    world = lapped().groups(75 // size, size, 50, literal=True)
    found = judged(world)
    assert counts(world, found)[1] == 0
    assert rms(found.state.poses, world) <= rms(world.graph.dead_reckoning(), world)


@pytest.mark.parametrize("size", [5, 10])
def test_groups_that_claim_the_very_same_do_not_keep_the_true_ones_out(size: int) -> None:
    world = lapped().groups(75 // size, size, 50, literal=True)
    assert counts(world, judged(world))[0] >= 0.97


@pytest.mark.parametrize("size", [1, 5, 10])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_where_all_claims_are_false_the_map_is_odometry_to_the_byte(size: int, seed: int) -> None:
    world = lapped(seed=seed).but(NONE).groups(60 // size, size, seed + 50)
    found = judged(world)
    assert not found.inlier.any()
    assert found.state.poses.tobytes() == world.graph.dead_reckoning().tobytes()
    assert found.kept == "odometry: nothing is likely"
    assert set(found.reason) <= {"odometry contradicts it", "the map makes it unlikely"}
    assert np.isneginf(found.log_odds[[word == "odometry contradicts it" for word in found.reason]]).all()


def test_without_claims_the_map_is_odometry() -> None:
    world = lapped().but(NONE)
    found = judged(world)
    assert (found.inlier.shape, found.log_odds.shape, found.reason) == ((0,), (0,), ())
    assert found.state.poses.tobytes() == world.graph.dead_reckoning().tobytes()


def short() -> Lapped:
    """Less than two laps, so that odometry still knows well where it is."""
    world = lapped(laps=2, every=1)
    return world.but(np.flatnonzero(world.graph.j < LAP + 12))


def test_a_single_claim_stands_if_odometry_is_sure_enough_of_it() -> None:
    world = short().but(np.array([0]))
    assert len(world.false) == 1
    found = judged(world, (Favour(6.0), *TESTS))
    assert found.inlier.tolist() == [True]
    assert found.reason == ("fits the map with all other closures",)
    off = replace(world, graph=replace(world.graph, relative=world.graph.relative + np.array([8.0, 0.0, 0.0])))
    wrong = judged(off, (Favour(6.0), *TESTS))
    assert wrong.inlier.tolist() == [False]
    assert wrong.state.poses.tobytes() == world.graph.dead_reckoning().tobytes()


class Favour:
    """Somebody's own test: speaks for all claims alike."""

    name, lowers = "favour", False

    def __init__(self, odds: float) -> None:
        self._odds = odds

    def weigh(self, claims: Claims, knowledge: Knowledge) -> FloatArray:
        return np.full(len(claims), self._odds)


class Refuse:
    """Somebody's own test: refuses claims that begin on some stretch."""

    name, lowers = "refuse", False  # those behind it may still speak for the others

    def __init__(self, before: int) -> None:
        self._before = before

    def weigh(self, claims: Claims, knowledge: Knowledge) -> FloatArray:
        return np.where(claims.i < self._before, -np.inf, 0.0)


@pytest.mark.parametrize("behind", [False, True])
def test_a_users_own_test_refuses_what_would_have_stood(behind: bool) -> None:
    world = lapped()
    claims = world.engine_input()[1]
    refused = claims.i < 40
    assert judged(world).inlier[refused].all()
    tests = (*TESTS, Refuse(40)) if behind else (Refuse(40), *TESTS)
    found = judged(world, tests)
    assert not found.inlier[refused].any()
    assert found.inlier[~refused].mean() > 0.97
    assert found.reason[int(np.flatnonzero(refused)[0])] == "the map makes it unlikely"


def test_a_users_own_test_speaks_for_what_would_not_have_stood() -> None:
    world = lapped(laps=2).but(np.array([6]))
    assert not judged(world).inlier.any()
    found = judged(world, (Favour(8.0), *TESTS))
    assert found.inlier.all()
    plain = Batch(*world.engine_input()[:2]).run()
    assert found.log_odds[0] - plain.log_odds[0] >= 8.0 - 1e-9  # and what it said is in the odds


def test_what_claims_look_like_counts() -> None:
    drive, claims, _ = lapped(laps=2).but(np.array([6])).engine_input()
    assert not Batch(drive, claims).run().inlier.any()
    assert Batch(drive, replace(claims, looks=np.full(1, 8.0))).run().inlier.all()


def test_of_two_claims_of_one_pair_the_one_that_the_others_bear_out_stands() -> None:
    world = lapped()
    graph = world.graph
    both = world.also(graph.i[[20]], graph.j[[20]], graph.relative[[20]] + np.array([1.0, 0.0, 0.0]))
    claims, false = both.engine_input()[1:]
    twice = np.flatnonzero((claims.i == graph.i[20]) & (claims.j == graph.j[20]))
    assert len(twice) == 2
    found = judged(both)
    assert found.inlier[twice].tolist() == (~false[twice]).tolist()


def test_a_claim_made_twice_stands_twice() -> None:
    world = lapped()
    graph = world.graph
    both = world.also(graph.i[[20]], graph.j[[20]], graph.relative[[20]], false=False)
    found = judged(both)
    assert found.inlier.all()
    assert rms(found.state.poses, both) < 0.15


def test_two_that_contradict_one_another_do_not_both_stand() -> None:
    world = short()
    graph = world.graph
    one = world.but(np.array([0]))
    both = one.also(graph.i[[0]], graph.j[[0]], graph.relative[[0]] + np.array([1.0, 0.0, 0.0]))
    found = judged(both, (Favour(6.0), *TESTS))
    assert found.inlier.sum() <= 1


def test_claims_at_both_ends_of_the_chain_stand() -> None:
    world = lapped(laps=3)
    last = len(world.truth) - 1
    i, j = np.array([0, 0, 1, last - LAP]), np.array([last - LAP + 1, 2 * LAP, last - 1 - LAP, last])
    relative = between(world.truth[i], world.truth[j])
    ends = world.also(i, j, relative, false=False)
    found, claims = judged(ends), ends.engine_input()[1]
    at = (claims.i == 0) | (claims.j == last)
    assert at.sum() >= 3
    assert found.inlier[at].all()


def test_two_places_are_a_drive() -> None:
    world = lapped(laps=2)
    graph = world.graph
    two = replace(
        world,
        graph=replace(
            graph,
            odometry=graph.odometry[:1],
            odometry_covariance=graph.odometry_covariance[:1],
            i=np.array([0]),
            j=np.array([1]),
            relative=graph.odometry[:1],
            covariance=graph.covariance[:1],
            gaps=graph.gaps[:1],
            names=graph.names[:2],
        ),
        false=np.zeros(1, bool),
    )
    found = judged(two, (Favour(20.0), *TESTS))
    assert found.inlier.all()
    assert np.isfinite(found.state.poses).all()


def test_two_runs_agree_to_the_byte() -> None:
    world = lapped(seed=2).groups(10, 5, 3).alone(75, 4)
    one, other = judged(world), judged(world)
    assert one.state.poses.tobytes() == other.state.poses.tobytes()
    assert one.log_odds.tobytes() == other.log_odds.tobytes()
    assert one.inlier.tobytes() == other.inlier.tobytes()
    assert one.reason == other.reason


def test_blind_claims_are_judged_by_where_they_are() -> None:
    """They tell less: of those that stand alone a false one would as often fit as a true one."""
    world = lapped(seed=1, step=STEP / 2).alone(75, 51)
    drive, claims, false = world.engine_input()
    covariance = claims.covariance.copy()
    covariance[:, 2, 2] = 40.0
    found = Batch(drive, replace(claims, covariance=covariance, relative=claims.relative * [1.0, 1.0, 0.0])).run()
    assert found.inlier[false].sum() == 0
    assert found.inlier[~false].mean() > 0.75
    assert rms(found.state.poses, world) < 0.3 * rms(drive.poses, world)


@pytest.mark.parametrize("few", [0, 10**6])
def test_of_many_claims_a_bound_sifts_and_changes_no_verdict(few: int, monkeypatch: pytest.MonkeyPatch) -> None:
    world = lapped(seed=3).alone(150, 53)
    expected = judged(world)
    monkeypatch.setattr(growing, "FEW", few)
    monkeypatch.setattr(settling, "FEW", few)
    found = judged(world)
    assert np.array_equal(found.inlier, expected.inlier)
    assert np.allclose(found.state.poses, expected.state.poses, atol=1e-6)


def test_a_second_way_to_the_same_map_is_no_rival(monkeypatch: pytest.MonkeyPatch) -> None:
    """What rounding makes of the same closures is not to choose between two ways."""
    expected = judged(lapped(seed=3))
    finished: list[WorkingMap] = []
    monkeypatch.setattr(batch, "_complete", lambda working: False)  # so that both ways are gone
    monkeypatch.setattr(batch, "_doubtful", lambda best: False)
    monkeypatch.setattr(batch, "confirm", finished.append)
    found = judged(lapped(seed=3))
    assert len(finished) == 1
    assert np.array_equal(found.inlier, expected.inlier)
    assert found.kept == expected.kept


def test_progress_goes_up_to_one() -> None:
    heard: list[tuple[float, str]] = []
    drive, claims, _ = lapped().alone(75).engine_input()
    Batch(drive, claims, told=lambda share, doing: heard.append((share, doing))).run()
    shares = [share for share, _ in heard]
    assert shares == sorted(shares)
    assert (min(shares) >= 0.0, shares[-1]) == (True, 1.0)
    assert heard[-1][1] == "75 closures"


def test_where_odometry_drifts_more_clusters_that_agree_start_the_map() -> None:
    """Odometry ends 4 m off, so that no lone claim is sure at once."""
    world = lapped(seed=1, step=2.5 * STEP).alone(300, 11)
    kept, wrong = counts(world, judged(world))
    assert wrong == 0
    assert kept >= 0.97


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize(("false", "least"), [(0, 0.85), (20, 0.7)])
def test_odometry_that_is_worse_than_it_says_does_not_refuse_what_is_true(seed: int, false: int, least: float) -> None:
    """It turns by one sigma a step more than it says, 1.6 rad in all, and ends 6 to 8 m off."""
    world = lapped(every=8, seed=seed)
    bent = world.graph.odometry + np.array([0.0, 0.0, STEP[2]])
    world = replace(world, graph=replace(world.graph, odometry=bent)).alone(false, seed + 5)
    found = judged(world)
    kept, wrong = counts(world, found)
    assert wrong == 0
    assert kept >= least
    assert rms(found.state.poses, world) < 0.25 * rms(world.graph.dead_reckoning(), world)
    assert "times less sure than stated" in found.kept


def test_odometry_that_holds_what_it_says_is_taken_at_its_word() -> None:
    for seed in range(3):
        assert "less sure" not in judged(lapped(every=8, seed=seed).alone(40, seed)).kept
