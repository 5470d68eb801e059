"""The simulated worlds for the command line: what there is, and pictures of it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sim2d import view, worlds
from sim2d.errors import WorldError
from sim2d.path import of_route
from sim2d.shapes import Spec
from sim2d.world import World
from topomap.core.errors import DataError
from topomap.core.names import safe_name


@dataclass(frozen=True, slots=True)
class WorldInfo:
    """A world in short: size w, d [m], length of its route [m], laps, names of other routes, what it is for."""

    name: str
    size: tuple[float, float]
    route_m: float
    laps: float
    routes: tuple[str, ...]
    purpose: str


def list_worlds() -> list[WorldInfo]:
    """Return all named worlds."""
    return [_info(worlds.spec(name)) for name in worlds.names()]


def show_world(world_name: str, out: Path) -> tuple[WorldInfo, tuple[Path, ...]]:
    """Write plan and panoramas of a world, by name or file, into a folder. Raises DataError."""
    try:
        world = worlds.load(world_name)
        name = safe_name(world.name)
        plan, panorama = out / f"{name}-plan.png", out / f"{name}-panorama.png"
        out.mkdir(parents=True, exist_ok=True)
        view.draw_plan(world, plan)
        view.draw_panorama(world, panorama)
    except WorldError as error:
        raise DataError(str(error)) from error
    except OSError as error:
        raise DataError(f"{out}: can't be written ({error.strerror})") from error
    return _info(world.spec), (plan, panorama)


def draw_sheet(path: Path) -> None:
    """Write plan and panorama of every named world on one sheet. Raises DataError."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        view.draw_sheet([World(worlds.spec(name)) for name in worlds.names()], path)
    except OSError as error:
        raise DataError(f"{path}: can't be written ({error.strerror})") from error


def _info(spec: Spec) -> WorldInfo:
    points = np.concatenate([np.array(wall.points, dtype=np.float64) for wall in spec.walls])
    width, depth = (points.max(axis=0) - points.min(axis=0)).tolist()
    length = of_route(spec.route).length
    return WorldInfo(spec.name, (width, depth), length, spec.route.laps, tuple(spec.routes), spec.purpose)
