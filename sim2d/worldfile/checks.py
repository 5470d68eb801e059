"""What a world file's tables cannot see one by one: names, outlines, sizes, and who has room where."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np

from sim2d.clearance import BODY, Clearance, grid_positions
from sim2d.path import of_route
from sim2d.shapes import Point, Route, Spec
from sim2d.worldfile.errors import Fault
from sim2d.worldfile.scenes import WorldTable
from sim2d.worldfile.spec import turning
from sim2d.worldfile.tables import DecalTable, ThingTable

TOUCH = 0.02  # [m] a door's ends lie on a wall if nearer than this
DENSE = 0.06  # [m] between the places where a route is checked


def check_tables(table: WorldTable) -> None:
    """Raise the first Fault of names, outlines, heights, decals, windows and changes."""
    _check_names(table)
    _check_outlines(table)
    _check_heights(table)
    for where, points, decals in _pictured(table):
        _check_decals(where, points, decals)
    _check_windows(table)
    _check_changes(table)


def check_room(table: WorldTable, spec: Spec) -> None:
    """Raise the first Fault of doors, start, goal, places, routes, people and grid: who would stand in a thing."""
    clearance = Clearance(spec)
    for k, door in enumerate(table.door):
        _check_door(f"door[{door.name or k}]", door.a, door.b, clearance)
    _check_spot("route.ring", spec.start, clearance, "the robot starts here, but")
    if spec.goal:
        _check_spot("goal", spec.goal, clearance, "the goal lies here, but")
    for name, (x, y, _) in spec.places.items():
        _check_spot(f"places.{name}", (x, y), clearance, "the place lies here, but")
    for name, route in {"route": spec.route, **{f"routes.{n}": r for n, r in spec.routes.items()}}.items():
        _check_route(name, route, clearance)
    for k, person in enumerate(spec.people):
        _check_walk(f"person[{table.person[k].name or k}].route", person.route, person.radius, clearance)
    if spec.grid and not np.isfinite(grid_positions(spec)).any():
        raise Fault("grid.origin", spec.grid.origin, "no position of the grid is free")


def _things(table: WorldTable) -> dict[str, Sequence[ThingTable]]:
    return {
        "wall": table.wall, "polygon": table.polygon, "furniture": table.furniture, "cylinder": table.cylinder,
        "pillar": table.pillar, "door": table.door,
    }  # fmt: skip


def _rows(table: WorldTable) -> Iterator[tuple[str, int, str]]:
    """Return kind, number and name of everything."""
    for kind, rows in _things(table).items():
        yield from ((kind, k, row.name) for k, row in enumerate(rows))
    yield from (("person", k, row.name) for k, row in enumerate(table.person))


def _check_names(table: WorldTable) -> None:
    seen: dict[str, str] = {}
    for kind, k, name in _rows(table):
        if name in seen:
            raise Fault(f"{kind}[{k}].name", name, f"the name must be the only one of its kind; it is {seen[name]}'s")
        if name:
            seen[name] = f"{kind}[{k}]"


def _check_outlines(table: WorldTable) -> None:
    for k, wall in enumerate(table.wall):
        _check_line(f"wall[{wall.name or k}].points", wall.points)
    for k, row in enumerate(table.polygon):
        where = f"polygon[{row.name or k}].points"
        _check_line(where, (*row.points, row.points[0]))
        if crossing(row.points):
            raise Fault(where, row.points, f"the outline crosses itself at side {crossing(row.points)}")
        if not any(turning(row.points)):
            raise Fault(where, row.points, "the outline needs an area")


def _check_line(where: str, points: Sequence[Point]) -> None:
    for a, b in pairwise(points):
        if math.dist(a, b) < 1e-3:
            raise Fault(where, points, f"the point {list(a)} stands there twice in a row")


def crossing(points: Sequence[Point]) -> int:
    """Return the number of the first side (from 1) that another, not neighbouring one crosses or touches, or 0."""
    sides = list(zip(points, [*points[1:], points[0]], strict=True))
    n = len(sides)
    for i in range(n):
        for j in range(i + 2, n):
            if (i, j) != (0, n - 1) and _meet(*sides[i], *sides[j]):
                return i + 1
    return 0


def _meet(a: Point, b: Point, c: Point, d: Point) -> bool:
    def side(p: Point, q: Point, r: Point) -> float:
        return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])

    boxes = all(max(min(a[k], b[k]), min(c[k], d[k])) <= min(max(a[k], b[k]), max(c[k], d[k])) for k in (0, 1))
    return boxes and side(a, b, c) * side(a, b, d) <= 0 and side(c, d, a) * side(c, d, b) <= 0


def _check_heights(table: WorldTable) -> None:
    top = table.ceiling_height
    for kind, rows in _things(table).items():
        for k, row in enumerate(rows):
            if row.height is not None and row.height > top:
                raise Fault(f"{kind}[{row.name or k}].height", row.height, f"the ceiling hangs at {top} m")
    for k, light in enumerate(table.light):
        if light.z is not None and light.z > top:
            raise Fault(f"light[{k}].z", light.z, f"the ceiling hangs at {top} m")


def _pictured(table: WorldTable) -> Iterator[tuple[str, Sequence[Point], tuple[DecalTable, ...]]]:
    for k, wall in enumerate(table.wall):
        points = (*wall.points, wall.points[0]) if wall.closed else wall.points
        yield f"wall[{wall.name or k}]", points, wall.decals
    for k, row in enumerate(table.polygon):
        yield f"polygon[{row.name or k}]", (*row.points, row.points[0]), row.decals


def _check_decals(where: str, points: Sequence[Point], decals: tuple[DecalTable, ...]) -> None:
    total = _length(points)
    for k, decal in enumerate(decals):
        if decal.start + decal.length > total + 1e-6:
            end = decal.start + decal.length
            raise Fault(
                f"{where}.decals[{k}].length", decal.length, f"it ends {end:g} m along a surface of {total:g} m"
            )


def _check_windows(table: WorldTable) -> None:
    walls = {wall.name: wall for wall in table.wall if wall.name}
    for k, light in enumerate(table.light):
        if light.kind != "window":
            continue
        wall = walls.get(light.wall)
        if wall is None:
            raise Fault(f"light[{k}].wall", light.wall, f"there is no such wall; there are {', '.join(walls)}")
        if len(wall.points) != 2:
            raise Fault(f"light[{k}].wall", light.wall, "a window's wall must have two points")
        end, total = light.start + light.length, _length(wall.points)
        if end > total + 1e-6:
            raise Fault(f"light[{k}].length", light.length, f"it ends {end:g} m along a wall of {total:g} m")


def _check_changes(table: WorldTable) -> None:
    kinds = {name: kind for kind, _, name in _rows(table) if name}
    for change in table.change:
        kind = kinds.get(change.name)
        if kind is None or kind == "person":
            names = ", ".join(name for name, kind in kinds.items() if kind != "person")
            raise Fault(f"change[{change.name}].name", change.name, f"there is no such thing; there are {names}")
        if change.opens is not None and kind != "door":
            raise Fault(f"change[{change.name}].opens", change.opens, f"only doors open, no {kind}s")
        if change.moves_to is not None and kind in ("door", "wall"):
            raise Fault(f"change[{change.name}].moves_to", change.moves_to, f"only loose things move, no {kind}s")


def _check_door(where: str, a: Point, b: Point, clearance: Clearance) -> None:
    if math.dist(a, b) < 0.1:
        raise Fault(f"{where}.b", b, "a door is at least 0.1 m wide")
    for end, point in (("a", a), ("b", b)):
        room, name = clearance.at(*point)
        if room > TOUCH:
            near = f"; the nearest, {name}, is {room:.2f} m off" if name else ""
            raise Fault(f"{where}.{end}", point, f"a door's ends lie on walls{near}")
    middle = (0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]))
    if clearance.at(*middle)[0] < min(TOUCH, 0.2 * math.dist(a, b)):
        raise Fault(f"{where}.a", a, f"{clearance.at(*middle)[1]} goes on behind the door: leave a gap there")


def _check_spot(where: str, spot: Point, clearance: Clearance, who: str, radius: float = BODY) -> None:
    room, name = clearance.at(*spot)
    if room < radius:
        place = f"inside {name}" if room < 0 else f"{room:.2f} m from {name}"
        raise Fault(where, spot, f"{who} that is {place}: keep {radius:g} m free")


def _check_route(where: str, route: Route, clearance: Clearance) -> None:
    corners = [*route.ring, route.ring[0]]
    _check_line(f"{where}.ring", route.ring if len(route.ring) > 2 else corners)
    points = of_route(route, math.ceil(route.laps) if not route.tail else None).points
    room, name, x, y = clearance.tightest(points[:: max(1, round(DENSE / 0.02))])
    if room < BODY - 0.01:
        raise Fault(
            f"{where}.ring", route.ring, f"at {x:.2f}, {y:.2f} the way comes {_how(room, name)}: keep {BODY:g} m"
        )


def _check_walk(where: str, route: Sequence[Point], radius: float, clearance: Clearance) -> None:
    for a, b in pairwise([*route[:1], *route]):
        count = max(2, math.ceil(math.dist(a, b) / DENSE))
        room, name, x, y = clearance.tightest(np.linspace(a, b, count))
        if room < radius - 0.01:
            raise Fault(where, route, f"at {x:.2f}, {y:.2f} the walk comes {_how(room, name)}: keep {radius:g} m")


def _how(room: float, name: str) -> str:
    return f"within {max(0.0, room):.2f} m of {name}"


def _length(points: Sequence[Point]) -> float:
    return sum(math.dist(a, b) for a, b in pairwise(points))
