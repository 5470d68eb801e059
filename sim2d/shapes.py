"""What a world is made of: frozen records, metres, world frame, x right and y up on the plan."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from sim2d.errors import WorldError

Point = tuple[float, float]
Colour = tuple[float, float, float]
DEFAULT_ROUTE = "default"


@dataclass(frozen=True, slots=True)
class Decal:
    """A flat thing on a surface, from `start` [m] along it, `length` [m] long, `base`..`top` [m] above the floor.

    kind: a painter's name (`sim2d.render.decals`); colour (r, g, b) in [0, 1]; seed: same seed, same look.
    """

    kind: str
    start: float
    length: float
    base: float
    top: float
    colour: Colour = (0.5, 0.5, 0.5)
    seed: int = 0


@dataclass(frozen=True, slots=True)
class Look:
    """How a surface looks: base colour (r, g, b) in [0, 1], painter's name (`sim2d.render.paint`), seed, decals.

    repeat: the picture is painted for so many metres and then repeats, 0: for the whole surface. Surfaces with the same
    look, repeat and height share their texels, however long they are. glass: a range scanner doesn't see it.
    """

    colour: Colour
    texture: str = "plaster"
    seed: int = 0
    decals: tuple[Decal, ...] = ()
    repeat: float = 0.0
    glass: bool = False


@dataclass(frozen=True, slots=True)
class Wall:
    """A thin wall along a polyline [m]; its surface coordinate runs from the first point on."""

    points: tuple[Point, ...]
    height: float
    look: Look
    name: str = ""


@dataclass(frozen=True, slots=True)
class Box:
    """A convex prism [m], points counter-clockwise; its surface coordinate runs round from the first point on."""

    points: tuple[Point, ...]
    height: float
    look: Look
    name: str = ""


@dataclass(frozen=True, slots=True)
class Cylinder:
    """An upright cylinder [m]."""

    x: float
    y: float
    radius: float
    height: float
    look: Look
    name: str = ""


@dataclass(frozen=True, slots=True)
class Gate:
    """A door: a wall from a to b [m], closed at first, that opens and closes when what it waits for is reached.

    opens_at, closes_at [laps driven]; opens_s, closes_s [s of run time]; opens_m, closes_m [m driven]; infinite: never.
    """

    a: Point
    b: Point
    height: float
    look: Look
    opens_at: float = math.inf
    name: str = "gate"
    closes_at: float = math.inf
    opens_s: float = math.inf
    closes_s: float = math.inf
    opens_m: float = math.inf
    closes_m: float = math.inf

    def is_open(self, laps: float, seconds: float = 0.0, metres: float = 0.0) -> bool:
        """Return whether it stands open after so many laps, seconds and metres; of pairs due, the last one counts."""
        pairs = (
            (self.opens_at, self.closes_at, laps),
            (self.opens_s, self.closes_s, seconds),
            (self.opens_m, self.closes_m, metres),
        )
        return any(opens <= now and not (opens < closes <= now) for opens, closes, now in pairs)


@dataclass(frozen=True, slots=True)
class Light:
    """A light at x, y, z [m]; strength 1 lights like the room itself; colour (r, g, b).

    A window is the stretch a-b [m] of a wall, between `sill` and `top` [m] above the floor; x, y, z is its middle.
    """

    x: float
    y: float
    z: float
    strength: float = 1.0
    colour: Colour = (1.0, 1.0, 1.0)
    kind: Literal["lamp", "window"] = "lamp"
    a: Point = (0.0, 0.0)
    b: Point = (0.0, 0.0)
    sill: float = 0.0
    top: float = 0.0


@dataclass(frozen=True, slots=True)
class Person:
    """Somebody who walks a route of points [m] to and fro at `speed` [m/s] from `start_s` [s] on.

    look: colour of clothes and seed. marks: how far along the robot's route each point lies [m]; such a person
    accompanies the robot and keeps `lead` [m] ahead of it; empty: walks whatever the robot does.
    """

    name: str
    route: tuple[Point, ...]
    speed: float = 0.8
    radius: float = 0.25
    height: float = 1.75
    look: Look = Look((0.3, 0.35, 0.6), "plain")
    start_s: float = 0.0
    marks: tuple[float, ...] = ()
    lead: float = 0.0


@dataclass(frozen=True, slots=True)
class Change:
    """What happens once to the wall, box, cylinder or door called `name`, at `at_s` [s] or after `at_lap` laps.

    opens: whether a door opens (True) or closes (False); moves_to: where a box's middle or a cylinder goes,
    (x, y) [m], turned by `turn` [rad]. None: not so.
    """

    name: str
    at_s: float | None = None
    at_lap: float | None = None
    opens: bool | None = None
    moves_to: Point | None = None
    turn: float = 0.0


@dataclass(frozen=True, slots=True)
class Grid:
    """Positions for homing benches: column i, row j lies at origin + spacing * (i, j) [m]; none inside things."""

    origin: Point
    spacing: float
    columns: int
    rows: int


@dataclass(frozen=True, slots=True)
class Ground:
    """Floor or ceiling: look, side of its square tile [m], gloss in [0, 1] (the share it mirrors), lamp spacing [m].

    A lamp hangs at (first_lamp, first_lamp) [m]; spacing 0: no lamps.
    """

    look: Look
    tile: float = 6.4
    gloss: float = 0.0
    lamps: float = 0.0
    first_lamp: float = 1.6


@dataclass(frozen=True, slots=True)
class Route:
    """Where the driver goes: a ring of corners, `laps` times, then a tail; corners are rounded with `radius` [m].

    both_ways: every second lap is driven the other way round.
    """

    ring: tuple[Point, ...]
    laps: float
    tail: tuple[Point, ...] = ()
    radius: float = 0.7
    both_ways: bool = False


@dataclass(frozen=True, slots=True)
class Spec:
    """A world as data, in metres; the robot starts where the route begins, and goal is where it shall go home to.

    routes: others than `route`, by name; places: x, y [m], heading [rad] by name; purpose: what it is for.
    """

    name: str
    route: Route
    floor: Ground
    ceiling: Ground
    ceiling_height: float
    walls: tuple[Wall, ...] = ()
    boxes: tuple[Box, ...] = ()
    cylinders: tuple[Cylinder, ...] = ()
    gates: tuple[Gate, ...] = ()
    goal: Point | None = None
    labels: tuple[tuple[float, float, str], ...] = ()
    routes: Mapping[str, Route] = field(default_factory=dict)
    lights: tuple[Light, ...] = ()
    people: tuple[Person, ...] = ()
    changes: tuple[Change, ...] = ()
    places: Mapping[str, tuple[float, float, float]] = field(default_factory=dict)
    grid: Grid | None = None
    purpose: str = ""

    @property
    def floor_gloss(self) -> float:
        """The share of light that the floor mirrors, in [0, 1]."""
        return self.floor.gloss

    @property
    def start(self) -> Point:
        """Where the robot stands at first [m]."""
        return self.route.ring[0]

    def route_named(self, name: str = "") -> Route:
        """Return a route by name, without one the default. Raises WorldError for an unknown name."""
        if name not in ("", DEFAULT_ROUTE, *self.routes):
            known = ", ".join((DEFAULT_ROUTE, *self.routes))
            raise WorldError(f"world {self.name} has no route {name!r}; there are {known}")
        return self.routes.get(name, self.route)


def rectangle(x0: float, y0: float, x1: float, y1: float) -> tuple[Point, ...]:
    """Return the corners of an upright rectangle, counter-clockwise from its lower left."""
    return ((x0, y0), (x1, y0), (x1, y1), (x0, y1))
