"""room-corridor: a room whose partition makes its floor a ring, a gate, and a corridor outside."""

from __future__ import annotations

from sim2d.shapes import Box, Colour, Cylinder, Decal, Gate, Ground, Look, Point, Route, Spec, Wall, rectangle

ROOM = 2.6  # [m] height


def room_corridor() -> Spec:
    """Return the thesis's loop experiment (chapter 5.2.4): two laps of the ring, then out through the gate."""
    return Spec(
        name="room-corridor",
        purpose="the thesis's loop experiment: two laps of a room, then through a door and home",
        route=Route(
            ring=((4.0, 1.2), (6.6, 1.2), (6.6, 5.8), (1.4, 5.8), (1.4, 1.2)),
            laps=2,
            tail=((14.0, 1.2), (14.0, 8.2)),
        ),
        floor=Ground(Look((0.5, 0.42, 0.34), "speckle", 3), gloss=0.06),
        ceiling=Ground(Look((0.82, 0.82, 0.8), "plaster", 4), tile=6.4, lamps=3.2),
        ceiling_height=ROOM,
        walls=(*_room(), *_corridor()),
        boxes=_furniture(),
        cylinders=_round_things(),
        gates=(Gate((8.0, 0.5), (8.0, 1.9), ROOM, _gate(), opens_at=1.3),),
        goal=(4.0, 1.2),
        labels=((4.0, 3.5, "partition"), (8.0, 1.2, "gate"), (11.0, 1.2, "corridor"), (1.4, 6.8, "room")),
    )


def _gate() -> Look:
    return Look((0.55, 0.3, 0.16), "wood", 9, (Decal("board", 0.3, 0.8, 1.2, 1.8, (0.85, 0.85, 0.3), 9),))


def _wall(name: str, a: Point, b: Point, colour: Colour, kind: str, seed: int, *decals: Decal) -> Wall:
    return Wall((a, b), ROOM, Look(colour, kind, seed, decals), name)


def _room() -> tuple[Wall, ...]:
    """The four walls, each of its own colour."""
    white = (0.92, 0.93, 0.95)
    return (
        _wall(
            "south", (0, 0), (8, 0), (0.75, 0.72, 0.6), "plaster", 11,
            Decal("board", 1.8, 2.4, 0.9, 2.1, (0.12, 0.3, 0.2), 1),
            Decal("poster", 5.2, 0.8, 1.0, 2.1, (0.8, 0.3, 0.2), 2),
            Decal("poster", 6.4, 0.6, 1.2, 2.0, (0.2, 0.4, 0.8), 3),
        ),
        _wall("east-a", (8, 0), (8, 0.5), (0.55, 0.65, 0.75), "plaster", 12),
        _wall(
            "east-b", (8, 1.9), (8, 7), (0.55, 0.65, 0.75), "plaster", 13,
            Decal("aircon", 1.6, 1.3, 1.7, 2.3, white, 4),
            Decal("curtain", 3.5, 1.3, 0.1, 2.4, (0.75, 0.2, 0.25), 5),
        ),
        _wall(
            "north", (8, 7), (0, 7), (0.8, 0.78, 0.74), "plaster", 14,
            Decal("window", 0.8, 2.4, 0.9, 2.2, white, 6),
            Decal("window", 4.8, 2.4, 0.9, 2.2, white, 7),
            Decal("radiator", 1.2, 1.5, 0.15, 0.75, (0.85, 0.85, 0.82), 8),
        ),
        _wall(
            "west", (0, 7), (0, 0), (0.6, 0.7, 0.55), "plaster", 15,
            Decal("poster", 0.5, 0.7, 1.0, 2.0, (0.9, 0.8, 0.2), 9),
            Decal("door", 4.9, 1.0, 0.0, 2.1, (0.45, 0.25, 0.15), 10),
        ),
    )  # fmt: skip


