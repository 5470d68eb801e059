"""Where all claims about a drive are judged: each limit, by tests that say what they are told to."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from chains import HELD
from lapped import CLOSURE, lapped
from told import PLACES, STEP, Told, apart, by_place, claims_on, even, straight

from topomap.core.arrays import BoolArray, FloatArray, IntArray
from topomap.core.geometry import between
from topomap.mapping.closures import growing
from topomap.mapping.closures import settling as finishing
from topomap.mapping.closures.batch import Batch, Judgement
from topomap.mapping.closures.claims import Claims
from topomap.mapping.closures.closure_tests import Knowledge
from topomap.mapping.closures.drive import Drive
from topomap.mapping.closures.odds import mahalanobis
from topomap.mapping.odometry.increments import Calibration, EdgeIncrements, Increments, track
from topomap.mapping.optimizer import OdometryEdges
from topomap.mapping.uncertainty.network import PathNetwork

DRIFTING = STEP  # of a lapped drive that ends metres off


def rounds_of(drive: Drive, claims: Claims, test: Told) -> tuple[Judgement, int, int]:
    """The verdicts, and how many rounds of growing and of settling it took."""
    heard: list[str] = []
    found = Batch(drive, claims, (test,), lambda _, doing: heard.append(doing)).grown()
    settling = sum("settling" in doing for doing in heard)
    return found, len(heard) - 1 - settling, settling


@pytest.mark.parametrize(("odds", "expected"), [(np.log(990.0), False), (np.log(1010.0), True)])
def test_a_claim_may_bend_the_map_when_one_such_in_a_thousand_is_false(odds: float, expected: bool) -> None:
    drive = straight()
    claims = claims_on(drive, *apart(1), [0.3, 0.0, 0.0])
    found = Batch(drive, claims, (even(odds),)).grown()
    assert found.inlier.tolist() == [expected]
    assert found.log_odds == pytest.approx([odds])
    assert (found.state.poses.tobytes() == drive.poses.tobytes()) == (not expected)
    assert found.reason == ("fits the map with all other closures" if expected else "the map makes it unlikely",)


@pytest.mark.parametrize(("sure", "expected"), [(60, False), (110, True)])
def test_in_the_finished_map_three_in_ten_thousand_may_be_false(sure: int, expected: bool) -> None:
    """A claim of odds 30 to 1 is false one time in 31: among 108 that are sure the share is within the limit."""
    drive = straight()
    i, j = np.repeat(np.arange(12) * 6, 10)[:sure], PLACES - 1 - np.tile(np.arange(10), 12)[:sure] * 2
    claims = claims_on(drive, np.append(i, 75), np.append(j, PLACES - 1))
    found = Batch(drive, claims, (by_place({75: np.log(30.0)}, 30.0),)).grown()
    assert found.inlier[:-1].all()
    assert found.inlier[-1] == expected
    assert (1 / 31 / (sure + 1) <= finishing.FALSE) == expected


@pytest.mark.parametrize(("odds", "expected"), [(19.5, False), (20.5, True)])
def test_below_twenty_to_one_none_is_taken_however_sure_the_others_are(odds: float, expected: bool) -> None:
    drive = straight()
    i, j = np.repeat(np.arange(12), 60), PLACES - 1 - np.tile(np.arange(60), 12)
    claims = claims_on(drive, np.append(i, 75), np.append(j, PLACES - 1))
    found = Batch(drive, claims, (by_place({75: np.log(odds)}, 30.0),)).grown()
    assert found.inlier[:-1].all()
    assert found.inlier[-1] == expected
    assert finishing.FALSE > 1 / 20.5 / 721  # it isn't the share of false ones that decides


def trio(drive: Drive) -> Claims:
    """A lone claim, and three others that agree: they have one representative."""
    return claims_on(drive, np.array([8, 9, 10, 60]), np.array([108, 109, 110, PLACES - 1]))


@pytest.mark.parametrize(("odds", "first"), [(19.5, 1), (20.5, 2)])
def test_three_that_agree_may_bend_the_map_sooner_than_a_lone_one(odds: float, first: int) -> None:
    """Beside a lone one that is sure: in the first round, if they are false one time in twenty."""
    drive, heard = straight(), list[str]()
    test = by_place({60: 30.0}, np.log(odds))
    Batch(drive, trio(drive), (test,), lambda _, doing: heard.append(doing)).grown()
    assert heard[1] == f"{first} closures"


@pytest.mark.parametrize(("odds", "settling"), [(4.9, 0), (5.1, 1)])
def test_where_nothing_is_likely_three_that_agree_may_start_the_map(odds: float, settling: int) -> None:
    drive = straight()
    started = rounds_of(drive, trio(drive), by_place({60: -9.0}, np.log(odds)))[2]
    assert min(started, 1) == settling
    pair = trio(drive)[np.array([0, 1, 3])]
    assert rounds_of(drive, pair, by_place({60: -9.0}, np.log(19.0)))[2] == 0  # two are too few


def off_by(drive: Drive, claims: Claims, chi2: float) -> Claims:
    """The claims, moved ahead until odometry has them off by this squared Mahalanobis distance."""
    chain = drive.chain(drive.start())
    errors = PathNetwork.of_chain(chain).errors(claims.i, claims.j)
    step = claims_on(drive, claims.i, claims.j, [1.0, 0.0, 0.0])
    per_metre = mahalanobis(step, drive.poses, errors)[0]
    moved = np.sqrt(chi2 / per_metre)[:, None] * [1.0, 0.0, 0.0]
    return claims_on(drive, claims.i, claims.j, moved)


@pytest.mark.parametrize(("chi2", "expected"), [(29.5, True), (30.5, False)])
def test_odometry_refuses_what_lies_beyond_its_gate(chi2: float, expected: bool) -> None:
    drive = straight()
    claims = off_by(drive, claims_on(drive, *apart(1)), chi2)
    test = even(30.0)
    found = Batch(drive, claims, (test,)).grown()
    assert (found.reason[0] != "odometry contradicts it") == expected
    assert (test.times(0) > 0) == expected
    assert np.isneginf(found.log_odds[0]) == (not expected)


def test_a_cluster_is_allowed_when_odometry_allows_one_of_its_representatives() -> None:
    """Two stretches of one cluster: the first is contradicted, the second isn't, and they agree with one another."""
    drive = straight()
    i = np.arange(4, 36, 4)
    claims = claims_on(drive, i, i + 80)
    moved = off_by(drive, claims, 33.0).relative[:, 0] - claims.relative[:, 0]
    shift = np.linspace(moved.mean() * 1.05, moved.mean() * 0.9, len(i))
    bent = claims_on(drive, i, i + 80, np.column_stack([shift, 0 * shift, 0 * shift]))
    chi2 = mahalanobis(bent, drive.poses, PathNetwork.of_chain(drive.chain(drive.start())).errors(i, i + 80))[0]
    assert chi2[0] > growing.GATE > chi2[-1]
    found = Batch(drive, bent, (even(-9.0),)).grown()
    assert set(found.reason) == {"the map makes it unlikely"}


