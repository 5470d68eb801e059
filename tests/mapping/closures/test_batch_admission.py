"""How clusters are let into the growing map, come back when they strained it, and are known once they stand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from lapped import CLOSURE, lapped
from told import Told, apart, claims_on, even, straight

from topomap.core.arrays import BoolArray, FloatArray, IntArray
from topomap.core.geometry import between, wrap_all
from topomap.mapping.closures import settling
from topomap.mapping.closures.batch import Batch, quiet
from topomap.mapping.closures.claims import Claims
from topomap.mapping.closures.closure_tests import Knowledge
from topomap.mapping.closures.working_map import CLOSING, WorkingMap
from topomap.mapping.odometry.increments import Calibration, EdgeIncrements, Increments, track
from topomap.mapping.pose_graph import gap_covariance
from topomap.mapping.uncertainty.network import PathNetwork


def begins(count: int, size: int) -> tuple[IntArray, IntArray]:
    """Pairs of places of a cluster that has one representative, and before it of so many that are alone."""
    i, j = apart(count, 24)
    return np.concatenate([np.arange(size), i]), np.concatenate([80 + np.arange(size), j])


def first_let_in(size: int, odds: float, others: int) -> tuple[int, bool]:
    """How many representatives stand after a round in which a cluster has the odds and others are sure; is any in?"""
    drive, heard, asked = straight(), [""], [0]

    def says(claims: Claims, _: Knowledge) -> FloatArray:
        asked[0] += 1
        return np.where((claims.i < 8) & (asked[0] == 1), np.log(odds), 30.0)

    claims = claims_on(drive, *begins(others, size))
    found = Batch(drive, claims, (Told(says),), lambda _, doing: heard.append(doing)).grown()
    return int(heard[2].split()[0]), bool(found.inlier.any())


@pytest.mark.parametrize(
    ("size", "odds", "expected"),
    [(1, 990, 2), (1, 1010, 3), (2, 990, 2), (2, 1010, 3), (3, 19.5, 2), (3, 20.5, 3), (7, 19.5, 2), (7, 20.5, 3)],
)
def test_three_that_agree_may_bend_the_map_sooner(size: int, odds: float, expected: int) -> None:
    """Two lone ones are sure and stand whatever becomes of the cluster."""
    assert first_let_in(size, odds, 2)[0] == expected


@pytest.mark.parametrize(("size", "odds", "expected"), [(3, 4.9, False), (3, 5.1, True), (2, 990, False)])
def test_where_nothing_is_likely_what_is_possible_starts_the_map(size: int, odds: float, expected: bool) -> None:
    assert first_let_in(size, odds, 0) == (int(expected), expected)


def strain_first(monkeypatch: pytest.MonkeyPatch, which: int, times: int = 1000) -> list[BoolArray]:
    """Let the cluster of claim `which` strain every map, or the first ones."""
    seen: list[BoolArray] = []

    def always(
        poses: FloatArray, claims: Claims, label: IntArray, standing: IntArray, network: PathNetwork
    ) -> BoolArray:
        tense = np.zeros(int(label.max()) + 1, bool)
        tense[label[which]] = np.isin(label[which], label[standing]) and len(seen) < times
        seen.append(tense)
        return tense

    monkeypatch.setattr(settling, "strained", always)
    return seen


class Afterthought(Told):
    """Favours all, but for place 0 once it has been known by its own closure and no longer is."""

    def __init__(self, later: float) -> None:
        self._was_in = False
        super().__init__(self._judge)
        self._later = later

    def _judge(self, claims: Claims, knowledge: Knowledge) -> FloatArray:
        odds = np.full(len(claims), 30.0)
        for n in np.flatnonzero(claims.i == 0).tolist():
            known = knowledge.errors[n, 2, 2] <= 1.01 * CLOSURE[2] ** 2
            odds[n] = 30.0 if known or not self._was_in else self._later
            self._was_in |= bool(known)
        return odds


@pytest.mark.parametrize(("later", "expected"), [(-5.0, False), (30.0, True)])
def test_what_strains_the_map_is_weighed_once_more_without_itself(
    later: float, expected: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    drive, (i, j) = straight(), apart(8)
    seen = strain_first(monkeypatch, 0)
    found = Batch(drive, claims_on(drive, i, j), (Afterthought(later),)).grown()
    assert found.inlier[1:].all()
    assert found.inlier[0] == expected
    assert 2 <= len(seen) <= 3  # suspected once, not over and over


@pytest.mark.parametrize(
    ("size", "odds", "suspected", "expected"),
    [
        (3, 20.5, True, True),
        (3, 19.5, True, False),
        (2, 100.0, True, False),
        (2, 1010.0, True, True),
        (3, 100.0, False, False),
    ],
)
def test_three_that_agree_come_back_as_they_came_in(
    size: int, odds: float, suspected: bool, expected: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """They strain the map and are less likely from then on; others, of the same odds, must be sure in the end."""
    drive, seen = straight(), strain_first(monkeypatch, 0)
    claims = claims_on(drive, *begins(8, size))
    if not suspected:
        monkeypatch.setattr(settling, "strained", lambda poses, claims, label, *_: np.zeros(label.max() + 1, bool))
    asked = [0]

    def says(some: Claims, _: Knowledge) -> FloatArray:
        asked[0] += 1
        later = bool(seen) if suspected else asked[0] > 1
        return np.where((some.i < 8) & later, np.log(odds), 30.0)

    found = Batch(drive, claims, (Told(says),)).grown()
    assert found.inlier[size:].all()
    assert found.inlier[:size].tolist() == [expected] * size


def test_what_comes_back_to_a_map_of_odometry_alone_may_pull_it_as_far_as_at_first(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The only closure, 5 m or a hundred of its sigmas to the side, strains once and is as likely as before."""
    drive = straight()
    claims = claims_on(drive, *apart(1), [0.0, 5.0, 0.0])
    seen = strain_first(monkeypatch, 0, times=1)
    found = Batch(drive, claims, (even(30.0),)).grown()
    assert len(seen) >= 2
    assert found.inlier.tolist() == [True]
    missed = between(found.state.poses[claims.i], found.state.poses[claims.j]) - claims.relative
    assert np.abs(missed).max() < 0.05


