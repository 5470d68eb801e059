"""A policy at the wheels: each move is driven to its end, then it looks; what stands in the way ends a move too."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
import pytest
from homing_fakes import RIG, KnowingCompass, TellingViews

from topomap.core.geometry import Pose2, wrap
from topomap.core.panorama import Panorama
from topomap.core.records import Command, HomeVector
from topomap.navigation.manoeuvres.policy_drive import PATIENCE, PolicyDrive
from topomap.navigation.pilot import Pilot, PilotSettings
from topomap.vision.aligned_homing import AlignedHoming
from topomap.vision.homing import Needs

DT = 0.25


@dataclass(frozen=True)
class Listed:
    """Makes the moves (bearing in the goal's frame [rad], distance [m]) it was given, one a look."""

    moves: tuple[tuple[float, float], ...]
    looks: list[Panorama] = field(default_factory=list)
    needs = Needs(compass=True)
    claims_homing = True

    def start(self, goal: Panorama) -> int:
        return 0

    def step(self, state: int, current: Panorama) -> tuple[int, HomeVector]:
        self.looks.append(current)
        return state + 1, HomeVector(*self.moves[min(state, len(self.moves) - 1)])


def view(pose: Pose2) -> Panorama:
    return TellingViews().view(pose.x, pose.y, pose.heading)


def moved(pose: Pose2, command: Command) -> Pose2:
    return pose @ Pose2(command.forward * DT * math.cos(command.turn * DT / 2), 0.0, command.turn * DT)


def driven(policy: Listed, start: Pose2, looks: int) -> tuple[list[Pose2], list[Command]]:
    """Drive till so many looks were taken; return where the robot stood at each and all commands."""
    drive = PolicyDrive(AlignedHoming(KnowingCompass(), policy), view(Pose2()), Pilot(PilotSettings()))
    pose, at, commands = start, [], []
    for _ in range(400):
        if not drive.moving(pose):
            at.append(pose)
            if len(at) == looks:
                break
            drive.look(view(pose), pose.heading, pose)
        commands.append(drive.drive(view(pose), pose, 0.4))
        pose = moved(pose, commands[-1])
    return at, commands


def test_each_move_ends_where_the_policy_wanted_it_whatever_the_heading() -> None:
    moves = ((0.0, 0.1), (math.pi * 0.75, 0.1414), (-math.pi / 2, 0.1), (0.3, 0.4))
    at, _ = driven(Listed(moves), Pose2(0.5, 0.5, 2.0), 5)
    x, y = 0.5, 0.5
    for pose, (bearing, distance) in zip(at[1:], moves, strict=True):
        x, y = x + distance * math.cos(bearing), y + distance * math.sin(bearing)
        assert math.dist((pose.x, pose.y), (x, y)) < 0.07
    steps = [math.dist((a.x, a.y), (b.x, b.y)) for a, b in pairwise(at)]
    assert steps == pytest.approx([d for _, d in moves], abs=0.04)


def test_it_turns_on_the_spot_before_a_move_to_the_side() -> None:
    _, commands = driven(Listed(((math.pi / 2, 0.1),)), Pose2(), 2)
    assert commands[0].forward == 0.0
    assert commands[0].turn > 0.0
    assert max(command.forward for command in commands) <= 0.4


def test_the_policy_is_shown_views_that_look_the_goals_way() -> None:
    policy = Listed(((0.0, 0.1),))
    driven(policy, Pose2(0.0, 0.0, 1.0), 3)
    assert len(policy.looks) == 2
    for seen in policy.looks:
        assert abs(wrap(int(seen.image[0, :, 2].argmax()) * math.tau / RIG.width)) < 0.02


def test_a_move_that_does_not_end_is_over_when_patience_is() -> None:
    drive = PolicyDrive(AlignedHoming(KnowingCompass(), Listed(((0.0, 0.5),))), view(Pose2()), Pilot(PilotSettings()))
    blocked = Panorama(np.zeros((2, 360, 3), np.uint8), np.full(360, 0.2, np.float32), RIG)
    assert not drive.moving(Pose2())
    drive.look(view(Pose2()), 0.0, Pose2())
    for _ in range(PATIENCE):
        assert drive.moving(Pose2())
        drive.drive(blocked, Pose2(), 0.4)
    assert not drive.moving(Pose2())


def test_a_policy_that_stays_looks_again_at_once() -> None:
    drive = PolicyDrive(AlignedHoming(KnowingCompass(), Listed(((0.0, 0.0),))), view(Pose2()), Pilot(PilotSettings()))
    drive.look(view(Pose2()), 0.0, Pose2())
    assert not drive.moving(Pose2())
