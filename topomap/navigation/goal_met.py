"""Whether a journey's goal is reached: by its own view and the belief; where it has no view, by the belief alone."""

from __future__ import annotations

from topomap.navigation.arrival import SAME, SURE, Arrival, Claim, doubt
from topomap.navigation.journey import Journey
from topomap.navigation.senses import Now
from topomap.navigation.sight import Look, Sight
from topomap.vision.image.compare import rotation_difference, signature

BARE = 0.1
"""[m] A goal without a view is reached where it is believed to be nearer than this, beside a place that was seen."""


def goal_met(j: Journey, sight: Sight, look: Look, now: Now) -> tuple[bool, str]:
    """Return whether the goal is reached, and a note: how, or why it isn't though it looks so."""
    if sight.node != j.goal:
        return _pose_met(j, sight, now)
    if not look.there:
        return False, ""
    why = doubt(_claim(j, sight, look, now))
    if not why:
        return True, "goal reached"
    sight.arrival = Arrival()
    return False, f"looks like the goal, but {why}"


def _pose_met(j: Journey, sight: Sight, now: Now) -> tuple[bool, str]:
    goal = now.mapper.map.pose(j.goal)
    sure = now.where.lost < SURE and sum(rival.weight for rival in now.where.rivals) < SURE
    if not (sure and sight.seen and now.where.pose.distance(goal) < BARE):
        return False, ""
    return True, f"goal reached: node {j.goal} has no view of its own, it lies beside node {sight.node}, which was seen"


def _claim(j: Journey, sight: Sight, look: Look, now: Now) -> Claim:
    topo, place = now.mapper.map, now.senses.place
    difference = rotation_difference(signature(now.senses.panorama), signature(sight.view))[0]
    away = 0.0 if place is None else topo.length(j.goal, place.node)
    return Claim(topo.pose(j.goal), look.rotation, difference, now.where, place, away, look.difference >= SAME)
