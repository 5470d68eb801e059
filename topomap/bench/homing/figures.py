"""Pictures of homing: vector maps and routes over the plan, one method each or all on a sheet."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import Colormap, LinearSegmentedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from topomap.bench.homing.answers import Entry
from topomap.bench.homing.bench import Table
from topomap.bench.homing.rows import Row
from topomap.core.arrays import FloatArray
from topomap.core.records import Plan
from topomap.evaluation.statistics import angular_errors
from topomap.evaluation.summary import write_whole
from topomap.report.figures import style
from topomap.report.figures.style import literal, png
from topomap.vision.arena import Point, bearings_home

ERRORS: Colormap = LinearSegmentedColormap.from_list("errors", ["#0072B2", "#56B4E9", "#E69F00", "#D55E00", "#7A1F00"])
"""Blue is right, orange is half wrong, dark red leads away: told apart with any colour vision."""
SCALE = Normalize(0.0, 120.0)
FLOOR = "#F6F4EF"
AROUND, CLOSE = 1.0, 0.3
"""How far around the grid a picture shows the plan [m]: alone, and on a sheet."""


def vector_map(axes: Axes, entry: Entry, ground: int = 0, margin: float = AROUND) -> None:
    """Draw a method's home vectors on one ground: an arrow a position, coloured by its error, over the plan."""
    survey, home = entry.grounds[ground].survey, entry.grounds[ground].home
    directions = entry.fields[ground].directions
    _background(axes, survey.plan, survey.positions, survey.spacing, margin)
    true = bearings_home(survey.positions, home)
    asked = entry.grounds[ground].asked
    told = asked & np.isfinite(directions)
    silent = survey.positions[asked & ~told]
    axes.plot(silent[:, 0], silent[:, 1], ".", color=style.GREY, markersize=2.5, zorder=3)
    errors = angular_errors(directions[told], true[told])
    length = 0.82 * survey.spacing
    u, v = length * np.cos(directions[told]), length * np.sin(directions[told])
    axes.quiver(
        survey.positions[told, 0], survey.positions[told, 1], u, v, errors, cmap=ERRORS, norm=SCALE, pivot="mid",
        angles="xy", scale_units="xy", scale=1.0, units="xy", width=0.11 * survey.spacing, headwidth=3.6,
        headlength=4.0, headaxislength=3.6, zorder=4,
    )  # fmt: skip
    _home(axes, home)


def homing_routes(axes: Axes, entry: Entry, ground: int = 0) -> None:
    """Draw the walks of iterated homing on one ground, those that reached home in blue, the others in red."""
    survey, home = entry.grounds[ground].survey, entry.grounds[ground].home
    _background(axes, survey.plan, survey.positions, survey.spacing)
    for walk in entry.fields[ground].walks:
        look, color = ("-", style.BLUE) if walk.reached else ("--", style.RED)
        axes.plot(walk.path[:, 0], walk.path[:, 1], look, color=color, linewidth=1.3, zorder=4)
        axes.plot(*walk.path[0], "o", color=color, markersize=4, markeredgecolor="white", markeredgewidth=0.5, zorder=5)
        if not walk.reached:
            axes.plot(
                *walk.path[-1], "X", color=color, markersize=6, markeredgecolor="white", markeredgewidth=0.4, zorder=5
            )
    _home(axes, home)


def method_figure(table: Table, entry: Entry, row: Row) -> Figure:
    """Return one method's vector map and, where it walked, its routes beside it."""
    walked = bool(entry.fields[0].walks)
    count = (not entry.acting) + walked
    width, height = _shape(entry)
    figure = style.canvas(count * 4.6 * width + 0.9, 4.6 * height + 0.7)
    figure.suptitle(
        literal(f"{row.method} in {table.environment}, seed {table.seeds[0]}"), fontsize=11, x=0.01, ha="left"
    )
    panels = np.atleast_1d(figure.subplots(1, max(count, 1)))
    if not entry.acting:
        vector_map(panels[0], entry)
        panels[0].set_title(_errors_said(row), fontsize=9.5, loc="left")
        _colours(figure, list(panels))
    if walked:
        homing_routes(panels[-1], entry)
        panels[-1].set_title(_walks_said(entry, row), fontsize=9.5, loc="left")
    for axes in panels:
        axes.set_xlabel("x [m]", fontsize=9)
        axes.tick_params(labelsize=8, color=style.PALE)
    panels[0].set_ylabel("y [m]", fontsize=9)
    return figure


