"""Journeys on the square map, step by step: the same commands and words as before."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from homing_fakes import Knowing, KnowingCompass
from kept import as_before
from roamer import Roamer, difference

from topomap.core.geometry import Pose2
from topomap.core.records import Hypothesis
from topomap.navigation import sight
from topomap.navigation.senses import Health
from topomap.vision.aligned_homing import AlignedHoming


def wall(x: float) -> Callable[[Pose2, Pose2], bool]:
    return lambda before, after: after.y < 1.0 and abs(after.x - x) < 0.2 and abs(after.x - x) < abs(before.x - x)


def wanders() -> Callable[[Pose2], Pose2]:
    """A belief that is off by something else in every step, as one is."""
    rng = np.random.default_rng(3)

    def believed(pose: Pose2) -> Pose2:
        x, y, turn = rng.normal(size=3) * [0.05, 0.05, 0.04]
        return Pose2(pose.x + x, pose.y + y, pose.heading + turn)

    return believed


def robots() -> dict[str, tuple[Roamer, int, int]]:
    """Robots, each with its goal and the steps it is watched for."""
    blind = AlignedHoming(KnowingCompass(), Knowing(silent_beyond=-9.0))
    return {
        "free": (Roamer(), 12, 200),
        "unsure": (Roamer(believed=wanders(), lost=0.04), 10, 200),
        "doubtful": (Roamer(believed=wanders(), lost=0.2), 6, 120),
        "blocked": (Roamer(wall=wall(2.25)), 8, 260),
        "lost": (Roamer(lost=0.9, homing=blind), 8, 160),
        "rivals": (Roamer(pose=Pose2(0.6, 0.1, 2.0), rivals=(Hypothesis(9, Pose2(9.0, 9.0), 0.4),)), 0, 120),
        "off course": (Roamer(pose=Pose2(1.0, 2.5, 0.0), believed=wanders()), 20, 200),
        "slow": (Roamer(pose=Pose2(0.3, 0.2, math.pi), health=Health(slow=True)), 9, 120),
        "beside": (Roamer(believed=lambda pose: Pose2(pose.x + 0.3, pose.y - 0.3, pose.heading + 0.1)), 10, 160),
    }


@pytest.mark.parametrize("name", robots())
def test_journeys_are_as_before(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sight, "aligned_difference", difference)
    robot, goal, steps = robots()[name]
    robot.travel(goal, steps)
    told = robot.travels
    as_before(
        f"journey {name}",
        {
            "forward": [command.forward for command in robot.commands],
            "turn": [command.turn for command in robot.commands],
            "milestone": [-1 if one.milestone is None else one.milestone for one in told],
            "left": [-1 if one.legs_left is None else one.legs_left for one in told],
            "bearing": [9.0 if one.home is None else one.home.bearing for one in told],
            "difference": [9.0 if one.difference is None else one.difference for one in told],
            "said": [f"{k}: {one.note}" for k, one in enumerate(told) if one.note],
            "end": [str(told[-1].phase)],
        },
    )
