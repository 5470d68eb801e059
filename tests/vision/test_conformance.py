"""Every method x every scene: identity, turning, eight directions, purity, empty and random pictures, wrong shapes,
one column, ranges with gaps and without any. The tolerances are in tolerances.py.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest
import tolerances as table
from scenes import Room, around, marker_view, plain_floor_view, view

from topomap.core.errors import DataError, ShapeError
from topomap.core.geometry import TAU, Pose2, wrap
from topomap.core.panorama import Panorama
from topomap.core.records import HomeVector
from topomap.core.rig import Rig
from topomap.vision.compass import ALIGNERS
from topomap.vision.homing import METHODS, POLICIES, REFERENCE_METHODS, GoalView
from topomap.vision.registry import entries

HOME = Pose2(3.7, 2.8, 0.4)
POSES = [Pose2(p.x, p.y, HOME.heading) for p in around(HOME, 0.4)]
PAIRWISE = [*METHODS, *REFERENCE_METHODS]
EVERYTHING = [*PAIRWISE, *POLICIES]
SMALL = Rig(60, 20, 9.5, 60 / TAU)
COLUMN = Rig(1, 100, 49.5, 114.6)


def seen(name: str, pose: Pose2) -> Panorama:
    if name == "alv-markers":
        return marker_view(pose)
    return plain_floor_view(pose, 2) if name in table.ON_A_PLAIN_FLOOR else view(pose, 2)


@cache
def references(name: str) -> GoalView:
    step = REFERENCE_METHODS[name].step
    ahead, left = (HOME @ Pose2(step, 0.0), HOME @ Pose2(0.0, step))
    return GoalView(seen(name, HOME), seen(name, ahead), seen(name, left), step)


def answer(name: str, current: Panorama, goal: Panorama | GoalView) -> HomeVector:
    """Ask a method of any of the contracts; policies for their first move."""
    if isinstance(goal, GoalView):
        return REFERENCE_METHODS[name].home(current, goal)
    if name in REFERENCE_METHODS:
        return REFERENCE_METHODS[name].home(current, GoalView(goal, goal, goal))
    if name in POLICIES:
        return POLICIES[name].step(POLICIES[name].start(goal), current)[1]
    method = METHODS[name]
    here, there = (p.derived(("test", name), method.describe) for p in (current, goal))
    return method.home(here, there)


def sane(home: HomeVector) -> bool:
    distance = home.distance is None or (math.isfinite(home.distance) and home.distance >= 0.0)
    return distance and -math.pi < home.bearing <= math.pi and 0.0 <= home.confidence <= 1.0


def test_the_table_names_every_method_once() -> None:
    assert set(table.METHOD) | table.NO_CLAIM >= set(METHODS)
    assert set(table.METHOD) | set(table.REFERENCES) | table.NO_CLAIM == set(PAIRWISE)
    assert set(table.POLICIES) == set(POLICIES)
    assert set(table.ALIGNER) == set(ALIGNERS)
    assert not (set(table.METHOD) | set(table.REFERENCES)) & table.NO_CLAIM
    claims = {**METHODS, **REFERENCE_METHODS, **POLICIES}
    assert {name for name, method in claims.items() if not method.claims_homing} == table.NO_CLAIM


def test_the_catalogue_names_every_row() -> None:
    listed = list(entries())
    assert len(listed) == len(EVERYTHING) + len(ALIGNERS)
    rows = {part for entry in listed for part in entry.row.split(", ")}
    assert rows >= {f"A{k}" for k in range(1, 9)} | {f"H{k}" for k in range(1, 29) if k != 14}


@pytest.mark.parametrize("name", sorted(set(PAIRWISE) - table.NO_CLAIM))
def test_eight_directions(name: str) -> None:
    goal = references(name) if name in REFERENCE_METHODS else seen(name, HOME)
    errors, lengths = [], []
    for pose in POSES:
        home = answer(name, seen(name, pose), goal)
        assert sane(home)
        assert home.confidence > 0.0
        errors.append(abs(wrap(home.bearing - pose.bearing_to(HOME))))
        lengths.append(home.distance)
    assert math.degrees(float(np.mean(errors))) < {**table.METHOD, **table.REFERENCES}[name]
    assert (lengths[0] is not None) == (name in table.METRIC)
    if name in table.METRIC:
        assert np.mean([d for d in lengths if d is not None]) == pytest.approx(0.4, rel=table.METRIC[name])


MODEST = Rig(180, 25, 12.0, 180 / TAU)
"""A camera that renders fast; the policies look at no more."""
AWAY, STARTS = 0.6, 6
"""Policies start so many times from so far off [m]."""


@cache
def luck(reach: float, looks: int, stride: float) -> float:
    """How often a random walk of as many looks comes as near from as far, every step anywhere."""
    rng = np.random.default_rng(0)
    turns = rng.uniform(0.0, TAU, (4000, looks))
    x, y = AWAY + stride * np.cumsum(np.cos(turns), axis=1), stride * np.cumsum(np.sin(turns), axis=1)
    return float((np.hypot(x, y).min(axis=1) < reach).mean())


def arrives(name: str, start: Pose2, reach: float, looks: int) -> bool:
    policy, pose = POLICIES[name], start
    state = policy.start(Room(2).view(HOME.x, HOME.y, HOME.heading, MODEST))
    for _ in range(looks):
        state, move = policy.step(state, Room(2).view(pose.x, pose.y, pose.heading, MODEST))
        assert sane(move)
        assert move.distance is not None
        pose = pose @ Pose2(move.distance * math.cos(move.bearing), move.distance * math.sin(move.bearing))
        if pose.distance(HOME) < reach:
            return True
    return False


@pytest.mark.parametrize("name", POLICIES)
def test_policies_arrive_where_luck_would_not(name: str) -> None:
    """Chance of as many arrivals by a random walk of the same steps: below one in a hundred."""
    reach, looks, stride = table.POLICIES[name]
    angles = [0.3 + k * TAU / STARTS for k in range(STARTS)]
    starts = [Pose2(HOME.x + AWAY * math.cos(a), HOME.y + AWAY * math.sin(a), HOME.heading) for a in angles]
    came = sum(arrives(name, start, reach, looks) for start in starts)
    chance = luck(reach, looks, stride)
    odds = sum(math.comb(STARTS, k) * chance**k * (1 - chance) ** (STARTS - k) for k in range(came, STARTS + 1))
    assert odds < 0.01


@pytest.mark.parametrize("name", PAIRWISE)
def test_at_home_there_is_nowhere_to_go(name: str) -> None:
    goal = references(name) if name in REFERENCE_METHODS else seen(name, HOME)
    home = answer(name, seen(name, HOME), goal)
    assert sane(home)
    assert home.confidence < table.EXACT_AT_HOME or home.distance == 0.0


@pytest.mark.parametrize("name", METHODS)
def test_turning_the_views_turns_the_answer(name: str) -> None:
    method, pose = METHODS[name], POSES[1]
    turn = 180
    here, there = seen(name, pose), seen(name, HOME)
    straight = answer(name, here, there)
    turned = answer(name, here.rolled(turn), there.rolled(turn) if method.needs.compass else there)
    if name != "random-masks":  # masks stand where they stand
        slack = 25.0 if name in ("moment-ground", "pixel-landmarks") or not method.claims_homing else 8.0
        assert abs(wrap(turned.bearing - straight.bearing - turn * TAU / 720)) < math.radians(slack)
    assert sane(turned)


@pytest.mark.parametrize("name", EVERYTHING)
def test_purity(name: str) -> None:
    here, there = seen(name, POSES[0]), seen(name, HOME)
    copies = [Panorama(p.image.copy(), None if p.ranges is None else p.ranges.copy()) for p in (here, there)]
    again = [Panorama(p.image.copy(), None if p.ranges is None else p.ranges.copy()) for p in (here, there)]
    assert answer(name, copies[0], copies[1]) == answer(name, again[0], again[1])
    for used, original in zip(copies, (here, there), strict=True):
        np.testing.assert_array_equal(used.image, original.image)
        np.testing.assert_array_equal(used.ranges, original.ranges)


@cache
def empty(kind: str) -> Panorama:
    if kind == "noise":
        image = np.random.default_rng(3).integers(0, 256, (100, 720, 3), dtype=np.uint8)
    else:
        image = np.full((100, 720, 3), 0 if kind == "black" else 128, np.uint8)
    return Panorama(image, np.full(720, 2.0, np.float32))


@pytest.mark.parametrize("kind", ["black", "constant", "noise"])
@pytest.mark.parametrize("name", EVERYTHING)
def test_pictures_that_hold_nothing(name: str, kind: str) -> None:
    for current, goal in (
        (empty(kind), seen(name, HOME)),
        (seen(name, POSES[0]), empty(kind)),
        (empty(kind), empty(kind)),
    ):
        assert sane(answer(name, current, goal))
    nothing = answer(name, empty(kind), empty(kind))
    if name in PAIRWISE:
        assert nothing.confidence < table.EXACT_AT_HOME or nothing.distance == 0.0


@pytest.mark.parametrize("name", EVERYTHING)
def test_views_of_two_cameras_are_refused(name: str) -> None:
    small = Panorama(np.zeros((20, 60, 3), np.uint8), np.ones(60, np.float32), SMALL)
    with pytest.raises(ShapeError):
        answer(name, small, seen(name, HOME))


@pytest.mark.parametrize("name", EVERYTHING)
def test_one_column(name: str) -> None:
    rng = np.random.default_rng(1)
    a, b = (Panorama(rng.integers(0, 256, (100, 1, 3), dtype=np.uint8), np.ones(1, np.float32), COLUMN) for _ in "ab")
    assert sane(answer(name, a, b))


@pytest.mark.parametrize("name", EVERYTHING)
def test_ranges_with_gaps_and_without_any(name: str) -> None:
    pose = POSES[2]
    here, there = seen(name, pose), seen(name, HOME)
    assert here.ranges is not None
    holes = here.ranges.copy()
    holes[100:160] = np.nan
    goal = references(name) if name in REFERENCE_METHODS else there
    home = answer(name, Panorama(here.image, holes), goal)
    assert sane(home)
    if name in table.METHOD:
        assert abs(wrap(home.bearing - pose.bearing_to(HOME))) < math.radians(max(3.5 * table.METHOD[name], 15.0))
    nothing = Panorama(here.image, np.full(720, np.nan, np.float32))
    blind = answer(name, nothing, goal)
    assert sane(blind)
    needs = {**METHODS, **REFERENCE_METHODS, **POLICIES}[name].needs
    if needs.ranges:
        assert blind.confidence == 0.0
        with pytest.raises(DataError):
            needs.check(Panorama(here.image))


@pytest.mark.parametrize("shape", [(100, 719, 3), (100, 720), (100, 720, 4)])
def test_a_panorama_of_another_shape_is_refused(shape: tuple[int, ...]) -> None:
    with pytest.raises(ShapeError):
        Panorama(np.zeros(shape, np.uint8))


@pytest.mark.parametrize("name", ALIGNERS)
def test_aligners_in_eight_directions(name: str) -> None:
    for distance, limit in zip((0.1, 0.5), table.ALIGNER[name], strict=True):
        errors = []
        for pose in around(HOME, distance)[:: 1 if distance > 0.2 else 2]:
            truth = wrap(pose.heading - HOME.heading)
            found = ALIGNERS[name].align(view(pose, 2), view(HOME, 2), truth if name == "given" else None)
            errors.append(abs(wrap(found.rotation - truth)))
        assert math.degrees(float(np.mean(errors))) < limit


@pytest.mark.parametrize("kind", ["black", "constant", "noise"])
@pytest.mark.parametrize("name", ALIGNERS)
def test_aligners_on_pictures_that_hold_nothing(name: str, kind: str) -> None:
    for current, goal in ((empty(kind), view(HOME, 2)), (view(HOME, 2), empty(kind)), (empty(kind), empty(kind))):
        found = ALIGNERS[name].align(current, goal)
        assert -math.pi < found.rotation <= math.pi
        assert math.isfinite(found.residual)
        assert found.home is None or sane(found.home)


@pytest.mark.parametrize("name", ALIGNERS)
def test_aligners_refuse_two_cameras_and_take_one_column(name: str) -> None:
    small = Panorama(np.zeros((20, 60, 3), np.uint8), np.ones(60, np.float32), SMALL)
    with pytest.raises(ShapeError):
        ALIGNERS[name].align(small, view(HOME, 2))
    column = Panorama(np.full((100, 1, 3), 9, np.uint8), np.ones(1, np.float32), COLUMN)
    assert math.isfinite(ALIGNERS[name].align(column, column).rotation)
