"""A world at work: its shapes in a pymunk space, its surfaces as arrays, its gates open or closed."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import pymunk
from numpy.typing import NDArray

from sim2d.errors import WorldError
from sim2d.people import People
from sim2d.render import scene as scenes
from sim2d.render.atlas import Atlas, AtlasBuilder
from sim2d.render.daylight import EVEN, daylight_at
from sim2d.shapes import Box, Cylinder, Gate, Look, Person, Point, Spec, Wall

STATIC = 0b1
ROBOT = 0b10


@dataclass(frozen=True, slots=True)
class Plan:
    """A plan for pictures, world frame: polylines [(N, 2) m], circles [(x, y, r) m], labels [(x, y, text)]."""

    polylines: tuple[NDArray[np.float64], ...]
    circles: tuple[tuple[float, float, float], ...]
    labels: tuple[tuple[float, float, str], ...]


@dataclass(frozen=True, slots=True)
class Skin:
    """What a pymunk shape looks like: body number, top [m], tile, surface coordinate of its first point [m], glass."""

    solid: int
    top: float
    tile: int
    along: float
    glass: bool = False


class World:
    """The space of a Spec; owns its gates' state, so every run loads its own. Raises WorldError on bad shapes."""

    def __init__(self, spec: Spec, seed: int = 0) -> None:
        self.spec = spec
        self.name = spec.name
        self.version = 0
        self.space = pymunk.Space()
        self.space.collision_slop = 1e-4
        self.space.collision_bias = 1e-60  # of an overlap this is left after a second: walls are hard
        self._skins: dict[pymunk.Shape, Skin] = {}
        self._gates: list[tuple[Gate, pymunk.Shape, Skin]] = []
        self._due = [False] * len(spec.gates)
        self._solids = 0
        self._scene: tuple[int, scenes.Scene] | None = None
        self._scanned: tuple[int, NDArray[np.float64]] | None = None
        self._things: list[tuple[Box | Cylinder, pymunk.Shape]] = []
        self.people = People(self.space)
        self.daylight = EVEN
        self.hour: float | None = None
        builder = AtlasBuilder(seed)
        self.floor = builder.ground(spec.floor)
        self.ceiling = builder.ground(spec.ceiling)
        for wall in spec.walls:
            self._add_wall(wall, builder)
        for box in spec.boxes:
            self._add_box(box, builder)
        for cylinder in spec.cylinders:
            self._add_cylinder(cylinder, builder)
        for gate in spec.gates:
            self._add_gate(gate, builder)
        self._builder = builder
        self.add_people(spec.people)

    def scene(self) -> scenes.Scene:
        """Return the surfaces as they stand now; extracted once per change."""
        if self._scene is None or self._scene[0] != self.version:
            surfaces = self.people.append_to(_surfaces(self._skins))
            self._scene = (self.version, scenes.build(surfaces, len(self.people)))
        scene = self._scene[1]
        self.people.place(scene.line, scene.along)
        return scene

    def scanned(self) -> scenes.Scene:
        """Return the surfaces as a range scanner meets them: glass is nowhere high enough."""
        scene = self.scene()
        if self._scanned is None or self._scanned[0] != self.version:
            glass = np.array([skin.glass for shape, skin in self._skins.items() for _ in _rows(shape)], dtype=bool)
            top = scene.top.copy()
            top[: len(glass)][glass] = -1.0
            self._scanned = (self.version, top)
        return scene._replace(top=self._scanned[1])

    def add_people(self, persons: Iterable[Person]) -> None:
        """Add people at the start of their routes. Raises WorldError for one that can't walk."""
        self.people.add(persons, self._builder)
        self.atlas: Atlas = self._builder.build()
        self.version += 1

    def set_hour(self, hour: float | None) -> None:
        """Light the world by its lamps and windows at an hour of the day, or evenly (None)."""
        self.hour = hour
        self._builder.repaint(hour)
        self.daylight = EVEN if hour is None else daylight_at(self.spec, self.scene(), hour)

    def things(self, name: str) -> tuple[Box | Cylinder, ...]:
        """Return the boxes and cylinders of a name as they stand now."""
        return tuple(thing for thing, _ in self._things if thing.name == name)

    def replace_thing(self, old: Box | Cylinder, new: Box | Cylinder) -> None:
        """Put a thing where it stands now: same size and look, other place."""
        k = next(k for k, (thing, _) in enumerate(self._things) if thing is old)
        shape = self._things.pop(k)[1]
        self.space.remove(shape)
        del self._skins[shape]
        if isinstance(new, Box):
            self._add_box(new, self._builder)
        else:
            self._add_cylinder(new, self._builder)
        self.version += 1

    def open_gates(self, laps: float, seconds: float = 0.0, metres: float = 0.0) -> bool:
        """Open and close every door that has become due since the last call; return whether one moved."""
        moved = False
        for k, (gate, *_) in enumerate(self._gates):
            wanted = gate.is_open(laps, seconds, metres)
            if wanted != self._due[k]:
                self._due[k] = wanted
                moved |= self._set(k, wanted)
        return moved

    def set_gate(self, name: str, is_open: bool) -> bool:
        """Open or close the doors of a name, whatever they wait for; return whether one moved."""
        return sum(self._set(k, is_open) for k, (gate, *_) in enumerate(self._gates) if gate.name == name) > 0

    def _set(self, k: int, is_open: bool) -> bool:
        _, shape, skin = self._gates[k]
        if is_open != (shape in self._skins):
            return False
        if is_open:
            self.space.remove(shape)
            del self._skins[shape]
        else:
            self.space.add(shape)
            self._skins[shape] = skin
        self.version += 1
        return True

    def plan(self) -> Plan:
        """Return the plan, with gates closed."""
        spec = self.spec
        lines = [np.array(wall.points) for wall in spec.walls]
        lines += [np.array([*box.points, box.points[0]]) for box in spec.boxes]
        lines += [np.array([gate.a, gate.b]) for gate in spec.gates]
        circles = tuple((c.x, c.y, c.radius) for c in spec.cylinders)
        return Plan(tuple(lines), circles, spec.labels)

    def _add_wall(self, wall: Wall, builder: AtlasBuilder) -> None:
        if len(wall.points) < 2:
            raise WorldError(f"wall {wall.name!r} of {self.name} needs at least two points")
        total = sum(math.dist(a, b) for a, b in zip(wall.points, wall.points[1:], strict=False))
        along, tile = 0.0, _tile(builder, wall.look, total, wall.height)
        for a, b in zip(wall.points, wall.points[1:], strict=False):
            self._add(pymunk.Segment(self.space.static_body, a, b, 0.0), wall.height, tile, along, wall.look.glass)
            along += math.dist(a, b)

    def _add_box(self, box: Box, builder: AtlasBuilder) -> None:
        points = list(box.points)
        if not _is_convex(points):
            raise WorldError(f"box {box.name!r} of {self.name} must be convex and counter-clockwise")
        tile = _tile(builder, box.look, _perimeter(points), box.height)
        shape = pymunk.Poly(self.space.static_body, points)
        # pymunk may begin with another corner: the surface coordinate starts where it begins
        self._add(shape, box.height, tile, _offset(points, shape.get_vertices()[0]), box.look.glass)
        self._things.append((box, shape))

    def _add_cylinder(self, cylinder: Cylinder, builder: AtlasBuilder) -> None:
        if not cylinder.radius > 0:
            raise WorldError(f"cylinder {cylinder.name!r} of {self.name} needs a radius above 0")
        tile = _tile(builder, cylinder.look, math.tau * cylinder.radius, cylinder.height)
        offset = (cylinder.x, cylinder.y)
        shape = pymunk.Circle(self.space.static_body, cylinder.radius, offset)
        self._add(shape, cylinder.height, tile, 0.0, cylinder.look.glass)
        self._things.append((cylinder, shape))

    def _add_gate(self, gate: Gate, builder: AtlasBuilder) -> None:
        tile = _tile(builder, gate.look, math.dist(gate.a, gate.b), gate.height)
        shape = pymunk.Segment(self.space.static_body, gate.a, gate.b, 0.0)
        self._gates.append((gate, shape, self._add(shape, gate.height, tile, 0.0, gate.look.glass)))

    def _add(self, shape: pymunk.Shape, top: float, tile: int, along: float, glass: bool) -> Skin:
        shape.friction = 0.0
        shape.filter = pymunk.ShapeFilter(categories=STATIC)
        self.space.add(shape)
        skin = self._skins[shape] = Skin(self._solids, top, tile, along, glass)
        self._solids += 1
        return skin


