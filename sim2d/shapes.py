"""What a world is made of: frozen records, metres, world frame, x right and y up on the plan."""

from __future__ import annotations

from dataclasses import dataclass

Point = tuple[float, float]
Colour = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Decal:
    """A flat thing on a surface, from `start` [m] along it, `length` [m] long, `base`..`top` [m] above the floor.

    kind: a painter's name (`sim2d.decals`); colour (r, g, b) in [0, 1]; seed: same seed, same look.
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
    """How a surface looks: base colour (r, g, b) in [0, 1], painter's name (`sim2d.paint`), seed, decals."""

    colour: Colour
    texture: str = "plaster"
    seed: int = 0
    decals: tuple[Decal, ...] = ()


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
    """A wall from a to b [m] that the driver opens once `opens_at` laps are driven."""

    a: Point
    b: Point
    height: float
    look: Look
    opens_at: float
    name: str = "gate"


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
    """Where the driver goes: a ring of corners, `laps` times, then a tail; corners are rounded with `radius` [m]."""

    ring: tuple[Point, ...]
    laps: float
    tail: tuple[Point, ...] = ()
    radius: float = 0.7


@dataclass(frozen=True, slots=True)
class Spec:
    """A world as data, in metres; the robot starts where the route begins, and goal is where it shall go home to."""

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


def rectangle(x0: float, y0: float, x1: float, y1: float) -> tuple[Point, ...]:
    """Return the corners of an upright rectangle, counter-clockwise from its lower left."""
    return ((x0, y0), (x1, y0), (x1, y1), (x0, y1))