def test_what_odometry_refuses_stays_out_though_the_map_comes_to_fit_it() -> None:
    """Odometry that is stated too sure refuses some true claims; the others put the map right all the same."""
    drive, claims, _ = lapped(seed=1).engine_input()
    told = drive.edges.increments
    sure = EdgeIncrements(told.deltas, 0.3 * told.covariances, told.starts)
    found = Batch(replace(drive, edges=replace(drive.edges, increments=sure)), claims, (even(30.0),)).grown()
    refused = np.array([word == "odometry contradicts it" for word in found.reason])
    assert 3 <= refused.sum() <= 30
    off = (between(found.state.poses[claims.i], found.state.poses[claims.j]) - claims.relative) / CLOSURE
    assert np.abs(off[refused]).max() < 6.0
    assert found.inlier.tolist() == (~refused).tolist()


def together(drive: Drive, off: float) -> tuple[Claims, BoolArray]:
    """Twelve claims of one pair of places that say the same and one that is off [sigmas]; and which one that is."""
    made = np.zeros((13, 3))
    made[6, 0] = off * CLOSURE[0]
    return claims_on(drive, np.full(13, 6), np.full(13, 107), made), np.arange(13) == 6


@pytest.mark.parametrize(("sigmas", "expected"), [(5.9, True), (6.7, False)])
def test_the_finished_map_has_no_closure_that_is_off_by_more_than_six_sigmas(sigmas: float, expected: bool) -> None:
    """It pulls the map its way by a thirteenth of that."""
    drive = straight()
    claims, odd = together(drive, sigmas)
    found = Batch(drive, claims, (even(30.0),)).grown()
    assert found.inlier[~odd].all()
    assert found.inlier[odd].tolist() == [expected]
    refused = "likely, but the map can't fit it beside the others"
    assert found.reason[6] == ("fits the map with all other closures" if expected else refused)


def test_what_does_not_fit_is_taken_up_three_times() -> None:
    drive = straight()
    claims, odd = together(drive, 20.0)
    found, rounds, _ = rounds_of(drive, claims, even(30.0))
    assert found.inlier.tolist() == (~odd).tolist()
    assert found.reason[6] == "likely, but the map can't fit it beside the others"
    assert rounds == growing.TRIES + 1 == 4  # in the last there is nothing left to take up


def test_where_all_fits_one_round_lets_it_in_and_two_settle_it() -> None:
    drive = straight()
    _, rounds, settling = rounds_of(drive, claims_on(drive, *apart(8)), even(30.0))
    assert (rounds, settling) == (2, 1)
    members = claims_on(drive, np.arange(40), np.arange(40) + 60)  # one cluster: more members than representatives
    _, rounds, settling = rounds_of(drive, members, even(30.0))
    assert (rounds, settling) == (2, 2)


def test_nothing_is_settled_where_nothing_stands() -> None:
    drive = straight()
    found, rounds, settling = rounds_of(drive, claims_on(drive, *apart(8)), even(0.0))
    assert (rounds, settling) == (1, 0)
    assert found.state.poses.tobytes() == drive.poses.tobytes()


