"""Odometry that can't be true is noticed by the views before and after; what is usual isn't."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from kept import as_before
from played import moved, taught

from sim2d import worlds
from sim2d.config import LaserConfig, SimConfig
from sim2d.records import SetDown, SimReading
from sim2d.robot import SimRobot
from sim2d.sensors.laser import Laser
from sim2d.streams import stream
from topomap.app.config import load_config
from topomap.core.geometry import Pose2
from topomap.core.panorama import Panorama
from topomap.core.records import Command, Motion
from topomap.mapping.odometry.gap import restated
from topomap.mapping.odometry.increments import Calibration, advance
from topomap.mapping.odometry.scan_watch import ranges_confirm
from topomap.mapping.odometry.watch import OdometryWatch

CALIBRATED = Calibration(rotation_scale=1.04, curvature=0.003, distance_scale=0.95)
TWO_CORRIDORS = Path(__file__).parents[2] / "examples" / "worlds" / "two-corridors.toml"


def watched(readings: list[SimReading]) -> tuple[list[tuple[int, str]], list[tuple[int, str]], Pose2]:
    """What is said of broken odometry and of mended, by step, and where the robot is believed to be in the end."""
    watch, pose, broken, mended = OdometryWatch(), Pose2(), [], []
    for k, reading in enumerate(readings):
        word = watch.judge(Panorama.from_reading(reading), reading.motion, CALIBRATED)
        broken += [(k, word)] if word else []
        mended += [(k, watch.said)] if watch.said else []
        read = Motion(reading.motion.forward, 0.0, reading.motion.turn, reading.motion.covariance, reading.motion.dt)
        motion = read if watch.seen is None else restated(read, watch.seen, CALIBRATED)
        pose = advance(pose, CALIBRATED.correct(motion)) if k else pose
    return broken, mended, pose


def said(readings: list[SimReading]) -> list[tuple[int, str]]:
    return watched(readings)[0]


def blind(readings: list[SimReading]) -> list[SimReading]:
    """The same of a robot without ranges."""
    return [replace(r, ranges=None) for r in readings]


def test_an_undisturbed_drive_is_believed() -> None:
    assert watched(taught(80))[:2] == ([], [])


def test_being_carried_on_by_two_metres_is_noticed_at_once() -> None:
    seen = taught(80)
    assert [(k, word.split(":")[0]) for k, word in said(seen[:40] + seen[60:])] == [(40, "carried away")]


@cache
def lit(hour: int) -> list[SimReading]:
    robot = SimRobot(worlds.load("room-corridor"), load_config(None, [f"sim.camera.hour={hour}"]).sim, 0)
    return [reading for _ in range(60) if (reading := robot.sense()) is not None]


def beside_a_lamp(reading: SimReading) -> SimReading:
    """The same by camera alone, twice as bright on one side of the robot and half as bright on the other."""
    gains = np.exp2(np.cos(np.linspace(0.0, 2 * np.pi, reading.image.shape[1])))[None, :, None]
    return replace(reading, image=np.clip(reading.image * gains, 0, 255).astype(np.uint8), ranges=None)


@pytest.mark.parametrize("ranged", [True, False])
def test_another_light_is_no_break_but_being_carried_under_it_is(ranged: bool) -> None:
    before = lit(13) if ranged else blind(taught(60))
    behind = lit(20) if ranged else [beside_a_lamp(reading) for reading in before]
    broken, mended, _ = watched(before[:40] + behind[40:])
    assert broken == []
    assert [(k, word.split(":")[0]) for k, word in mended] == [(40, "the light changed")]
    assert [k for k, _ in said(before[:30] + behind[50:])] == [30]


@pytest.mark.parametrize(("carried", "light"), [(0.0, True), (4.2, False)])
def test_a_wall_alone_confirms_no_change_of_the_light(carried: float, light: bool) -> None:
    """Carried on along a wall of the hall, the step before was shown by .39 of the rays, and by .27 the wall is."""
    world, laser = worlds.load("hall"), Laser(LaserConfig(), stream(0, "test"))
    earlier, before, now = (
        replace(Panorama.from_reading(taught(1)[0]), ranges=laser.exact(world, x, 14.0, math.pi).astype(np.float32))
        for x in (13.3, 13.2, 13.2 - (carried or 0.1))
    )
    step = Motion(0.1, 0.0, 0.0, np.eye(3), 0.25)
    assert ranges_confirm(before, now, Pose2(0.1, 0.0, 0.0)), "by the wall at least"
    watch = OdometryWatch()
    for reading in taught(40):
        watch.judge(Panorama.from_reading(reading), reading.motion, CALIBRATED)
    assert watch._is_light(0.54, (earlier, Pose2(0.1, 0.0, 0.0)), before, now, step) is light


def beside_a_blade(reading: SimReading, share: float) -> SimReading:
    """The same with something so near that it hides a share of the view."""
    image = reading.image.copy()
    image[:, : round(share * image.shape[1])] = (20, 130, 20)
    return replace(reading, image=image)


def test_what_now_and_then_hides_the_view_is_no_break_and_one_such_time_takes_no_alarm_away() -> None:
    """Three blades announce themselves by growing, the fourth doesn't."""
    plain, thrice = blind(taught(80)), blind(taught(80))
    for k, share in itertools.product((20, 32, 44), enumerate((0.2, 0.6, 0.2))):
        thrice[k + share[0]] = beside_a_blade(plain[k + share[0]], share[1])
    assert said(thrice) == []
    assert [k for k, _ in said([*plain[:60], beside_a_blade(plain[60], 0.6), *plain[61:]])] == [60]
    assert said([*thrice[:60], beside_a_blade(plain[60], 0.6), *plain[61:]]) == []
    assert [k for k, _ in said([*thrice[:30], *plain[60:]])] == [30]


