"""Odometry that can't be true is noticed by the views before and after; what is usual isn't."""

from __future__ import annotations

from pathlib import Path

from played import moved, taught

from sim2d import worlds
from sim2d.config import SimConfig
from sim2d.records import SetDown, SimReading
from sim2d.robot import SimRobot
from topomap.core.panorama import Panorama
from topomap.core.records import Command
from topomap.mapping.odometry.watch import OdometryWatch

TWO_CORRIDORS = Path(__file__).parents[2] / "examples" / "worlds" / "two-corridors.toml"


def said(readings: list[SimReading]) -> list[tuple[int, str]]:
    watch = OdometryWatch()
    words = [(k, watch.judge(Panorama.from_reading(r), r.motion)) for k, r in enumerate(readings)]
    return [(k, word) for k, word in words if word]


def test_an_undisturbed_drive_is_believed() -> None:
    assert said(taught(80)) == []


def test_being_carried_on_by_two_metres_is_noticed_at_once() -> None:
    seen = taught(80)
    assert [(k, word.split(":")[0]) for k, word in said(seen[:40] + seen[60:])] == [(40, "carried away")]


def test_wheels_that_stood_while_the_view_moved_are_noticed_when_they_go_on() -> None:
    seen = taught(60)
    dead = [moved(r, forward=0.0, turn=0.0) if 30 <= k < 45 else r for k, r in enumerate(seen)]
    found = said(dead)
    assert [k for k, _ in found] == [45]
    assert "stood still for 15 steps" in found[0][1]


def test_wheels_that_spin_on_the_spot_are_noticed_when_they_grip() -> None:
    seen = taught(60)
    stuck = seen[:30] + [moved(seen[29], forward=0.1, turn=0.0) for _ in range(8)] + seen[30:]
    found = said(stuck)
    assert [k for k, _ in found] == [38]
    assert "spun for 8 steps" in found[0][1]


def test_turning_on_the_spot_and_driving_into_a_corridor_are_no_breaks() -> None:
    config = SimConfig()
    robot = SimRobot(worlds.load(str(TWO_CORRIDORS)), config, 1, SetDown((3.0, 6.5, 0.0), 10))
    watch = OdometryWatch()
    for k in range(95):
        reading = robot.sense()
        assert reading is not None
        assert watch.judge(Panorama.from_reading(reading), reading.motion) == "", k
        robot.act(Command(0.0, 0.8) if 70 <= k < 86 else Command(0.4, 0.0))
