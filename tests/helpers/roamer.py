"""A robot without a simulator on the square map: where it is and where it believes to be are one's to set."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import cast

import numpy as np
from homing_fakes import Knowing, KnowingCompass, TellingViews, told
from maps import square

from topomap.core.geometry import Pose2, wrap
from topomap.core.panorama import Panorama
from topomap.core.records import Command, Goal, Hypothesis, Phase, Travel, Where
from topomap.mapping.graph import TopoMap
from topomap.mapping.mapper import Mapper
from topomap.navigation.senses import SOUND, Health, Senses
from topomap.navigation.traveller import Traveller, TravelSettings
from topomap.vision.aligned_homing import AlignedHoming

DT, STEP_NS = 0.25, 250_000_000


def difference(current: Panorama, goal: Panorama, rotation: float) -> float:
    """As of real views: nothing at the place itself, 0.35 at 0.1 m, unrelated from 0.3 m on or turned by 0.6 rad."""
    (x, y, heading), (gx, gy, goal_heading) = told(current), told(goal)
    turned = abs(wrap(heading - goal_heading - rotation))
    return min(1.1, 3.5 * math.hypot(x - gx, y - gy) + 2.0 * turned)


@dataclass
class Roamer:
    """The robot: `pose` is where it is, `believed` where it believes to be (None: the same)."""

    topo: TopoMap = field(default_factory=lambda: square(8))
    pose: Pose2 = field(default_factory=Pose2)
    homing: AlignedHoming = field(default_factory=lambda: AlignedHoming(KnowingCompass(), Knowing()))
    believed: Callable[[Pose2], Pose2] = lambda pose: pose
    lost: float = 0.0
    rivals: tuple[Hypothesis, ...] = ()
    health: Health = SOUND
    contact: bool = False
    wall: Callable[[Pose2, Pose2], bool] = lambda before, after: False
    travels: list[Travel] = field(default_factory=list)
    commands: list[Command] = field(default_factory=list)
    way: float = 0.0

    def __post_init__(self) -> None:
        self.traveller = Traveller(TravelSettings(), self.homing)
        self._turn, self._raw = 0.0, Pose2()

    def step(self, goal: int) -> Travel:
        """Sense, decide and drive one step towards a node."""
        where = self.believed(self.pose)
        away = np.hypot(self.topo.poses[:, 0] - where.x, self.topo.poses[:, 1] - where.y)
        belief = Where(where, int(np.argmin(away)), 0.5, self.lost, self.rivals)
        view = TellingViews().view(self.pose.x, self.pose.y, self.pose.heading)
        senses = Senses(len(self.commands) * STEP_NS, view, self._turn, self.contact, self.health, view.ranges)
        command, travel = self.traveller.step(senses, belief, Goal(Phase.TRAVEL, goal), self._mapper())
        self.commands.append(command)
        self.travels.append(travel)
        self._drive(command)
        return travel

    def travel(self, goal: int, steps: int = 400) -> Travel:
        """Step until the journey has ended; return its last word."""
        for _ in range(steps):
            if self.step(goal).phase is not Phase.TRAVEL:
                break
        return self.travels[-1]

    def notes(self) -> list[str]:
        """What the traveller said, in order."""
        return [travel.note for travel in self.travels if travel.note]

    def _drive(self, command: Command) -> None:
        turned = Pose2(0.0, 0.0, command.turn * DT)
        after = self.pose @ turned @ Pose2(command.forward * DT)
        if self.wall(self.pose, after):
            after = self.pose @ turned
        self.way += self.pose.distance(after)
        self._raw = self._raw @ self.pose.to(after)
        self._turn, self.pose = command.turn * DT, after

    def _mapper(self) -> Mapper:
        def panorama(node: int) -> Panorama:
            pose = self.topo.pose(node)
            return TellingViews().view(pose.x, pose.y, pose.heading)

        track = SimpleNamespace(raw=self._raw, turn=self._turn, travel=self.way)
        return cast(Mapper, SimpleNamespace(map=self.topo, view_cache=SimpleNamespace(panorama=panorama), track=track))