def test_wheels_that_stood_while_the_view_moved_are_noticed_when_they_go_on() -> None:
    seen = blind(taught(60))
    dead = [moved(r, forward=0.0, turn=0.0) if 30 <= k < 45 else r for k, r in enumerate(seen)]
    found = said(dead)
    assert [k for k, _ in found] == [45]
    assert "stood still for 15 steps" in found[0][1]


def test_wheels_that_spin_on_the_spot_are_noticed_when_they_grip() -> None:
    seen = blind(taught(60))
    stuck = seen[:30] + [moved(seen[29], forward=0.1, turn=0.0) for _ in range(8)] + seen[30:]
    found = said(stuck)
    assert [k for k, _ in found] == [38]
    assert "spun for 8 steps" in found[0][1]


def changed(reading: SimReading, forward: float, turn: float, times: float) -> SimReading:
    motion = reading.motion
    return moved(reading, forward=times * motion.forward + forward, turn=times * motion.turn + turn)


@pytest.mark.parametrize(
    ("forward", "turn", "times", "steps", "at"),
    [(0.0, 0.0, 3.0, 14, 30), (0.0, 0.0, 0.0, 14, 35), (0.0, 0.1, 0.5, 14, 35), (-5.0, 1.0, 1.0, 1, 30)],
    ids=["wheels slip", "wheels count nothing", "one wheel counts nothing", "the odometer is reset"],
)
def test_what_ranges_and_views_show_stands_in_for_odometry_that_fails(
    forward: float, turn: float, times: float, steps: int, at: int
) -> None:
    seen = taught(60)
    wrong = [changed(r, forward, turn, times) if 30 <= k < 30 + steps else r for k, r in enumerate(seen)]
    (_, _, true), (broken, mended, pose) = watched(seen), watched(wrong)
    assert broken == []
    assert [k for k, _ in mended] == [at]
    assert true.distance(pose) < 0.15
    assert abs(true.to(pose).heading) < 0.06
    told = {f"{forward} {turn} {times}": pose.array(), f"said {forward} {turn} {times}": [w for _, w in mended]}
    as_before("odometry restated", told, part=True)


def test_ranges_that_stay_the_same_say_nothing_against_the_odometry() -> None:
    seen = taught(60)
    frozen = [replace(r, ranges=seen[30].ranges) if k > 30 else r for k, r in enumerate(seen)]
    assert watched(frozen)[:2] == ([], [])


@pytest.mark.parametrize("value", [0.0, -1.0, float("inf"), float("nan")])
def test_ranges_that_are_dead_say_nothing_against_the_odometry(value: float) -> None:
    dead = [replace(r, ranges=np.full_like(r.ranges, value)) for r in taught(30)]
    assert watched(dead)[:2] == ([], [])


def test_a_robot_that_somebody_turned_is_told_by_the_view() -> None:
    robot = SimRobot(worlds.load("room-corridor"), SimConfig(), 0)
    watch, found = OdometryWatch(), []
    for k in range(34):
        reading = robot.sense()
        assert reading is not None
        assert watch.judge(Panorama.from_reading(reading), reading.motion, CALIBRATED) == ""
        found += [(k, watch.said)] if watch.said else []
        if k == 30:
            here = robot.truth()
            robot.put(here.x, here.y, here.heading + 1.5)
    assert [k for k, _ in found] == [31]
    assert "which the odometry doesn't count" in found[0][1]


