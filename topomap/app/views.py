"""Simulated worlds as arenas for benches: views at any pose, and the grid of free positions."""

from __future__ import annotations

import math
from collections import deque
from functools import cache
from pathlib import Path

import numpy as np
from pydantic import ValidationError

import sim2d
from sim2d import worlds
from sim2d.config import CameraConfig, LaserConfig
from sim2d.errors import WorldError
from sim2d.sensors.camera import Camera
from sim2d.sensors.laser import Laser
from sim2d.shapes import Grid
from sim2d.world import World
from topomap.bench.pool import digest_files
from topomap.core.arrays import FloatArray, Image
from topomap.core.errors import DataError
from topomap.core.panorama import Panorama
from topomap.core.records import Plan
from topomap.vision.arena import Arena, Point, Recipe, central

NOISE_TABLE = 1 << 20
CLEARANCE = 0.25
"""Grid positions keep this distance [m] from everything: the robot's radius and a little more."""
GRID_CLEARANCE = 0.05
"""Declared positions are only dropped [m] where the camera itself would stand in something."""
SPACINGS = (0.2, 0.3, 0.4, 0.5, 0.75, 1.0)
MOST_POSITIONS = 700
WORLD_FILES = ("**/*.py", "**/*.toml")
"""The simulator's files that decide its views."""


class WorldViews:
    """A simulated world as a ViewSource: the same pose gives the same view, whatever was asked before.

    noise: whether image and ranges carry the sensors' noise, drawn from seed and pose.
    """

    def __init__(self, world: World, seed: int, noise: bool = True, camera: CameraConfig | None = None) -> None:
        self.world = world
        self._seed = seed
        self._noise = noise
        self._config = camera or CameraConfig()
        self._camera = Camera(self._config.model_copy(update={"noise": 0.0}), np.random.default_rng(0))
        self._laser_config = LaserConfig(rays=self._config.width)
        self._laser = Laser(self._laser_config, np.random.default_rng(0))
        table = np.random.default_rng(np.random.SeedSequence([seed, 1])).normal(0.0, self._config.noise, NOISE_TABLE)
        self._table = np.rint(table).astype(np.int16)

    def view(self, x: float, y: float, heading: float) -> Panorama:
        """Return the panorama with ranges at a pose [m, rad]."""
        image = self._camera.view(self.world, x, y, heading)
        ranges = self._laser.exact(self.world, x, y, heading)
        if self._noise:
            rng = np.random.default_rng([self._seed, *np.array([x, y, heading]).view(np.uint32).tolist()])
            image, ranges = self._grainy(image, rng), self._measured(ranges, rng)
        return Panorama.from_recorded(image, self._camera.rig, ranges.astype(np.float32))

    def nearest_thing(self, point: Point) -> float:
        """Return the distance to the nearest surface [m]."""
        return float(np.nanmin(self._laser.exact(self.world, *point, 0.0), initial=math.inf))

    def sees(self, a: Point, b: Point) -> bool:
        """Return whether nothing stands between two points."""
        free = self._laser.exact(self.world, *a, math.atan2(b[1] - a[1], b[0] - a[0]))[0]
        return not free < math.dist(a, b)

    def _grainy(self, image: Image, rng: np.random.Generator) -> Image:
        grain = np.resize(np.roll(self._table, -int(rng.integers(NOISE_TABLE))), image.shape)
        noisy: Image = np.clip(image + grain, 0, 255).astype(np.uint8)
        return noisy

    def _measured(self, ranges: FloatArray, rng: np.random.Generator) -> FloatArray:
        noisy = ranges + rng.normal(0.0, self._laser_config.noise, len(ranges))
        noisy[rng.random(len(ranges)) < self._laser_config.dropout] = np.nan
        return np.maximum(noisy, 0.0)


