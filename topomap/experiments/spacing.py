"""How far milestones may lie apart: a robot that goes from one to the next by what a method sees, and by that alone."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from topomap.core.geometry import Pose2, wrap
from topomap.core.panorama import Panorama
from topomap.core.records import Command
from topomap.core.robot import Reading, Robot
from topomap.evaluation.statistics import Interval, share_interval
from topomap.navigation.arrival import Arrival
from topomap.navigation.manoeuvres.policy_drive import PolicyDrive
from topomap.navigation.pilot import Pilot, PilotSettings
from topomap.navigation.sight import Look, Sight
from topomap.vision.aligned_homing import AlignedHoming

SPACINGS = (0.5, 0.8, 1.2, 1.8)
"""[m] Those of the milestone spacing study."""
LEGS = 3
"""Milestones of a course: errors of one leg are the next one's start."""
LONGEST, TRIALS = 2.5, 10.0
"""Longest way as a multiple of the direct one, and a policy's, which moves to look."""
POLICY_REST = 12
"""Looks without a new minimum after which a policy's leg is over: a round of trial moves is up to nine."""
REACHED = 0.3
"""[m] What an arrival may miss by."""
COAST = 5
"""Steps that the robot keeps its direction where the method has no answer."""


@dataclass(frozen=True, slots=True, eq=False)
class Milestone:
    """A view on the way, and the pose there by odometry (for the turn between milestones, as a map's edges tell it)."""

    view: Panorama
    odometry: Pose2


@dataclass(frozen=True, slots=True)
class Course:
    """One course: method, world, seed, spacing [m], legs done of LEGS, errors of the arrivals [m], and whether it
    ended by an arrival claimed elsewhere.
    """

    world: str
    method: str
    seed: int
    spacing: float
    legs: int
    errors: tuple[float, ...]
    false: bool

    @property
    def done(self) -> bool:
        """Whether every milestone was reached."""
        return self.legs == LEGS


def milestones(way: Sequence[tuple[Panorama, Pose2, float]], spacing: float) -> tuple[list[Milestone], list[int]]:
    """Return the first LEGS milestones after the beginning of a taught way, and where in it they stand.

    way: view, odometry, and metres driven, step by step.
    """
    wanted = [spacing * (k + 1) for k in range(LEGS)]
    places = [min(range(len(way)), key=lambda k: abs(way[k][2] - metres)) for metres in wanted]
    return [Milestone(*way[k][:2]) for k in places], places


@dataclass(slots=True)
class Follower:
    """Goes from milestone to milestone: turned and tracked by odometry as the robot's own travelling is, steered by the
    method's home vector and held clear by the pilot; each is reached when its view says so.
    """

    homing: AlignedHoming
    course: Sequence[Milestone]
    settings: PilotSettings = field(default_factory=PilotSettings)

    def follow(self, robot: Robot, reached: Callable[[int], bool], start: Pose2, spacing: float) -> int:
        """Drive the course; return how many milestones were reached. reached: judges each claim, False ends the course.

        start: the pose by odometry where the course begins, in the frame of the milestones'. Raises DataError.
        """
        pilot, heading, raw = Pilot(self.settings), start.heading, Pose2()
        for k, milestone in enumerate(self.course):
            leg = _Leg(self.homing, milestone, wrap(heading - milestone.odometry.heading), pilot)
            while not leg.over(spacing):
                reading = robot.sense()
                if reading is None:
                    return k
                raw = raw @ _moved(reading)
                command = leg.step(reading, raw)
                if leg.there:
                    break
                robot.act(command)
            if not leg.there or not reached(k):
                return k
            heading = milestone.odometry.heading + leg.sight.rotation
        return len(self.course)


class _Leg:
    """The way to one milestone."""

    def __init__(self, homing: AlignedHoming, milestone: Milestone, rotation: float, pilot: Pilot) -> None:
        self._homing, self._pilot = homing, pilot
        acting = homing.policy is not None
        self._drive = PolicyDrive(homing, milestone.view, pilot) if acting else None
        self.sight = Sight(0, 0, milestone.view, rotation, Arrival(POLICY_REST, POLICY_REST) if acting else None)
        self._most = TRIALS if acting else LONGEST
        self._way, self._steps, self._silent, self._last = 0.0, 0, 0, 0.0
        self.there = False

    def over(self, spacing: float) -> bool:
        """Return whether more way or time has been spent than a leg is worth."""
        return self._way > self._most * spacing or self._steps > 20 * self._most * (1.0 + spacing)

    def step(self, reading: Reading, raw: Pose2) -> Command:
        """Return the command of a step; raw: pose by odometry."""
        self._steps += 1
        self._way += abs(reading.motion.forward)
        self.sight.rotation = wrap(self.sight.rotation + reading.motion.turn)
        seen, speed = Panorama.from_reading(reading), math.inf
        if self._drive is not None and self._drive.moving(raw):
            return self._drive.drive(seen, raw, speed)
        look = self.sight.look(seen, self._homing)
        self.there = look.there
        if self._drive is not None:
            self._drive.look(seen, look.rotation, raw)
            return self._drive.drive(seen, raw, speed)
        return self._pilot.steer(self._bearing(look, reading.motion.turn), seen.ranges)

    def _bearing(self, look: Look, turned: float) -> float:
        """Return the home vector's bearing, or for some steps the last one where there is none."""
        answers = look.home.confidence > 0.0 and math.isfinite(look.home.bearing)
        self._silent = 0 if answers else self._silent + 1
        self._last = look.home.bearing if answers else wrap(self._last - turned)
        return self._last if self._silent <= COAST else math.pi / 2


def _moved(reading: Reading) -> Pose2:
    m = reading.motion
    return Pose2(m.forward * math.cos(m.turn / 2), m.forward * math.sin(m.turn / 2), m.turn)


HEAD = ("world", "method", "spacing", "courses", "done", "low", "high", "legs", "false", "error")
"""Columns of `tally`: courses done whole with Wilson's 95 % interval, legs done, courses that ended by an arrival
elsewhere, mean error of the arrivals [m]."""


def tally(courses: Sequence[Course]) -> list[tuple[str, ...]]:
    """Return a row for each world, method and spacing, under HEAD."""
    groups = dict.fromkeys((c.world, c.method, c.spacing) for c in courses)
    return [_row([c for c in courses if (c.world, c.method, c.spacing) == group]) for group in groups]


def _row(own: Sequence[Course]) -> tuple[str, ...]:
    done: Interval = share_interval(sum(c.done for c in own), len(own))
    errors = [error for c in own for error in c.errors]
    error = f"{sum(errors) / len(errors):.2f}" if errors else ""
    return (
        own[0].world, own[0].method, f"{own[0].spacing:g}", str(len(own)), str(sum(c.done for c in own)),
        f"{done.low:.2f}", f"{done.high:.2f}", str(sum(c.legs for c in own)), str(sum(c.false for c in own)), error,
    )  # fmt: skip


def judged(error: float, errors: list[float]) -> bool:
    """Keep the error [m] of an arrival that was one; return whether it was."""
    if error > REACHED:
        return False
    errors.append(error)
    return True