class OneMore(Told):
    """Favours one claim more each time it is asked."""

    def __init__(self, order: IntArray) -> None:
        self._asked = 1
        super().__init__(self._grow)
        self._order = order.tolist()

    def _grow(self, claims: Claims, knowledge: Knowledge) -> FloatArray:
        self._asked += 1
        good = set(self._order[: self._asked])
        return np.where([i in good for i in claims.i.tolist()], 30.0, -30.0)


def test_settling_ends_though_every_turn_brings_another() -> None:
    """While the map grows only the first is likely; once all are weighed by it, one more each time."""
    drive, (i, j) = straight(), apart(20)
    more, grown = OneMore(i), [False]

    def says(some: Claims, knowledge: Knowledge) -> FloatArray:
        settling = len(some) == 20 and grown[0]
        grown[0] = True
        return more.weigh(some, knowledge) if settling else np.where(some.i == 0, 30.0, -30.0)

    found, rounds, settling = rounds_of(drive, claims_on(drive, i, j), Told(says))
    assert rounds == 2
    assert settling == finishing.SETTLINGS == 6
    assert found.inlier.sum() == 7


def test_growing_ends_after_sixty_rounds_though_each_brings_another(monkeypatch: pytest.MonkeyPatch) -> None:
    assert growing.ROUNDS == 60
    monkeypatch.setattr(growing, "ROUNDS", 5)
    drive, (i, j) = straight(), apart(20)
    _, rounds, _ = rounds_of(drive, claims_on(drive, i, j), OneMore(i))
    assert rounds == 5


def test_what_a_test_is_told_of_a_claim() -> None:
    """Cluster sizes, how often such are true, and that who agrees with a cluster that stands is likely, too."""
    drive = straight()
    i = np.concatenate([np.arange(40), [70]])
    j = np.concatenate([np.arange(40) + 60, [139]])
    test = even(30.0)
    claims = claims_on(drive, i, j)
    found = Batch(drive, claims, (test,)).grown()
    assert found.inlier.all()
    asked, known = test.heard[0]
    assert asked.i.tolist() == [*asked.i[:-1].tolist(), 70]
    assert len(asked) == 6  # a representative every eight places, and the lone one
    assert known.size.tolist() == [40] * 5 + [1]
    assert known.prevalence == pytest.approx(np.log([2.0 / 0.1] * 6))
    everyone, settled = test.heard[-1]
    assert len(everyone) == 41
    assert (settled.prevalence >= finishing.LIKELY).all()
    assert (settled.errors[:, 2, 2] <= known.errors[0, 2, 2] / 3).all()  # it knows them over the closures now


def fickle_map(seed: int) -> tuple[Drive, Judgement]:
    """Where all claims are likely at first and none any more once the map was solved with them."""
    drive, claims, _ = lapped(seed=seed, step=DRIFTING).engine_input()
    asked = [0]

    def fickle(some: Claims, knowledge: Knowledge) -> FloatArray:
        asked[0] += 1
        return np.full(len(some), 30.0 if asked[0] == 1 else -30.0)

    return drive, Batch(drive, claims, (Told(fickle),)).grown()


def test_a_map_that_keeps_nothing_after_all_says_so() -> None:
    _, found = fickle_map(0)
    assert not found.inlier.any()
    assert found.kept == "odometry: nothing is likely"


@pytest.mark.parametrize("seed", [0, 1])
def test_a_map_that_keeps_nothing_after_all_is_odometry_again(seed: int) -> None:
    drive, found = fickle_map(seed)
    assert found.state.poses.tobytes() == drive.poses.tobytes()


def test_an_unsure_calibration_is_found_with_the_map() -> None:
    """The engine takes a drive whose odometry bends by something: its prior tells how much odometry may be off."""
    world = lapped(laps=3)
    drive, claims, _ = world.engine_input()
    bent = drive.edges.increments.deltas.copy()
    bent[:, 2] += 0.002 * bent[:, 0]
    increments = EdgeIncrements(bent, drive.edges.increments.covariances, drive.edges.increments.starts)
    start = track(Increments(np.arange(len(bent)), bent, increments.covariances), Calibration())
    edges = OdometryEdges(drive.edges.i, drive.edges.j, increments)
    unsure = Batch(Drive(start, edges, sigmas=(1e-6, 0.005, 1e-6)), claims).grown()
    assert unsure.inlier.mean() > 0.9
    assert unsure.state.calibration.curvature == pytest.approx(0.002, abs=0.0003)
    assert not np.allclose(unsure.state.covariance, HELD)


@pytest.mark.parametrize(("beside", "stands"), [(1, False), (8, True), (100, True)])
def test_a_lone_closure_is_one_of_all_that_the_map_holds(beside: int, stands: bool) -> None:
    """Of odds of 200 to 1: beside a cluster of so many sure ones, 1 in 1000 closures at most may be false."""
    odds, size = np.array([30.0, np.log(200.0)]), np.array([beside, 1])
    assert (1 in finishing.doubtful(odds, size)) != stands
