"""Pictures of a world: its plan with the route, and what the camera sees. The only place that draws."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon

from sim2d.camera import Camera
from sim2d.config import CameraConfig
from sim2d.path import of_route
from sim2d.streams import stream
from sim2d.world import World


def draw_plan(world: World, path: Path | str) -> None:
    """Write the plan with route, start and goal as a PNG."""
    spec = world.spec
    figure = Figure(figsize=(9, 7), layout="constrained")
    axes = figure.add_subplot()
    for wall in spec.walls:
        axes.plot(*np.array(wall.points).T, color=_dark(wall.look.colour), lw=3, solid_capstyle="round")
    for box in spec.boxes:
        axes.add_patch(Polygon(box.points, closed=True, fc=box.look.colour, ec="0.2", lw=0.8))
    for thing in spec.cylinders:
        axes.add_patch(Circle((thing.x, thing.y), thing.radius, fc=thing.look.colour, ec="0.2", lw=0.8))
    for gate in spec.gates:
        axes.plot(*np.array([gate.a, gate.b]).T, color="tab:red", lw=2.5, ls="--")
    route = of_route(spec.route)
    axes.plot(*route.points.T, color="tab:blue", lw=1.2)
    axes.plot(*route.points[0], "o", color="tab:green", label="start")
    axes.plot(*route.points[-1], "s", color="tab:orange", label="end of the taught route")
    if spec.goal:
        axes.plot(*spec.goal, "*", color="tab:purple", ms=11, label="goal")
    for x, y, text in spec.labels:
        axes.text(x, y, text, ha="center", va="center", fontsize=8, bbox={"fc": "w", "ec": "none", "alpha": 0.7})
    axes.set(aspect="equal", xlabel="x [m]", ylabel="y [m]", title=f"{spec.name}: {route.length:.1f} m")
    axes.legend(loc="upper left", fontsize=8)
    FigureCanvasAgg(figure).print_png(str(path))


def draw_panorama(world: World, path: Path | str, along: Sequence[float] = (0.0,), scale: int = 2) -> None:
    """Write what the camera sees at places `along` the route [m], one below the other, as a PNG."""
    route = of_route(world.spec.route)
    camera = Camera(CameraConfig(noise=0.0), stream(0, "view"))
    views = [camera.view(world, *route.at(s), route.heading(s)) for s in along]
    sheet = np.concatenate([np.pad(v, ((0, 4), (0, 0), (0, 0)), constant_values=255) for v in views])
    large = cv2.resize(sheet, None, fx=scale, fy=scale, interpolation=cv2.INTER_NEAREST)
    cv2.imwrite(str(path), cv2.cvtColor(large, cv2.COLOR_RGB2BGR))


def _dark(colour: tuple[float, float, float]) -> tuple[float, float, float]:
    r, g, b = colour
    return 0.6 * r, 0.6 * g, 0.6 * b
