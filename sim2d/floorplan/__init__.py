"""Floor plans: the ROS map-server pair (map.yaml and its image) as a world, walls traced and papered from a seed."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from sim2d.clearance import BODY, Clearance
from sim2d.errors import WorldError
from sim2d.floorplan.map_file import FloorMap, read_map
from sim2d.floorplan.route import find_route
from sim2d.generate.blocks import Edge
from sim2d.generate.looks import TONES, Stock, mixed
from sim2d.shapes import Ground, Look, Point, Route, Spec, Wall
from sim2d.streams import stream

HEIGHT = 2.6  # [m] a plan doesn't say how high its walls are
LAPS = 1.3  # the tour is driven once and then some of it again, so that there are loops to close


def load(path: Path | str, points: tuple[Point, ...] = (), seed: int = 0) -> Spec:
    """Return the world of a map.yaml, driven through `points` [m, map frame] or else on a long tour of its own.

    Raises WorldError with one line that names the file.
    """
    path = Path(path)
    plan = read_map(path)
    ring = find_route(plan, points, str(path))
    spec = Spec(
        name=path.stem if path.stem != "map" else path.resolve().parent.name,
        purpose=f"floor plan {path.name}",
        route=Route(ring=ring, laps=LAPS, radius=0.4),
        floor=Ground(Look((0.46, 0.44, 0.42), "speckle", 3), gloss=0.06),
        ceiling=Ground(Look((0.84, 0.84, 0.82), "plaster", 4), tile=6.4, lamps=3.2),
        ceiling_height=HEIGHT,
        walls=_walls(plan, seed),
        goal=ring[len(ring) // 3],
    )
    for k, point in enumerate(points):
        room, _ = Clearance(spec).at(*point)
        if room < BODY:
            raise WorldError(f"{path}: points[{k}] = {list(point)}: a wall is {max(room, 0):.2f} m off: keep {BODY} m")
    return spec


def trace(plan: FloorMap) -> list[NDArray[np.float64]]:
    """Return the closed outlines (N, 2) [m, map frame] of all that isn't free, straightened to half a cell."""
    fine = 4 if max(plan.free.shape) <= 2500 else 2
    # contours run through the centres of cells: finer cells bring them to the true edges
    free = np.pad(np.kron(plan.free, np.ones((fine, fine), dtype=np.uint8)), 1)
    contours, _ = cv2.findContours(free, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
    out = []
    for contour in contours:
        straight = cv2.approxPolyDP(contour, 0.5 * fine, closed=True)[:, 0].astype(np.float64)
        if len(straight) >= 3:
            out.append(plan.points((straight - 0.5) / fine - 0.5))
    return out


def _walls(plan: FloorMap, seed: int) -> tuple[Wall, ...]:
    """Return the outlines as walls, each stretch with a tone by its place."""
    edges = []
    for outline in trace(plan):
        corners = [(float(x), float(y)) for x, y in outline]
        edges += [Edge(a, b) for a, b in pairwise([*corners, corners[0]]) if math.dist(a, b) > 1e-6]
    tones = [int(abs(edge.a[0] + edge.b[0]) // 12 + abs(edge.a[1] + edge.b[1]) // 8) % len(TONES) for edge in edges]
    looks = mixed(stream(seed, "floor plan looks"), 16)
    return Stock(looks, HEIGHT).hang(edges, tones, stream(seed, "floor plan walls"))
