"""long-corridor: more than half a kilometre of one corridor with side corridors and doors that repeat."""

from __future__ import annotations

from itertools import pairwise

from sim2d.generate.blocks import Blocks, Edge
from sim2d.generate.looks import Stock
from sim2d.generate.things import along_walls
from sim2d.shapes import Decal, Ground, Look, Point, Route, Spec
from sim2d.streams import stream

HEIGHT, HALF, PITCH = 2.6, 1.0, 3.0  # [m] ceiling, half the corridor's width, from door to door
WAY: tuple[Point, ...] = ((0, 0), (138, 0), (138, 60), (30, 60), (30, 120), (192, 120))
SIDE = 5.0  # [m] how far a side corridor goes
WALLPAPER = (0.76, 0.75, 0.7)


def long_corridor() -> Spec:
    """Return a corridor of 528 m with five bends, driven to its end and back: 1 km in all."""
    edges = _edges()
    boxes, rounds = along_walls(edges, 24.0, stream(7, "long-corridor"))
    return Spec(
        name="long-corridor",
        purpose="528 m of look-alike doors, out and back: drift that only the way back can mend",
        route=Route(ring=(*WAY, *WAY[-2:0:-1]), laps=1, radius=0.7),
        floor=Ground(Look((0.4, 0.42, 0.46), "speckle", 3), tile=3.0, gloss=0.08),
        ceiling=Ground(Look((0.85, 0.85, 0.83), "plain", 4), tile=3.0, lamps=3.0, first_lamp=0.0),
        ceiling_height=HEIGHT,
        walls=Stock([_looks()], HEIGHT, PITCH).hang(edges, [0] * len(edges), stream(7, "long-corridor walls")),
        boxes=tuple(boxes),
        cylinders=tuple(rounds),
        goal=(138.0, 6.0),
        labels=tuple((x, y + 4.0, f"bend {k}") for k, (x, y) in enumerate(WAY[1:-1], 1)),
    )


def _edges() -> list[Edge]:
    """Return the walls of the corridor and of its side corridors, every 18 m in turn to the left and the right."""
    blocks = Blocks((-8.0, -8.0), 1.0, 210, 138)
    for number, (a, b) in enumerate(pairwise(WAY)):
        (x0, x1), (y0, y1) = sorted((a[0], b[0])), sorted((a[1], b[1]))
        blocks.cut(x0 - HALF, y0 - HALF, x1 + HALF, y1 + HALF)
        for k, s in enumerate(range(12 + 3 * (number % 3), round(x1 - x0 + y1 - y0) - 8, 18)):
            sign = 1 if (k + number) % 2 else -1
            if a[0] == b[0]:
                side = sorted((x0 + sign * HALF, x0 + sign * (HALF + SIDE)))
                blocks.cut(side[0], y0 + s, side[1], y0 + s + 2)
            else:
                side = sorted((y0 + sign * HALF, y0 + sign * (HALF + SIDE)))
                blocks.cut(x0 + s, side[0], x0 + s + 2, side[1])
    return blocks.edges()


def _looks() -> list[Look]:
    """Return the pictures of the walls: four times out of five a door and nothing else."""
    door = Decal("door", 1.0, 1.0, 0.0, 2.1, (0.5, 0.36, 0.22), 1)
    plain = Look(WALLPAPER, "paper", 5, (door,), repeat=PITCH)
    marks = []
    for k in range(12):
        tone = (k * 37 % 97 / 97, k * 53 % 89 / 89, k * 71 % 83 / 83)
        mark = Decal("extinguisher" if k % 3 == 0 else "poster", 2.2, 0.4 + 0.05 * (k % 5), 0.9, 1.8, tone, 50 + k)
        marks.append(Look(WALLPAPER, "paper", 5, (door, mark), repeat=PITCH))
    return [plain] * 48 + marks
