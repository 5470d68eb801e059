"""Image differences over time: the difference to the last snapshot, and to the most similar older
place."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from topomap.core.arrays import FloatArray
from topomap.core.run_data import RunData
from topomap.evaluation.trajectory import step_at
from topomap.report.figures import style


def image_difference(run: RunData) -> Figure:
    """Return the image difference to the last snapshot over time, with threshold, snapshots and events."""
    figure = style.canvas(7.4, 3.2)
    axes = figure.add_subplot()
    style.dress(axes, "Image difference to the last snapshot", "time [s]", "difference")
    _curve(axes, run, run.difference, style.BLUE, "difference")
    if run.threshold is not None and np.isfinite(run.threshold):
        axes.axhline(run.threshold, color=style.RED, linewidth=1.0, linestyle="--", label="snapshot threshold")
    _mark_snapshots(axes, run)
    _finish(figure, axes, run)
    return figure


def place_difference(run: RunData) -> Figure:
    """Return the difference to the most similar older node over time and, going home, to the milestone."""
    figure = style.canvas(7.4, 3.2)
    axes = figure.add_subplot()
    style.dress(axes, "Difference to the most similar older place", "time [s]", "difference")
    _curve(axes, run, run.place_difference, style.BLUE, "best older node")
    if run.homing_difference is not None and np.isfinite(run.homing_difference).any():
        _curve(axes, run, run.homing_difference, style.AMBER, "milestone, going home")
    _finish(figure, axes, run)
    return figure


def _curve(axes: Axes, run: RunData, values: FloatArray | None, color: str, label: str) -> None:
    if values is not None:
        axes.plot(style.seconds(run), values, color=color, linewidth=1.0, label=label)


def _mark_snapshots(axes: Axes, run: RunData) -> None:
    steps = [step_at(run.stamps_ns, node.stamp_ns) for node in run.nodes if node.snapshot]
    axes.plot(
        style.seconds(run)[steps], np.full(len(steps), 0.985), "|", transform=axes.get_xaxis_transform(),
        color=style.RED, markersize=7, markeredgewidth=0.9, label=f"snapshot ({len(steps)})",
    )  # fmt: skip


def _finish(figure: Figure, axes: Axes, run: RunData) -> None:
    axes.set_ylim(bottom=0.0, top=axes.get_ylim()[1] * 1.06)
    style.mark_events(axes, run)
    style.legend_below(figure, axes, 4)