def _tile(builder: AtlasBuilder, look: Look, length: float, height: float) -> int:
    """Return the tile of a surface: painted for its whole length, or for what repeats."""
    return builder.surface(look, look.repeat or length, height)


def _perimeter(points: list[Point]) -> float:
    return sum(math.dist(a, b) for a, b in zip(points, points[1:] + points[:1], strict=True))


def _offset(points: list[Point], corner: Point) -> float:
    """Return the distance round a polygon from its first point to a corner [m]."""
    along = 0.0
    for a, b in zip(points, points[1:] + points[:1], strict=True):
        if math.dist(a, corner) < 1e-9:
            return along
        along += math.dist(a, b)
    return 0.0


def _is_convex(points: list[Point]) -> bool:
    triples = zip(points, points[1:] + points[:1], points[2:] + points[:2], strict=True)
    return len(points) >= 3 and all(
        (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0]) > 0 for a, b, c in triples
    )


def _light(ax: float, ay: float, bx: float, by: float) -> float:
    """Return the brightness of a surface by where it faces: light falls in from the upper right of the plan."""
    length = math.hypot(bx - ax, by - ay) or 1.0
    return 0.86 + 0.1 * (by - ay) / length - 0.06 * (bx - ax) / length


def _rows(shape: pymunk.Shape) -> list[tuple[int, tuple[float, float, float, float], float]]:
    """Return the surfaces of a shape as kind, line and distance along it from its first point [m]."""
    if isinstance(shape, pymunk.Segment):
        return [(scenes.SEGMENT, (*shape.a, *shape.b), 0.0)]
    if isinstance(shape, pymunk.Circle):
        return [(scenes.CIRCLE, (*shape.offset, shape.radius, 0.0), 0.0)]
    corners = shape.get_vertices()
    rows, along = [], 0.0
    for a, b in zip(corners, corners[1:] + corners[:1], strict=True):
        rows.append((scenes.EDGE, (*a, *b), along))
        along += math.dist(a, b)
    return rows


def _surfaces(skins: dict[pymunk.Shape, Skin]) -> scenes.Surfaces:
    rows = [(skin, row) for shape, skin in skins.items() for row in _rows(shape)]
    return scenes.Surfaces(
        np.array([row[0] for _, row in rows], dtype=np.int64),
        np.array([row[1] for _, row in rows], dtype=np.float64).reshape(-1, 4),
        np.array([skin.solid for skin, _ in rows], dtype=np.int64),
        np.array([skin.top for skin, _ in rows], dtype=np.float64),
        np.array([skin.tile for skin, _ in rows], dtype=np.int64),
        np.array([skin.along + row[2] for skin, row in rows], dtype=np.float64),
        np.array([_light(*row[1]) for _, row in rows], dtype=np.float64),
    )
