"""Small pieces of what drives and judges, each where a mistake in it would show."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest
from maps import square
from played import taught

from topomap.core.panorama import Panorama
from topomap.navigation import odometry_check
from topomap.navigation.homeward import METHOD_SIGMA, Homeward
from topomap.navigation.journey import Journey
from topomap.navigation.localiser import belief
from topomap.navigation.localiser.belief import LOOK, Belief
from topomap.navigation.localiser.fix import Fix
from topomap.navigation.localiser.mixture import Mixture
from topomap.navigation.navigator import Navigator
from topomap.navigation.odometry_check import TURN_BEYOND, Restated
from topomap.navigation.robot_check.directions import Roll, _compared
from topomap.navigation.sense_check import RANGES_STEPS, SenseCheck

READINGS = taught(3)


def test_while_a_manoeuvre_has_the_wheels_the_journey_pauses() -> None:
    calls: list[str] = []
    traveller = SimpleNamespace(pause=lambda: calls.append("pause"), step=lambda *_: calls.append("step") or "drive")
    for found, answer, told in (("back off", "back off", ["pause"]), (None, "drive", ["step"])):
        calls.clear()
        navigator = SimpleNamespace(_manoeuvre=lambda *_, found=found: found, _traveller=traveller, mapper=None)
        assert Navigator._travel(navigator, None, None, None) == answer
        assert calls == told


def test_a_restated_reading_is_the_reading_but_for_its_motion() -> None:
    reading, motion = READINGS[1], READINGS[2].motion
    restated = Restated(reading, motion)
    for name in ("stamp_ns", "image", "ranges", "rig", "contact", "driven"):
        assert getattr(restated, name) is getattr(reading, name), name
    assert restated.driven is True
    assert restated.motion is motion


def test_a_turn_is_sought_about_half_of_what_was_told(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[tuple[float, float]] = []
    monkeypatch.setattr(odometry_check, "rotation_within", lambda a, b, about, reach: asked.append((about, reach)))
    view = Panorama.from_reading(READINGS[0])
    for told in (0.2, -0.2):
        odometry_check._turned(view, view, told)
    assert asked == [(0.1, 0.1 + TURN_BEYOND), (-0.1, 0.1 + TURN_BEYOND)]


def test_rolls_and_turns_belong_together_as_they_are() -> None:
    turns = np.array([0.1, -0.2, 0.05, 0.0])
    found = _compared(1.5 * turns, turns)
    assert (found.ratio, found.agreement) == pytest.approx((1.5, 1.0))
    assert found.turned == pytest.approx(0.3, abs=0.051)
    assert _compared(np.zeros(0), np.zeros(0)) == _compared(np.ones(2), np.zeros(2)) == Roll(0.0, 0.0, 0.0)


def test_ranges_are_lost_after_so_many_readings_without() -> None:
    check, view = SenseCheck(), Panorama.from_reading(READINGS[0])
    assert view.ranges is not None
    dead = Panorama(view.image, np.full_like(view.ranges, np.nan), view.rig)
    assert check._ranges(view) is not None
    told = [check._ranges(dead) is None for _ in range(RANGES_STEPS + 1)]
    assert told == [False] * (RANGES_STEPS - 1) + [True] * 2
    assert check._ranges(view) is not None


def test_each_edge_up_to_a_place_was_passed_in_its_share_of_the_time() -> None:
    topo = square()
    journey = SimpleNamespace(course=SimpleNamespace(path=[0, 1, 2, 3, 4]), last=1, left_ns=10_000_000_000)
    Journey.passed(journey, topo, 3, 16_000_000_000)
    assert [topo.experience.of(a, a + 1).passed for a in range(4)] == [0, 1, 1, 0]
    assert topo.experience.of(1, 2).seconds == topo.experience.of(2, 3).seconds == 3.0
    assert (journey.last, journey.left_ns) == (3, 16_000_000_000)


def test_only_a_methods_bearing_has_a_least_error() -> None:
    for method, sigma in ((None, 0.0), ("some method", METHOD_SIGMA)):
        assert Homeward(SimpleNamespace(method=method, policy=None), None, 0.4)._least_sigma == sigma


class Looked(Exception):
    """Raised by what is asked once a look is taken."""


def test_a_belief_looks_where_there_is_something_to_hold_the_view_against_and_it_can_have_changed() -> None:
    def nodes() -> None:
        raise Looked

    mapper = SimpleNamespace(recognition=SimpleNamespace(nodes=nodes))
    held = Belief(Mixture.at(np.zeros(3), np.eye(3), 0.1), square())
    view = Panorama.from_reading(READINGS[0])
    held.see(view, mapper, 0)
    with pytest.raises(Looked):
        held.see(view, mapper, 1)
    held._since_look = LOOK - 1e-6
    held.see(view, mapper, 1)


def test_a_fix_is_turned_into_the_maps_axes_with_its_errors(monkeypatch: pytest.MonkeyPatch) -> None:
    topo = square()
    place, spread = topo.poses[6], np.diag([0.04, 0.0004, 0.01])
    monkeypatch.setattr(belief, "fix", lambda *_: Fix(np.array([0.1, 0.0, 0.0]), spread))
    held = Belief(Mixture.at(place, np.diag([4.0, 4.0, 4.0]), 1e-9), topo)
    held.likeness = 0.1
    mapper = SimpleNamespace(map=topo, view_cache=SimpleNamespace(panorama=lambda _: None))
    held._fix(None, mapper, np.arange(len(topo.nodes)))
    c, s = math.cos(place[2]), math.sin(place[2])
    assert held.mixture.poses[0] == pytest.approx(np.add(place, [0.1 * c, 0.1 * s, 0.0]), abs=0.01)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    assert held.mixture.covariances[0] == pytest.approx(turn @ spread @ turn.T, rel=0.02, abs=1e-3)
