from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from topomap.core.geometry import Pose2
from topomap.core.panorama import Panorama
from topomap.core.recorded import RecordedRig
from topomap.core.records import Command, Motion
from topomap.experiments.pillars import Pillar, Room, painted
from topomap.experiments.results import add_results, read_results
from topomap.experiments.spacing import HEAD, LEGS, Course, Follower, Milestone, judged, milestones, tally
from topomap.vision.registry import aligned_homing

ROOM = Room([Pillar(1.5, 2.0, 0.3, (20, 60, 200)), Pillar(-1.0, -1.8, 0.3, (200, 60, 20))], 4.0,
            painted(np.random.default_rng(3)))  # fmt: skip
DT = 0.25


class Rolling:
    """A robot that moves as it is told in a painted room; its odometry is right."""

    def __init__(self, pose: Pose2, steps: int = 400) -> None:
        self.pose, self.left, self.command, self.motion = pose, steps, Command(), Motion(0.0, 0.0, 0.0, np.eye(3), DT)

    def sense(self) -> Any:
        if self.left == 0:
            return None
        self.left -= 1
        way, turn = self.command.forward * DT, self.command.turn * DT
        self.pose = self.pose @ Pose2(way * math.cos(turn / 2), way * math.sin(turn / 2), turn)
        seen = ROOM.view(self.pose.x, self.pose.y, self.pose.heading)
        motion = Motion(way, 0.0, turn, np.eye(3), DT)
        rig = RecordedRig.cylinder(seen.rig.width, seen.rig.height, 0.0, forward_column=0, clockwise=False)
        return SimpleNamespace(image=seen.image, ranges=seen.ranges, motion=motion, rig=rig, stamp_ns=0)

    def act(self, command: Command) -> None:
        self.command = command

    def stop(self) -> None:
        pass


def way(length: float = 2.0) -> list[tuple[Panorama, Pose2, float]]:
    return [(ROOM.view(-1.0 + x, 0.3, 0.0), Pose2(x, 0.0, 0.0), x) for x in np.arange(0.0, length, 0.1)]


def drive(method: str, spacing: float, start: Pose2) -> tuple[int, list[float]]:
    course, places = milestones(way(), spacing)
    robot, errors = Rolling(start), list[float]()

    def reached(k: int) -> bool:
        return judged(math.dist((robot.pose.x, robot.pose.y), (-1.0 + 0.1 * places[k], 0.3)), errors)

    homing = aligned_homing(method, "visual-compass")
    return Follower(homing, course).follow(robot, reached, Pose2(), spacing), errors


def test_a_method_that_homes_goes_from_milestone_to_milestone() -> None:
    legs, errors = drive("area-centroid", 0.5, Pose2(-1.0, 0.3, 0.0))
    assert legs == LEGS
    assert max(errors) < 0.3


def test_a_method_without_a_sign_gets_nowhere() -> None:
    legs, _ = drive("moment-colour-only", 0.5, Pose2(-1.0, 0.3, 0.0))
    assert legs < LEGS


def test_an_arrival_elsewhere_ends_the_course() -> None:
    course, _ = milestones(way(), 0.5)
    homing = aligned_homing("area-centroid", "visual-compass")
    claims: list[int] = []

    def refused(k: int) -> bool:
        claims.append(k)
        return False

    assert Follower(homing, course).follow(Rolling(Pose2(-1.0, 0.3, 0.0)), refused, Pose2(), 0.5) == 0
    assert claims == [0]
    assert Follower(homing, course).follow(Rolling(Pose2(-1.0, 0.3, 0.0), 3), refused, Pose2(), 0.5) == 0


def test_milestones_stand_a_spacing_apart() -> None:
    course, places = milestones(way(), 0.5)
    assert places == [5, 10, 15]
    assert [m.odometry.x for m in course] == pytest.approx([0.5, 1.0, 1.5])
    assert all(isinstance(m, Milestone) for m in course)


def test_arrivals_count_within_the_bound_alone() -> None:
    errors: list[float] = []
    assert judged(0.3, errors)
    assert not judged(0.31, errors)
    assert errors == [0.3]


def test_the_tally_counts_whole_courses_and_is_kept_and_read(tmp_path: Path) -> None:
    courses = [
        Course("hall", "did", seed, 0.5, legs, (0.1,) * legs, legs == 1) for seed, legs in enumerate((LEGS, LEGS, 1, 0))
    ]
    (row,) = tally(courses)
    told = dict(zip(HEAD, row, strict=True))
    assert (told["courses"], told["done"], told["legs"], told["false"], told["error"]) == ("4", "2", "7", "1", "0.10")
    assert float(told["low"]) < 0.5 < float(told["high"])
    path = tmp_path / "kept.csv"
    add_results(path, HEAD, [row], keys=3)
    add_results(path, HEAD, [(*row[:3], "8", *row[4:]), ("room", *row[1:])], keys=3)
    kept = read_results(path)
    assert [r["world"] for r in kept.rows] == ["hall", "room"]
    assert kept.rows[0]["courses"] == "8"
    assert len(kept.commands) == 1
