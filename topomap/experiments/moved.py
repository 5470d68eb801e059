"""The study of moved objects: part of what home looked like is far or near now (3.35, 3.36)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from typing import Literal

import numpy as np

from topomap.bench.homing.figures import vector_map
from topomap.bench.homing.table import JsonValue
from topomap.core.arrays import FloatArray
from topomap.core.geometry import TAU, wrap_all
from topomap.core.panorama import Panorama
from topomap.experiments.occlusion import contenders
from topomap.experiments.pillars import Pillar, Room, painted, room_arena, room_recipe
from topomap.experiments.study import Finding, Lab, curve_values, draw_curves, error_curve
from topomap.report.figures import style
from topomap.vision.arena import Arena, Recipe

Where = Literal["far", "near"]
ANGLES = (0, 30, 60, 90, 120, 150, 180)
"""How much of the home view is moved [degrees]."""
SHOWN = 60
OBJECTS, OBJECT, WALL = 10, 0.2, 4.0
CLOSE = 1.2
"""Where near things stand [m]."""
HALF, SPACING = 1.0, 0.25


@dataclass(frozen=True, slots=True, eq=False)
class MovedViews:
    """A ViewSource: a sector of the room's view is another room's, in pixels and ranges.

    middle, width [rad]: the sector, in the world.
    """

    room: Room
    other: Room
    middle: float
    width: float

    def view(self, x: float, y: float, heading: float) -> Panorama:
        """Return the panorama with ranges at a pose [m, rad]."""
        seen, moved = self.room.view(x, y, heading), self.other.view(x, y, heading)
        angles: FloatArray = heading + np.arange(seen.rig.width) * TAU / seen.rig.width
        inside = np.abs(wrap_all(angles - self.middle)) < self.width / 2
        if seen.ranges is None or moved.ranges is None:
            return seen
        image = np.where(inside[:, np.newaxis], moved.image, seen.image)
        return Panorama(image, np.where(inside, moved.ranges, seen.ranges), seen.rig)


def moved_objects(lab: Lab) -> Finding:
    """The error over the angle of the moved region, far and near, with a vector map of each (3.35, 3.36)."""
    several = contenders()
    figure = style.canvas(12.6, 9.0)
    panels = figure.subplots(2, 2, width_ratios=(1.0, 1.6))
    found: dict[str, JsonValue] = {}
    wheres: tuple[Where, ...] = ("far", "near")
    for where, (shown, axes) in zip(wheres, panels, strict=True):
        tables = {degrees: lab.measured([moved_recipe(where, degrees, s) for s in lab.seeds], several)
                  for degrees in ANGLES}  # fmt: skip
        rows = {degrees: {row.method: row for row in table.rows} for degrees, table in tables.items()}
        curves = [error_curve(one.name, ANGLES, [rows[d][one.name] for d in ANGLES]) for one in several]
        vector_map(shown, next(entry for entry in tables[SHOWN].entries if entry.name == several[0].name))
        shown.set_title(f"{several[0].name}, {SHOWN}° moved {where}, seed {lab.seeds[0]}", fontsize=9.5, loc="left")
        style.dress(axes, f"moved {where}", "region moved [deg]", "mean angular error [deg]")
        draw_curves(axes, curves)
        axes.set_xticks(ANGLES)
        found[where] = curve_values(curves)
    style.legend_below(figure, panels[-1, -1], len(several))
    return Finding(figure, found)


def rooms(seed: int) -> dict[str, Room]:
    """Return a painted room with objects, "now", and what a moved sector shows: the bare wall or a wall close by."""
    rng = np.random.default_rng([seed, 335])
    angles = np.arange(OBJECTS) * TAU / OBJECTS + rng.uniform(-0.2, 0.2, OBJECTS)
    reach = rng.uniform(1.7, 2.6, OBJECTS)
    colours = [tuple(int(v) for v in rng.integers(20, 250, 3)) for _ in range(OBJECTS)]
    objects = [
        Pillar(r * math.cos(a), r * math.sin(a), OBJECT, (red, green, blue))
        for a, r, (red, green, blue) in zip(angles, reach, colours, strict=True)
    ]
    paint = painted(rng)
    return {"now": Room(objects, WALL, paint), "far": Room([], WALL, paint), "near": Room([], CLOSE, painted(rng))}


def moved_recipe(where: Where, degrees: int, seed: int) -> Recipe:
    """Return the recipe of a room whose home view has so much of it moved; the seed says where."""
    return room_recipe(f"moved {where} {degrees}", seed, partial(_arena, where, degrees))


def _arena(where: Where, degrees: int, name: str, seed: int, _options: tuple[str, ...]) -> Arena:
    known = rooms(seed)
    middle = float(np.random.default_rng([seed, 336]).uniform(0.0, TAU))
    goals = MovedViews(known["now"], known[where], middle, math.radians(degrees))
    return room_arena(name, known["now"], HALF, SPACING, goals)
