"""What the localiser decides at its bounds, with a map and a belief made by hand."""

from __future__ import annotations

import itertools
import math
from types import SimpleNamespace

import numpy as np
import pytest
from homing_fakes import TellingViews
from kept import as_before
from maps import square

from topomap.core.geometry import Pose2
from topomap.core.records import Hypothesis, MapChange, Motion, Verdict, Where
from topomap.navigation.localiser import belief as belief_file
from topomap.navigation.localiser import localiser as localiser_file
from topomap.navigation.localiser.belief import ALIKE, LED, REACH, Belief
from topomap.navigation.localiser.localiser import (
    ASTRAY,
    ASTRAY_TURN,
    DOUBTFUL,
    STRETCHES,
    SURE,
    UNPROVEN,
    Localiser,
    _alike,
    _near_one,
    _nearest,
    _noise,
    _pass_began,
    _rivals,
)
from topomap.navigation.localiser.mixture import LEAST, MOST, SAME, SAME_TURN, Mixture
from topomap.navigation.localiser.start import ANYWHERE, Start
from topomap.navigation.localiser.views import Seen, Usual

MAP = square(8)
VIEW = TellingViews().view(0.0, 0.0, 0.0)


class Mapped:
    """A mapper at a pose of the map, with as many snapshots known as one says; what was asked of it is kept."""

    def __init__(self, pose: Pose2 | None = None, known: int = 33, behind: int = 20, catchment: float = 0.0) -> None:
        motion = Motion(0.1, 0.0, 0.05, np.diag([1e-4, 1e-6, 1e-4]), 0.25)
        self.map, self.located, self.left_behind, self.catchment = MAP, known, behind, catchment
        self.track = SimpleNamespace(pose=pose or Pose2(1.0, 0.1, 0.0), travel=30.0, motion=motion)
        self.recognition = self
        self.handled = self.doubted = False
        self.relocated: list[tuple[Pose2, int | None]] = []
        self.view_cache = SimpleNamespace(panorama=lambda node: VIEW)

    def __len__(self) -> int:
        return self.located

    def nodes(self) -> np.ndarray:
        return np.arange(self.located)

    def old_nodes(self, travel: float) -> np.ndarray:
        return np.array([k for k in range(self.located) if MAP.nodes[k].travel < travel - 10.0], np.int64)

    def relocate(self, pose: Pose2, since: int | None) -> None:
        self.relocated.append((pose, since))


def change(**told: object) -> MapChange:
    return MapChange(Pose2(1.0, 0.1, 0.0), 0.4, 0.8, **told)


def around(bound: float) -> tuple[float, float, float]:
    """Just below, at, and just above."""
    return math.nextafter(bound, -math.inf), bound, math.nextafter(bound, math.inf)


def test_a_step_errs_by_what_it_slips_and_by_all_where_wheels_and_views_contradict_one_another() -> None:
    motion = Motion(0.3, -0.1, -0.2, np.diag([1e-3, 2e-3, 3e-3]), 0.25)
    told = _noise(motion, False)
    slip = np.square([0.03 * 0.4, 0.02 * 0.4, 0.05 * 0.2]) + np.square([0.003, 0.003, 0.005])
    assert told == pytest.approx(motion.covariance + np.diag(slip))
    assert np.sqrt(np.diag(_noise(motion, True))) == pytest.approx([0.1, 0.1, math.radians(5.0)])


def test_places_are_near_up_to_a_metre_and_rivals_count_from_a_thousandth_on() -> None:
    nodes = np.array([0, 1])
    assert [_near_one(Pose2(-x, 0.0, 0.0), Mapped(), nodes) for x in (0.0, *around(1.0))] == [True, True, True, False]
    assert _near_one(Pose2(), Mapped(), nodes[:0]) is False
    assert _nearest(Pose2(0.3, 0.2, 0.0), Mapped(), nodes) == 1
    assert _nearest(Pose2(), Mapped(), nodes[:0]) is None
    told = tuple(Hypothesis(k, Pose2(), weight) for k, weight in enumerate((0.9, 0.5, *around(1e-3))))
    assert [one.node for one in _rivals(told)] == [1, 4]
    assert [_alike(Mapped(catchment=c)) > 0.0 for c in (0.0, *around(localiser_file.SLOW))] == [
        False,
        False,
        True,
        True,
    ]


def test_a_pass_began_where_the_newest_snapshots_lie_off_all_before() -> None:
    assert _pass_began(Mapped()) == 30
    assert _pass_began(Mapped(known=0)) == 0
    assert _pass_began(Mapped(known=12)) == 12


