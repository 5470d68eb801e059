"""hall: a large open hall with pillars, flowerpots, marble benches and a floor that glitters."""

from __future__ import annotations

from sim2d.shapes import Box, Colour, Cylinder, Decal, Ground, Look, Point, Route, Spec, Wall, rectangle

WIDTH, DEPTH, HEIGHT = 25.0, 18.0, 4.2  # [m]


def hall() -> Spec:
    """Return the thesis's hall (chapter 5.2.4): a course of about 50 m whose first 15 m are driven again."""
    return Spec(
        name="hall",
        purpose="pillars, glass and a polished floor: occlusion and glitter",
        route=Route(ring=((7.0, 4.0), (20.0, 4.0), (20.0, 14.0), (5.0, 14.0), (5.0, 4.0)), laps=1.3, radius=1.2),
        floor=Ground(Look((0.62, 0.58, 0.53), "slabs", 3), gloss=0.38),
        ceiling=Ground(Look((0.72, 0.72, 0.74), "plaster", 4), tile=6.4, lamps=3.2),
        ceiling_height=HEIGHT,
        walls=_walls(),
        boxes=_boxes(),
        cylinders=(*_pillars(), *_pots()),
        goal=(7.0, 4.0),
        labels=((12.5, 9.0, "hall"), (12.5, 17.0, "windows"), (1.6, 9.0, "entrance")),
    )


def _wall(name: str, a: Point, b: Point, colour: Colour, kind: str, seed: int, *decals: Decal) -> Wall:
    return Wall((a, b), HEIGHT, Look(colour, kind, seed, decals), name)


def _walls() -> tuple[Wall, ...]:
    """A glass front to the north, shops to the south, an entrance in the west, a stage curtain in the east."""
    frame = (0.35, 0.36, 0.4)
    glass = tuple(Decal("window", 0.8 + 4.1 * k, 3.4, 0.4, 3.6, frame, 60 + k) for k in range(6))
    return (
        _wall(
            "south", (0, 0), (WIDTH, 0), (0.8, 0.7, 0.52), "panels", 11,
            Decal("door", 2.0, 1.8, 0.0, 2.4, (0.4, 0.2, 0.12), 1),
            Decal("board", 5.5, 3.2, 1.0, 2.6, (0.1, 0.12, 0.2), 2),
            Decal("poster", 10.2, 1.6, 0.7, 2.9, (0.85, 0.25, 0.2), 3),
            Decal("curtain", 13.0, 2.6, 0.1, 3.0, (0.2, 0.45, 0.35), 4),
            Decal("poster", 17.2, 2.2, 0.8, 2.4, (0.2, 0.35, 0.75), 5),
            Decal("door", 21.2, 1.8, 0.0, 2.4, (0.15, 0.3, 0.5), 6),
        ),
        _wall(
            "east", (WIDTH, 0), (WIDTH, DEPTH), (0.5, 0.58, 0.66), "plaster", 12,
            Decal("poster", 2.0, 1.4, 0.9, 2.6, (0.9, 0.8, 0.15), 7),
            Decal("curtain", 5.0, 6.5, 0.1, 3.6, (0.62, 0.12, 0.16), 8),
            Decal("board", 13.2, 2.5, 0.9, 2.3, (0.92, 0.92, 0.88), 9),
        ),
        _wall("north", (WIDTH, DEPTH), (0, DEPTH), (0.74, 0.74, 0.72), "plaster", 13, *glass),
        _wall(
            "west", (0, DEPTH), (0, 0), (0.66, 0.42, 0.3), "brick", 14,
            Decal("poster", 2.0, 1.5, 0.8, 2.4, (0.2, 0.65, 0.4), 10),
            Decal("door", 7.2, 2.0, 0.0, 2.6, (0.62, 0.6, 0.55), 11),
            Decal("window", 9.4, 2.0, 0.3, 2.6, (0.5, 0.5, 0.5), 12),
            Decal("extinguisher", 12.2, 0.5, 0.6, 1.8, (0.8, 0.1, 0.1), 13),
            Decal("board", 13.6, 2.2, 0.9, 2.2, (0.15, 0.32, 0.2), 14),
        ),
    )  # fmt: skip


def _boxes() -> tuple[Box, ...]:
    """Marble benches, a counter and a show-case."""
    pale, dark = (0.85, 0.83, 0.8), (0.45, 0.42, 0.42)

    def box(name: str, x: float, y: float, w: float, d: float, height: float, look: Look) -> Box:
        return Box(rectangle(x, y, x + w, y + d), height, look, name)

    return (
        box("bench", 9.0, 5.9, 2.0, 0.5, 0.45, Look(pale, "marble", 21)),
        box("bench", 14.5, 5.9, 2.0, 0.5, 0.45, Look(dark, "marble", 22)),
        box("bench", 17.4, 8.0, 0.5, 2.2, 0.45, Look(pale, "marble", 23)),
        box("bench", 9.0, 11.6, 2.0, 0.5, 0.45, Look(dark, "marble", 24)),
        box("bench", 22.6, 7.5, 0.5, 2.4, 0.45, Look(dark, "marble", 25)),
        box("counter", 1.2, 12.0, 0.8, 3.2, 1.1, Look((0.5, 0.32, 0.2), "wood", 26)),
        box("show-case", 11.6, 8.4, 1.8, 1.2, 1.6, Look((0.3, 0.34, 0.42), "books", 27)),
        box("kiosk", 22.8, 15.4, 1.4, 1.6, 2.4, Look((0.3, 0.55, 0.7), "panels", 28)),
        box("rack", 12.2, 0.1, 2.0, 0.4, 1.3, Look((0.55, 0.4, 0.25), "books", 29)),
    )


def _pillars() -> tuple[Cylinder, ...]:
    """Two rows of pillars, each banded in its own colours."""
    spots = [(x, y) for y in (2.2, 12.4) for x in (3.0, 8.2, 16.8, 22.0)] + [(7.6, 8.2), (15.6, 9.6)]
    tones = ((0.7, 0.68, 0.64), (0.62, 0.55, 0.5), (0.55, 0.6, 0.65))
    return tuple(
        Cylinder(x, y, 0.3, HEIGHT, Look(tones[k % 3], "concrete", 31 + k), "pillar") for k, (x, y) in enumerate(spots)
    )


def _pots() -> tuple[Cylinder, ...]:
    """Flowerpots of several sizes."""
    spots = (
        (6.2, 2.4, 0.35, 1.1), (11.5, 2.3, 0.3, 0.9), (13.6, 2.1, 0.4, 1.5), (18.4, 2.3, 0.3, 1.0),
        (22.4, 4.6, 0.4, 1.6), (22.2, 11.4, 0.35, 1.2), (18.0, 15.8, 0.45, 1.8), (14.0, 15.9, 0.3, 0.9),
        (10.0, 16.0, 0.4, 1.4), (6.0, 16.0, 0.35, 1.0), (2.9, 8.6, 0.4, 1.5), (2.6, 5.4, 0.3, 0.8),
        (7.2, 6.1, 0.3, 0.8), (17.6, 6.1, 0.35, 1.2), (7.4, 11.8, 0.35, 1.1), (13.5, 11.9, 0.3, 0.9),
    )  # fmt: skip
    clay = ((0.62, 0.3, 0.18), (0.85, 0.83, 0.78), (0.25, 0.3, 0.5), (0.4, 0.4, 0.42))
    return tuple(
        Cylinder(x, y, r, h, Look(clay[k % 4], "leaves", 51 + k), "flowerpot") for k, (x, y, r, h) in enumerate(spots)
    )
