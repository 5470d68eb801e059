"""The thesis's mission in the hall (5.2.4): one home image, a rectangle by odometry, home from where it looks alike."""

from __future__ import annotations

import math
from copy import copy

import numpy as np
from pydantic import BaseModel, Field

from topomap.core.geometry import Pose2, wrap
from topomap.core.panorama import Panorama
from topomap.core.records import Alignment, Command, HomeVector, Phase, Travel
from topomap.navigation.arrival import Arrival
from topomap.navigation.manoeuvres.policy_drive import PolicyDrive
from topomap.navigation.pilot import Pilot
from topomap.vision.aligned_homing import AlignedHoming
from topomap.vision.image.aligned_difference import aligned_difference
from topomap.vision.image.compare import rotation_difference, signature
from topomap.vision.image.equalised import equalised

LEFT = 10.0
"""[m] Way after which home counts as left: within it the image difference still falls back towards home."""
SHARE = 0.8
"""Share of the course's median image difference below which a minimum is home: it is 0 to 0.62 where the course passes
home within 0.7 m, 0.84 or more where it passes 1.5 m off and everywhere else in the hall, equalised or not."""
RISE, RISING = 1.05, 2
"""The minimum is passed when the difference is this much above it for so many steps."""
CORNER = 1.2
"""[m] So near a corner the next side is steered for: the radius of the bends of the hall's own course."""
LOOKAHEAD = 1.0
"""[m] To the point on a side that is steered for: two and a half seconds' way."""
GOAL_SPEED = 0.2
"""[m/s] On the way home: a step of 0.25 s is 5 cm."""
POLICY_REST = 12
"""Looks without a new minimum after which a policy has come to its end: a round of trial moves is up to nine."""
LEARNT = 1.0
"""[m] Way from home on which the robot learns how unlike home a place looks by how far away it is."""
AT, NEAR = 0.1, 0.2
"""[m] Home is where the view is as alike as it was so near while home was left, or so near where it has just passed its
minimum. Of 519 looks that were as alike as within 0.2 m (ten missions of three methods in the hall, equalised and not)
all were within 0.18 m; what was asked before, 0.7 of the difference where homing began, was met 0.4 m off."""
AHEAD = 1.0
"""[rad] A home vector this near the nose is driven along; with others the robot turns first."""
TRIES, STALE = 400, 80
"""Steps after which homing is given up, and those without a lower difference."""


class HallSettings(BaseModel, frozen=True, extra="forbid"):
    """The rectangle that the mission in the hall drives, home on one of its long sides."""

    ahead: float = Field(13.0, gt=0, le=1000, description="from home to the first corner [m]")
    behind: float = Field(2.0, ge=0, le=1000, description="from the last corner to home [m]")
    width: float = Field(10.0, gt=0, le=1000, description="of the rectangle, which lies to the left [m]")
    equalise: bool = Field(False, description="equalise the histograms of the views that are compared")


