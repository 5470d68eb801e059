"""Travelling: from snapshot to snapshot along a planned route, by local visual homing."""

from __future__ import annotations

from pydantic import BaseModel

from topomap.core.errors import TopomapError
from topomap.core.geometry import wrap
from topomap.core.panorama import Panorama
from topomap.core.records import Command, Goal, HomeVector, Phase, Travel, Where
from topomap.mapping.mapper import Mapper
from topomap.navigation import planner
from topomap.navigation.arrival import Arrival
from topomap.navigation.pilot import Pilot, PilotSettings
from topomap.vision.contracts import Aligner
from topomap.vision.image.aligned_difference import aligned_difference

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

    pilot: PilotSettings = PilotSettings()


class _Leg:
    """One milestone: the view to home to, and what homing has seen on the way."""

    def __init__(self, node: int, view: Panorama, heading: float) -> None:
        self.node = node
        self.view = view
        self.rotation = heading  # the robot's heading minus the milestone's, kept up to date by compass and odometry
        self.arrival = Arrival()
        self.steps = 0


class Traveller:
    """Plans, homes to milestone after milestone, notices arrival, recovers, gives up.

    The aligner must give home vectors as well (min-warping does).
    """

    def __init__(self, settings: TravelSettings, homing: Aligner) -> None:
        self._pilot = Pilot(settings.pilot)
        self._homing = homing
        self._route: list[int] | None = None
        self._leg: _Leg | None = None
        self._recoveries = 0

    def step(self, panorama: Panorama, turn: float, where: Where, goal: Goal, mapper: Mapper) -> tuple[Command, Travel]:
        """Return the command and what was done; `turn` is the odometry's (corrected) turn of this step [rad]."""
        if goal.node is None:
            return Command(), Travel(goal.phase)
        if self._route is None:
            failure = self._plan(where, goal.node, mapper)
            if failure:
                return Command(), Travel(Phase.FAILED, note=failure)
        return self._travel(panorama, turn, where, goal.node, mapper)

    def pause(self) -> None:
        """Begin the leg anew when travelling goes on: something else has the wheels."""
        self._leg = None

    def _travel(
        self, panorama: Panorama, turn: float, where: Where, goal: int, mapper: Mapper
    ) -> tuple[Command, Travel]:
        route = self._route or []
        if not route:
            return Command(), Travel(Phase.ARRIVED, goal, note="already there")
        leg = self._leg_to(route[0], where, mapper)
        leg.steps += 1
        leg.rotation = wrap(leg.rotation + turn)
        alignment = self._homing.align(panorama, leg.view, leg.rotation)
        leg.rotation = alignment.rotation
        difference = aligned_difference(panorama, leg.view, alignment.rotation)
        if leg.arrival.update(difference):
            return self._arrive(difference)
        if leg.steps > LEG_STEPS or leg.arrival.since_minimum > STALE_STEPS:
            return self._recover(difference, where)
        home = alignment.home or HomeVector(0.0, confidence=0.0)
        speed = GOAL_SPEED if len(route) == 1 else None
        command = self._pilot.steer(home.bearing, panorama.ranges, speed)
        return command, Travel(Phase.TRAVEL, leg.node, home, difference, len(route))

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
            self._leg = _Leg(node, mapper.view_cache.panorama(node), heading)
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
        if self._recoveries > RECOVERIES:
            return Command(), Travel(Phase.FAILED, node, None, difference, 0, f"gave up on the way to node {node}")
        return Command(), Travel(Phase.TRAVEL, node, None, difference, 0, f"leg to node {node} given up: new plan")