def test_where_a_belief_begins() -> None:
    accepted = SimpleNamespace(verdict=Verdict.ACCEPTED)
    other = SimpleNamespace(verdict=Verdict.PENDING)
    rows = []
    for start, driven, decisions in itertools.product(
        (Start(), ANYWHERE, Start(node=5), Start(pose=Pose2(2.0, 1.0, 0.3), node=5)), (True, False),
        ((), (other,), (other, accepted))
    ):  # fmt: skip
        localiser = Localiser(start)
        found = localiser._begun(Mapped(), change(decisions=decisions), driven)
        told = "none" if found is None else f"{np.round(found.mixture.poses, 3).tolist()} {found.mixture.elsewhere:.3f}"
        rows.append(f"{localiser._earlier} {localiser._right} {localiser._lost} {localiser._start == Start()} {told}")
    as_before("belief begun", {"rows": rows})


def test_how_many_snapshots_a_view_is_held_against() -> None:
    rows = []
    for earlier, lost, driven, ahead in itertools.product((None, 0, 10, 50), (True, False), (True, False), (8, 33)):
        localiser = Localiser()
        localiser._earlier, localiser._lost = earlier, lost
        rows.append(localiser._first(Mapped(behind=ahead), driven))
    for x in (1.0, -3.0):
        rows.append(Localiser()._on_known_ground(Mapped(Pose2(x, 0.0, 0.0), behind=8)))
    as_before("belief held against", {"rows": rows})


def test_the_track_is_set_right_at_its_bounds() -> None:
    rows = []
    for lost, stretches, found, x, turn, catchment in itertools.product(
        (0.0, *around(SURE), *around(DOUBTFUL)), (STRETCHES - 1, STRETCHES), (True, False),
        (0.0, ASTRAY, ASTRAY + 1e-9, 3.0), (0.0, ASTRAY_TURN + 1e-9), (0.0, 9.0)
    ):  # fmt: skip
        mapper, localiser = Mapped(Pose2(), catchment=catchment), Localiser()
        localiser._lost, localiser._right = found, 7
        localiser._belief = SimpleNamespace(stretches=stretches)
        event = localiser._mend(Where(Pose2(x, 0.0, turn), 4, 0.3, lost), mapper, True)
        rows.append(f"{event} {localiser._lost} {localiser._right} {mapper.relocated}")
    as_before("belief mends", {"rows": rows})


class Unseeing(Belief):
    """A belief that never looks."""

    def see(self, panorama: object, mapper: object, first: int) -> None:
        self.likeness = first / 100.0


def says(lost: float, stretches: int) -> Belief:
    held = Unseeing(Mixture.at(np.array([1.0, 0.1, 0.0]), np.eye(3), lost), MAP)
    held.stretches = stretches
    return held


