"""What happens to a world while the robot drives: doors, and things that are moved."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from sim2d.shapes import Box, Change, Cylinder, Point
from sim2d.world import World


def is_due(change: Change, laps: float, seconds: float) -> bool:
    """Return whether a change's time or lap has come; without either it is due at once."""
    if change.at_s is None and change.at_lap is None:
        return True
    return (change.at_s is not None and change.at_s <= seconds) or (change.at_lap is not None and change.at_lap <= laps)


def moved(thing: Box | Cylinder, to: Point, turn: float) -> Box | Cylinder:
    """Return a thing with its middle at `to` [m], turned by `turn` [rad]."""
    if isinstance(thing, Cylinder):
        return replace(thing, x=to[0], y=to[1])
    mx, my = middle(thing)
    c, s = math.cos(turn), math.sin(turn)
    corners = tuple((to[0] + c * (x - mx) - s * (y - my), to[1] + s * (x - mx) + c * (y - my)) for x, y in thing.points)
    return replace(thing, points=corners)


def middle(thing: Box | Cylinder) -> Point:
    """Return the middle of a thing [m]: the mean of a box's corners."""
    if isinstance(thing, Cylinder):
        return thing.x, thing.y
    n = len(thing.points)
    return sum(x for x, _ in thing.points) / n, sum(y for _, y in thing.points) / n


def reach(thing: Box | Cylinder) -> float:
    """Return how far a thing reaches from its middle [m]."""
    if isinstance(thing, Cylinder):
        return thing.radius
    return max(math.dist(middle(thing), corner) for corner in thing.points)


class Changes:
    """Carries out a world's changes, each once, when it is due and the robot isn't in the way."""

    def __init__(self, world: World) -> None:
        self._world = world
        self._left: list[Change] = list(world.spec.changes)

    def update(self, laps: float, seconds: float, metres: float, robot: tuple[float, float, float]) -> None:
        """Do what is due after so many laps, seconds and metres; robot: x, y, radius [m]."""
        self._world.open_gates(laps, seconds, metres)
        waiting: Sequence[Change] = [c for c in self._left if not is_due(c, laps, seconds) or self._blocked(c, robot)]
        due = [change for change in self._left if change not in waiting]
        self._left = list(waiting)
        for change in due:
            self._carry_out(change)

    def _carry_out(self, change: Change) -> None:
        if change.opens is not None:
            self._world.set_gate(change.name, change.opens)
        if change.moves_to is not None:
            for thing in self._world.things(change.name):
                self._world.replace_thing(thing, moved(thing, change.moves_to, change.turn))

    def _blocked(self, change: Change, robot: tuple[float, float, float]) -> bool:
        if change.moves_to is None:
            return False
        room = math.dist(change.moves_to, robot[:2]) - robot[2]
        return any(reach(thing) > room for thing in self._world.things(change.name))
