"""The methods the stack steers by, on geometry: eight directions, the issue's limits, pictures that hold nothing."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scenes import around, view

from topomap.core.errors import DataError, ShapeError
from topomap.core.geometry import TAU, Pose2, wrap
from topomap.core.panorama import Panorama
from topomap.core.records import HomeVector
from topomap.core.rig import Rig
from topomap.vision.aligned_homing import AlignedHoming
from topomap.vision.compass import GivenHeading, MinWarpingCompass
from topomap.vision.homing import METHODS, AreaCentroid, DynamicWarping
from topomap.vision.matching.ring_flow import FLOW, fitted_flow

HOME = Pose2(3.7, 2.8, 0.4)
TOLERANCE = {"min-warping": 6.0, "dtw-wing": 5.0, "dtw-unifying": 5.0, "area-centroid": 3.0}
"""Mean error [deg] with a given compass, eight directions (all methods: test_conformance.py)."""


def found(name: str, pose: Pose2, seed: int, given: bool) -> HomeVector:
    aligner = GivenHeading() if given else MinWarpingCompass()
    prior = wrap(pose.heading - HOME.heading) if given else None
    return AlignedHoming(aligner, METHODS[name]).home(view(pose, seed), view(HOME, seed), prior).home


@pytest.mark.parametrize("given", [True, False], ids=["given", "A6"])
@pytest.mark.parametrize("distance", [0.4, 0.8])
@pytest.mark.parametrize("name", TOLERANCE)
def test_home_lies_where_geometry_says(name: str, distance: float, given: bool) -> None:
    errors = []
    for pose in around(HOME, distance):
        home = found(name, pose, 2, given)
        errors.append(abs(wrap(home.bearing - pose.bearing_to(HOME))))
        assert home.confidence > 0.3
        if home.distance is not None:
            assert home.distance == pytest.approx(distance, rel=0.15)
    assert math.degrees(float(np.mean(errors))) < TOLERANCE[name] + (0.0 if given else 1.5)
    assert math.degrees(max(errors)) < 25.0


@pytest.mark.parametrize("name", TOLERANCE)
def test_at_home_there_is_nowhere_to_go(name: str) -> None:
    home = METHODS[name].home(METHODS[name].describe(view(HOME)), METHODS[name].describe(view(HOME)))
    assert home.confidence == 0.0 or home.distance == 0.0


@pytest.mark.parametrize("name", [n for n in TOLERANCE if not METHODS[n].needs.ranges])
def test_empty_and_random_pictures_are_not_believed(name: str) -> None:
    rng = np.random.default_rng(3)
    blank = [Panorama(np.full((100, 720, 3), value, np.uint8)) for value in (0, 255)]
    random = [Panorama(rng.integers(0, 256, (100, 720, 3), dtype=np.uint8)) for _ in range(2)]
    for a, b in [blank, random, (blank[0], view(HOME)), (view(HOME), blank[1]), (random[0], view(HOME))]:
        home = METHODS[name].home(METHODS[name].describe(a), METHODS[name].describe(b))
        assert math.isfinite(home.bearing)
        assert home.confidence < 0.15


@pytest.mark.parametrize("name", TOLERANCE)
def test_purity(name: str) -> None:
    a, b = view(Pose2(3.2, 2.6, 0.4)), view(HOME)
    again = Panorama(a.image.copy(), a.ranges), Panorama(b.image.copy(), b.ranges)
    method = METHODS[name]
    first = method.home(method.describe(a), method.describe(b))
    assert first == method.home(method.describe(again[0]), method.describe(again[1]))


def test_ranges_with_gaps_still_home_and_none_at_all_say_so() -> None:
    pose = Pose2(3.3, 2.4, HOME.heading)
    here, there = view(pose), view(HOME)
    assert here.ranges is not None
    holes = here.ranges.copy()
    holes[100:160] = np.nan
    method = AreaCentroid()
    home = method.home(method.describe(Panorama(here.image, holes)), method.describe(there))
    assert abs(wrap(home.bearing - pose.bearing_to(HOME))) < math.radians(10)
    nothing = Panorama(here.image, np.full(720, np.nan, np.float32))
    assert method.home(method.describe(nothing), method.describe(there)).confidence == 0.0
    with pytest.raises(DataError):
        AlignedHoming(GivenHeading(), method).home(Panorama(here.image), there)


@pytest.mark.parametrize("seed", [1, 2])
def test_matching_cost_tells_the_place_from_another(seed: int) -> None:
    method = DynamicWarping()
    goal = method.describe(view(HOME, seed))
    same = [method.match(method.describe(view(Pose2(3.7 + d, 2.8, 0.4), seed)), goal).cost for d in (0.1, 0.4)]
    other = [method.match(method.describe(view(Pose2(3.0 + d, 2.8, d), seed + 50)), goal).cost for d in (0, 1)]
    assert max(same) < 0.4
    assert min(other) > 0.75


def test_the_flow_shows_direction_and_compass_error() -> None:
    method = DynamicWarping()
    goal = method.describe(view(HOME)).coarse
    for pose in around(HOME, 0.4):
        current = view(Pose2(pose.x, pose.y, HOME.heading + math.radians(4)))
        flow = fitted_flow(method.describe(current).coarse, goal, FLOW)
        assert abs(wrap(flow.direction - HOME.bearing_to(pose))) < math.radians(12)
        assert flow.turn == pytest.approx(-math.radians(4), abs=math.radians(3))


@pytest.mark.parametrize("name", [n for n in TOLERANCE if not METHODS[n].needs.ranges])
def test_views_of_two_cameras_are_refused(name: str) -> None:
    small = Panorama(np.zeros((20, 60, 3), np.uint8), rig=Rig(60, 20, 9.5, 60 / TAU))
    method = METHODS[name]
    with pytest.raises(ShapeError):
        method.home(method.describe(small), method.describe(view(HOME)))


def test_bearing_is_the_robots_own_after_alignment() -> None:
    pose = Pose2(3.2, 2.8, 0.4 + TAU / 4)
    homing = AlignedHoming(MinWarpingCompass(), None).home(view(pose), view(HOME))
    assert AlignedHoming(MinWarpingCompass(), None).align(view(pose), view(HOME)) == homing.alignment
    matched = AlignedHoming(MinWarpingCompass(), DynamicWarping()).align(view(pose), view(HOME))
    assert matched.rotation == homing.alignment.rotation
    assert matched.home is not None
    assert abs(wrap(matched.home.bearing - pose.bearing_to(HOME))) < math.radians(8)
    assert homing.alignment.rotation == pytest.approx(TAU / 4, abs=math.radians(2))
    assert abs(wrap(homing.home.bearing - pose.bearing_to(HOME))) < math.radians(8)
