"""Where the robot is set before the first reading."""

from __future__ import annotations

import math

from sim2d.config import StartConfig
from sim2d.errors import WorldError
from sim2d.path import Path
from sim2d.world import World

Pose = tuple[float, float, float]


def start_pose(world: World, path: Path, start: StartConfig) -> Pose:
    """Return x, y [m], heading [rad]. Raises WorldError for an unknown place or a way beyond the route's end."""
    if start.place and start.place not in world.spec.places:
        known = ", ".join(world.spec.places) or "none"
        raise WorldError(f"sim.start.place = {start.place!r}: world {world.name} has no such place; there are {known}")
    along = start.along or 0.0
    if along >= path.length:
        raise WorldError(f"sim.start.along = {along:g}: the route is {path.length:.1f} m long")
    x, y = path.at(along)
    pose = world.spec.places[start.place] if start.place else (x, y, path.heading(along))
    if start.x is not None and start.y is not None:
        pose = start.x, start.y, pose[2]
    return pose if start.heading_deg is None else (pose[0], pose[1], math.radians(start.heading_deg))
