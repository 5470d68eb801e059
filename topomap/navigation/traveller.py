"""Travelling: from snapshot to snapshot along a planned route, by local visual homing."""

from __future__ import annotations

import math

from pydantic import BaseModel, Field, model_validator

from topomap.core.errors import TopomapError
from topomap.core.geometry import wrap
from topomap.core.panorama import Panorama
from topomap.core.records import Command, Goal, HomeVector, Phase, Travel, Where
from topomap.mapping.mapper import Mapper
from topomap.navigation import planner
from topomap.navigation.arrival import Arrival
from topomap.navigation.manoeuvres.policy_drive import PolicyDrive
from topomap.navigation.pilot import Pilot, PilotSettings
from topomap.vision.aligned_homing import AlignedHoming
from topomap.vision.choice import CompassChoice, HomingChoice, found
from topomap.vision.image.aligned_difference import aligned_difference
from topomap.vision.registry import aligned_homing

GOAL_SPEED = 0.2
"""[m/s] Limit on the last leg: a step of 0.25 s is then 5 cm, and so the minimum is met to a few centimetres."""
LEG_STEPS = 80
"""Steps after which a leg is given up: snapshots are at most 1 m apart, 10 steps at 0.4 m/s, 20 on the last leg."""
STALE_STEPS = 35
"""Steps without a new minimum after which a leg is given up: 3.5 m at 0.4 m/s, room for a way round an obstacle."""
RECOVERIES = 3
"""How often a given-up leg leads to a new plan before the journey is given up."""


class TravelSettings(BaseModel, frozen=True, extra="forbid"):
    """How a journey is made."""

    homing: HomingChoice = Field("min-warping", description="the method that homes, by its name in `topomap methods`")
    aligner: CompassChoice = Field(
        "own", description="the aligner it is given its rotation by; own: the method's own, or min-warping"
    )
    pilot: PilotSettings = PilotSettings()

    @model_validator(mode="after")
    def _fit(self) -> TravelSettings:
        """Refuse an aligner for what aligns by itself."""
        found(aligned_homing, self.homing, self.aligner)
        return self


POLICY_REST = 12
"""Looks without a new minimum after which a policy's leg has come to its end: a round of trial moves is up to nine."""
ASTRAY, FAR, LOST = math.pi / 2, 0.2, 0.5
"""How far off the map's bearing a home vector leads away [rad], the distance from which on that counts [m] (nearer,
the map's own error turns its bearing), and the probability of being lost from which on the map isn't asked.
"""


class _Leg:
    """One milestone: the view to home to, and what homing has seen on the way; drive: a policy's moves, if it has one.

    A step of the leg is a look: a policy's difference rises and falls with its trial moves, so that only a whole round
    of them without a new minimum says that the minimum has been passed.
    """

    def __init__(
        self,
        node: int,
        view: Panorama,
        heading: float,
        drive: PolicyDrive | None,
        astray: bool,
    ) -> None:
        self.node = node
        self.view = view
        self.rotation = heading  # the robot's heading minus the milestone's, kept up to date by compass and odometry
        self.drive = drive
        self.arrival = Arrival(POLICY_REST, POLICY_REST) if drive else Arrival()
        self.steps = 0
        self.astray = astray  # homing leads away from the milestone: the rest of the leg goes by the map


