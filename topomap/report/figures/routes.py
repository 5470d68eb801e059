"""The routes over the world's plan: dead reckoning, map and truth, with snapshots and closures."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from topomap.core.run_data import RunData
from topomap.evaluation.trajectory import placed
from topomap.report.figures import style


def routes(run: RunData) -> Figure:
    """Return the three routes in one frame, the snapshots on the map's and the closures on it as well."""
    _, how = placed(run, run.final)
    figure = style.canvas(7.4, _height(run))
    axes = figure.add_subplot()
    style.dress(axes, f"Routes ({how})", "x [m]", "y [m]")
    draw_plan(axes, run)
    draw_routes(axes, run)
    draw_snapshots(axes, run)
    _draw_closures(axes, run)
    axes.set_aspect("equal", adjustable="datalim")
    style.legend_below(figure, axes, 4)
    return figure


def draw_plan(axes: Axes, run: RunData) -> None:
    """Draw the world's plan in grey, where the truth's frame is drawn."""
    if run.truth is None:
        return
    lines = LineCollection([line[:, :2] for line in run.plan.polylines], colors="#9A9A9A", linewidths=1.4)
    axes.add_collection(lines)
    for x, y, radius in run.plan.circles:
        axes.add_patch(Circle((x, y), radius, facecolor="#E4E4E4", edgecolor="#9A9A9A", linewidth=0.8))
    for x, y, text in run.plan.labels:
        axes.text(x, y, style.literal(text), fontsize=8, color="#6A6A6A", ha="center", va="center", clip_on=True)


def draw_routes(axes: Axes, run: RunData) -> None:
    """Draw dead reckoning, truth and map, each by its own colour and line."""
    reckoned, _ = placed(run, run.dead_reckoning)
    mapped, _ = placed(run, run.final)
    style.line(axes, reckoned[:, 0], reckoned[:, 1], style.DEAD_RECKONING)
    if run.truth is not None:
        style.line(axes, run.truth[:, 0], run.truth[:, 1], style.TRUTH)
    style.line(axes, mapped[:, 0], mapped[:, 1], style.MAP)


def draw_snapshots(axes: Axes, run: RunData) -> None:
    """Draw the snapshot nodes where the final map has them."""
    poses = [node.pose for node in run.nodes if node.snapshot]
    if not poses:
        return
    there, _ = placed(run, np.array(poses))
    axes.plot(
        there[:, 0], there[:, 1], "o", markersize=style.size_for(len(poses) // 4, 3.6),
        markerfacecolor="white", markeredgecolor=style.RED, markeredgewidth=0.8, label="snapshot",
    )  # fmt: skip


def _draw_closures(axes: Axes, run: RunData) -> None:
    mapped, _ = placed(run, run.final)
    for look, steps in style.closure_steps(run):
        style.mark(axes, mapped[steps, :2], look)


def _height(run: RunData) -> float:
    shown = [placed(run, run.final)[0][:, :2], placed(run, run.dead_reckoning)[0][:, :2]]
    extent = np.ptp(np.concatenate(shown), axis=0)
    return float(np.clip(1.2 + 6.4 * extent[1] / max(extent[0], 1e-6), 3.4, 7.6))
