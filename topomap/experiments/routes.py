"""The study of the four route models: landmarks by colour alone, and the run that changes the model (5.12-5.17)."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import partial
from typing import ClassVar

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from topomap.bench.homing.bench import Table
from topomap.bench.homing.contestant import Pairwise
from topomap.bench.homing.figures import draw_plan, vector_map
from topomap.bench.homing.table import JsonValue
from topomap.core.arrays import FloatArray
from topomap.core.geometry import TAU
from topomap.core.panorama import Panorama
from topomap.core.records import HomeVector
from topomap.experiments.pillars import Pillar, Room, plain, room_arena, room_recipe
from topomap.experiments.study import Finding, Lab, row_values
from topomap.report.figures import style
from topomap.vision.arena import Arena
from topomap.vision.contracts import Needs
from topomap.vision.homing.run_down import COUNT, FIELDS, RunDown, Selection
from topomap.vision.homing.view_vector import vector_home

WALL, HALF, SPACING = 6.0, 2.0, 0.5
REACH, WIDE = 4.0, 0.7
"""Wide landmarks overlap their images at home, without which the image difference says nothing [m]."""
AROUND = 2.5
"""How far around the grid the maps reach [m], so that the landmarks are seen."""
STARTS, AWAY, REACHED, FARTHEST, MOST = 8, 1.6, 0.25, 3.0, 200
"""Runs start at so many places this far from home; home counts as reached, and the run as lost, this far from it [m];
the most moves.
"""
EVERY_COLUMN = RunDown(selection="all")
"""The pillars alone are bright, so every column may count; a fixed number of them would cut some off."""
COLOURS = (style.RED, style.BLUE, style.BLACK, style.PURPLE)
"""M_1 .. M_4 as in the thesis."""

ARRANGEMENTS: dict[str, tuple[tuple[float, float, float, int], ...]] = {
    "K1, K2 both not 0": ((110, 3.6, 0.8, 230), (290, 3.8, 0.7, 250), (20, 4.8, 0.5, 180), (205, 4.6, 0.6, 140)),
    "K1 > 0, K2 = 0": ((90, REACH, WIDE, 220), (270, REACH, WIDE, 220)),
    "K1 = 0, K2 not 0": ((45, REACH, WIDE, 220), (225, REACH, WIDE, 220)),
    "K1 = K2 = 0": tuple((angle, REACH, WIDE, 220) for angle in (0, 90, 180, 270)),
    "both not 0, in pairs": ((95, 3.6, 0.6, 230), (125, 4.4, 0.8, 180), (285, 3.8, 0.7, 250), (315, 4.6, 0.6, 140)),
}
"""Pillars by bearing [degrees], distance and radius [m] and brightness, in a black room about home.

