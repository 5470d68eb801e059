"""Align, ask, turn back, for all three contracts; references taken and predicted; methods found by name."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np
import pytest
from homing_fakes import Knowing, KnowingCompass, TellingViews, told
from scenes import Room, view

from topomap.core.errors import DataError
from topomap.core.geometry import TAU, Pose2, wrap
from topomap.core.panorama import Panorama
from topomap.core.records import Alignment, HomeVector
from topomap.vision.aligned_homing import AlignedHoming
from topomap.vision.compass import ALIGNERS, MinWarpingCompass
from topomap.vision.contracts import Aligner, GoalView, HomingMethod, HomingPolicy, ReferenceHoming
from topomap.vision.home import home
from topomap.vision.homing import METHODS, POLICIES, REFERENCE_METHODS, Needs
from topomap.vision.image.aligned_difference import aligned_difference
from topomap.vision.image.displaced import displaced
from topomap.vision.registry import aligned_homing

HERE, GOAL = Pose2(1.0, 0.5, TAU / 4), Pose2(-0.5, 0.5, TAU / 8)


def seen(pose: Pose2) -> Panorama:
    return TellingViews().view(pose.x, pose.y, pose.heading)


@dataclass
class Counting:
    """Knows the way, counts its work, has no hash, and wants references."""

    step: float = 0.1
    goals: list[GoalView] = field(default_factory=list)
    needs = Needs(compass=True)
    claims_homing = True

    def home(self, current: Panorama, goal: GoalView) -> HomeVector:
        self.goals.append(goal)
        x, y, heading = told(current)
        there = told(goal.home)
        return HomeVector(wrap(math.atan2(there[1] - y, there[0] - x) - heading))


@dataclass
class Describing:
    """Counts how often it describes, and has no hash."""

    described: int = 0
    needs = Needs()
    claims_homing = True

    def describe(self, panorama: Panorama) -> int:
        self.described += 1
        return self.described

    def home(self, current: int, goal: int) -> HomeVector:
        return HomeVector(0.1 * current)


@dataclass(frozen=True)
class Step:
    """A policy that counts its steps and goes straight to the goal in the aligned frame."""

    needs = Needs(compass=True)
    claims_homing = True

    def start(self, goal: Panorama) -> tuple[int, Panorama]:
        return 0, goal

    def step(self, state: tuple[int, Panorama], current: Panorama) -> tuple[tuple[int, Panorama], HomeVector]:
        x, y, heading = told(current)
        there = told(state[1])
        return (state[0] + 1, state[1]), HomeVector(wrap(math.atan2(there[1] - y, there[0] - x) - heading), 0.2)


@pytest.mark.parametrize("method", [Knowing(), Knowing(compass=False), Counting()])
def test_the_answer_is_in_the_robots_own_frame(method: HomingMethod[object] | ReferenceHoming) -> None:
    homing = AlignedHoming(KnowingCompass(), method)
    found = homing.home(seen(HERE), seen(GOAL))
    assert found.alignment.rotation == pytest.approx(TAU / 8)
    assert found.home.bearing == pytest.approx(HERE.bearing_to(GOAL), abs=1e-6)
    assert homing.ask(seen(HERE), seen(GOAL), TAU / 8) == found.home
    assert homing.align(seen(HERE), seen(GOAL)) == Alignment(found.alignment.rotation, 0.0, found.home)


def test_a_policy_moves_in_the_robots_own_frame_and_homes_by_its_aligner() -> None:
    homing = AlignedHoming(KnowingCompass(), Step())
    assert homing.policy == Step()
    state, move = homing.move(Step().start(seen(GOAL)), seen(HERE), TAU / 8)
    assert state[0] == 1
    assert (move.bearing, move.distance) == (pytest.approx(HERE.bearing_to(GOAL), abs=1e-6), 0.2)
    assert homing.home(seen(HERE), seen(GOAL)).home.confidence == 0.0
    assert AlignedHoming(MinWarpingCompass(), Step()).home(seen(HERE), seen(GOAL)).home == (
        MinWarpingCompass().align(seen(HERE), seen(GOAL)).home
    )


def test_a_goal_is_described_once_even_by_a_method_without_a_hash() -> None:
    method, goal = Describing(), seen(GOAL)
    homing = AlignedHoming(KnowingCompass(), method)
    for k in range(3):
        homing.home(seen(Pose2(0.1 * k, 0.0)), goal)
    assert method.described == 4
    AlignedHoming(KnowingCompass(), Describing()).home(seen(HERE), goal)
    assert method.described == 4, "another's descriptions are its own"


def test_references_that_were_taken_are_used_and_others_predicted_once() -> None:
    method, goal = Counting(step=0.3), seen(GOAL)
    homing = AlignedHoming(KnowingCompass(), method)
    given = GoalView(goal, goal, goal, 0.3)
    homing.ask(seen(HERE), given, 0.0)
    homing.ask(seen(HERE), goal, 0.0)
    homing.ask(seen(GOAL), goal, 0.0)
    assert method.goals[0] is given
    assert method.goals[1] is method.goals[2]
    assert method.goals[1].home is goal
    assert method.goals[1].step == 0.3


@pytest.mark.parametrize(("source", "share"), [("ranges", 0.6), ("ground line", 0.75), ("neither", 0.95)])
@pytest.mark.parametrize("way", [(0.1, 0.0), (0.0, 0.1), (-0.2, 0.2)])
def test_a_predicted_view_is_nearer_to_the_true_one_than_the_view_it_is_made_of(
    way: tuple[float, float], source: str, share: float
) -> None:
    heading, room = 0.7, Room(4)
    start = Pose2(3.7, 2.8, heading)
    there = start @ Pose2(*way)
    here, true = room.at(start), room.at(there)
    if source != "ranges":
        height = here.rig.camera_height if source == "ground line" else 0.0  # without it the ground line tells nothing
        here = Panorama(here.image, None, replace(here.rig, camera_height=height))
    predicted = displaced(here, *way)
    wrong = displaced(here, -way[0], -way[1])
    far = aligned_difference(here, true, 0.0)
    assert aligned_difference(predicted, true, 0.0) < share * far
    assert aligned_difference(wrong, true, 0.0) > far


@pytest.mark.parametrize("name", ["did", "masks-3"])
def test_predicted_references_lead_home_as_taken_ones_do(name: str) -> None:
    goal, method, errors = Pose2(3.7, 2.8, 0.4), REFERENCE_METHODS[name], []
    for k in range(8):
        pose = goal @ Pose2(0.4 * math.cos(k * TAU / 8), 0.4 * math.sin(k * TAU / 8))
        found = AlignedHoming(KnowingCompass(), method).ask(view(pose), view(goal), 0.0)
        errors.append(abs(wrap(found.bearing - pose.bearing_to(goal))))
    assert math.degrees(float(np.mean(errors))) < 30.0


def test_a_method_that_aligns_by_itself_is_asked_once_unless_another_aligner_is_wanted() -> None:
    for name in ("min-warping", "epipolar", "auto", "rearrangement"):
        assert aligned_homing(name).aligner is ALIGNERS[name]
        assert aligned_homing(name).method is None
        assert aligned_homing(name, name).method is None
    apart = aligned_homing("min-warping", "visual-compass")
    assert apart.aligner is ALIGNERS["visual-compass"]
    assert apart.method is METHODS["min-warping"]
    assert aligned_homing("acv").aligner is ALIGNERS["min-warping"]
    assert aligned_homing(POLICIES["run-down"]).policy is POLICIES["run-down"]


def test_objects_are_taken_for_what_they_are() -> None:
    assert aligned_homing(KnowingCompass()).method is None
    own, compass = Describing(), KnowingCompass()
    both = aligned_homing(own, compass)
    assert (both.method, both.aligner) == (own, compass)
    assert both.method is own
    with pytest.raises(DataError, match="is no homing method"):
        aligned_homing(object())  # type: ignore[arg-type]


def test_every_method_of_the_registry_keeps_exactly_one_contract() -> None:
    contracts = (HomingMethod, ReferenceHoming, HomingPolicy)
    for table, contract in ((METHODS, HomingMethod), (REFERENCE_METHODS, ReferenceHoming), (POLICIES, HomingPolicy)):
        for method in table.values():
            assert [one for one in contracts if isinstance(method, one)] == [contract]
    assert all(isinstance(one, Aligner) for one in ALIGNERS.values())


@pytest.mark.parametrize("method", ["acv", "did", "run-down", "min-warping", "rearrangement", METHODS["acv"]])
def test_home_takes_any_of_them(method: str) -> None:
    goal = Pose2(3.7, 2.8, 0.4)
    pose = Pose2(3.2, 2.8, 0.4 + TAU / 4)
    found = home(view(pose), view(goal), method)
    assert math.isfinite(found.bearing)
    if method != "run-down":  # whose first move may be wrong
        assert abs(wrap(found.bearing - pose.bearing_to(goal))) < math.radians(45)


def test_home_by_an_unknown_name_lists_the_known_ones() -> None:
    with pytest.raises(DataError, match=r"unknown homing method 'nope'; there are alv, .*auto.*did.*run-down"):
        home(view(HERE), view(GOAL), "nope")
