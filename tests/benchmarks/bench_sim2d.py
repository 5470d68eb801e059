"""sim2d's speed: the ray cast beside a loop of pymunk queries, the panorama, the cost of a bigger world."""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Callable

import numpy as np
import pymunk

from sim2d import worlds
from sim2d.config import CameraConfig
from sim2d.path import of_route
from sim2d.render.raycast import cast
from sim2d.sensors.camera import Camera
from sim2d.shapes import Box, Ground, Look, Route, Spec, rectangle
from sim2d.streams import stream
from sim2d.world import STATIC, World

Row = dict[str, str | float | None]
REACH = 60.0


NAMES = ("hall", "office-loop", "room-corridor")


def median_ms(work: Callable[[], object], runs: int = 30) -> float:
    """Return the median time of a call after one for warming up [ms]."""
    work()
    times = []
    for _ in range(runs):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return 1e3 * statistics.median(times)


def pymunk_loop(world: World, x: float, y: float, angles: np.ndarray) -> list[float]:
    """Return the ranges [m] that one query a ray gives."""
    only_static = pymunk.ShapeFilter(mask=STATIC)
    out = []
    for angle in angles:
        end = (x + REACH * math.cos(angle), y + REACH * math.sin(angle))
        hit = world.space.segment_query_first((x, y), end, 0.0, only_static)
        out.append(hit.alpha * REACH if hit else math.nan)
    return out


def field(count: int) -> World:
    """Return boxes on a jittered grid, `count` surfaces at the same density for every count."""
    side, rng = math.ceil(math.sqrt(count / 4)), np.random.default_rng(0)
    look, ground = Look((0.5, 0.4, 0.3), "plain"), Ground(Look((0.5, 0.5, 0.5), "plain"), 1.0)
    boxes = []
    for k in range(count // 4):
        x, y = 2.0 * (k % side) + rng.uniform(0.4, 1), 2.0 * (k // side) + rng.uniform(0.4, 1)
        boxes.append(Box(rectangle(x, y, x + 0.4, y + 0.4), 2.6, look))
    return World(Spec("field", Route(((0, 0), (1, 0), (1, 1)), 1), ground, ground, 2.6, boxes=tuple(boxes)))


def cast_row(name: str, world: World, x: float, y: float) -> Row:
    """Return the row of a ray cast of 720 rays and its peer."""
    angles, scene = np.arange(720) * math.tau / 720, world.scene()
    # turn by turn, so that a busy machine slows both alike
    ours, theirs = [], []
    for _ in range(5):
        ours.append(median_ms(lambda: cast(scene, x, y, angles, REACH), 40))
        theirs.append(median_ms(lambda: pymunk_loop(world, x, y, angles), 3))
    ms, peer = statistics.median(ours), statistics.median(theirs)
    size = f"720 rays, {len(scene.kind)} surfaces"
    return {"name": name, "ms": ms, "size": size, "peer": "pymunk per ray", "peer_ms": peer, "ratio": peer / ms}


def view_row(name: str, what: str = "", **settings: float) -> Row:
    """Return the row of a whole panorama, with camera settings beside the usual ones."""
    world = worlds.load(name)
    path, camera = of_route(world.spec.route), Camera(CameraConfig.model_validate(settings), stream(0, "bench"))
    x, y = path.at(8.0)
    ms = median_ms(lambda: camera.view(world, x, y, 0.3), 100)
    return {
        "name": f"panorama {name}{what}",
        "ms": ms,
        "size": "720 x 100 RGB",
        "peer": None,
        "peer_ms": None,
        "ratio": None,
    }


def rows() -> list[Row]:
    """Return all rows: name, ms, size, peer, peer_ms, ratio."""
    out: list[Row] = []
    for name in worlds.names():
        world = worlds.load(name)
        out.append(cast_row(f"ray cast {name}", world, *of_route(world.spec.route).at(3.0)))
    out += [view_row(name) for name in NAMES]
    out += [view_row("room-corridor", " by day", hour=14.0), view_row("room-corridor", " tilted", roll_deg=5.0)]
    few, many = field(100), field(10_000)
    small, large = cast_row("ray cast field 100", few, 4.1, 4.1), cast_row("ray cast field 10000", many, 50.1, 50.1)
    return [*out, small, large]


if __name__ == "__main__":
    for row in rows():
        print(row)
