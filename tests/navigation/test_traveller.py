"""Journeys of a robot whose place and belief are set by the test: arrival, passing, recovery, giving up."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
import pytest
from homing_fakes import RIG, Knowing, KnowingCompass, TellingViews
from maps import STEP_NS
from roamer import Roamer, difference

from topomap.core.errors import DataError
from topomap.core.geometry import Pose2, wrap
from topomap.core.panorama import Panorama
from topomap.core.records import Alignment, Command, Goal, HomeVector, Hypothesis, Phase, Where
from topomap.navigation import sight
from topomap.navigation.homeward import POLICY_REST
from topomap.navigation.manoeuvres.back_off import SPEED, STEPS
from topomap.navigation.recovery import LADDER, Remedy, Trouble
from topomap.navigation.senses import Health, Senses
from topomap.navigation.traveller import STAND_STEPS, Traveller, TravelSettings
from topomap.vision.aligned_homing import AlignedHoming
from topomap.vision.homing import Needs


@pytest.fixture(autouse=True)
def places_look_their_own_way(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sight, "aligned_difference", difference)


def test_it_flows_through_the_milestones_and_stops_at_the_goal_only() -> None:
    robot = Roamer()
    last = robot.travel(6)
    assert (last.phase, last.note) == (Phase.ARRIVED, "goal reached")
    assert robot.pose.distance(robot.topo.pose(6)) < 0.1
    assert robot.notes()[:-1] == ["milestone reached"] * (len(robot.notes()) - 1)
    moving = [command.forward for command in robot.commands[:-1]]
    assert min(moving) > 0.1
    assert robot.way / (len(moving) * 0.25) > 0.3


def test_already_there_is_seen_and_a_second_goal_is_travelled_to() -> None:
    robot = Roamer()
    assert robot.travel(0).note == "goal reached"
    assert len(robot.travels) == 1
    assert robot.travel(4).phase is Phase.ARRIVED
    assert robot.pose.distance(robot.topo.pose(4)) < 0.1
    assert robot.travel(0).phase is Phase.ARRIVED
    assert robot.pose.distance(robot.topo.pose(0)) < 0.1


def test_already_there_is_not_believed_where_the_view_is_another() -> None:
    blind = AlignedHoming(KnowingCompass(), Knowing(silent_beyond=-9.0))
    robot = Roamer(pose=Pose2(0.0, 2.0), homing=blind, believed=lambda pose: Pose2(0.0, 0.0, pose.heading))
    robot.wall = lambda before, after: math.hypot(after.x, after.y - 2.0) > 1.0
    assert robot.travel(0, 1500).phase is Phase.FAILED
    assert "goal reached" not in robot.notes()


@pytest.mark.parametrize(
    ("kind", "says"),
    [
        ({"believed": lambda pose: Pose2(pose.x - 2.0, pose.y, pose.heading)}, "it is believed to be 2.0 m away"),
        ({"lost": 0.4}, "lost with a probability of 0.40"),
        ({"rivals": (Hypothesis(9, Pose2(9.0, 9.0), 0.4),)}, "with a probability of 0.40 it is another place"),
    ],
)
def test_the_goals_view_alone_is_no_arrival(kind: dict[str, object], says: str) -> None:
    robot = Roamer(pose=Pose2(0.3, 0.0, math.pi), **kind)
    last = robot.travel(0, 2500)
    assert last.phase is Phase.FAILED
    assert "goal reached" not in robot.notes()
    if "believed" not in kind:  # else the robot drives to where it believes the goal to be
        assert any(f"looks like the goal, but {says}" in note for note in robot.notes())


def test_a_look_alike_place_with_the_wrong_heading_is_no_arrival() -> None:
    robot = Roamer(believed=lambda pose: Pose2(pose.x, pose.y, pose.heading + 1.5))
    robot.travel(0, 30)
    assert any("its view is turned by" in note for note in robot.notes())


@dataclass(frozen=True)
class NearPrior:
    """A compass that searches half a radian around what it is told, as aligners do."""

    def align(self, current: Panorama, goal: Panorama, prior: float | None = None) -> Alignment:
        true = KnowingCompass().align(current, goal).rotation
        return Alignment(true if prior is None or abs(wrap(true - prior)) < 0.5 else prior, 0.0)


@pytest.mark.parametrize("off", [math.pi / 2, -math.pi / 2, math.pi])
def test_a_wrong_heading_is_found_by_the_full_turn(off: float) -> None:
    homing = AlignedHoming(NearPrior(), Knowing())
    views = TellingViews()
    place = sight.Sight(0, 0, views.view(0.0, 0.0, 0.0), off)
    look = place.look(views.view(0.1, 0.0, 0.3), homing)
    assert look.turned
    assert look.rotation == pytest.approx(0.3, abs=0.02)
    told = sight.Sight(0, 0, views.view(0.0, 0.0, 0.0), 0.4).look(views.view(0.1, 0.0, 0.3), homing)
    assert not told.turned
    sure = sight.Sight(0, 0, views.view(0.0, 0.0, 0.0), math.pi)
    sure.expect(0.4)  # as a belief has it that is sure; a view that is alike turned round doesn't change that
    assert sure.rotation == 0.4
    sure.expect(0.5)
    assert sure.rotation == 0.4  # the compass tells that better
    narrow = sight.Sight(0, 0, views.view(0.0, 0.0, 0.0), math.pi)
    assert not narrow.look(views.view(0.1, 0.0, 0.3), homing, wide=False).turned
    assert told.rotation == pytest.approx(0.3, abs=0.02)


def test_a_goal_that_is_no_node_is_one_line_with_the_range() -> None:
    last = Roamer().travel(99)
    assert last.phase is Phase.FAILED
    assert last.note == "no route from node 0 to node 99: there is no node 99, the map's nodes are 0 to 32"


def test_a_goal_without_a_view_is_reached_by_pose_beside_a_place_that_was_seen() -> None:
    robot = Roamer()
    bare = robot.topo.insert(12 * STEP_NS)
    last = robot.travel(bare)
    assert last.phase is Phase.ARRIVED
    assert f"node {bare} has no view of its own" in last.note
    assert robot.pose.distance(robot.topo.pose(bare)) < 0.15


def blocked_at(x: float) -> Roamer:
    """A robot on the square's southern side with an unseen wall across it, that its body, 0.2 m, can't pass."""

    def hits(before: Pose2, after: Pose2) -> bool:
        return after.y < 1.0 and abs(after.x - x) < 0.2 and abs(after.x - x) < abs(before.x - x)

    return Roamer(wall=hits)


def test_a_blocked_way_is_gone_round_and_every_remedy_is_said_in_order() -> None:
    robot = blocked_at(2.25)
    last = robot.travel(8, 3000)
    assert last.phase is Phase.ARRIVED
    said = [note for note in robot.notes() if note.startswith(Trouble.BLOCKED)]
    assert said == [f"{Trouble.BLOCKED}: {remedy}" for remedy in LADDER[Trouble.BLOCKED][: len(said)]]
    assert said[-1].endswith(Remedy.REPLAN)
    assert robot.topo.experience.of(4, 5).failed == 1
    assert robot.topo.experience.of(0, 32).passed == 1


def test_a_blocked_only_way_is_said_and_the_wheels_stand() -> None:
    robot = blocked_at(2.25)
    robot.topo.remove(robot.topo.closures[0])
    last = robot.travel(8, 3000)
    assert last.phase is Phase.FAILED
    assert last.note == "gave up on the way to node 8: no way through"
    assert any("the only way is blocked" in note for note in robot.notes())
    assert robot.commands[-1] == Command()


def test_a_way_that_clears_is_driven_on_and_the_ladder_begins_anew() -> None:
    robot = blocked_at(1.25)
    for _ in range(150):
        robot.step(8)
    robot.wall = lambda before, after: False
    assert robot.travel(8, 600).phase is Phase.ARRIVED
    tried = robot.notes()
    assert f"{Trouble.BLOCKED}: {Remedy.LOOK}" in tried
    assert f"{Trouble.BLOCKED}: {Remedy.REPLAN}" not in tried


def test_the_lost_look_and_then_give_up() -> None:
    robot = Roamer(lost=0.9, homing=AlignedHoming(KnowingCompass(), Knowing(silent_beyond=-9.0)))
    last = robot.travel(8, 3000)
    assert last.phase is Phase.FAILED
    said = [note.partition(": ")[2] for note in robot.notes() if note.startswith(f"{Trouble.LOST}:")]
    assert said == [str(remedy) for remedy in LADDER[Trouble.LOST][:-1]]
    about = next(k for k, travel in enumerate(robot.travels) if travel.note.endswith(Remedy.RELOCALISE))
    assert all(command.forward > 0.1 for command in robot.commands[about + 10 : about + 40])


def test_without_a_view_the_wheels_stand_and_in_the_end_it_says_so() -> None:
    robot = Roamer()
    for _ in range(5):
        robot.step(8)
    robot.health = Health(stop="the camera shows nothing")
    last = robot.travel(8)
    assert last.phase is Phase.FAILED
    assert last.note == "the camera shows nothing"
    assert robot.commands[5:] == [Command()] * (STAND_STEPS + 1)


def test_a_contact_backs_off() -> None:
    robot = Roamer()
    for _ in range(5):
        robot.step(8)
    robot.contact = True
    robot.step(8)
    robot.contact = False
    for _ in range(STEPS):
        robot.step(8)
    assert [command.forward for command in robot.commands[5 : 5 + STEPS]] == [-SPEED] * STEPS
    assert robot.commands[5 + STEPS].forward >= 0.0
    assert "contact: backing off" in robot.notes()


@dataclass(frozen=True)
class Stays:
    """A policy that never moves."""

    needs = Needs()
    claims_homing = True
    looks: list[int] = field(default_factory=list)

    def start(self, goal: Panorama) -> int:
        return 0

    def step(self, state: int, current: Panorama) -> tuple[int, HomeVector]:
        self.looks.append(state)
        return state + 1, HomeVector(0.0, 0.0)


def test_a_policys_leg_counts_looks_and_ends_after_a_round_without_a_new_minimum() -> None:
    robot = Roamer(pose=Pose2(0.1, 0.0), homing=AlignedHoming(KnowingCompass(), Stays()))
    robot.travel(0, 40)
    assert robot.travels[-1].phase is Phase.ARRIVED
    assert len(robot.travels) == POLICY_REST + 1


@dataclass(frozen=True)
class Wanting:
    """A method that needs ranges."""

    needs = Needs(ranges=True)
    claims_homing = True

    def describe(self, panorama: Panorama) -> int:
        return 0

    def home(self, current: int, goal: int) -> HomeVector:
        return HomeVector(0.0)


def test_a_lack_is_said_at_the_first_view_of_the_lesson() -> None:
    traveller = Traveller(TravelSettings(), AlignedHoming(KnowingCompass(), Wanting()))
    blind = Panorama(np.zeros((2, 360, 3), np.uint8), None, RIG)
    robot = Roamer()
    with pytest.raises(DataError, match="needs measured ranges"):
        traveller.step(Senses(0, blind), Where(Pose2(), 0, 0.0, 0.0), Goal(Phase.TEACH), robot._mapper())


@dataclass(frozen=True)
class BothWays:
    """A compass in a corridor that looks alike both ways: the true rotation or the opposite one, the nearer."""

    def align(self, current: Panorama, goal: Panorama, prior: float | None = None) -> Alignment:
        true = KnowingCompass().align(current, goal).rotation
        turned = abs(wrap(true - (prior or 0.0))) > math.pi / 2
        return Alignment(wrap(true + math.pi) if turned else true, 0.0)


def alike(current: Panorama, goal: Panorama, rotation: float) -> float:
    """The view turned round is the one a little more alike."""
    return min(difference(current, goal, rotation), 0.05 + 0.3 * difference(current, goal, rotation + math.pi))


@pytest.mark.parametrize("lost", [0.0, 0.06, 0.3])
def test_a_belief_that_is_likelier_right_than_wrong_is_not_turned_round_by_a_view(
    lost: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sight, "aligned_difference", alike)
    monkeypatch.setattr(sight.Sight, "_elsewhere", lambda self, panorama, rotation: wrap(rotation + math.pi))
    robot = Roamer(pose=Pose2(0.05, 0.0, 0.0), lost=lost, homing=AlignedHoming(BothWays(), Knowing()))
    robot.travel(6, 25)
    assert robot.pose.x > 1.5
    assert max(abs(command.turn) for command in robot.commands) < 0.5
