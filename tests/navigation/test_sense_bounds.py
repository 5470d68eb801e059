"""What is made of senses and odometry at its bounds, and what manoeuvres decide there: the same as before."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest
from homing_fakes import RIG, TellingViews
from kept import as_before
from maps import square

from topomap.core.errors import TopomapError
from topomap.core.geometry import Pose2
from topomap.core.panorama import Panorama
from topomap.core.records import Alignment, Command, Goal, HomeVector, Motion, Phase, Travel, Where
from topomap.core.rig import Rig
from topomap.mapping.odometry.increments import Calibration
from topomap.navigation import odometry_check, sense_check
from topomap.navigation.arrival import Arrival
from topomap.navigation.manoeuvres import active_check
from topomap.navigation.manoeuvres.active_check import ActiveCheck, ActiveSettings, _Approach, _goals
from topomap.navigation.manoeuvres.back_off import FORGET, BackOff
from topomap.navigation.manoeuvres.hall_course import HallCourse, HallSettings, _ahead_on
from topomap.navigation.manoeuvres.policy_drive import NEAR, PATIENCE, PolicyDrive
from topomap.navigation.manoeuvres.relocalise import (
    FOUND,
    LED,
    LOST,
    NEXT,
    STEPS,
    WAY,
    Relocalise,
    _along_the_map,
    free_bearing,
)
from topomap.navigation.manoeuvres.turn_and_look import TurnAndLook
from topomap.navigation.mission import Mission, MissionSettings
from topomap.navigation.odometry_check import BEYOND, MORE, SEEN_MOVE, SEEN_TURN, TURN_OFF, OdometryCheck
from topomap.navigation.pilot import Pilot, PilotSettings
from topomap.navigation.robot_check.numbers import FAST, SPIN, TALL, check_motion, check_rig, check_stamps
from topomap.navigation.sense_check import FROZEN_STEPS, LATE, MOVED, SenseCheck
from topomap.navigation.wish import parse_wish

PILOT = Pilot(PilotSettings())
MAP = square(8)
VIEW = TellingViews().view(0.2, 0.0, 0.1)
PATTERN = replace(
    VIEW, image=np.kron(np.random.default_rng(0).integers(0, 200, (2, 36, 3), np.uint8), np.ones((1, 10, 1), np.uint8))
)


def around(bound: float) -> tuple[float, float, float]:
    """Just below, at, and just above."""
    return math.nextafter(bound, -math.inf), bound, math.nextafter(bound, math.inf)


def reading(k: int = 0, image: np.ndarray = VIEW.image, **motion: float) -> SimpleNamespace:
    moved = Motion(*(motion.get(name, 0.0) for name in ("forward", "left", "turn")), np.eye(3), motion.get("dt", 0.25))
    return SimpleNamespace(stamp_ns=k, image=image, motion=moved, contact=False, driven=False)


def test_a_camera_that_stands_still_in_motion_is_frozen_after_so_many_steps() -> None:
    own = partial(reading, 0, PATTERN.image)
    for forward, turn, told in (
        (MOVED, 0.0, False),
        (MOVED + 1e-9, 0.0, True),
        (0.0, -0.02, False),
        (0.0, -0.03, True),
    ):
        check = SenseCheck()
        said = [check._camera(own(forward=forward, turn=turn), PATTERN) for _ in range(1)]
        for _ in range(FROZEN_STEPS + 1):
            check._last = own()
            said.append(check._camera(own(forward=forward, turn=turn), PATTERN))
        assert [bool(one) for one in said] == [False] * FROZEN_STEPS + [told] * 2
        check._last = reading(0, PATTERN.image + 1)
        assert check._camera(own(forward=forward, turn=turn), PATTERN) == ""
        check.commanded(Command(0.1))
        check._last = own()
        assert [check._camera(own(), PATTERN) != "" for _ in range(3)] == [False, False, True]


def test_a_reading_is_late_after_so_many_times_the_usual_wait() -> None:
    assert [SenseCheck()._is_late(dt) for dt in (0.0, 0.25, 9.0)] == [False] * 3
    for dt, late in zip(around(LATE * 0.25), (False, False, True), strict=True):
        check = SenseCheck()
        assert [check._is_late(one) for one in (0.25, 0.25, dt)] == [False, False, late]
    check = SenseCheck()
    assert [check._is_late(dt) for dt in (0.0, 0.0, 0.0, 0.5)] == [False] * 4


def test_rays_that_are_none_are_left_out_and_too_few_are_none(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sense_check, "RANGES_SHARE", 0.025)
    for good, told in ((1, False), (2, False), (3, True)):
        ranges = np.full(100, np.nan, np.float32)
        ranges[:good], ranges[40:44] = 2.0, (0.0, 0.02, np.inf, -1.0)
        check = SenseCheck()
        found = check._ranges(Panorama(np.zeros((2, 100, 3), np.uint8), ranges, Rig(100, 2)))
        assert (found is not None) is told
        assert found is None or np.flatnonzero(np.isfinite(found)).tolist() == list(range(good))
    assert SenseCheck()._ranges(replace(VIEW, ranges=None)) is None


def test_what_is_amiss_is_told_once_and_when_it_is_over() -> None:
    check, rows = SenseCheck(), []
    for k, odometry in enumerate(("", "odometry dead", "odometry dead", "")):
        blank = Panorama(np.full_like(VIEW.image, 60), VIEW.ranges if k < 2 else None, RIG)
        told = check.senses(reading(k, blank.image, dt=0.25), blank if k else VIEW, 0.1 * k, None, odometry)
        rows.append(f"{told.health} {told.ranges is None} {told.turn:.1f} {told.trusted().ranges is None}")
    as_before("senses told", {"rows": rows})


def test_increments_are_judged_at_their_bounds(monkeypatch: pytest.MonkeyPatch) -> None:
    rows: list[float] = []
    calibration = Calibration(1.05, 0.02, 0.9)
    ahead, back = MORE * 0.4 * 0.25 + BEYOND, MORE * odometry_check.SPEED * 0.25 + BEYOND
    for forward, turn, seen, difference in itertools.product(
        (0.0, 0.1, *around(ahead), *around(-back)), (0.0, TURN_OFF - 1e-9, TURN_OFF + 1e-9), (0.0, SEEN_TURN, 0.04),
        around(SEEN_MOVE)
    ):  # fmt: skip
        monkeypatch.setattr(odometry_check, "_turned", lambda *_, d=difference, s=seen: (d, s))
        check, kept = OdometryCheck(0.4), []
        for k in range(5):
            own = reading(k, forward=forward, turn=turn)
            found = check.checked(own, VIEW, Command(0.3 if k > 1 else 0.0, 0.1), calibration)
            kept.append(found is own)
        motion = found.motion
        rows += [check.dead, check.turns, check.ways, sum(kept), motion.forward, motion.turn, motion.left, motion.dt]
        rows += [*np.sqrt(motion.covariance.diagonal()), motion.covariance[0, 1], motion.covariance[1, 2]]
    as_before("odometry judged", {"rows": np.array(rows).reshape(-1, 13).sum(axis=1), "all": rows[:520]})


def test_an_odometer_is_believed_again_after_so_many_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(odometry_check, "_turned", lambda *_: (0.5, 0.0))
    check, said = OdometryCheck(0.4), []
    bad = {2, 4, 9, 20, 30, 36}
    for k in range(90):
        check.checked(reading(k, forward=0.9 if k in bad else 0.1, turn=0.5 if k in bad | {5} else 0.0), VIEW,
                      Command(0.3), Calibration())  # fmt: skip
        said.append(f"{k}: {check.amiss}")
    changed = [one for one, before in zip(said[1:], said, strict=False) if one.split(": ")[1] != before.split(": ")[1]]
    as_before("odometry believed again", {"said": changed})
    driven = reading(forward=0.9)
    driven.driven = True
    assert check.checked(driven, VIEW, Command(), Calibration()) is driven
    assert (check.amiss, list(check._bad_ways), list(check._bad_turns)) == ("", [], [])


def test_what_was_touched_stands_in_the_ranges_for_so_far() -> None:
    off, rows = BackOff(0.2), []
    for k, (contact, forward) in enumerate([(True, False), (False, True), (True, True)] + [(True, True)] * 8):
        command = off.step(contact, Pose2(0.1 * k, 0.2, 0.3), 0.5 * k, forward)
        rows.append(f"{command}")
    ranges = off.ranges(np.full(72, 2.0, np.float32), Pose2(0.1, 0.1, 0.2))
    alone = off.ranges(None, Pose2(0.1, 0.1, 0.2))
    near = off.ranges(None, Pose2(0.45, 0.27, 0.0))
    for travel, left in zip(around(1.0 + FORGET), (True, False, False), strict=True):
        fresh = BackOff(0.2)
        fresh.step(True, Pose2(), 1.0, True)
        fresh.step(False, Pose2(), travel, True)
        assert (fresh.ranges(None, Pose2()) is not None) is left
    as_before(
        "touched", {"commands": rows, "ranges": ranges, "alone": np.minimum(alone, 9.0), "near": np.minimum(near, 9.0)}
    )


def candidate(query: int, match: int, heading: float = 0.3) -> SimpleNamespace:
    return SimpleNamespace(
        query=query, match=match, relative=Pose2(0.2, 0.1, heading), query_ns=query, match_ns=match)  # fmt: skip


def test_a_pending_closure_is_checked_to_its_end(monkeypatch: pytest.MonkeyPatch) -> None:
    rows: list[str] = []
    curves = {
        "falls": [0.8 - 0.1 * k for k in range(7)], "rises": [0.2 + 0.1 * k for k in range(7)],
        "flat": [0.5] * 50, "few": [0.5, 0.4, 0.3, 0.2], "little": [0.5 - 0.001 * k for k in range(12)],
    }  # fmt: skip
    for (name, curve), confidence, contact in itertools.product(curves.items(), (0.8, 0.0), (False, True)):
        told, k = list[str](), iter(range(99))
        monkeypatch.setattr(active_check, "aligned_difference", lambda *_, c=curve, k=k: c[min(next(k), len(c) - 1)])
        monkeypatch.setattr(active_check, "key_of", lambda one: (one.query, one.match))
        looks = SimpleNamespace(align=lambda *a, c=confidence: Alignment(a[2], 0.5, HomeVector(0.1, None, c)))
        check = ActiveCheck(ActiveSettings(on=True), PILOT, looks)
        track = SimpleNamespace(travel=MAP.nodes[20].travel + 0.6, pose=MAP.pose(20), turn=0.02)
        mapper = SimpleNamespace(
            map=MAP, track=track, ledger=SimpleNamespace(pending=[candidate(20, 3), candidate(10, 2)]),
            view_cache=SimpleNamespace(panorama=lambda node: VIEW),
            testify=lambda one, true, why, told=told: told.append(f"{true} {why}"),
        )  # fmt: skip
        for step in range(50):
            found = check.step(VIEW, contact and step > 2, mapper)
            if found is None:
                break
            track.travel += 0.04
            rows.append(f"{name} {confidence} {contact} {step} {found[0]} {found[1].milestone} {found[1].note}")
        rows += told
    as_before("closures checked", {"rows": rows})
    assert _goals(3, MAP) == [3, 4, 2]
    assert _goals(0, MAP) == [0, 1]
    assert _goals(len(MAP.nodes) - 1, MAP) == [len(MAP.nodes) - 1, len(MAP.nodes) - 2]


def test_only_a_candidate_near_behind_is_checked_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(active_check, "key_of", lambda one: (one.query, one.match))
    for way, begun in ((0.6 - 1e-9, True), (0.6 + 1e-9, False)):
        check = ActiveCheck(ActiveSettings(on=True), PILOT, None)
        track = SimpleNamespace(travel=MAP.nodes[20].travel + way, pose=Pose2(9.0, 9.0, 1.0), turn=0.1)
        mapper = SimpleNamespace(map=MAP, track=track, ledger=SimpleNamespace(pending=[candidate(20, 3)]))
        found = check._begin(mapper)
        assert isinstance(found, _Approach) is begun
        assert check._begin(mapper) is None
        if found is not None:
            assert found.rotation == pytest.approx(0.3 + 1.0 - MAP.pose(20).heading - 0.1)


def test_a_policys_move_is_driven_to_its_end() -> None:
    moves = iter([HomeVector(0.4, 0.5, 0.8), HomeVector(-2.0, None, 0.0)])
    policy = SimpleNamespace(start=lambda goal: 0)
    homing = SimpleNamespace(policy=policy, move=lambda state, *_: (state + 1, next(moves)))
    drive, said = PolicyDrive(homing, VIEW, PILOT), list[str]()
    assert not drive.moving(Pose2())
    drive.look(VIEW, 0.1, Pose2(1.0, 2.0, 0.3))
    end = drive._end
    said.append(f"{end.x:.4f} {end.y:.4f}")
    for here in (Pose2(1.0, 2.0, 0.3), Pose2(1.0, 2.0, 0.7), Pose2(1.2, 2.2, 0.9), Pose2(end.x - 0.05, end.y, 0.0),
                 Pose2(end.x, end.y, 0.64), Pose2(1.0, 2.0, 1.06), Pose2(1.0, 2.0, 0.36)):  # fmt: skip
        command = drive.drive(VIEW, here, 0.2)
        said.append(f"{command.forward:.5f} {command.turn:.5f} {drive.moving(here)}")
    assert [drive.moving(Pose2(end.x - d, end.y, 0.0)) for d in (NEAR - 1e-6, NEAR + 1e-6)] == [False, True]
    drive._steps = PATIENCE - 1
    assert drive.moving(Pose2())
    drive._steps = PATIENCE
    assert not drive.moving(Pose2())
    drive.look(VIEW, 0.1, Pose2(1.0, 2.0, 0.3))
    assert (drive._steps, drive._state, drive._end) == (0, 2, Pose2(1.0, 2.0, 0.3))
    as_before("policy driven", {"said": said})


def test_who_is_lost_looks_around_for_so_far() -> None:
    view = Panorama(np.zeros((10, 72, 3), np.uint8), np.full(72, 3.0, np.float32), Rig(72, 10, 4.5, 72 / math.tau))
    track = SimpleNamespace(travel=5.0, raw=Pose2(), pose=Pose2())
    mapper = SimpleNamespace(map=MAP, track=track, located=20,
                             recognition=SimpleNamespace(nodes=lambda: np.arange(len(MAP.nodes))))  # fmt: skip
    goal, said = Goal(Phase.TRAVEL, 5), list[str]()
    for lost in (*around(LOST), *around(FOUND), *around(1.0 - LED), 0.9):
        where, looks = Where(Pose2(1.0, 0.2, 0.5), 3, 0.5, lost), Relocalise(PILOT)
        said.append(f"{lost} {looks.step(view, False, where, goal, mapper)}")
        looks._began = 5.0
        said.append(f"{lost} {looks.step(view, False, where, goal, mapper)}")
        assert looks.step(view, False, where, Goal(Phase.TEACH), mapper) is None
    where = Where(Pose2(1.0, 0.2, 0.5), 3, 0.5, 0.95)
    for way, steps in ((WAY, 3), (WAY + 0.1, 3), (1.0, STEPS - 1), (1.0, STEPS)):
        looks = Relocalise(PILOT)
        looks._began, looks._steps = 5.0 - way, steps
        said.append(f"{way} {steps} {looks.step(view, False, where, goal, mapper)}")
    fresh = Relocalise(PILOT)
    track.travel = 5.0
    ended = [fresh.step(view, False, where, goal, mapper)[1].phase is Phase.FAILED for _ in range(STEPS + 1)]
    assert ended == [False] * STEPS + [True]
    contact = Relocalise(PILOT)
    said += [f"{contact.step(view, k > 0, where, goal, mapper)[0]}" for k in range(3)]
    for x, y, heading in ((1.0, 0.2, 0.5), (0.0, 0.0, 3.0), (2.0, 2.0, 0.0), (-NEXT[0], 0.0, 0.0), (-9.0, 0.0, 0.0)):
        found = _along_the_map(Where(Pose2(x, y, heading), 0, 0.5, 0.3), mapper)
        said.append("none" if found is None else f"{found:.6f}")
    as_before("looked around", {"said": said})


def test_room_is_sought_between_walls() -> None:
    rows = []
    for seed in range(6):
        rng = np.random.default_rng(seed)
        ranges = rng.uniform(0.4, 6.0, 90).astype(np.float32)
        ranges[rng.random(90) < 0.2] = np.nan
        rows.append(free_bearing(ranges))
        corridor = np.full(90, 3.5, np.float32)
        corridor[18:27], corridor[63:72] = 0.5 + 0.3 * seed, 1.2
        rows.append(free_bearing(corridor))
    as_before("room sought", {"rows": rows})


def test_a_turn_is_over_once_odometry_has_counted_it_or_after_so_many_steps() -> None:
    turn = TurnAndLook(0.8)
    assert [turn.step(math.tau / 4) for _ in range(4)] == [Command(0.0, 0.8)] * 3 + [None]
    turn = TurnAndLook(0.8)
    assert [turn.step(0.0) is None for _ in range(81)] == [False] * 80 + [True]


def test_the_halls_course_at_its_bounds() -> None:
    course = HallCourse(HallSettings(), PILOT, None)
    rows: list[float] = []
    for x, y in ((0.0, 0.0), (3.0, 0.5), (12.6, -0.4), (-4.0, 1.0), (9.0, 9.0)):
        ahead = _ahead_on(Pose2(0.0, 0.0), Pose2(13.0, 2.0), Pose2(x, y, 0.3))
        rows += [ahead.x, ahead.y]
    course._begin(VIEW, Pose2(1.0, 2.0, 0.5))
    rows += [value for corner in course._corners for value in (corner.x, corner.y, corner.heading)]
    for curve in ([1.0] * 6 + [0.4, 0.5, 0.41, 0.45, 0.6], [1.0] * 5 + [0.9, 0.96, 0.97, 0.2, 0.3, 0.3], [0.5] * 4):
        course._way, course._lowest, course._rising, course.differences = 10.0, math.inf, 0, []
        for one in curve:
            course.differences.append(one)
            rows += [course._passed(one), course._rising, min(course._lowest, 9.0)]
    for way in around(10.0):
        course._way, course._lowest, course._rising = way, 0.1, 1
        rows.append(course._passed(0.9))
    course._left = [(0.0, 0.0), (0.3, 0.3), (0.1, 0.12)]
    ahead_, behind = (Alignment(0.0, 0.5, HomeVector(bearing, None, 0.5)) for bearing in (0.2, 2.0))
    for low, there in itertools.product((*around(0.12), *around(0.21)), (ahead_, behind)):
        course._arrival = Arrival()
        course._arrival.update(0.9 * low)  # it has been lower for so long
        rows += [course._is_home(low, there) for _ in range(7)]
    for bearing in (*around(1.0), -0.9, -1.1):
        rows.append(course._towards(Alignment(0.0, 0.5, HomeVector(bearing, None, 0.5))))
    rows.append(course._towards(Alignment(0.0, 0.5, None)))
    as_before("hall course", {"rows": rows})


def test_a_mission_goes_from_goal_to_goal() -> None:
    mission = Mission(MissionSettings(do="patrol:3,5,0"))
    assert mission.goal(True, MAP) == Goal(Phase.TEACH, None)
    assert mission.goal(False, MAP) == Goal(Phase.TRAVEL, 3)
    for phase, node, over in ((Phase.TRAVEL, 3, False), (Phase.ARRIVED, 5, False), (Phase.ARRIVED, 0, False)):
        mission.report(Travel(phase))
        assert mission.goal(False, MAP).node == node
        assert mission.over is over
    mission.report(Travel(Phase.ARRIVED))
    assert (mission.phase, mission.over, mission.goal(False, MAP).node) == (Phase.ARRIVED, True, None)
    mission.report(Travel(Phase.FAILED))
    assert mission.phase is Phase.ARRIVED
    failed = Mission(MissionSettings(do="patrol:3,5"))
    failed.goal(False, MAP)
    failed.report(Travel(Phase.FAILED))
    assert (failed.phase, failed.over, failed.goal(False, MAP).node) == (Phase.TRAVEL, False, 5)
    failed.report(Travel(Phase.FAILED))
    assert (failed.phase, failed.over) == (Phase.FAILED, True)
    unknown = Mission(MissionSettings(do="goto:99"))
    assert unknown.goal(False, MAP) == Goal(Phase.FAILED, None)
    assert "99" in unknown.failure
    with pytest.raises(TopomapError):
        raise TopomapError(unknown.failure)
    told = [Mission(MissionSettings(then=then, goal_node=4)).goal(False, MAP) for then in ("stop", "home")]
    assert told == [Goal(Phase.ARRIVED, None), Goal(Phase.TRAVEL, 4)]


@pytest.mark.parametrize("text", ["", "go", "goto", "goto:", "goto:1,2", "patrol", "patrol:", "patrol:1,,2", "home:1",
                                  "teach:", "hall:3"])  # fmt: skip
def test_what_is_no_mission_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match="expected teach, home, goto"):
        parse_wish(text)


def rig(**values: object) -> SimpleNamespace:
    usual = {"width": 90, "height": 20, "horizon_row": 9.5, "focal": 90 / math.tau, "camera_height": 0.5,
             "forward_column": 4, "clockwise": True}  # fmt: skip
    return SimpleNamespace(rig=SimpleNamespace(**(usual | values)))


def test_rigs_stamps_and_motions_are_found_wrong_at_their_bounds() -> None:
    said = list[str]()
    for name, values in {
        "width": (0, 1, -3), "height": (0, 1), "horizon_row": (-1e-9, 0, 19.9, 20), "camera_height": (0, 1e-9, TALL),
        "focal": tuple(s * 90 / math.tau for s in (*around(0.5), *around(2.0))), "forward_column": (-1, 0, 89, 90),
    }.items():  # fmt: skip
        for value in values:
            said.append(f"{name} {value}: {[str(one) for one in check_rig([rig(**{name: value})])]}")
    said.append(str([str(one) for one in check_rig([rig(), rig(focal=14.0)])]))
    for speed, dt, gap in itertools.product((*around(FAST), -11.0), (0.25, 1.0, 1e-4), (0.25, 0.0)):
        for name, bound in (("forward", 1.0), ("left", 1.0), ("turn", SPIN / FAST)):
            moved = [reading(0), reading(round(gap * 1e9), dt=dt, **{name: speed * bound * max(dt, gap, 1e-3)})]
            said.append(f"{name} {speed} {dt} {gap}: {[str(one) for one in check_motion(moved)]}")
    for step, dt in itertools.product(
        (1e9, 1.0, 1e3, 1e6, 0.29e6, 0.31e6, 3.1e6, 2.9e6, 0, -5, 5e8, 2e9), (1.0, 2.0, 40.0, 0.0)
    ):
        stamps = [reading(round(step * dt * k) if dt else round(step * k), dt=dt) for k in range(3)]
        said.append(f"{step} {dt}: {[str(one) for one in check_stamps(stamps)]}")
    as_before("driver numbers", {"said": said})
