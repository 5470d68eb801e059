"""The way home: planned milestones, the path that was driven and the goals, with the last one's surroundings."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from topomap.core.arrays import FloatArray
from topomap.core.run_data import RunData
from topomap.evaluation.journey import REACHED_M, handover_step, home, reference_route
from topomap.evaluation.trajectory import placed
from topomap.report.figures import style
from topomap.report.figures.routes import draw_plan

ZOOM_M = 1.0


def way_home(run: RunData) -> Figure:
    """Return the true path after hand-over, beside it the surroundings of the goal."""
    figure = style.canvas(7.4, 4.2)
    overview, zoom = figure.subplots(1, 2, width_ratios=(1.6, 1.0))
    style.dress(overview, "The way home", "x [m]", "y [m]")
    style.dress(zoom, "At the goal", "x [m]")
    route, start = reference_route(run), handover_step(run)
    if route is not None and run.truth is not None and start is not None:
        for axes in (overview, zoom):
            _draw(axes, run, run.truth, route, start)
        _look_at(overview, np.concatenate([route, run.truth[start:, :2]]))
        zoom.set_xlim(route[-1, 0] - ZOOM_M, route[-1, 0] + ZOOM_M)
        zoom.set_ylim(route[-1, 1] - ZOOM_M, route[-1, 1] + ZOOM_M)
        _say(zoom, run)
    overview.set_aspect("equal", adjustable="box")
    zoom.set_aspect("equal", adjustable="box")
    style.legend_below(figure, overview, 4)
    return figure


def _draw(axes: Axes, run: RunData, truth: FloatArray, route: FloatArray, start: int) -> None:
    draw_plan(axes, run)
    axes.plot(truth[:start, 0], truth[:start, 1], color=style.PALE, linewidth=0.9, label="driven before")
    axes.plot(route[:, 0], route[:, 1], "s--", color=style.GREEN, linewidth=0.9, markersize=4,
              markerfacecolor="white", label="planned milestones")  # fmt: skip
    online, _ = placed(run, run.online)
    style.line(axes, online[start:, 0], online[start:, 1], style.ONLINE)
    style.line(axes, truth[start:, 0], truth[start:, 1], replace(style.TRUTH, width=1.6, label="true path"))
    axes.plot(*truth[start, :2], "^", color=style.BLACK, markersize=7, label="hand-over")
    axes.add_patch(Circle(route[-1], REACHED_M, facecolor="none", edgecolor=style.RED, linewidth=1.2))
    axes.plot(*route[-1], "*", color=style.RED, markersize=11, markeredgecolor="white",
              markeredgewidth=0.5, label="goal, 0.3 m", zorder=6)  # fmt: skip
    axes.plot(*truth[-1, :2], "o", color=style.BLACK, markersize=5, label="end", zorder=6)
    _draw_goals(axes, run, truth)


def _draw_goals(axes: Axes, run: RunData, truth: FloatArray) -> None:
    """Number the goals of a patrol where their legs ended; a leg that wasn't claimed has its number in brackets."""
    if len(run.legs) < 2:
        return
    for number, leg in enumerate(run.legs, 1):
        said = f"{number}" if leg.claimed else f"({number})"
        axes.annotate(said, tuple(truth[leg.last, :2]), (4, 4), textcoords="offset points", fontsize=8,
                      color=style.RED, clip_on=True, zorder=7)  # fmt: skip
        axes.plot(*truth[leg.last, :2], ".", color=style.RED, markersize=6, zorder=6)


def _look_at(axes: Axes, points: FloatArray) -> None:
    low, high = np.nanmin(points, axis=0), np.nanmax(points, axis=0)
    axes.set_xlim(low[0] - 0.8, high[0] + 0.8)
    axes.set_ylim(low[1] - 0.8, high[1] + 0.8)


def _say(axes: Axes, run: RunData) -> None:
    result = home(run)
    if result.error is None:
        return
    said = "claimed" if result.claimed else "not claimed"
    axes.set_title(f"At the goal: {result.error:.2f} m, {said}", loc="left", fontsize=10.5)