def _corridor() -> tuple[Wall, ...]:
    """A corridor 2 m wide with a bend to the north, each wall of its own kind."""
    red, grey, teal = (0.66, 0.36, 0.26), (0.66, 0.64, 0.6), (0.35, 0.6, 0.6)
    return (
        _wall(
            "corridor south", (8, 0.2), (15, 0.2), red, "brick", 21,
            Decal("poster", 1.4, 0.9, 0.9, 2.0, (0.2, 0.6, 0.4), 21),
            Decal("extinguisher", 3.6, 0.4, 0.7, 1.7, red, 22),
            Decal("window", 4.7, 1.4, 0.9, 2.1, (0.3, 0.3, 0.32), 23),
        ),
        _wall(
            "corridor north", (13, 2.2), (8, 2.2), grey, "panels", 22,
            Decal("door", 1.2, 1.0, 0.0, 2.1, (0.2, 0.35, 0.6), 24),
            Decal("poster", 3.2, 0.6, 1.0, 1.9, (0.85, 0.5, 0.1), 25),
        ),
        _wall(
            "corridor east", (15, 0.2), (15, 9.6), teal, "panels", 23,
            Decal("board", 0.7, 1.3, 1.0, 2.0, (0.9, 0.9, 0.85), 26),
            Decal("door", 3.3, 1.0, 0.0, 2.1, (0.5, 0.2, 0.2), 27),
            Decal("poster", 5.6, 1.2, 0.8, 1.9, (0.4, 0.2, 0.6), 28),
            Decal("extinguisher", 7.9, 0.4, 0.7, 1.7, red, 29),
        ),
        _wall("corridor end", (15, 9.6), (13, 9.6), (0.85, 0.75, 0.4), "plaster", 24,
              Decal("curtain", 0.4, 1.2, 0.2, 2.3, (0.2, 0.3, 0.65), 30)),
        _wall(
            "corridor west", (13, 9.6), (13, 2.2), red, "brick", 25,
            Decal("window", 1.2, 1.2, 0.9, 2.0, (0.9, 0.9, 0.9), 31),
            Decal("board", 3.5, 1.0, 1.0, 1.9, (0.15, 0.2, 0.25), 32),
            Decal("poster", 5.6, 0.7, 0.9, 1.9, (0.1, 0.7, 0.7), 33),
        ),
    )  # fmt: skip


def _box(name: str, x0: float, y0: float, x1: float, y1: float, height: float, look: Look) -> Box:
    return Box(rectangle(x0, y0, x1, y1), height, look, name)


def _furniture() -> tuple[Box, ...]:
    """The partition in the middle and the furniture along the walls."""
    partition = Look(
        (0.78, 0.55, 0.35), "panels", 41,
        (
            Decal("poster", 0.5, 0.7, 0.9, 1.9, (0.3, 0.5, 0.9), 41),
            Decal("board", 1.5, 0.9, 0.9, 1.7, (0.9, 0.9, 0.9), 42),
            Decal("curtain", 2.8, 1.0, 0.1, 2.2, (0.3, 0.55, 0.3), 43),
            Decal("poster", 5.0, 1.2, 0.8, 1.8, (0.9, 0.85, 0.6), 44),
            Decal("window", 6.6, 0.9, 1.0, 2.0, (0.4, 0.25, 0.15), 45),
        ),
    )  # fmt: skip
    return (
        _box("partition", 2.7, 2.6, 5.3, 4.4, ROOM, partition),
        _box("bookcase", 0.05, 2.6, 0.4, 4.6, 2.0, Look((0.5, 0.33, 0.2), "books", 42)),
        _box("bookcase low", 7.55, 4.2, 7.95, 5.3, 1.2, Look((0.45, 0.3, 0.2), "books", 43)),
        _box("table", 3.2, 6.3, 5.0, 6.95, 0.75, Look((0.7, 0.55, 0.38), "wood", 44)),
        _box("screen", 3.9, 6.75, 4.5, 6.85, 1.25, Look((0.12, 0.14, 0.2), "plaster", 45)),
        _box("drawers", 2.2, 0.05, 3.1, 0.5, 0.9, Look((0.8, 0.7, 0.55), "drawers", 46)),
        _box("cupboard", 7.3, 6.3, 7.95, 6.95, 1.8, Look((0.65, 0.67, 0.7), "drawers", 47)),
        _box("crate", 5.0, 0.05, 5.5, 0.45, 0.45, Look((0.75, 0.6, 0.25), "wood", 48)),
        _box("shoe rack", 12.0, 0.25, 12.8, 0.45, 0.8, Look((0.3, 0.25, 0.4), "drawers", 49)),
    )


def _round_things() -> tuple[Cylinder, ...]:
    """Bins, a vase and a plant."""
    return (
        Cylinder(0.35, 0.35, 0.2, 0.5, Look((0.2, 0.35, 0.7), "plaster", 51), "bin"),
        Cylinder(0.8, 0.3, 0.16, 0.4, Look((0.85, 0.75, 0.1), "plaster", 52), "bin"),
        Cylinder(7.6, 2.4, 0.22, 1.4, Look((0.6, 0.25, 0.15), "leaves", 53), "plant"),
        Cylinder(0.35, 6.6, 0.25, 1.7, Look((0.85, 0.85, 0.8), "leaves", 54), "plant"),
        Cylinder(13.25, 6.0, 0.18, 1.1, Look((0.3, 0.3, 0.35), "leaves", 55), "plant"),
    )