class HallCourse:
    """Drives the course, notices home by the image difference, and homes by whatever method it is given.

    differences: of each step's view to the home image, at the best rotation; homing_from: the step at which homing
    began, None before.
    """

    def __init__(self, settings: HallSettings, pilot: Pilot, homing: AlignedHoming) -> None:
        self._s, self._pilot, self._homing = settings, pilot, homing
        self._home: Panorama | None = None
        self._at = Pose2()
        self._corners: list[Pose2] = []
        self._way, self._last = 0.0, Pose2()
        self._rising = 0
        self._lowest = math.inf
        self._rotation: float | None = None
        self._arrival = Arrival()
        self._drive: PolicyDrive | None = None
        self._steps = 0
        self._seen: list[float] = []  # differences on the way home
        self._left: list[tuple[float, float]] = []  # distance from home [m] and difference while it was left
        self.differences: list[float] = []
        self.homing_from: int | None = None

    def homing_by(self, homing: AlignedHoming) -> HallCourse:
        """Return the course as it stands, to be ended by another method."""
        other = copy(self)
        other._homing, other.differences, other._seen = homing, list(self.differences), []
        other._ready()
        return other

    def _ready(self) -> None:
        """Begin to home."""
        assert self._home is not None
        self._drive = PolicyDrive(self._homing, self._home, self._pilot) if self._homing.policy else None
        self._arrival = Arrival(POLICY_REST, POLICY_REST) if self._drive else Arrival()

    def step(self, seen: Panorama, pose: Pose2, raw: Pose2) -> tuple[Command, Travel]:
        """Return the command and what was done; pose: by corrected odometry, raw: by odometry as read."""
        panorama = equalised(seen) if self._s.equalise else seen
        if self._home is None:
            self._begin(panorama, pose)
        assert self._home is not None
        self._way += self._last.distance(pose)
        turn, self._last = wrap(pose.heading - self._last.heading), pose
        difference, rotation = rotation_difference(signature(panorama), signature(self._home))
        self.differences.append(difference)
        if self._way <= LEARNT:
            self._left.append((self._at.distance(pose), aligned_difference(panorama, self._home, rotation)))
        if self.homing_from is None and self._passed(difference):
            self.homing_from = len(self.differences) - 1
            self._ready()
        return self._course(seen, pose, difference) if self.homing_from is None else self._homeward(panorama, raw, turn)

    def _begin(self, panorama: Panorama, pose: Pose2) -> None:
        s = self._s
        self._home, self._at, self._last = panorama, pose, pose
        around = (
            (0.0, 0.0),
            (s.ahead, 0.0),
            (s.ahead, s.width),
            (-s.behind, s.width),
            (-s.behind, 0.0),
            (s.ahead, 0.0),
        )
        self._corners = [pose @ Pose2(x, y) for x, y in around]

    def _passed(self, difference: float) -> bool:
        """Return whether a minimum that is home's has just been passed."""
        if self._way < LEFT:
            return False
        self._lowest = min(self._lowest, difference)
        usual = float(np.median(self.differences))
        self._rising = self._rising + 1 if difference > RISE * self._lowest else 0
        if self._rising < RISING:
            return False
        found = self._lowest < SHARE * usual
        self._lowest, self._rising = math.inf, 0  # another one may come
        return found

    def _course(self, seen: Panorama, pose: Pose2, difference: float) -> tuple[Command, Travel]:
        while len(self._corners) > 1 and pose.distance(self._corners[1]) < CORNER:
            self._corners.pop(0)
        if len(self._corners) < 2:
            return Command(), Travel(Phase.FAILED, 0, None, difference, 0, "the course is over and home wasn't noticed")
        command = self._pilot.steer(pose.bearing_to(_ahead_on(self._corners[0], self._corners[1], pose)), seen.ranges)
        return command, Travel(Phase.TRAVEL, None, None, difference, len(self._corners) - 1)

    def _is_home(self, difference: float, alignment: Alignment) -> bool:
        """Return whether the view is as alike as at home, or has passed its minimum near home on the way there."""
        if self._as_within(AT, difference):
            return True
        # beyond home the difference has just risen: only on the way there does its minimum tell of home
        if not (self._towards(alignment) and self._arrival.update(difference)):
            return False
        if self._as_within(NEAR, difference):
            return True
        self._arrival = Arrival(POLICY_REST, POLICY_REST) if self._drive else Arrival()
        return False

    def _as_within(self, distance: float, difference: float) -> bool:
        """Return whether a view is as alike as views were within a distance [m] of home while that was left."""
        away, seen = np.array(sorted(self._left)).T
        return difference <= float(np.interp(distance, away, seen))

    def _towards(self, alignment: Alignment) -> bool:
        """Return whether the robot drives the way that its home vector points, or moves as a policy does."""
        return self._drive is not None or (alignment.home is not None and abs(alignment.home.bearing) < AHEAD)

    def _homeward(self, panorama: Panorama, raw: Pose2, turn: float) -> tuple[Command, Travel]:
        assert self._home is not None
        if self._rotation is not None:
            self._rotation = wrap(self._rotation + turn)
        if self._drive is not None and self._drive.moving(raw):
            return self._drive.drive(panorama, raw, GOAL_SPEED), Travel(Phase.TRAVEL, 0, legs_left=1)
        alignment = self._homing.align(panorama, self._home, self._rotation)
        self._rotation = alignment.rotation
        difference = aligned_difference(panorama, self._home, alignment.rotation)
        self._steps += 1
        self._seen.append(difference)
        if self._is_home(difference, alignment):
            return Command(), Travel(Phase.ARRIVED, 0, None, difference, 0, "home")
        if self._steps > TRIES or len(self._seen) - int(np.argmin(self._seen)) > STALE:
            return Command(), Travel(Phase.FAILED, 0, None, difference, 0, "homing leads no nearer")
        if self._drive is not None:
            home = self._drive.look(panorama, alignment.rotation, raw)
            command = self._drive.drive(panorama, raw, GOAL_SPEED)
        else:
            home = alignment.home or HomeVector(0.0, None, 0.0)
            command = self._pilot.steer(home.bearing, panorama.ranges, GOAL_SPEED)
        note = "home looks near" if self._steps == 1 else ""
        return command, Travel(Phase.TRAVEL, 0, home, difference, 1, note)


def _ahead_on(begin: Pose2, end: Pose2, pose: Pose2) -> Pose2:
    """Return the point on a side that lies ahead of where a pose is beside it."""
    length = begin.distance(end)
    x, y = (end.x - begin.x) / length, (end.y - begin.y) / length
    along = (pose.x - begin.x) * x + (pose.y - begin.y) * y + LOOKAHEAD
    along = min(max(along, 0.0), length)
    return Pose2(begin.x + along * x, begin.y + along * y)