In pairs one landmark's image comes to lie on the other's, where the image difference has minima that aren't home.
"""


@dataclass(frozen=True, slots=True)
class RouteModel:
    """One of the four fields as a homing method of its own: number 0 .. 3 for M_1 .. M_4 (5.10).

    selection, colour, count: which columns count and of which channels, as in `RunDown`.
    """

    needs: ClassVar[Needs] = Needs(compass=True)
    claims_homing: ClassVar[bool] = False
    number: int
    selection: Selection = "all"
    colour: bool = False
    count: int = COUNT

    def describe(self, panorama: Panorama) -> Panorama:
        """Return the view itself: both views are compared column by column."""
        return panorama

    def home(self, current: Panorama, goal: Panorama) -> HomeVector:
        """Return the bearing [rad] the field tells in the aligned frame. Raises ShapeError."""
        x, y = RunDown(self.selection, self.colour, self.count).field(current, goal, self.number)
        return vector_home(x, y, 1.0)


@dataclass(frozen=True, slots=True, eq=False)
class Run:
    """A run by the combination of models: path (K, 2) [m], the model (K - 1,) of each move, and if home was reached."""

    path: FloatArray
    models: tuple[int, ...]
    reached: bool


def four_routes(lab: Lab) -> Finding:
    """Vector maps of M_1 .. M_4 in five arrangements of landmarks, and the run that changes models (5.12-5.17)."""
    figure = style.canvas(13.2, 13.6)
    panels = figure.subplots(len(ARRANGEMENTS), len(FIELDS) + 1)
    models = [Pairwise(f"M{k + 1}", RouteModel(k)) for k in range(len(FIELDS))]
    found: dict[str, JsonValue] = {}
    for name, line in zip(ARRANGEMENTS, panels, strict=True):
        table = lab.measured([room_recipe(f"routes, {name}", 0, partial(_arena, name))], models)
        runs = [run(landmarks(name), k) for k in range(STARTS)]
        _draw(line, name, table, runs)
        values: dict[str, JsonValue] = {row.method: row_values(row) for row in table.rows}
        k1, k2 = constants(name)
        found[name] = {"K1": round(k1, 4), "K2": round(k2, 4), "models": values, "runs": [_said(one) for one in runs]}
    keys = [Line2D([], [], color=colour, label=f"led by M{k + 1}") for k, colour in enumerate(COLOURS)]
    figure.legend(handles=keys, loc="outside lower right", ncols=len(keys), fontsize=9, frameon=False)
    figure.suptitle("Four route models without distances, and a run that changes them", fontsize=11, x=0.01, ha="left")
    return Finding(figure, found)


def landmarks(name: str) -> Room:
    """Return the room of an arrangement."""
    pillars = [
        Pillar(r * math.cos(math.radians(a)), r * math.sin(math.radians(a)), radius, (bright, bright, bright))
        for a, r, radius, bright in ARRANGEMENTS[name]
    ]
    return Room(pillars, WALL, plain((0, 0, 0)))


def constants(name: str) -> tuple[float, float]:
    """Return K_1 and K_2 (5.12) of an arrangement at home [1/m], radius for R and brightness in [0, 1] for C."""
    angles, distance, radius, bright = np.array(ARRANGEMENTS[name]).T
    weight = radius * (bright / 255.0) / distance**2
    double = 2.0 * np.radians(angles)
    return float(-(weight * np.cos(double)).sum()), float(-(weight * np.sin(double)).sum())


def run(room: Room, number: int) -> Run:
    """Run home from one of the starts, at first by one model, changing it when the image difference grows.

    number: of the start; it decides the first model as well, which the thesis draws at random.
    """
    angle = (number + 0.5) * TAU / STARTS
    state = replace(EVERY_COLUMN.start(room.view(0.0, 0.0, 0.0)), field=number % len(FIELDS))
    path, models = [(AWAY * math.cos(angle), AWAY * math.sin(angle))], []
    while math.hypot(*path[-1]) > REACHED and len(path) <= MOST:
        x, y = path[-1]
        state, move = EVERY_COLUMN.step(state, room.view(x, y, 0.0))
        if not move.distance or math.hypot(x, y) > FARTHEST:
            break
        path.append((x + move.distance * math.cos(move.bearing), y + move.distance * math.sin(move.bearing)))
        models.append(state.field)
    return Run(np.array(path), tuple(models), math.hypot(*path[-1]) <= REACHED)


def _arena(name: str, _name: str, _seed: int, _options: tuple[str, ...]) -> Arena:
    return room_arena(name, landmarks(name), HALF, SPACING)


def _draw(line: FloatArray, name: str, table: Table, runs: list[Run]) -> None:
    entries = {entry.name: (entry, row) for entry, row in zip(table.entries, table.rows, strict=True)}
    for k, axes in enumerate(line[:-1]):
        entry, row = entries[f"M{k + 1}"]
        vector_map(axes, entry, margin=AROUND)
        share = 0.0 if row.catchment is None else row.catchment.value
        axes.set_title(f"M{k + 1}: {100 * share:.0f} % reach home", fontsize=9, loc="left")
    k1, k2 = constants(name)
    line[0].set_ylabel(f"{name}\nK1 {k1:+.3f}, K2 {k2:+.3f}", fontsize=9)
    _draw_runs(line[-1], landmarks(name), runs)


def _draw_runs(axes: Axes, room: Room, runs: list[Run]) -> None:
    draw_plan(axes, room.plan())
    for one in runs:
        for k, model in enumerate(one.models):
            axes.plot(*one.path[k : k + 2].T, "-", color=COLOURS[model], linewidth=1.2, zorder=4)
        axes.plot(*one.path[0], "o", color=style.GREY, markersize=3.5, zorder=5)
        if not one.reached:
            axes.plot(*one.path[-1], "X", color=style.GREY, markersize=6, zorder=5)
    axes.plot(0.0, 0.0, "*", color="#FFD400", markersize=11, markeredgecolor=style.BLACK, zorder=6)
    axes.set(xlim=(-5.1, 5.1), ylim=(-5.1, 5.1), aspect="equal")
    axes.set_title(f"changing: {sum(one.reached for one in runs)} of {len(runs)} reach home", fontsize=9, loc="left")


def _said(one: Run) -> dict[str, JsonValue]:
    changes = sum(a != b for a, b in zip(one.models, one.models[1:], strict=False))
    length = float(np.hypot(*np.diff(one.path, axis=0).T).sum())
    return {"first": f"M{one.models[0] + 1}" if one.models else "", "reached": one.reached, "changes": changes,
            "metres": round(length, 2)}  # fmt: skip