def world_recipe(name: str, seed: int, options: tuple[str, ...] = ()) -> Recipe:
    """Return the recipe of a named world's arena. Raises DataError for an unknown world or option.

    options: `noise=off`, and settings of the camera as in `hour=14` or `roll_deg=2`; with `goal:` before it a setting
    holds for the view at the goal only, else for all the others.
    """
    _options(options)
    if name not in worlds.names():
        raise DataError(f"unknown environment {name!r}; there are {', '.join(worlds.names())}")
    return Recipe(name, seed, world_arena, options, _code())


def world_arena(name: str, seed: int, options: tuple[str, ...]) -> Arena:
    """Return the arena of a named world. Raises DataError."""
    try:
        world = worlds.load(name, seed)
    except WorldError as error:
        raise DataError(str(error)) from error
    camera, goal_camera = _options(options)
    views = WorldViews(world, seed, "noise=off" not in options, camera)
    goals = None
    if camera != goal_camera:  # a world of its own: one world has one hour of the day
        goals = WorldViews(worlds.load(name, seed), seed, "noise=off" not in options, goal_camera)
    positions, spacing = free_grid(views)
    plan = world.plan()
    return Arena(
        name,
        views,
        positions,
        spacing,
        True,
        central(positions),
        Plan(plan.polylines, plan.circles, plan.labels),
        goals,
    )


def free_grid(views: WorldViews) -> tuple[FloatArray, float]:
    """Return the free positions (N, 2) [m] of the world's grid and its spacing [m].

    A world that declares none gets those that can be reached from its goal, at the narrowest usual spacing that needs
    at most `MOST_POSITIONS`.
    """
    spec = views.world.spec
    if spec.grid is not None:
        return _declared(views, spec.grid), spec.grid.spacing
    anchor = spec.goal or spec.route.ring[0]
    for spacing in SPACINGS:
        found = _flood(views, anchor, spacing)
        if len(found) <= MOST_POSITIONS:
            break
    return found, spacing


def _declared(views: WorldViews, grid: Grid) -> FloatArray:
    cells = [(i, j) for j in range(grid.rows) for i in range(grid.columns)]
    points = [_point(grid.origin, cell, grid.spacing) for cell in cells]
    return np.array([point for point in points if views.nearest_thing(point) > GRID_CLEARANCE])


def _flood(views: WorldViews, anchor: Point, spacing: float) -> FloatArray:
    start = (0, 0)
    seen, waiting = {start}, deque([start])
    free: list[tuple[int, int]] = []
    while waiting and len(free) <= MOST_POSITIONS:
        cell = waiting.popleft()
        here = _point(anchor, cell, spacing)
        if views.nearest_thing(here) < CLEARANCE and cell != start:
            continue
        free.append(cell)
        for step in ((1, 0), (0, 1), (-1, 0), (0, -1)):
            beside = (cell[0] + step[0], cell[1] + step[1])
            if beside not in seen and views.sees(here, _point(anchor, beside, spacing)):
                seen.add(beside)
                waiting.append(beside)
    cells = sorted(free, key=lambda cell: (cell[1], cell[0]))
    return np.array([_point(anchor, cell, spacing) for cell in cells])


def _point(anchor: Point, cell: tuple[int, int], spacing: float) -> Point:
    return round(anchor[0] + cell[0] * spacing, 6), round(anchor[1] + cell[1] * spacing, 6)


def _options(options: tuple[str, ...]) -> tuple[CameraConfig, CameraConfig]:
    """Return the cameras of the current views and of the goal's."""
    settings: tuple[dict[str, str], dict[str, str]] = ({}, {})
    for option in options:
        key, equals, value = option.partition("=")
        if not equals:
            raise DataError(f"view option {option!r}: expected noise=off or a camera setting, as in hour=14")
        if option != "noise=off":
            settings[key.startswith("goal:")][key.removeprefix("goal:")] = value
    try:
        return CameraConfig.model_validate(settings[0]), CameraConfig.model_validate(settings[1])
    except ValidationError as error:
        first = error.errors()[0]
        raise DataError(f"view option {'.'.join(map(str, first['loc']))}: {first['msg']}") from error


@cache
def _code() -> str:
    return digest_files(Path(sim2d.__file__).parent, WORLD_FILES) + digest_files(Path(__file__).parent, ("views.py",))
