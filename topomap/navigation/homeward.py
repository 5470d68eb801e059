"""Following a course by sight: which milestone to look for, when it is passed, where to head."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from topomap.core.geometry import Pose2, wrap
from topomap.core.records import Command, Phase, Travel
from topomap.mapping.mapper import Mapper
from topomap.navigation.arrival import Arrival
from topomap.navigation.goal_met import goal_met
from topomap.navigation.journey import Journey
from topomap.navigation.manoeuvres.policy_drive import PolicyDrive
from topomap.navigation.pilot import Pilot
from topomap.navigation.senses import Now
from topomap.navigation.sight import KNOWN, NEAR_TURN, SEEN, Look, Sight
from topomap.navigation.steering import LOST, heading_for
from topomap.vision.aligned_homing import AlignedHoming

GOAL_SPEED = 0.2
"""[m/s] Limit near the goal: a step of 0.25 s is then 5 cm, and so the minimum is met to a few centimetres."""
DOCK = 0.7
"""[m] Way to the goal from which on that limit holds."""
LOOK_AHEAD = 0.7
"""[m] How far ahead on the course the robot heads: less sways, more cuts corners (0.2 m radius, 0.4 m/s)."""
AIMS = (LOOK_AHEAD, 1.0, 1.4)
"""[m] Points of the course that a way round what stands ahead may lead to."""
PASSED = 0.15
"""[m] A milestone that lies nearer ahead than this is passed: its bearing tells little any more."""
SPACING = 0.5
"""[m] The next milestone lies at least so far ahead: bearings are as good from 0.6 to 1 m as nearer."""
REACH = 1.0
"""[m] How far along the course the belief may be off a milestone that its view says is reached."""
UNSURE = LOST
"""Probability of being lost from which on a view may contradict the believed heading: the belief is then likelier wrong
than right. In `office-loop` the view turned round looked more alike than the right one, 0.7 m off, in each of the ways
home looked at; obeyed from 0.05 on, it had the robot turn to and fro until it gave up, with a belief that was right to
half a degree but not proven yet."""
POLICY_REST = 12
"""Looks without a new minimum after which a policy's leg has come to its end: a round of trial moves is up to nine."""
TRIALS = 12
"""A policy makes up to nine trial moves for one step ahead, and turns on the spot for each."""
METHOD_SIGMA = 0.3
"""[rad] Error of a method's bearing, however confident: 0.2 for DTW, 0.7 for moments, whose confidence says little."""


