"""One journey to one goal: its course, the milestone in view, its troubles, and what passing each edge taught."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from topomap.mapping.graph import TopoMap
from topomap.navigation import planner
from topomap.navigation.course import Course
from topomap.navigation.edge_costs import Shut
from topomap.navigation.progress import Progress
from topomap.navigation.recovery import Recovery, Remedy
from topomap.navigation.senses import Now
from topomap.navigation.sight import Sight

STEPS_PER_M, STEPS_MORE = 50, 400
"""Steps after which a journey ends, by its planned way: a metre takes 10 at 0.4 m/s and 0.25 s a step."""
SET_BACK = 0.5
"""[m] A milestone that was passed and lies so far ahead was not passed."""
PLANS = 12
"""Plans after which it ends: each shuts another place, and a map has few ways round one."""


@dataclass
class Journey:
    """The state of one journey.

    last: place in the course of the milestone passed last, left_ns: when; unseen: milestones in a row that weren't seen
    in passing; sought: steps near the goal; remedy: what is being tried, for `tried` steps; shut: places where
    nothing got through.
    """

    goal: int
    course: Course
    left_ns: int
    sight: Sight | None = None
    last: int = -1
    unseen: int = 0
    sought: int = 0
    progress: Progress = field(default_factory=Progress)
    recovery: Recovery = field(default_factory=Recovery)
    remedy: Remedy | None = None
    tried: int = 0
    shut: tuple[Shut, ...] = ()
    lost_for: int = 0
    astray_for: int = 0
    stood: int = 0
    steps: int = 0
    budget: int = 0
    plans: int = 0

    @staticmethod
    def begin(goal: int, now: Now) -> Journey:
        """Plan a journey. Raises TopomapError where there is no way."""
        journey = Journey(goal, Course(now.mapper.map, [goal] if goal < len(now.mapper.map.nodes) else []), 0)
        journey.plan(now)
        return journey

    def plan(self, now: Now) -> None:
        """Set a new course from where the robot is. Raises TopomapError where there is none."""
        if now.where.node is None:
            raise planner.NoRoute("the map is empty: there is nowhere to go")
        topo, stamp = now.mapper.map, now.senses.stamp_ns
        joins = planner.near(topo, now.where.pose, now.senses.ranges, self.shut)
        path = planner.route(topo, now.where.node, self.goal, self.shut, stamp, joins)
        self.course = Course(topo, path)
        self.sight, self.last, self.left_ns, self.sought = None, -1, stamp, 0
        self.progress.renew()
        self.plans += 1
        self.budget = self.steps + STEPS_MORE + round(STEPS_PER_M * self.course.length)

    def over_budget(self, patience: int) -> bool:
        """Whether it has taken longer than any way round can explain; patience: how slow the method is."""
        return self.steps > self.budget * patience or self.plans > PLANS

    @property
    def last_leg(self) -> bool:
        """Whether the goal is what is looked for."""
        return self.sight is not None and self.sight.place == len(self.course.path) - 1

    @property
    def legs_left(self) -> int:
        """Milestones that aren't passed yet."""
        return sum(place > self.last for place in self.course.milestones)

    def step_back(self) -> None:
        """Look for milestones again that the belief, set right meanwhile, has still before it."""
        while self.last >= 0 and self.ahead(self.last) > SET_BACK:
            self.last, self.sight = self.last - 1, None

    def ahead(self, place: int) -> float:
        """Return how far ahead along the course a place of it lies [m]; negative where it is passed."""
        return float(self.course.lengths()[place]) - self.course.along

    def passed(self, topo: TopoMap, place: int, stamp_ns: int) -> None:
        """Learn from reaching a place of the course: each edge up to it was passed in its share of the time."""
        path = self.course.path[max(self.last, 0) : place + 1]
        seconds = (stamp_ns - self.left_ns) * 1e-9 / max(len(path) - 1, 1)
        for a, b in pairwise(path):
            topo.experience.passed(a, b, seconds)
        self.last, self.left_ns = place, stamp_ns

    def shut_ahead(self, topo: TopoMap, ahead: float, stamp_ns: int) -> None:
        """Shut the place so far ahead [m], and learn that the edge over it failed."""
        spot = self.course.point(ahead)
        self.shut = (*self.shut, Shut(spot.x, spot.y, stamp_ns))
        beyond = np.flatnonzero(self.course.lengths() >= self.course.along + ahead)
        if len(beyond) and beyond[0] > 0:
            a, b = self.course.path[beyond[0] - 1], self.course.path[beyond[0]]
            topo.experience.failed(a, b, stamp_ns)