@pytest.mark.parametrize(("turn", "stands_in"), [(0.0, False), (0.05, False), (1.0, True), (-0.6, True)])
def test_a_leaps_turn_is_taken_from_the_view_only_where_that_contradicts_it(turn: float, stands_in: bool) -> None:
    """A park's photographs showed 7 degrees more than there were, and the map was 2 m worse than dead reckoning."""
    watch, at = OdometryWatch(), 40
    for k, reading in enumerate(blind(taught(at + 1))):
        leaps = changed(reading, 2.0, turn, 1.0) if k == at else reading
        watch.judge(Panorama.from_reading(leaps), leaps.motion, CALIBRATED)
    assert watch.seen is not None
    assert watch.seen.ways is not None
    assert (watch.seen.turns is not None) == stands_in


def test_readings_that_were_left_out_are_no_leap() -> None:
    seen = taught(60)
    way, turn = (sum(getattr(r.motion, name) for r in seen[30:37]) for name in ("forward", "turn"))
    late = [*seen[:30], moved(seen[36], forward=way, turn=turn, dt=1.75), *seen[37:]]
    assert watched(late)[:2] == ([], [])


def test_turning_on_the_spot_and_driving_into_a_corridor_are_no_breaks() -> None:
    config = SimConfig()
    robot = SimRobot(worlds.load(str(TWO_CORRIDORS)), config, 1, SetDown((3.0, 6.5, 0.0), 10))
    watch = OdometryWatch()
    for k in range(95):
        reading = robot.sense()
        assert reading is not None
        assert watch.judge(Panorama.from_reading(reading), reading.motion, CALIBRATED) == "", k
        robot.act(Command(0.0, 0.8) if 70 <= k < 86 else Command(0.4, 0.0))


@cache
def along_a_corridor(steps: int, seed: int) -> list[SimReading]:
    """Readings between two bare walls of look-alike doors, whose ranges don't tell the way along."""
    robot = SimRobot(worlds.load(str(TWO_CORRIDORS)), SimConfig(), seed, SetDown((7.0, 6.5, 0.0), 10))
    readings = []
    for _ in range(steps):
        reading = robot.sense()
        assert reading is not None
        readings.append(reading)
        robot.act(Command(0.4, 0.0))
    return readings[12:]


@pytest.mark.parametrize("times", [2.7, 1.8, 0.4])
def test_a_slip_along_a_corridor_is_told_by_the_view(times: float) -> None:
    seen = along_a_corridor(90, 1)
    wrong = [changed(r, 0.0, 0.0, times) if 30 <= k < 44 else r for k, r in enumerate(seen)]
    (said_of_true, mended_of_true, true), (broken, mended, pose) = watched(seen), watched(wrong)
    assert (said_of_true, mended_of_true, broken) == ([], [], [])
    assert [30 <= k <= 37 for k, _ in mended] == [True]
    assert "odometry untrue" in mended[0][1]
    assert true.distance(pose) < 0.35, "0.8 to 2.4 m were counted wrongly"


@pytest.mark.parametrize("times", [2.7, 0.4])
def test_a_slip_takes_no_turn_away_that_ranges_confirm(times: float) -> None:
    watch, between_looks = OdometryWatch(), list[float | None]()
    for k, reading in enumerate(along_a_corridor(90, 1)):
        slips = changed(reading, 0.0, 0.0, times) if 30 <= k < 44 else reading
        watch.judge(Panorama.from_reading(slips), slips.motion, CALIBRATED)
        if watch.seen is not None and k % 5:
            between_looks.append(watch.seen.turns)
    assert len(between_looks) >= 8
    assert set(between_looks) == {None}


@cache
def amid_people(world: str, seed: int, steps: int, beside: int) -> list[SimReading]:
    words = ["sim.driver.lateral_offset=0.2", f"sim.people={{extra=6,beside={beside}}}"]
    robot = SimRobot(worlds.load(world), load_config(None, words).sim, seed)
    return [reading for _ in range(steps) if (reading := robot.sense()) is not None]


@pytest.mark.parametrize(
    ("world", "seed", "steps"), [("office-loop", 0, 130), ("office-loop", 3, 130), ("hall", 3, 180)]
)
def test_people_who_walk_along_with_the_robot_are_no_slip(world: str, seed: int, steps: int) -> None:
    """Ranges and most of the view stand still: half a metre a look was taken back, 8.9 m of a map in all."""
    assert watched(amid_people(world, seed, steps, 6))[:2] == ([], [])


