"""Slip, noise per radian, missing frames, being carried away: what the wheels say, and what they don't."""

from __future__ import annotations

import math

import numpy as np
import pytest
from pydantic import ValidationError

from sim2d import worlds
from sim2d.config import KidnapConfig, OdometerConfig, SimConfig
from sim2d.errors import WorldError
from sim2d.records import EPOCH_NS, SetDown, SimReading, SimTruth
from sim2d.robot import SimRobot
from sim2d.sensors.odometer import Odometer, joined
from sim2d.streams import stream

SMALL = {"camera": {"width": 72, "height": 20, "forward_column": 36}, "laser": {"rays": 36}}
EXACT = OdometerConfig(
    distance_scale=1.0, rotation_scale=1.0, curvature=0.0, forward_noise=0.0, turn_noise_deg=0.0, spread=0.0
)


def odometer(**changes: float) -> Odometer:
    return Odometer(EXACT.model_copy(update=changes), *(stream(1, name) for name in ("drift", "noise", "slip")))


def run(sim: dict[str, object], count: int, world: str = "room-corridor") -> list[tuple[SimReading, SimTruth]]:
    robot = SimRobot(worlds.load(world), SimConfig.model_validate(SMALL | sim), 5)
    return [(reading, robot.truth()) for _ in range(count) if (reading := robot.sense()) is not None]


@pytest.mark.parametrize("times", [0.0, 0.111, 1.0, 9.0])
def test_it_declares_what_it_is_told_to_and_reads_the_same(times: float) -> None:
    own, told = (odometer(forward_noise=0.02, declared=one).read(0.1, 0.2, 0.25) for one in (1.0, times))
    assert (told.forward, told.turn) == (own.forward, own.turn)
    assert told.covariance == pytest.approx(times * own.covariance)


@pytest.mark.parametrize(
    ("slip", "contact", "read"), [(0.0, True, 0.02), (1.0, True, 0.1), (0.5, True, 0.06), (1.0, False, 0.02)]
)
def test_spinning_wheels_read_the_blocked_way(slip: float, contact: bool, read: float) -> None:
    assert odometer(slip=slip).read(0.02, 0.0, 0.25, 0.08, contact).forward == pytest.approx(read)


def test_contact_twists_the_reading_only_in_contact() -> None:
    twisted = odometer(slip_turn_deg=2.0)
    assert twisted.read(0.1, 0.0, 0.25).turn == 0.0
    turns = [twisted.read(0.1, 0.0, 0.25, 0.0, True).turn for _ in range(2000)]
    assert np.std(turns) == pytest.approx(math.radians(2.0), rel=0.06)


def test_noise_per_radian_comes_with_turning_and_is_declared() -> None:
    noisy = odometer(turn_noise_per_rad_deg=3.0)
    assert noisy.read(0.5, 0.0, 0.25).turn == 0.0
    readings = [noisy.read(0.0, 0.25, 0.25) for _ in range(3000)]
    sigma = math.radians(3.0) * math.sqrt(0.25)
    assert np.std([r.turn for r in readings]) == pytest.approx(sigma, rel=0.05)
    assert readings[0].covariance[2, 2] == pytest.approx(sigma**2)


def test_slip_draws_leave_the_other_noise_as_it_was() -> None:
    plain, slipping = (
        Odometer(OdometerConfig(slip_turn_deg=deg), *(stream(1, name) for name in ("drift", "noise", "slip")))
        for deg in (0.0, 5.0)
    )
    for k in range(20):
        a, b = plain.read(0.1, 0.1, 0.25, 0.0, k < 10), slipping.read(0.1, 0.1, 0.25, 0.0, k < 10)
        assert a.forward == b.forward
        assert (a.turn == b.turn) == (k >= 10)


def test_joined_increments_add_up() -> None:
    a, b = odometer().read(0.1, 0.2, 0.25), odometer().read(0.3, -0.1, 0.25)
    both = joined(a, b)
    assert (both.forward, both.turn, both.dt) == pytest.approx((0.4, 0.1, 0.5))
    np.testing.assert_allclose(both.covariance, a.covariance + b.covariance)


def test_a_missing_frame_is_a_missing_reading_whose_motion_is_not_lost() -> None:
    exact = {"odometer": EXACT.model_dump()}
    gappy = run(exact | {"camera": {**SMALL["camera"], "missing": 0.4}}, 60)
    stamps = np.array([reading.stamp_ns for reading, _ in gappy])
    steps = np.diff(stamps) / 0.25e9
    assert stamps[0] == EPOCH_NS
    assert set(steps) > {1.0, 2.0}
    assert (steps == 1).mean() == pytest.approx(0.6, abs=0.15)
    for (reading, truth), dt in zip(gappy[1:], steps * 0.25, strict=True):
        assert reading.motion.dt == pytest.approx(dt)
        assert truth.stamp_ns == reading.stamp_ns
    way = sum(reading.motion.forward for reading, _ in gappy)
    assert way == pytest.approx((len(gappy) + sum(steps - 1) - 1) * 0.1, rel=0.05)


def test_missing_frames_leave_the_odometry_as_it_was() -> None:
    whole, gappy = run({}, 40), run({"camera": {**SMALL["camera"], "missing": 0.3}}, 25)
    along = {reading.stamp_ns: total for reading, total in _totals(whole)}
    for reading, total in _totals(gappy):
        assert total == pytest.approx(along[reading.stamp_ns])


