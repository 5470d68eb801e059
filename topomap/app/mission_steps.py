"""How many readings a run in the simulator takes: for its progress bar, and to end one that would never end."""

from __future__ import annotations

import math
from itertools import pairwise

from sim2d.robot import SimRobot
from topomap.app.saved_map import SavedMap
from topomap.evaluation.trajectory import travel
from topomap.mapping.graph import TopoMap
from topomap.navigation import planner
from topomap.navigation.mission import MissionSettings, goals_of
from topomap.navigation.wish import Kind


def expected_steps(robot: SimRobot, mission: MissionSettings, saved: SavedMap | None = None) -> int:
    """Return about how many readings a run takes: the taught route's, or those of the ways to the goals.

    On a fresh map each goal of a patrol is as far away as the route is long, at most; one way home isn't counted.
    saved: the map whose ways are measured. Raises TopomapError for goals that it hasn't.
    """
    wish = mission.wish
    if saved is None or wish.kind is Kind.TEACH:
        return robot.expected_steps * max(1, len(wish.targets))
    return math.ceil(way_over(saved, mission) / robot.step_m) + 1


def way_over(saved: SavedMap, mission: MissionSettings) -> float:
    """Return the length [m] of the ways to a mission's goals; to the first one of the chain where the start isn't
    known. Raises TopomapError."""
    topo, goals = saved.map, goals_of(mission.wish, saved.map)
    starts = [] if saved.start.node is None else [saved.start.node]
    first = 0.0 if starts else float(travel(topo.poses)[-1])
    return first + sum(way_between(topo, a, b) for a, b in pairwise([*starts, *goals]))


def way_between(topo: TopoMap, start: int, goal: int) -> float:
    """Return the length [m] of the way between two nodes, 0 where there is none: the journey will say so."""
    try:
        return float(travel(topo.poses[planner.route(topo, start, goal)])[-1])
    except planner.NoRoute:
        return 0.0
