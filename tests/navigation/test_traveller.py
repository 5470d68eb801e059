"""Whose bearing the robot follows on a leg: the method's, or the map's where that one leads away or says nothing."""

from __future__ import annotations

import math
from dataclasses import dataclass
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from homing_fakes import RIG, KnowingCompass, TellingViews

from topomap.core.errors import DataError
from topomap.core.geometry import Pose2
from topomap.core.panorama import Panorama
from topomap.core.records import Alignment, Goal, HomeVector, Phase, Travel, Where
from topomap.mapping.mapper import Mapper
from topomap.navigation import arrival, traveller
from topomap.navigation.traveller import Traveller, TravelSettings
from topomap.vision.aligned_homing import AlignedHoming
from topomap.vision.homing import Needs

GOAL = Goal(Phase.TRAVEL, 0)
NEVER = TravelSettings()


@pytest.fixture(autouse=True)
def never_there(monkeypatch: pytest.MonkeyPatch) -> None:
    """No view is like the milestone's, so that no leg ends by arrival."""
    monkeypatch.setattr(arrival, "SAME", 1e-9)
    monkeypatch.setattr(arrival, "MINIMUM_BELOW", 1e-9)


@dataclass(frozen=True)
class Fixed:
    """Always gives the same home vector."""

    bearing: float
    confidence: float = 1.0
    ranges: bool = False
    claims_homing: bool = True

    @property
    def needs(self) -> Needs:
        return Needs(ranges=self.ranges)

    def describe(self, panorama: Panorama) -> int:
        return 0

    def home(self, current: int, goal: int) -> HomeVector:
        return HomeVector(self.bearing, None, self.confidence)

    def align(self, current: Panorama, goal: Panorama, prior: float | None = None) -> Alignment:
        return Alignment(0.0, 0.0, HomeVector(self.bearing, None, self.confidence))


@dataclass(frozen=True)
class Method:
    """The same as a method only."""

    fixed: Fixed
    claims_homing: bool = True

    def __post_init__(self) -> None:
        object.__setattr__(self, "needs", self.fixed.needs)
        object.__setattr__(self, "describe", self.fixed.describe)
        object.__setattr__(self, "home", self.fixed.home)


def mapper() -> Mapper:
    """A map of one milestone, at its origin."""
    topo = SimpleNamespace(pose=lambda node: Pose2(), nodes=[None])
    cache = SimpleNamespace(panorama=lambda node: TellingViews().view(0.0, 0.0, 0.0))
    return cast(Mapper, SimpleNamespace(map=topo, view_cache=cache, track=SimpleNamespace(raw=Pose2(), turn=0.0)))