def _totals(readings: list[tuple[SimReading, SimTruth]]) -> list[tuple[SimReading, float]]:
    return list(zip((r for r, _ in readings), np.cumsum([r.motion.forward for r, _ in readings]), strict=True))


def test_carried_away_the_truth_jumps_and_the_odometry_does_not() -> None:
    kidnap = {"kidnaps": [{"at_s": 2.0, "x": 3.0, "y": 5.8, "heading_deg": 180.0}]}
    usual, carried = run({}, 12), run(kidnap, 12)
    for (a, _), (b, _) in zip(usual[:9], carried[:9], strict=True):
        assert (a.motion.forward, a.motion.turn) == (b.motion.forward, b.motion.turn)
    jump = math.dist((carried[7][1].x, carried[7][1].y), (carried[8][1].x, carried[8][1].y))
    assert jump > 3
    assert (carried[8][1].x, carried[8][1].y) == pytest.approx((3.0, 5.8))
    assert carried[8][0].motion.forward < 0.12
    assert carried[8][0].encoded != usual[8][0].encoded
    # the driver goes on with the route from there
    assert math.dist((carried[11][1].x, carried[11][1].y), (3.0, 5.8)) == pytest.approx(0.3, abs=0.05)
    assert abs(carried[11][1].y - 5.8) < 0.1


def test_carried_to_a_named_place() -> None:
    robot = worlds.load("room-corridor")
    with pytest.raises(WorldError, match="no place 'nowhere'"):
        SimRobot(robot, SimConfig.model_validate({"kidnaps": [{"at_s": 1.0, "place": "nowhere"}]}), 0)
    with pytest.raises(ValidationError, match="one of a place, x and y, along"):
        KidnapConfig(at_s=1.0)
    with pytest.raises(ValidationError, match="one of a place, x and y, along"):
        KidnapConfig(at_s=1.0, place="there", x=1.0, y=2.0)


def test_carried_on_along_the_route_and_turned_on_the_spot() -> None:
    usual = run({}, 12)
    carried = run({"kidnaps": [{"at_s": 2.0, "along": 1.0}]}, 12)
    turned = run({"kidnaps": [{"at_s": 2.0, "turn_deg": 90.0}]}, 12)
    before, after = usual[8][1], carried[8][1]
    assert (after.x - before.x, after.y - before.y) == pytest.approx((1.0, 0.0), abs=0.02)
    assert after.heading == pytest.approx(before.heading, abs=0.02)
    assert math.dist((turned[8][1].x, turned[8][1].y), (before.x, before.y)) < 1e-3
    assert turned[8][1].heading - before.heading == pytest.approx(math.pi / 2, abs=0.01)
    assert [r.motion.forward for r, _ in carried[:9]] == [r.motion.forward for r, _ in usual[:9]]


def test_a_kidnap_waits_for_the_driver_to_hand_over() -> None:
    config = {"driver": {"laps": 0.02}, "kidnaps": [{"handed_over_s": 0.5, "turn_deg": 180.0}]}
    robot = SimRobot(worlds.load("hall"), SimConfig.model_validate(SMALL | config), 0)
    headings, driven = [], []
    for _ in range(20):
        reading = robot.sense()
        assert reading is not None
        headings.append(robot.truth().heading)
        driven.append(reading.driven)
    over = driven.index(False)
    assert headings[over + 1] == pytest.approx(headings[over])
    assert abs(math.remainder(headings[over + 2] - headings[over + 1], math.tau)) == pytest.approx(math.pi)


def test_dead_and_noisy_odometry_from_a_moment_on() -> None:
    usual, truth = run({}, 14), run({}, 14)
    dead = run({"odometry_faults": [{"at_s": 2.0, "forward_scale": 0.0, "turn_scale": 0.0}]}, 14)
    brief = run({"odometry_faults": [{"at_s": 2.0, "lasts_s": 0.5, "jump": 3.0}]}, 14)
    assert [r.motion.forward for r, _ in dead[:8]] == [r.motion.forward for r, _ in usual[:8]]
    assert all(r.motion.forward == 0.0 and r.motion.turn == 0.0 for r, _ in dead[8:])
    assert [t for _, t in dead] == [t for _, t in truth]
    jumps = [a.motion.forward - b.motion.forward for (a, _), (b, _) in zip(brief, usual, strict=True)]
    assert jumps == pytest.approx([0.0] * 8 + [3.0] + [0.0] * 5)
    noisy = run({"odometry_faults": [{"at_s": 0.0, "forward_noise": 0.1, "turn_noise": 0.3}]}, 40)
    off = [a.motion.turn - b.motion.turn for (a, _), (b, _) in zip(noisy, run({}, 40), strict=True)]
    assert 0.2 < float(np.std(off[1:])) < 0.4


def test_set_down_in_mid_run_nobody_drives_and_commands_count() -> None:
    config = SimConfig.model_validate(SMALL)
    robot = SimRobot(worlds.load("hall"), config, 0, SetDown((10.0, 8.0, 1.0), 100))
    first = robot.sense()
    assert first is not None
    assert not first.driven
    assert first.stamp_ns == EPOCH_NS + 100 * 250_000_000
    assert (robot.truth().x, robot.truth().y, robot.truth().heading) == (10.0, 8.0, 1.0)
    robot.act(Ahead())
    second = robot.sense()
    assert second is not None
    assert second.stamp_ns - first.stamp_ns == 250_000_000
    assert math.dist((robot.truth().x, robot.truth().y), (10.0, 8.0)) == pytest.approx(0.1, abs=1e-3)


class Ahead:
    forward, turn = 0.4, 0.0
