from __future__ import annotations

import math

import numpy as np
import pytest
from homing_fakes import RIG, TellingViews

from topomap.bench.homing.walk import Eyes, WalkSettings, catchment, policy_walk, walk
from topomap.core.geometry import TAU, Pose2
from topomap.core.panorama import Panorama
from topomap.core.records import HomeVector
from topomap.vision.arena import bearings_home, central, spread
from topomap.vision.homing import Needs

HOME = (0.0, 0.0)


def blank(ranges: np.ndarray | None = None) -> Panorama:
    kept = None if ranges is None else ranges.astype(np.float32)
    return Panorama(np.zeros((RIG.height, RIG.width, 3), np.uint8), kept, RIG)


def grid(n: int = 9, spacing: float = 0.3) -> np.ndarray:
    x, y = np.meshgrid(np.arange(n) * spacing, np.arange(n) * spacing)
    return np.column_stack([x.ravel(), y.ravel()]) - (n // 2) * spacing


def test_true_vectors_bring_every_start_home() -> None:
    positions = grid()
    walks = catchment(positions, np.nan_to_num(bearings_home(positions, HOME)), HOME, 0.3)
    assert all(w.reached for w in walks)
    assert max(w.ratio(HOME, 0.0) for w in walks) < 1.2


def test_vectors_turned_by_60_degrees_spiral_in_and_by_120_out() -> None:
    positions = grid()
    true = np.nan_to_num(bearings_home(positions, HOME))
    assert all(w.reached for w in catchment(positions, true + math.radians(60), HOME, 0.3))
    outwards = catchment(positions, true + math.radians(120), HOME, 0.3)
    far = np.hypot(*positions.T) > 0.3
    assert not any(w.reached for w, away in zip(outwards, far, strict=True) if away)


def test_a_silent_place_ends_the_walk() -> None:
    positions = grid()
    directions = np.where(positions[:, 0] > 0.5, np.nan, np.nan_to_num(bearings_home(positions, HOME)))
    walks = catchment(positions, directions, HOME, 0.3)
    assert [w.reached for w in walks] == [x <= 0.5 for x in positions[:, 0]]
    assert all(len(w.path) == 1 or w.reached or w.path[-1][0] > 0 for w in walks)


def test_a_straight_walk_reaches_home_on_a_straight_path() -> None:
    found = walk(lambda p: (math.atan2(-p.y, -p.x), blank()), Pose2(2.0, 1.0), HOME, False, WalkSettings())
    assert found.reached
    assert found.ratio(HOME, 0.2) < 1.07


def test_a_walk_slides_along_what_stands_in_the_way_and_stops_where_nothing_is_free() -> None:
    def wall(pose: Pose2) -> tuple[float, Panorama]:
        bearings = np.arange(RIG.width) * TAU / RIG.width + pose.heading
        # a wall across the way home, at x = 1, from y = -0.5 up
        reach = (pose.x - 1.0) / np.where(np.abs(np.cos(bearings)) > 1e-9, -np.cos(bearings), 1e-9)
        hit = (reach > 0.0) & (pose.y + reach * np.sin(bearings) > -0.5)
        ranges = np.where(hit, np.minimum(reach, 9.0), 9.0)
        return math.atan2(-pose.y, -pose.x), blank(ranges)

    found = walk(wall, Pose2(1.5, 0.05), HOME, True, WalkSettings(longest=6.0))
    assert found.reached
    assert found.path[:, 1].min() < -0.45
    stuck = walk(lambda p: (math.pi, blank(np.full(RIG.width, 0.1))), Pose2(1.5, 0.0), HOME, False, WalkSettings())
    assert not stuck.reached
    assert len(stuck.path) == 1


def test_a_walk_coasts_over_a_few_silent_steps_but_not_from_the_start() -> None:
    def patchy(pose: Pose2) -> tuple[float, Panorama]:
        return (math.nan if 0.8 < pose.x < 1.1 else math.pi), blank()

    assert walk(patchy, Pose2(2.0, 0.0), HOME, False, WalkSettings()).reached
    assert not walk(patchy, Pose2(1.0, 0.0), HOME, False, WalkSettings()).reached
    assert not walk(patchy, Pose2(2.0, 0.0), HOME, False, WalkSettings(coast=0)).reached


def test_a_policy_moves_in_the_aligned_frame() -> None:
    class West:
        needs = Needs(compass=True)
        claims_homing = True

        def start(self, goal: Panorama) -> int:
            return 0

        def step(self, state: int, current: Panorama) -> tuple[int, HomeVector]:
            return state + 1, HomeVector(math.pi, 0.15)

    views = TellingViews()
    eyes = Eyes(views, views.view(0.0, 0.0, 0.0), None)
    found = policy_walk(West(), eyes, Pose2(1.5, 0.0), HOME, WalkSettings())
    assert found.reached
    assert np.ptp(found.path[:, 1]) == pytest.approx(0.0, abs=1e-9)


def test_starts_are_far_from_home_and_from_each_other() -> None:
    positions = grid()
    chosen = positions[spread(positions, central(positions), 4)]
    assert sorted(map(tuple, np.abs(chosen).round(6))) == [(1.2, 1.2)] * 4