def test_what_is_told_of_a_step_at_its_bounds(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(localiser_file, "Belief", Unseeing)
    rows = []
    for lost, stretches, was_lost, unproven, driven, broken, handled in itertools.product(
        (0.01, *around(SURE), 0.3), (STRETCHES - 1, STRETCHES), (True, False), (True, False), (True, False),
        ("", "slipped"), (True, False)
    ):  # fmt: skip
        localiser, mapper = Localiser(), Mapped()
        localiser._lost, localiser._unproven, localiser._belief = was_lost, unproven, says(lost, stretches)
        localiser._earlier, mapper.handled = 12, handled
        where = localiser.update(VIEW, mapper, change(broken=broken), driven)
        after = localiser._belief
        rows.append(
            f"{where.lost:.4f} {where.node} {where.pose.x:.3f} {where.event} {where.difference:.2f} {len(where.rivals)}"
            f" {localiser._lost} {localiser._unproven} {None if after is None else after.lost:.4f}"
        )
    assert any(f"{UNPROVEN:.4f}" in row for row in rows)
    as_before("belief told", {"rows": rows})
    fresh = Localiser()
    told = fresh.update(VIEW, Mapped(Pose2(-5.0, 0.0, 0.0)), change(), True)
    assert (told.lost, told.node, told.difference, fresh._earlier) == (0.0, 2, 0.4, 33)
    nothing = Localiser(ANYWHERE)
    told = nothing.update(VIEW, Mapped(known=0), change(), False)
    assert (told.lost, told.node, told.pose) == (1.0, None, Pose2(1.0, 0.1, 0.0))


def test_hypotheses_are_one_up_to_a_bound_and_few_are_kept() -> None:
    one = Mixture.at(np.zeros(3), np.eye(3), 0.1)
    for away, turn, same in ((SAME - 1e-9, 0.0, True), (SAME, 0.0, False), (0.0, SAME_TURN - 1e-9, True),
                             (0.0, SAME_TURN, False), (0.0, -SAME_TURN + 1e-9, True)):  # fmt: skip
        assert one.near(np.array([[away, 0.0, turn]]))[0, 0] == same
        assert len(one.joined_by(np.array([[away, 0.0, turn]]), np.eye(3), np.array([-2.0])).pruned()) == 2 - same
    assert one.near(np.array([[0.9, 0.0, 0.0]]), 1.0)[0, 0]
    for weight, kept in zip(around(LEAST), (1, 1, 2), strict=True):
        assert len(one.joined_by(np.array([[9.0, 0.0, 0.0]]), np.eye(3), np.array([weight])).pruned()) == kept
    many = np.column_stack([np.arange(MOST + 3.0), np.zeros(MOST + 3), np.zeros(MOST + 3)])
    assert len(Mixture.unknown().joined_by(many, np.eye(3), np.full(MOST + 3, -6.0)).pruned()) == MOST
    looked = one.looked(np.array([0]), np.array([0.5]), 0.2).looked(np.array([0]), np.array([0.3]), 0.4)
    assert looked.seen.tolist() == [[0.5, 2.0, 0.3]]


@pytest.mark.parametrize(("weight", "away", "likeness", "fixed"), [
    (LED * 1.001, REACH - 1e-6, ALIKE - 1e-6, True), (LED * 0.999, 0.5, 0.3, False), (0.9, REACH + 1e-6, 0.3, False),
    (0.9, 0.5, ALIKE, False), (0.9, 0.5, math.nan, False), (LED, 0.5, 0.3, True),
])  # fmt: skip
def test_the_likeliest_is_measured_where_its_place_is_near_and_alike(
    weight: float, away: float, likeness: float, fixed: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[Pose2] = []
    monkeypatch.setattr(belief_file, "fix", lambda *a: asked.append(a[2]))
    held = Belief(Mixture.at(np.array([-away, 0.0, 0.2]), np.eye(3), 0.5), MAP)
    held.mixture.weights[:] = math.log(weight)
    held.likeness = likeness
    held._fix(VIEW, Mapped(), np.arange(5))
    assert bool(asked) is fixed
    assert not fixed or (asked[0].x, asked[0].heading) == pytest.approx((-away, 0.2))


def test_looks_correct_hypotheses_that_are_like_their_places() -> None:
    columns = np.arange(90) * math.tau / 90
    rows: list[float] = []
    for least in (0.04, 0.2 * ALIKE**2, 0.5):
        squares = least + 0.5 * (1.0 - np.cos(columns[None] - np.array([[0.0], [0.1], [3.0]])))
        seen = Seen(np.arange(3), squares, np.zeros(squares.shape, np.int64), np.array([[0.1, 0.05]]),
                    Usual(0.9, np.linspace(0.4, 1.2, 9)))  # fmt: skip
        held = Belief(Mixture.at(np.array([0.3, 0.1, 0.05]), 0.1 * np.eye(3), 0.2), MAP)
        held.mixture = held.mixture.joined_by(np.array([[9.0, 9.0, 0.0], [0.9, 0.0, 3.0]]), np.eye(3), np.full(2, -3.0))
        places = MAP.poses[:3]
        held._compare(seen, held._nearby(places), places)
        rows += [held.likeness, *held.mixture.poses.ravel(), *np.minimum(held.mixture.seen, 9.0).ravel()]
        rows += np.sqrt(held.mixture.covariances[:, [0, 1, 2], [0, 1, 2]]).ravel().tolist()
    as_before("belief compared", {"rows": rows})


def test_a_map_that_moves_carries_hypotheses_along_and_new_nodes_do_not() -> None:
    topo = square(8)
    held = Belief(Mixture.at(np.array([1.0, 0.1, 0.0]), np.eye(3), 0.2), topo)
    before = held.mixture
    held.follow(topo, np.arange(20))
    assert held.mixture is before
    moved = SimpleNamespace(poses=topo.poses + np.array([1.0, 2.0, 0.0]))
    held.follow(moved, np.arange(20))
    assert held.mixture.poses[0] == pytest.approx([2.0, 2.1, 0.0])
    grown = SimpleNamespace(poses=np.concatenate([moved.poses, moved.poses[-1:] + 0.5]))
    held.follow(grown, np.arange(20))
    assert held.mixture.poses[0] == pytest.approx([2.0, 2.1, 0.0])
    assert len(held._poses) == len(grown.poses)


def test_ways_add_up_to_looks_and_a_shaken_belief_looks_at_once() -> None:
    held = Belief(Mixture.at(np.zeros(3), np.eye(3), 0.2), MAP)
    assert (held._since_look, held._since_weighed, held._fresh) == (math.inf, 0.0, True)
    held._since_look = 0.0
    held.stretches = 4
    held.move(Motion(0.03, -0.04, 0.1, np.zeros((3, 3)), 0.25), np.zeros((3, 3)))
    held.move(Motion(-0.3, 0.4, 0.1, np.zeros((3, 3)), 0.25), np.zeros((3, 3)))
    assert (held._since_look, held._since_weighed) == pytest.approx((0.55, 0.55))
    held._fresh = False
    held.shake(0.25)
    assert (held._since_look, held._fresh, held.stretches) == (math.inf, True, 0)
    assert held.lost == pytest.approx(1.0 - 0.8 * 0.75)