def sheet(table: Table) -> Figure:
    """Return the vector maps of all methods that have one, best first, on one sheet."""
    shown = [(e, r) for e, r in zip(table.entries, table.rows, strict=True) if r.mean is not None]
    columns = min(max(math.ceil(math.sqrt(1.4 * len(shown))), 1), 7)
    lines = max(math.ceil(len(shown) / columns), 1)
    width, height = _shape(table.entries[0], CLOSE)
    figure = style.canvas(columns * 2.5 * width + 0.9, lines * (2.5 * height + 0.42) + 0.5)
    heading = "compass given" if table.compass_error is None else f"compass {table.compass}"
    figure.suptitle(
        literal(f"Home vectors in {table.environment}, {heading}, best first"), fontsize=12, x=0.01, ha="left"
    )
    panels = np.atleast_1d(figure.subplots(lines, columns)).ravel()
    for axes, (entry, row) in zip(panels, shown, strict=False):
        vector_map(axes, entry, margin=CLOSE)
        axes.set_title(f"{row.method}\n{_brief(row)}", fontsize=8, loc="left", linespacing=1.15)
    for axes in panels:
        axes.set_xticks([])
        axes.set_yticks([])
    for axes in panels[len(shown) :]:
        axes.set_visible(False)
    _colours(figure, list(panels))
    return figure


def save(figure: Figure, path: Path) -> Path:
    """Write a figure as PNG, the same bytes every time, and return its path."""
    write_whole(path, png(figure, 130))
    return path


def draw_plan(axes: Axes, plan: Plan) -> None:
    """Draw a plan's lines and circles in grey."""
    lines = LineCollection([line[:, :2] for line in plan.polylines], colors="#8E8E8E", linewidths=1.3, zorder=2)
    axes.add_collection(lines)
    for x, y, radius in plan.circles:
        axes.add_patch(Circle((x, y), radius, facecolor="#DADADA", edgecolor="#8E8E8E", linewidth=0.8, zorder=2))


def _background(axes: Axes, plan: Plan, positions: FloatArray, spacing: float, margin: float = AROUND) -> None:
    axes.set_facecolor(FLOOR)
    draw_plan(axes, plan)
    low, high = _extent(plan, positions, spacing, margin)
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.set_aspect("equal")
    axes.spines[:].set_color(style.PALE)


def _extent(plan: Plan, positions: FloatArray, spacing: float, margin: float) -> tuple[FloatArray, FloatArray]:
    """Return the corners (2,) of what is worth showing: the grid, and the plan as far as `margin` [m] around it."""
    low, high = positions.min(axis=0) - 0.6 * spacing, positions.max(axis=0) + 0.6 * spacing
    if plan.polylines:
        points = np.concatenate([line[:, :2] for line in plan.polylines])
        low = np.maximum(np.minimum(low, points.min(axis=0) - 0.05), low - margin)
        high = np.minimum(np.maximum(high, points.max(axis=0) + 0.05), high + margin)
    return low, high


def _shape(entry: Entry, margin: float = AROUND) -> tuple[float, float]:
    """Return width and height of a panel in units of its longer side."""
    survey = entry.grounds[0].survey
    low, high = _extent(survey.plan, survey.positions, survey.spacing, margin)
    side = (high - low) / float((high - low).max())
    return max(float(side[0]), 0.45), max(float(side[1]), 0.3)


def _home(axes: Axes, home: Point) -> None:
    axes.plot(*home, "*", color="#FFD400", markersize=11, markeredgecolor=style.BLACK, markeredgewidth=0.8, zorder=6)


def _colours(figure: Figure, panels: Sequence[Axes]) -> None:
    bar = figure.colorbar(
        ScalarMappable(SCALE, ERRORS), ax=list(panels), extend="max", fraction=0.02, pad=0.015, shrink=0.6
    )
    bar.set_ticks([0, 45, 90, 120])
    bar.set_label("angular error [deg]", fontsize=8.5)
    bar.ax.tick_params(labelsize=8)


def _errors_said(row: Row) -> str:
    if row.mean is None or row.below_45 is None:
        return ""
    return f"mean error {row.mean.value:.1f}°, below 45° {100 * row.below_45.value:.0f} %" + _catchment_said(row)


def _walks_said(entry: Entry, row: Row) -> str:
    walks = [walk for answers in entry.fields for walk in answers.walks]
    ratio = "" if row.path_ratio is None else f", path ratio {row.path_ratio:.2f}"
    return f"iterated: {sum(walk.reached for walk in walks)} of {len(walks)} reach home{ratio}"


def _brief(row: Row) -> str:
    return "" if row.mean is None else f"{row.mean.value:.1f}°" + _catchment_said(row)


def _catchment_said(row: Row) -> str:
    return "" if row.catchment is None else f", catchment {100 * row.catchment.value:.0f} %"
