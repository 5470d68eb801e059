"""Pictures of a world: its plan with routes, places and grid, and what the camera sees. The only place that draws."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import EllipseCollection, LineCollection, PolyCollection
from matplotlib.figure import Figure
from numpy.typing import NDArray

from sim2d.clearance import grid_positions
from sim2d.config import CameraConfig
from sim2d.path import of_route
from sim2d.sensors.camera import Camera
from sim2d.shapes import Colour, Spec
from sim2d.streams import stream
from sim2d.world import World

VIEWS = 4  # panoramas along a route
ROUTES = ("tab:blue", "tab:orange", "tab:green", "tab:purple")


def draw_plan(world: World, path: Path | str) -> None:
    """Write the plan with routes, start, goal, places, people and grid as a PNG."""
    figure = Figure(figsize=(9, 7), layout="constrained")
    axes = figure.add_subplot()
    _plan(axes, world.spec, small=False)
    axes.set(xlabel="x [m]", ylabel="y [m]", title=f"{_literal(world.name)}: {of_route(world.spec.route).length:.1f} m")
    axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), fontsize=8, frameon=False)
    FigureCanvasAgg(figure).print_png(str(path))


def draw_panorama(world: World, path: Path | str, along: Sequence[float] | None = None, scale: int = 2) -> None:
    """Write what the camera sees at places `along` the route [m], one below the other, as a PNG."""
    if along is None:
        along = np.linspace(0.0, of_route(world.spec.route).lap, VIEWS, endpoint=False).tolist()
    views = [panorama(world, s) for s in along]
    sheet = np.concatenate([np.pad(v, ((0, 4), (0, 0), (0, 0)), constant_values=255) for v in views])
    large = cv2.resize(sheet, None, fx=scale, fy=scale, interpolation=cv2.INTER_NEAREST)
    cv2.imwrite(str(path), cv2.cvtColor(large, cv2.COLOR_RGB2BGR))


def panorama(world: World, along: float = 0.0) -> NDArray[np.uint8]:
    """Return the panorama (H, W, 3) RGB, without noise, at a place along the route [m]."""
    route = of_route(world.spec.route)
    return Camera(CameraConfig(noise=0.0), stream(0, "view")).view(world, *route.at(along), route.heading(along))


def draw_sheet(worlds: Sequence[World], path: Path | str, columns: int = 3) -> None:
    """Write all worlds on one sheet as a PNG: the plan of each and a panorama from its start."""
    rows = -(-len(worlds) // columns)
    figure = Figure(figsize=(4.4 * columns, 3.9 * rows), dpi=110, layout="constrained")
    for world, cell in zip(worlds, figure.subfigures(rows, columns, squeeze=False).ravel(), strict=False):
        above, below = cell.subplots(2, 1, height_ratios=(3.6, 1))
        _plan(above, world.spec, small=True)
        above.set_title(f"{world.name}, {of_route(world.spec.route).length:.0f} m", fontsize=9)
        below.imshow(panorama(world), aspect="auto", interpolation="antialiased")
        for axes in (above, below):
            axes.set_axis_off()
    FigureCanvasAgg(figure).print_png(str(path))
    _fewer_colours(path)


def _fewer_colours(path: Path | str) -> None:
    """Write a picture again with 5 bits a channel, which a PNG packs far better."""
    image = cv2.imread(str(path))
    if image is not None:
        few = np.asarray(image, dtype=np.uint8)
        cv2.imwrite(str(path), few >> 3 << 3 | few >> 5, [cv2.IMWRITE_PNG_COMPRESSION, 9])


def _plan(axes: Axes, spec: Spec, small: bool) -> None:
    width = 1.2 if small else 2.5
    lines = [(wall.points, _dark(wall.look.colour)) for wall in spec.walls]
    if len(lines) > 1000:
        width *= 0.5
    axes.add_collection(LineCollection([p for p, _ in lines], colors=[c for _, c in lines], linewidths=width))
    _solids(axes, spec)
    for gate in spec.gates:
        axes.plot(*np.array([gate.a, gate.b]).T, color="tab:red", lw=width, ls="--")
    for light in spec.lights:
        if light.kind == "window":
            axes.plot(*np.array([light.a, light.b]).T, color="deepskyblue", lw=1.4 * width)
    _ways(axes, spec, small)
    grid = grid_positions(spec).reshape(-1, 2)
    axes.plot(*grid.T, ".", color="0.35", ms=1.2 if small else 2.5, zorder=1)
    if not small:
        _words(axes, spec)
    axes.set_aspect("equal")
    axes.autoscale_view()


def _solids(axes: Axes, spec: Spec) -> None:
    boxes = [(box.points, box.look.colour) for box in spec.boxes]
    thin = 0.3 if len(boxes) > 200 else 0.8
    colours = [colour for _, colour in boxes]
    axes.add_collection(PolyCollection([p for p, _ in boxes], facecolors=colours, edgecolors="0.2", linewidths=thin))
    sizes = [2 * thing.radius for thing in spec.cylinders]
    places = [(thing.x, thing.y) for thing in spec.cylinders] or np.zeros((0, 2))
    colours = [thing.look.colour for thing in spec.cylinders]
    discs = EllipseCollection(
        sizes, sizes, [0.0] * len(sizes), units="xy", offsets=places, offset_transform=axes.transData,
        facecolors=colours, edgecolors="0.2", linewidths=thin,
    )  # fmt: skip
    axes.add_collection(discs)


def _ways(axes: Axes, spec: Spec, small: bool) -> None:
    """Draw routes, start, goal and walks."""
    size = 4.0 if small else 7.0
    for colour, (name, route) in zip(ROUTES, {"route": spec.route, **spec.routes}.items(), strict=False):
        points = of_route(route).points
        axes.plot(
            *points[::5].T,
            color=colour,
            lw=0.8 if small else 1.2,
            label=_literal(name),
            ls="-" if name == "route" else ":",
        )
    axes.plot(*spec.start, "o", color="tab:green", ms=size, label="start")
    if spec.goal:
        axes.plot(*spec.goal, "*", color="tab:purple", ms=1.5 * size, label="goal")
    for person in spec.people:
        axes.plot(*np.array(person.route).T, color=person.look.colour, lw=1.2, ls="-.", label=_literal(person.name))


def _words(axes: Axes, spec: Spec) -> None:
    """Write labels and named places."""
    for x, y, text in spec.labels:
        axes.text(
            x, y, _literal(text), ha="center", va="center", fontsize=8, bbox={"fc": "w", "ec": "none", "alpha": 0.7}
        )
    for name, (x, y, heading) in spec.places.items():
        axes.plot(x, y, marker=(3, 0, np.degrees(heading) - 90), color="k", ms=8)
        axes.annotate(_literal(name), (x, y), textcoords="offset points", xytext=(6, 6), fontsize=8)


def _dark(colour: Colour) -> Colour:
    r, g, b = colour
    return 0.6 * r, 0.6 * g, 0.6 * b


def _literal(text: str) -> str:
    """Return a name as matplotlib shall draw it: dollar signs begin no formula, control characters are written out."""
    return "".join(c if c.isprintable() else repr(c)[1:-1] for c in text).replace("$", r"\$")
