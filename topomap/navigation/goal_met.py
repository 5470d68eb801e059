"""Whether a journey's goal is reached: by its own view and the belief; where it has no view, by the belief alone."""

from __future__ import annotations

from topomap.core.geometry import wrap
from topomap.navigation.arrival import ELSEWHERE, SAME, SURE, Arrival, Claim, doubt
from topomap.navigation.journey import Journey
from topomap.navigation.senses import Now
from topomap.navigation.sight import Look, Sight
from topomap.vision.image.compare import rotation_difference, signature
from topomap.vision.image.sectors import SECTORS, agreement

BARE = 0.1
"""[m] A goal without a view is reached where it is believed to be nearer than this, beside a place that was seen; so is
one whose view is partly hidden."""
PARTS = 3
"""Directions, of 12, in which the view has to be the goal's where the rest is hidden then or now: it is in half of the
looks at the place, and in 2 of 1,514 from .3 to 1.2 m off."""


def goal_met(j: Journey, sight: Sight, look: Look, now: Now) -> tuple[bool, str]:
    """Return whether the goal is reached, and a note: how, or why it isn't though it looks so."""
    if sight.node != j.goal:
        return _pose_met(j, sight, now)
    if not look.there:
        return _met_in_part(j, sight, now)
    why = doubt(_claim(j, sight, look, now))
    if not why:
        return True, "goal reached"
    met, told = _met_in_part(j, sight, now)
    sight.arrival = Arrival()
    return met, told or f"looks like the goal, but {why}"


def _pose_met(j: Journey, sight: Sight, now: Now) -> tuple[bool, str]:
    goal = now.mapper.map.pose(j.goal)
    sure = now.where.lost < SURE and sum(rival.weight for rival in now.where.rivals) < SURE
    if not (sure and sight.seen and now.where.pose.distance(goal) < BARE):
        return False, ""
    return True, f"goal reached: node {j.goal} has no view of its own, it lies beside node {sight.node}, which was seen"


def _met_in_part(j: Journey, sight: Sight, now: Now) -> tuple[bool, str]:
    """Return whether the goal is reached though its view isn't seen whole: people hid some of it then, or do so now.

    The belief has to be as sure and nearer than for a view; no other place may be as alike.
    """
    topo, where = now.mapper.map, now.where
    goal = topo.pose(j.goal)
    if not sight.arrival.over or where.pose.distance(goal) >= BARE:
        return False, ""
    turn = wrap(where.pose.heading - goal.heading)
    part = agreement(now.senses.panorama, sight.view, turn)
    if part.sectors < PARTS or doubt(Claim(goal, part.rotation, 0.0, where)):
        return False, ""
    other = now.senses.place
    if other is not None and topo.length(j.goal, other.node) > ELSEWHERE:
        view = now.mapper.view_cache.panorama(other.node)
        if agreement(now.senses.panorama, view, other.rotation).sectors >= part.sectors:
            return False, ""
    return True, f"goal reached: {part.sectors} of {SECTORS} directions are as they were, though the whole isn't"


def _claim(j: Journey, sight: Sight, look: Look, now: Now) -> Claim:
    topo, place = now.mapper.map, now.senses.place
    difference = rotation_difference(signature(now.senses.panorama), signature(sight.view))[0]
    away = 0.0 if place is None else topo.length(j.goal, place.node)
    return Claim(topo.pose(j.goal), look.rotation, difference, now.where, place, away, look.difference >= SAME)