@pytest.mark.parametrize("turned", [2.5, -3.0])
def test_a_part_behind_a_gap_is_joined_however_it_is_turned(turned: float) -> None:
    """Odometry knows nothing of step 60: claims over it say where what lies behind it is."""
    drive, gap = straight(), 60
    told = drive.edges.increments
    covariances, deltas = told.covariances.copy(), told.deltas.copy()
    covariances[gap], deltas[gap] = gap_covariance(drive.poses), [5.0, -8.0, turned]
    truth = track(Increments(np.arange(len(deltas)), deltas, covariances), Calibration())
    lost = EdgeIncrements(told.deltas, covariances, told.starts)
    i, j = np.array([5, 6, 8, 9, 10, 40]), np.array([85, 87, 88, 89, 91, 120])
    claims = claims_on(replace(drive, poses=truth), i, j)
    found = Batch(replace(drive, edges=replace(drive.edges, increments=lost)), claims, (even(30.0),)).grown()
    assert found.inlier.all()
    missed = between(found.state.poses[i], found.state.poses[j]) - claims.relative
    missed[:, 2] = wrap_all(missed[:, 2])
    assert np.abs(missed).max() < 0.05


def test_members_of_a_cluster_that_stands_are_known_over_the_closure_beside_them() -> None:
    drive = straight()
    i = np.concatenate([np.arange(24), [3]])
    j = np.concatenate([np.arange(24) + 80, [139]])
    claims = claims_on(drive, i, j)
    order = np.lexsort((claims.j, claims.i))
    claims = claims[order]
    made = WorkingMap(drive, claims, (even(0.0),), quiet)
    made.standing = np.array([5, 20])
    assert claims.i[made.standing].tolist() == [4, 19]
    errors, member = settling.beside_standing(made, made.network())
    alone = claims.j == 139
    assert member.tolist() == (((claims.i < 8) | (claims.i >= 16)) & ~alone).tolist()
    for standing, those in ((5, claims.i < 8), (20, claims.i >= 16)):
        one = claims[[standing]]
        only = PathNetwork(drive.chain(drive.start()), one.i, one.j, one.covariance, np.zeros(1, np.int64))
        part = np.flatnonzero(those & ~alone)
        assert errors[part] == pytest.approx(only.errors(claims.i[part], claims.j[part]), rel=1e-6, abs=1e-9)
    assert not errors[~member].any()
    made.standing = np.zeros(0, np.int64)
    assert not settling.beside_standing(made, made.network())[1].any()


def test_what_is_no_member_of_a_standing_cluster_is_known_over_the_representative_beside_it() -> None:
    drive = straight()
    claims = claims_on(drive, np.arange(24), np.arange(24) + 80)
    made = WorkingMap(drive, claims, (even(0.0),), quiet)
    representatives = made.clusters.representatives
    assert len(representatives) == 3
    errors = settling.beside_representatives(made, made.network(), np.arange(24))
    network = made.network()
    assert errors[representatives] == pytest.approx(network.errors(claims.i, claims.j)[representatives])
    beside = made.clusters.own
    assert (claims.i[beside] // 8 == claims.i // 8).all()
    there = network.along(claims.i, claims.i[beside]) + network.along(claims.j, claims.j[beside])
    assert errors == pytest.approx(errors[beside] + there)


@pytest.mark.parametrize(("off", "sigma", "stands"), [(0.8, 0.2, True), (1.3, 0.2, False), (1.3, 0.9, True)])
@pytest.mark.parametrize("axis", [0, 1])
def test_a_closure_that_the_others_put_a_metre_away_is_taken_out(
    off: float, sigma: float, stands: bool, axis: int
) -> None:
    """Though its cluster stands, and though as a heavy tail it is likely; of vague closures that says nothing."""
    drive, claims, _ = lapped(laps=2, every=1).engine_input()
    there = np.zeros((16, 3))
    there[7, axis] = off
    spread = np.tile(np.diag([sigma, sigma, 0.06]) ** 2, (16, 1, 1))
    claims = replace(claims[:16], relative=claims.relative[:16] + there, covariance=spread)
    made = WorkingMap(drive, claims, (even(9.0),), quiet)
    made.solve(np.arange(16), CLOSING.model_copy(update={"cutoff": 20.0}))
    assert len(made.standing) == 16
    settling.confirm(made)
    assert (7 in made.standing) == stands
    assert len(made.standing) == 15 + stands