@pytest.fixture(autouse=True)
def one_leg(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(traveller.planner, "route", lambda topo, start, goal: [0])
    monkeypatch.setattr(traveller, "aligned_difference", lambda *_: 0.5)


def followed(homing: AlignedHoming, *poses: Pose2, lost: float = 0.0) -> list[Travel]:
    """What the traveller does at poses on one leg to a milestone at the map's origin."""
    robot = Traveller(NEVER, homing)
    seen = TellingViews().view(2.0, 0.0, 0.0)
    return [robot.step(seen, 0.0, Where(pose, 0, 0.5, lost), GOAL, mapper())[1] for pose in poses]


def method(bearing: float, confidence: float = 1.0) -> AlignedHoming:
    return AlignedHoming(KnowingCompass(), Method(Fixed(bearing, confidence)))


FAR, NEAR = Pose2(2.0, 0.0, 0.0), Pose2(0.15, 0.0, 0.0)  # the milestone lies behind


@pytest.mark.parametrize("bearing", [math.pi, 2.0, -2.0])
def test_a_home_vector_that_leads_nearer_is_followed(bearing: float) -> None:
    assert followed(method(bearing), FAR)[0].home == HomeVector(bearing)


def test_one_that_leads_away_is_not_and_the_rest_of_the_leg_goes_by_the_map() -> None:
    travels = followed(method(0.5), FAR, NEAR, Pose2(0.0, 1.0, 0.0))
    bearings = [travel.home.bearing for travel in travels if travel.home]
    assert bearings == pytest.approx([math.pi, math.pi, -math.pi / 2])
    assert [travel.home.confidence for travel in travels if travel.home] == [0.0] * 3


def test_near_the_milestone_and_when_lost_the_map_is_not_asked() -> None:
    assert followed(method(0.5), NEAR)[0].home == HomeVector(0.5)
    assert followed(method(0.5), FAR, lost=0.9)[0].home == HomeVector(0.5)


def test_where_a_method_says_nothing_the_map_leads_and_the_method_may_speak_again() -> None:
    assert followed(method(0.0, 0.0), NEAR)[0].home == HomeVector(math.pi, None, 0.0)
    quiet = followed(method(0.0, 0.0), FAR, NEAR)
    assert [travel.home.bearing for travel in quiet if travel.home] == pytest.approx([math.pi, math.pi])


def test_a_leg_that_homing_gave_up_is_tried_again_by_the_map(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(traveller, "LEG_STEPS", 5)
    robot, seen = Traveller(NEVER, method(2.0)), TellingViews().view(2.0, 0.0, 0.0)
    travels = [robot.step(seen, 0.0, Where(FAR, 0, 0.5, 0.0), GOAL, mapper())[1] for _ in range(8)]
    assert [travel.home.bearing for travel in travels[:5] if travel.home] == pytest.approx([2.0] * 5)
    assert "given up" in travels[5].note
    assert [travel.home.bearing for travel in travels[6:] if travel.home] == pytest.approx([math.pi] * 2)


def test_what_aligns_and_homes_at_once_is_followed_even_unsure() -> None:
    assert followed(AlignedHoming(Fixed(0.5)), FAR)[0].home == HomeVector(0.5)
    assert followed(AlignedHoming(Fixed(0.5, 0.0)), FAR)[0].home == HomeVector(0.5, None, 0.0)


def test_a_lack_is_said_at_the_first_view_of_the_lesson_only() -> None:
    robot = Traveller(NEVER, AlignedHoming(KnowingCompass(), Method(Fixed(0.0, ranges=True))))
    blind, seeing = Panorama(np.zeros((2, 360, 3), np.uint8), None, RIG), TellingViews().view(0.0, 0.0, 0.0)
    here = Where(Pose2(), 0, 0.0, 0.0)
    with pytest.raises(DataError, match="needs measured ranges"):
        robot.step(blind, 0.0, here, Goal(Phase.TEACH), mapper())
    later = Traveller(NEVER, AlignedHoming(KnowingCompass(), Method(Fixed(0.0, ranges=True))))
    later.step(seeing, 0.0, here, Goal(Phase.TEACH), mapper())
    later.step(blind, 0.0, here, Goal(Phase.TEACH), mapper())


def test_a_policys_leg_counts_looks_and_ends_after_a_round_without_a_new_minimum(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(arrival, "MINIMUM_BELOW", 0.55)

    class Stays:
        needs = Needs()
        claims_homing = True

        def start(self, goal: Panorama) -> int:
            return 0

        def step(self, state: int, current: Panorama) -> tuple[int, HomeVector]:
            return state + 1, HomeVector(0.0, 0.0)

    robot = Traveller(NEVER, AlignedHoming(KnowingCompass(), Stays()))
    seen, where = TellingViews().view(0.0, 0.0, 0.0), Where(Pose2(), 0, 0.5, 0.0)
    travels = [robot.step(seen, 0.0, where, GOAL, mapper())[1] for _ in range(14)]
    arrived = next((k for k, travel in enumerate(travels) if travel.phase is Phase.ARRIVED), None)
    assert arrived == traveller.POLICY_REST