class Traveller:
    """Plans, homes to milestone after milestone, notices arrival, recovers, gives up."""

    def __init__(self, settings: TravelSettings, homing: AlignedHoming) -> None:
        self._s = settings
        self._pilot = Pilot(settings.pilot)
        self._homing = homing
        self._route: list[int] | None = None
        self._leg: _Leg | None = None
        self._recoveries = 0
        self._given_up: set[int] = set()  # milestones that homing didn't reach
        self._checked = False

    def step(self, panorama: Panorama, turn: float, where: Where, goal: Goal, mapper: Mapper) -> tuple[Command, Travel]:
        """Return the command and what was done; `turn` is the odometry's (corrected) turn of this step [rad]."""
        if goal.node is None:
            self._check(panorama)
            return Command(), Travel(goal.phase)
        if self._route is None:
            failure = self._plan(where, goal.node, mapper)
            if failure:
                return Command(), Travel(Phase.FAILED, note=failure)
        return self._travel(panorama, turn, where, goal.node, mapper)

    def pause(self) -> None:
        """Begin the leg anew when travelling goes on: something else has the wheels."""
        self._leg = None

    def _check(self, panorama: Panorama) -> None:
        """Say at the first view, not after a whole lesson, that the robot lacks what the method needs."""
        if not self._checked and self._homing.method is not None:
            self._homing.method.needs.check(panorama)
        self._checked = True

    def _travel(
        self, panorama: Panorama, turn: float, where: Where, goal: int, mapper: Mapper
    ) -> tuple[Command, Travel]:
        route = self._route or []
        if not route:
            return Command(), Travel(Phase.ARRIVED, goal, note="already there")
        leg = self._leg_to(route[0], where, mapper)
        leg.rotation = wrap(leg.rotation + turn)
        speed = GOAL_SPEED if len(route) == 1 else None
        if leg.drive is not None and leg.drive.moving(mapper.track.raw):
            return self._drive(leg.drive, panorama, mapper, speed), Travel(Phase.TRAVEL, leg.node, legs_left=len(route))
        leg.steps += 1
        alignment = self._homing.align(panorama, leg.view, leg.rotation)
        leg.rotation = alignment.rotation
        difference = aligned_difference(panorama, leg.view, alignment.rotation)
        if leg.arrival.update(difference):
            return self._arrive(difference)
        if leg.steps > LEG_STEPS or leg.arrival.since_minimum > STALE_STEPS:
            return self._recover(difference, where)
        if leg.drive is not None:
            home = leg.drive.look(panorama, leg.rotation, mapper.track.raw)
            command = self._drive(leg.drive, panorama, mapper, speed)
        else:
            home = self._trusted(alignment.home or HomeVector(0.0, confidence=0.0), leg, where, mapper)
            command = self._pilot.steer(home.bearing, panorama.ranges, speed)
        return command, Travel(Phase.TRAVEL, leg.node, home, difference, len(route))

    def _trusted(self, home: HomeVector, leg: _Leg, where: Where, mapper: Mapper) -> HomeVector:
        """Return the home vector to follow: the map's, with no confidence, where a method's isn't to be trusted.

        A home vector that leads away from a milestone that still lies far off was found between places that have
        little in common: through a doorway ranges show other rooms, and the centroid of the open space lies behind.
        Over so short a way the map is never that wrong, unless the robot is lost. A leg that homing gave up is tried
        again by the map. What aligns and homes at once searches all directions for one that explains the view, and is
        followed even where it isn't sure.
        """
        if self._homing.method is None:
            return home
        milestone = mapper.map.pose(leg.node)
        bearing = where.pose.bearing_to(milestone)
        away = abs(wrap(home.bearing - bearing)) > ASTRAY and where.pose.distance(milestone) > FAR
        leg.astray = leg.astray or (away and home.confidence > 0.0 and where.lost < LOST)
        return HomeVector(bearing, None, 0.0) if leg.astray or home.confidence <= 0.0 else home

    def _drive(self, drive: PolicyDrive, panorama: Panorama, mapper: Mapper, speed: float | None) -> Command:
        return drive.drive(panorama, mapper.track.raw, speed or self._s.pilot.speed)

    def _plan(self, where: Where, goal: int, mapper: Mapper) -> str:
        """Set a route from the node where the robot is; return why there is none, or ""."""
        if where.node is None:
            return "the map is empty"
        try:
            self._route = planner.route(mapper.map, where.node, goal)
        except TopomapError as error:
            return str(error)
        self._leg = None
        return ""

    def _leg_to(self, node: int, where: Where, mapper: Mapper) -> _Leg:
        if self._leg is None or self._leg.node != node:
            heading = wrap(where.pose.heading - mapper.map.pose(node).heading)
            view = mapper.view_cache.panorama(node)
            drive = PolicyDrive(self._homing, view, self._pilot) if self._homing.policy else None
            self._leg = _Leg(node, view, heading, drive, node in self._given_up)
        return self._leg

    def _arrive(self, difference: float) -> tuple[Command, Travel]:
        assert self._route
        node = self._route.pop(0)
        if self._route:
            return Command(), Travel(Phase.TRAVEL, node, None, difference, len(self._route), "milestone reached")
        return Command(), Travel(Phase.ARRIVED, node, None, difference, 0, "goal reached")

    def _recover(self, difference: float, where: Where) -> tuple[Command, Travel]:
        """Give the leg up: plan anew from the node that the map says is near, or give up the journey."""
        assert self._leg
        node, self._leg, self._route = self._leg.node, None, None
        self._recoveries += 1
        self._given_up.add(node)
        if self._recoveries > RECOVERIES:
            return Command(), Travel(Phase.FAILED, node, None, difference, 0, f"gave up on the way to node {node}")
        return Command(), Travel(Phase.TRAVEL, node, None, difference, 0, f"leg to node {node} given up: new plan")