class Homeward:
    """Drives along a journey's course."""

    def __init__(self, homing: AlignedHoming, pilot: Pilot, speed: float) -> None:
        self._homing, self._pilot, self._speed = homing, pilot, speed
        self._policy: PolicyDrive | None = None
        self._least_sigma = 0.0 if homing.method is None else METHOD_SIGMA

    @property
    def patience(self) -> int:
        """How many times as long the method takes as one that heads straight home: a policy tries moves."""
        return 1 if self._homing.policy is None else TRIALS

    def step(self, j: Journey, now: Now) -> tuple[Command, Travel]:
        """Return the command of this step and what was done."""
        note = self._advance(j, now)
        sight = self._sight(j, now)
        sight.rotation = wrap(sight.rotation + now.senses.turn)
        travel = Travel(Phase.TRAVEL, sight.node, legs_left=j.legs_left, note=note)
        raw, speed = now.mapper.track.raw, self._speed_for(j, now)
        if self._policy is not None and self._policy.moving(raw):
            return self._policy.drive(now.senses.panorama, raw, speed), travel
        unsure = now.where.lost >= UNSURE
        if not unsure:
            sight.expect(wrap(now.where.pose.heading - now.mapper.map.pose(sight.node).heading))
        moved = sight.has_moved(now.mapper.track.raw)
        look = sight.look(now.senses.panorama, self._homing, unsure, moved, moved or self._counts(j, sight, now))
        travel = replace(travel, home=look.home, difference=look.difference)
        if j.last_leg:
            j.sought += j.course.left < DOCK
            met, told = goal_met(j, sight, look, now)
            travel = replace(travel, note=told or note)
            if met:
                return Command(), replace(travel, phase=Phase.ARRIVED, milestone=j.goal, legs_left=0)
        elif look.there and self._may_be_there(j, sight, now):
            j.course.reach(sight.place)
            travel = replace(travel, note=self._pass(j, sight, now))
        if self._policy is not None:
            move = self._policy.look(now.senses.panorama, look.rotation, raw)
            return self._policy.drive(now.senses.panorama, raw, speed), replace(travel, home=move)
        bearing = self._bearing(j, sight, look, now)
        aims = self._aims(j, now, bearing)
        command = self._pilot.steer(bearing, now.ranges, speed, aims)
        return command, replace(travel, home=replace(look.home, bearing=bearing))

    @staticmethod
    def _counts(j: Journey, sight: Sight, now: Now) -> bool:
        """Return whether a look of who turns on the spot can tell that the milestone is passed: the goal only where the
        robot is believed to be there."""
        return not j.last_leg or now.where.pose.distance(now.mapper.map.pose(sight.node)) < PASSED

    def _aims(self, j: Journey, now: Now, bearing: float) -> list[tuple[float, float]]:
        """Return points of the course ahead in the robot's frame, turned as the bearing is against the first's."""
        if now.where.lost >= LOST:
            return []
        ahead = [j.course.point(way) for way in AIMS]
        turn = wrap(bearing - now.where.pose.bearing_to(ahead[0]))
        ways = [(now.where.pose.distance(point), now.where.pose.bearing_to(point) + turn) for point in ahead]
        return [(way * math.cos(angle), way * math.sin(angle)) for way, angle in ways]

    def _advance(self, j: Journey, now: Now) -> str:
        """Leave a milestone that is believed to be passed; return a note where one was."""
        sight = j.sight
        if sight is None or j.last_leg or now.where.lost >= LOST or self._policy is not None:
            return ""
        return self._pass(j, sight, now) if j.ahead(sight.place) < PASSED else ""

    def _pass(self, j: Journey, sight: Sight, now: Now) -> str:
        j.passed(now.mapper.map, sight.place, now.senses.stamp_ns)
        j.sight, j.unseen = None, 0 if sight.seen else j.unseen + 1
        return "milestone reached" if sight.seen else "milestone passed by the believed pose"

    def _may_be_there(self, j: Journey, sight: Sight, now: Now) -> bool:
        """Return whether a milestone whose view says so is reached, by the belief: the lost and policies go by view."""
        return now.where.lost >= LOST or self._policy is not None or abs(j.ahead(sight.place)) < REACH

    def _sight(self, j: Journey, now: Now) -> Sight:
        """Return the milestone to look for: the next one far enough ahead for its bearing to tell, or the goal."""
        if j.sight is None:
            place = j.course.next_milestone(j.last, SPACING)
            place = len(j.course.path) - 1 if place is None else place
            node = self._with_view(j.course.path[place], now.mapper)
            rotation = wrap(now.where.pose.heading - now.mapper.map.pose(node).heading)
            view, policy = now.mapper.view_cache.panorama(node), self._homing.policy is not None
            self._policy = PolicyDrive(self._homing, view, self._pilot) if policy else None
            j.sight = Sight(place, node, view, rotation, Arrival(POLICY_REST, POLICY_REST) if policy else None)
        return j.sight

    @staticmethod
    def _with_view(node: int, mapper: Mapper) -> int:
        """Return a node, or the snapshot nearest to it where it is a bare pose."""
        topo = mapper.map
        if topo.nodes[node].snapshot is not None:
            return node
        views = np.array([k for k, one in enumerate(topo.nodes) if one.snapshot is not None])
        away = np.hypot(*(topo.poses[views, :2] - topo.poses[node, :2]).T)
        return int(views[int(np.argmin(away))])

    def _speed_for(self, j: Journey, now: Now) -> float:
        """Return the speed limit [m/s]: slow near the goal, and the slower the less sure the belief."""
        speed = GOAL_SPEED if j.last_leg and j.course.left < DOCK else self._speed
        if now.where.lost >= LOST or now.senses.health.slow:
            return min(speed, GOAL_SPEED)
        return min(speed, self._speed * (1.0 - now.where.lost))

    def _bearing(self, j: Journey, sight: Sight, look: Look, now: Now) -> float:
        """Return where to head, by view and belief."""
        pose, milestone = now.where.pose, now.mapper.map.pose(sight.node)
        heading = wrap(milestone.heading + look.rotation)
        agrees = abs(wrap(heading - pose.heading)) < NEAR_TURN
        if look.difference < (SEEN if agrees else KNOWN) and (agrees or now.where.lost >= UNSURE):
            # where the view is known the compass is right to some degrees, and the belief's heading may be anything;
            # from farther off a corridor looks much the same both ways
            pose = Pose2(pose.x, pose.y, heading)
        ahead = j.course.point(LOOK_AHEAD)
        return heading_for(pose, milestone, ahead, look.home, now.where.lost, self._least_sigma)
