"""From the tables of a world file to the records of a world."""

from __future__ import annotations

import math
from collections.abc import Sequence

from sim2d.furniture import KINDS, furniture
from sim2d.shapes import (
    Box,
    Change,
    Cylinder,
    Decal,
    Gate,
    Grid,
    Light,
    Look,
    Person,
    Point,
    Route,
    Spec,
    Wall,
)
from sim2d.worldfile.scenes import LightTable, RouteTable, WorldTable
from sim2d.worldfile.tables import CylinderTable, DoorTable, PolygonTable


def spec_of(table: WorldTable) -> Spec:
    """Return the world of checked tables; things without a name are called by their table and number."""
    top = table.ceiling_height
    solids = [_solid(row, row.name or f"polygon {k}", k, top) for k, row in enumerate(table.polygon)]
    return Spec(
        name=table.name,
        purpose=table.purpose,
        route=_route(table.route),
        routes={name: _route(route) for name, route in table.routes.items()},
        floor=table.floor.ground(3),
        ceiling=table.ceiling.ground(4),
        ceiling_height=top,
        walls=(*_walls(table), *(solid for solid in solids if isinstance(solid, Wall))),
        boxes=(*(solid for solid in solids if isinstance(solid, Box)), *_furniture(table)),
        cylinders=(
            *(_cylinder(row, f"cylinder {k}", 500 + k, top) for k, row in enumerate(table.cylinder)),
            *(_cylinder(row, f"pillar {k}", 700 + k, top) for k, row in enumerate(table.pillar)),
        ),
        gates=tuple(_door(row, row.name or f"door {k}", 800 + k, top) for k, row in enumerate(table.door)),
        goal=table.goal,
        labels=tuple((row.x, row.y, row.text) for row in table.label),
        lights=tuple(_light(row, table) for row in table.light),
        people=tuple(
            Person(
                row.name or f"person {k}", row.route, row.speed, row.radius, row.height,
                Look(row.colour, "plain", row.seed), row.start_s,
            )
            for k, row in enumerate(table.person)
        ),
        changes=tuple(
            Change(row.name, row.at_s, row.at_lap, row.opens, row.moves_to, math.radians(row.turn_deg))
            for row in table.change
        ),
        places={name: (row.x, row.y, math.radians(row.heading_deg)) for name, row in table.places.items()},
        grid=Grid(table.grid.origin, table.grid.spacing, table.grid.columns, table.grid.rows) if table.grid else None,
    )  # fmt: skip


def turning(points: Sequence[Point]) -> list[float]:
    """Return the cross product at each corner of an outline: all of one sign where it is convex."""
    ring = [*points, *points[:2]]
    triples = zip(ring, ring[1:], ring[2:], strict=False)
    return [(b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0]) for a, b, c in triples]


def _route(row: RouteTable) -> Route:
    return Route(row.ring, row.laps, row.tail, row.radius, row.both_ways)


def _walls(table: WorldTable) -> list[Wall]:
    """Return the walls, with their windows painted on."""
    out = []
    for k, row in enumerate(table.wall):
        windows = tuple(_pane(light) for light in table.light if light.kind == "window" and light.wall == row.name)
        points = (*row.points, row.points[0]) if row.closed else row.points
        decals = tuple(decal.decal() for decal in row.decals) + windows
        height = row.height or table.ceiling_height
        out.append(Wall(points, height, row.look(100 + k, decals), row.name or f"wall {k}"))
    return out


def _pane(row: LightTable) -> Decal:
    return Decal("window", row.start, row.length, row.sill, row.top, row.frame, row.seed)


def _solid(row: PolygonTable, name: str, k: int, top: float) -> Box | Wall:
    """Return a convex outline as a box; another as a closed wall."""
    look = row.look(300 + k, tuple(decal.decal() for decal in row.decals))
    corners = turning(row.points)
    if min(corners) > 0 or max(corners) < 0:
        points = row.points if corners[0] > 0 else row.points[::-1]
        return Box(points, row.height or top, look, name)
    return Wall((*row.points, row.points[0]), row.height or top, look, name)


def _furniture(table: WorldTable) -> list[Box]:
    out = []
    for k, row in enumerate(table.furniture):
        seed = 400 + k if row.seed is None else row.seed
        made = furniture(row.kind, row.at, row.size, seed, math.radians(row.turn_deg), row.name, row.colour)
        out.append(Box(made.points, row.height or KINDS[row.kind][0], made.look, row.name or f"furniture {k}"))
    return out


def _cylinder(row: CylinderTable, name: str, seed: int, top: float) -> Cylinder:
    return Cylinder(*row.at, row.radius, row.height or top, row.look(seed), row.name or name)


def _door(row: DoorTable, name: str, seed: int, top: float) -> Gate:
    times = (row.opens_at, row.closes_at, row.opens_s, row.closes_s, row.opens_m, row.closes_m)
    lap, shut, opens_s, closes_s, opens_m, closes_m = (math.inf if value is None else value for value in times)
    return Gate(row.a, row.b, row.height or top, row.look(seed), lap, name, shut, opens_s, closes_s, opens_m, closes_m)


def _light(row: LightTable, table: WorldTable) -> Light:
    if row.kind == "lamp":
        x, y = row.at or (0.0, 0.0)
        return Light(x, y, row.z or table.ceiling_height - 0.05, row.strength, row.colour)
    wall = next(wall for wall in table.wall if wall.name == row.wall)
    a, b = (_along(wall.points[0], wall.points[1], s) for s in (row.start, row.start + row.length))
    x, y = 0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])
    return Light(x, y, 0.5 * (row.sill + row.top), row.strength, row.colour, "window", a, b, row.sill, row.top)


def _along(a: Point, b: Point, s: float) -> Point:
    """Return the point s [m] from a towards b."""
    share = s / math.dist(a, b)
    return a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])
