"""The robot's closing, stage by stage: a line out and back, places known by a number, costs as each test wants them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from topomap.core.arrays import FloatArray
from topomap.core.panorama import Panorama
from topomap.core.records import Alignment, Decision, Motion, PlaceMatch, Verdict
from topomap.core.rig import Rig
from topomap.mapping.closures.claims import Claims
from topomap.mapping.closures.closure_tests import Knowledge
from topomap.mapping.closures.ledger import Ledger
from topomap.mapping.closures.online import Closing, ClosingSettings
from topomap.mapping.closures.robot_tests import RobotTests
from topomap.mapping.graph import TopoMap
from topomap.mapping.optimisation import Optimisation
from topomap.mapping.places.recognition import Moment, Proposal
from topomap.mapping.places.view_cache import ViewCache
from topomap.mapping.solve_due import OptimisationSettings
from topomap.mapping.track import Track

STEP, OUT = 0.1, 201  # [m], readings on the way out: 20 m
RIG = Rig(width=48, height=16, horizon_row=7.5, focal=48 / math.tau)
SURE, VAGUE = np.diag([1e-4, 1e-6, 1e-5]) ** 2, np.diag([0.3, 0.03, 0.02]) ** 2


def view(number: int) -> Panorama:
    """A plain view with a number in its corner."""
    image = np.full((16, 48, 3), 90, np.uint8)
    image[0, 0, 0] = number
    return Panorama(image, None, RIG)


class Costs:
    """An aligner that knows what each place costs, and finds the same rotation everywhere."""

    def __init__(self) -> None:
        self.costs: dict[int, float] = {}
        self.rotation = 0.0

    def align(self, current: Panorama, goal: Panorama, guess: float | None = None) -> Alignment:
        return Alignment(self.rotation, self.costs.get(int(goal.image[0, 0, 0]), 0.9))


class Drive:
    """A closing on a line of 20 m with a snapshot a metre, driven out, and then some way back in reverse."""

    def __init__(self, covariance: FloatArray, certainty: float = 0.5, tests: RobotTests | tuple[()] = ()) -> None:
        self.map = TopoMap()
        self.track, self.costs, self.ledger = Track(self.map), Costs(), Ledger()
        self._views = ViewCache(self.map)
        optimisation = Optimisation(OptimisationSettings(), self.costs, self.map)
        settings = ClosingSettings(certainty=certainty)
        self.closing = Closing(settings, self.costs, self.track, self._views, self.ledger, optimisation, tests)
        self._covariance = covariance
        self._stamp = 0
        self.go(OUT)
        self.go(10)  # back at place 19

    def go(self, steps: int) -> None:
        for _ in range(steps):
            self._stamp += 1
            way = STEP if self._stamp <= OUT else -STEP
            self.track.advance(self._stamp, Motion(way, 0.0, 0.0, self._covariance, 0.25))
            if self._stamp % 10 == 1:
                self._views.put(self.track.node_at(self._stamp), view(len(self.map.nodes) - 1))

    def propose(self, places: dict[int, float], rivals: dict[int, float] | None = None) -> Decision:
        """Let place search propose the places of these costs, the first one most alike; return the last verdict."""
        asked = rivals or {}
        self.costs.costs = {**places, **asked}
        near, far = (tuple(PlaceMatch(node, 0.3, 0.0) for node in some) for some in (places, asked))
        known = {place.node: 0.3 for place in near}
        moment = Moment(self._stamp, self.track.travel, view(200), near, (*near, *far), known)
        return self.closing.judge(self._stamp, Proposal(moment, near, (*near, *far), 0.5))[-1]


def test_where_odometry_leaves_no_other_place_one_closure_stands_alone() -> None:
    drive = Drive(SURE)
    made = drive.propose({19: 0.3})
    assert made.verdict is Verdict.ACCEPTED
    assert "odometry allows it: 0.0 m" in made.reason
    assert [(edge.i, edge.j) for edge in drive.map.closures] == [(19, made.candidate.query)]


def test_what_is_no_more_alike_than_other_places_are_is_refused() -> None:
    drive = Drive(SURE)
    drive.costs.costs = {19: 0.3}
    unlike = PlaceMatch(19, 0.6, 0.0)
    moment = Moment(drive._stamp, drive.track.travel, view(200), (unlike,), (unlike,), {19: 0.6})
    made = drive.closing.judge(drive._stamp, Proposal(moment, (unlike,), (unlike,), 0.5))[-1]
    assert (made.verdict, made.reason) == (
        Verdict.REFUSED, "the view is as unlike it as other places are (0.60 > 0.50)",
    )  # fmt: skip


def test_a_place_out_of_reach_that_wins_is_refused_and_nothing_is_closed() -> None:
    drive = Drive(VAGUE)
    made = drive.propose({19: 0.6}, {4: 0.3})
    assert (made.verdict, made.reason) == (Verdict.REFUSED, "the place most alike is out of the odometry's reach")
    assert not drive.map.closures


def test_a_rival_out_of_reach_counts_where_odometry_leaves_several_places_open() -> None:
    drive = Drive(VAGUE)
    assert "another place is nearly as alike" in drive.propose({19: 0.5}, {4: 0.52}).reason
    sure = Drive(SURE)
    assert sure.propose({19: 0.5}, {4: 0.52}).verdict is Verdict.ACCEPTED


@pytest.mark.parametrize(("degrees", "accepted"), [(10.0, True), (12.2, False), (15.0, False)])
def test_odometry_stops_what_is_off_by_more_than_19_in_20_true_ones(degrees: float, accepted: bool) -> None:
    """2.5, 3.05 and 3.8 sigmas of the rotation by sight; 2.8 are allowed."""
    drive = Drive(SURE)
    drive.costs.rotation = math.radians(degrees)
    made = drive.propose({19: 0.3})
    assert (made.verdict is Verdict.ACCEPTED) is accepted
    assert ("odometry allows" if accepted else "odometry contradicts") in made.reason


def test_where_several_places_are_open_three_must_agree() -> None:
    drive = Drive(VAGUE)
    verdicts = []
    for place in (19, 18, 17):
        verdicts.append(drive.propose({place: 0.3}, {4: 0.8}).verdict)
        drive.go(10)
    assert verdicts == [Verdict.PENDING, Verdict.PENDING, Verdict.ACCEPTED]
    assert sorted(edge.i for edge in drive.map.closures) == [17, 18, 19]


def test_what_hardly_beats_its_rival_needs_more_votes() -> None:
    drive = Drive(VAGUE)
    verdicts = []
    for place in (19, 18, 17):
        verdicts.append(drive.propose({place: 0.7}, {4: 0.8}).verdict)  # half a vote each
        drive.go(10)
    assert verdicts == [Verdict.PENDING] * 3


def test_an_unmeasured_place_that_looks_as_all_others_do_waits() -> None:
    drive = Drive(SURE)
    for _ in range(10):  # what places elsewhere cost becomes known
        drive.propose({19: 0.3}, {4: 0.6, 9: 0.6})
    made = drive.propose({19: 0.6}, {4: 0.6, 9: 0.6})
    assert made.verdict is Verdict.PENDING
    assert "it may as well be a look-alike (log odds -" in made.reason
    assert (made.candidate.evidence.looks or 0.0) < -2.0
    assert drive.propose({19: 0.3}, {4: 0.6, 9: 0.6}).verdict is Verdict.ACCEPTED


def test_who_asks_for_more_certainty_waits_for_others() -> None:
    drive = Drive(SURE, certainty=0.9999)
    assert drive.propose({19: 0.3}).verdict is Verdict.PENDING


def test_an_active_check_counts_and_a_contradiction_refuses() -> None:
    drive = Drive(VAGUE)
    first = drive.propose({19: 0.3}, {4: 0.8})
    drive.go(10)
    assert drive.propose({18: 0.3}, {4: 0.8}).verdict is Verdict.PENDING
    drive.closing.testify(first.candidate, True, "it was seen from near")
    made = drive.closing.judge(drive._stamp, None)
    assert [d.verdict for d in made] == [Verdict.ACCEPTED, Verdict.ACCEPTED]
    other = Drive(VAGUE)
    waiting = other.propose({19: 0.3}, {4: 0.8})
    other.closing.testify(waiting.candidate, False, "it wasn't there")
    assert [(d.verdict, d.reason) for d in other.closing.judge(other._stamp, None)] == [
        (Verdict.REFUSED, "it wasn't there")
    ]


def test_what_nothing_supports_in_time_is_refused() -> None:
    drive = Drive(VAGUE)
    drive.propose({19: 0.3}, {4: 0.8})
    drive.go(85)
    late = drive.closing.judge(drive._stamp, None)
    assert [d.verdict for d in late] == [Verdict.REFUSED]
    assert "no other closure agreed in time" in late[0].reason


class Never:
    name, lowers = "never", True

    def weigh(self, claims: Claims, knowledge: Knowledge) -> FloatArray:
        return np.full(len(claims), -np.inf)


def test_a_users_list_of_tests_takes_the_place_of_the_robots() -> None:
    drive = Drive(SURE, tests=RobotTests(sight=(Never(),)))
    made = drive.propose({19: 0.3})
    assert (made.verdict, made.reason) == (Verdict.REFUSED, "the test 'never' speaks against it")
    free = Drive(SURE, tests=RobotTests(sight=(), spot=(), place=()))
    assert free.propose({19: 5.0}).verdict is Verdict.ACCEPTED


def test_the_list_is_asked_in_parts_that_make_the_whole() -> None:
    tests = RobotTests()
    parts = [test for stage in tests.stages() for test in tests.all()[stage]]
    assert parts == list(tests.all())