@pytest.mark.parametrize("beside", [0, 6])
def test_wheels_that_spin_amid_people_are_noticed(beside: int) -> None:
    """Later than else, as people who go along stand still as well."""
    words = ["sim.driver.laps=0.3", f"sim.people={{extra=20,beside={beside}}}"]
    robot = SimRobot(worlds.load("hall"), load_config(None, words).sim, 1)
    readings = []
    while len(readings) < 190:
        reading = robot.sense()
        assert reading is not None
        if not reading.driven:
            reading = moved(reading, forward=0.1)
            robot.act(Command(0.0, 0.0))
        readings.append(reading)
    broken, mended, _ = watched(readings)
    assert all("spun" in words for _, words in broken)
    spins = sum(reading.driven for reading in readings)
    assert any("untrue" in words for k, words in mended if spins <= k < spins + 40)


@pytest.mark.parametrize("along", [134, 195, 2504])
def test_things_along_a_narrow_corridor_are_no_slip(along: int) -> None:
    robot = SimRobot(worlds.load("campus"), load_config(None, [f"sim.start.along={along}"]).sim, 0)
    readings = [reading for _ in range(60) if (reading := robot.sense()) is not None]
    assert watched(readings)[:2] == ([], [])


def faster(readings: list[SimReading], since: int, times: int) -> list[SimReading]:
    """The same drive, from a reading on so many times as fast."""
    fast = []
    for k in range(since + times - 1, len(readings), times):
        poses = Pose2()
        for reading in readings[k - times + 1 : k + 1]:
            poses = advance(poses, Motion(reading.motion.forward, 0.0, reading.motion.turn, np.eye(3), 0.25))
        half = poses.heading / 2
        forward = np.cos(half) * poses.x + np.sin(half) * poses.y
        left = np.cos(half) * poses.y - np.sin(half) * poses.x
        fast.append(moved(readings[k], forward=float(forward), left=float(left), turn=poses.heading))
    return readings[:since] + fast


@pytest.mark.parametrize("times", [4, 6])
def test_who_drives_much_faster_where_views_change_slowly_is_believed(times: int) -> None:
    seen = blind(faster(taught(100, "hall"), 40, times))
    assert max(reading.motion.forward for reading in seen) > 0.35
    assert watched(seen)[:2] == ([], [])


@pytest.mark.parametrize(("at", "times"), [(15, 2), (33, 2), (63, 2), (64, 1), (67, 3)])
def test_a_frame_that_the_camera_repeats_is_no_break_once_it_goes_on(at: int, times: int) -> None:
    """Straight on and in a turn: the next view shows what the wheels did in all steps since the last new one."""
    seen = blind(taught(at + 12))
    again = seen[at - 1]
    stale = [replace(r, image=again.image, encoded=again.encoded) if at <= k < at + times else r
             for k, r in enumerate(seen)]  # fmt: skip
    assert watched(stale)[:2] == ([], [])


@pytest.mark.parametrize("at", range(17, 24))
def test_a_frame_repeated_after_two_that_are_missing_takes_no_turn_back(at: int) -> None:
    """Where a corner begins, what wheels turned in three steps is more than in any reading before, and no view shows
    it: 14 degrees were taken back with it in the hall, and the map was worse than dead reckoning."""
    seen = blind(taught(at + 12))
    motions = [reading.motion for reading in seen[at : at + 3]]
    whole = replace(
        motions[-1], forward=sum(m.forward for m in motions), turn=sum(m.turn for m in motions),
        covariance=sum(m.covariance for m in motions), dt=sum(m.dt for m in motions),
    )  # fmt: skip
    stale = replace(seen[at + 2], image=seen[at - 1].image, encoded=seen[at - 1].encoded, motion=whole)
    assert watched([*seen[:at], stale, *seen[at + 3 :]])[:2] == ([], [])


@pytest.mark.parametrize("ranged", [True, False])
@pytest.mark.parametrize("turn", [1.0, -0.6])
def test_a_turn_that_only_the_odometry_of_a_standing_robot_counts_is_taken_back(turn: float, ranged: bool) -> None:
    """Its camera's frame may be repeated, until the next view shows that nothing turned."""
    at = 40
    seen = taught(at + 12) if ranged else blind(taught(at + 12))
    ghost = moved(seen[at - 1], forward=0.02, left=0.0, turn=turn)
    watch, believed = OdometryWatch(), 0.0
    for reading in [*seen[:at], ghost, *seen[at:]]:
        assert not watch.judge(Panorama.from_reading(reading), reading.motion, Calibration())
        believed += reading.motion.turn if watch.seen is None else watch.seen.turn
    assert believed == pytest.approx(sum(reading.motion.turn for reading in seen), abs=math.radians(6))
